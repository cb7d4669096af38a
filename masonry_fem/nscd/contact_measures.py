"""Contact measures: what is left of the laws of contact at each contact, and norms of their blocks, compiled.

The loop of all solvers asks for them at every offer. NumPy takes thirty calls, which on some hundred contacts
cost more than the arithmetic.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]


@compiled(error_model="numpy")
def measured(
    pressed: FloatArray, velocity: FloatArray, friction: FloatArray, scale: FloatArray
) -> tuple[FloatArray, float, float, float, float]:
    """Size of the natural map at each contact, and what the laws are violated by at most.

    Parameters
    ----------
    pressed : Contact part p̃ of the impulses, shape (c, d) [N s].
    velocity : v, shape (c, d) [m/s].
    friction : Coefficients μ, shape (c,).
    scale : w of each contact, shape (c,) [1/kg].

    Returns
    -------
    ‖p̃ − P_K(p̃ − v̂/w)‖, shape (c,) [N s], written as ``graphs.natural_map`` explains it; and the largest of
    −v_N [m/s], −p̃_N [N s], ‖p̃_T‖ − μ p̃_N [N s] and |p̃ · v̂| [J], each at least 0, nan where one is.
    """
    count, d = pressed.shape
    natural = np.empty(count)
    motion, trial = np.empty(d), np.empty(d)
    penetration = tension = violation = work = 0.0
    for contact in range(count):
        p, v, mu, w = pressed[contact], velocity[contact], friction[contact], scale[contact]
        augmented = v[0] + mu * _tangent(v)
        done = p[0] * augmented
        motion[0] = augmented / w
        for axis in range(1, d):
            done += p[axis] * v[axis]
            motion[axis] = v[axis] / w
        for axis in range(d):
            trial[axis] = p[axis] - motion[axis]
        normal, tangent = trial[0], _tangent(trial)
        if mu * tangent <= -normal:  # within the polar cone
            for axis in range(d):
                motion[axis] = p[axis]
        elif tangent > mu * normal:
            excess = (tangent - mu * normal) / (1.0 + mu * mu)
            motion[0] -= mu * excess
            for axis in range(1, d):
                motion[axis] += excess / tangent * trial[axis]
        square = 0.0
        for axis in range(d):
            square += motion[axis] * motion[axis]
        natural[contact] = math.sqrt(square)
        penetration = _larger(penetration, -v[0])
        tension = _larger(tension, -p[0])
        violation = _larger(violation, _tangent(p) - mu * p[0])
        work = _larger(work, abs(done))
    return natural, penetration, tension, violation, work


@compiled(error_model="numpy")
def curnier(
    impulse: FloatArray, velocity: FloatArray, friction: FloatArray, rho: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """F and its derivatives by p and v, as ``graphs.alart_curnier`` explains them.

    Parameters
    ----------
    impulse, velocity : p and v, shape (c, d). friction : μ, shape (c,). rho : ρ > 0, shape (c,) [kg].

    Returns
    -------
    F (c, d), ∂F/∂p (c, d, d), ∂F/∂v (c, d, d).
    """
    count, d = impulse.shape
    residual, by_impulse = impulse.copy(), np.zeros((count, d, d))
    by_velocity = np.zeros((count, d, d))
    trial, slope = np.empty(d), np.empty((d, d))  # of the projection, by the trial point
    for contact in range(count):
        for axis in range(d):
            trial[axis] = impulse[contact, axis] - rho[contact] * velocity[contact, axis]
            by_impulse[contact, axis, axis] = 1.0
        if not trial[0] >= 0:
            continue
        radius, size = friction[contact] * trial[0], _tangent(trial)
        slope[:] = 0.0
        slope[0, 0] = 1.0
        if size > radius:
            for axis in range(1, d):
                direction = trial[axis] / size
                slope[axis, 0] = friction[contact] * direction
                for other in range(1, d):
                    across = (1.0 if axis == other else 0.0) - direction * (trial[other] / size)
                    slope[axis, other] = radius / size * across
            for axis in range(1, d):
                trial[axis] = radius * (trial[axis] / size)
        else:
            for axis in range(1, d):
                slope[axis, axis] = 1.0
        for axis in range(d):
            residual[contact, axis] -= trial[axis]
            for other in range(d):
                by_impulse[contact, axis, other] -= slope[axis, other]
                by_velocity[contact, axis, other] = rho[contact] * slope[axis, other]
    return residual, by_impulse, by_velocity


@compiled(error_model="numpy")
def spectral_norms(blocks: FloatArray) -> FloatArray:
    """‖block‖₂ of each, from the largest eigenvalue of blockᵀ block: SVDs cost a hundred times as much.

    Parameters
    ----------
    blocks : Shape (c, d, d), d = 2 or 3.

    Returns
    -------
    Norms, shape (c,).

    References
    ----------
    O. K. Smith, "Eigenvalues of a symmetric 3 × 3 matrix", Communications of the ACM 4 (1961).
    """
    count, d, _ = blocks.shape
    norms = np.empty(count)
    square = np.empty((d, d))
    for contact in range(count):
        size = 0.0  # squares must not leave the range of floats
        for i in range(d):
            for j in range(d):
                size = _larger(size, abs(blocks[contact, i, j]))
        _square(blocks[contact] / (size if size > 0 else 1.0), square)
        mean = deviation = 0.0
        for i in range(d):
            mean += square[i, i] / d
        for i in range(d):
            square[i, i] -= mean
            for j in range(d):
                deviation += square[i, j] ** 2
        spread = math.sqrt(deviation / (d * (d - 1)))
        largest = mean + spread
        if d == 3 and spread > 0:  # the cubic's largest root by cosines
            a = square / spread
            third = (
                a[0, 0] * (a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1])
                - a[0, 1] * (a[1, 0] * a[2, 2] - a[1, 2] * a[2, 0])
                + a[0, 2] * (a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0])
            ) / 2
            largest = mean + 2 * spread * math.cos(math.acos(min(max(third, -1.0), 1.0)) / 3)
        norms[contact] = size * math.sqrt(largest)
    return norms


@compiled(inline="always")
def _square(block: FloatArray, square: FloatArray) -> None:
    """Put blockᵀ block (d, d) into ``square``."""
    d = len(block)
    for i in range(d):
        for j in range(d):
            square[i, j] = 0.0
            for k in range(d):
                square[i, j] += block[k, i] * block[k, j]


@compiled(inline="always")
def _tangent(vector: FloatArray) -> float:
    """‖x_T‖ of a vector (d,)."""
    return abs(vector[1]) if len(vector) == 2 else math.hypot(vector[1], vector[2])


@compiled(inline="always")
def _larger(one: float, other: float) -> float:
    """The larger of two numbers; nan where one is."""
    return one if other <= one or one != one else other  # noqa: PLR0124 - nan
