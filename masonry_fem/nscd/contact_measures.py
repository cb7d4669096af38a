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
Mask = NDArray[np.bool_]

_LEAST, _MOST = 1e-280, 1e280  # squares that are as exact as others


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
    count = len(pressed)
    natural = np.empty(count)
    penetration = tension = violation = work = 0.0
    for contact in range(count):
        p, v, mu = _three(pressed, contact), _three(velocity, contact), friction[contact]
        left = _natural(p, v, mu, scale[contact])
        natural[contact] = math.sqrt(left[0] * left[0] + left[1] * left[1] + left[2] * left[2])
        done = p[0] * (v[0] + mu * _length(v[1], v[2])) + p[1] * v[1] + p[2] * v[2]
        penetration = _larger(penetration, -v[0])
        tension = _larger(tension, -p[0])
        violation = _larger(violation, _length(p[1], p[2]) - mu * p[0])
        work = _larger(work, abs(done))
    return natural, penetration, tension, violation, work


@compiled(error_model="numpy")
def natural_maps(
    pressed: FloatArray, velocity: FloatArray, friction: FloatArray, scale: FloatArray
) -> FloatArray:
    """What ``graphs.natural_map`` explains, shape (c, d) [N s].

    Parameters
    ----------
    pressed, velocity, friction, scale : As for ``measured``.
    """
    found = np.empty_like(pressed)
    for contact in range(len(pressed)):
        p, v = _three(pressed, contact), _three(velocity, contact)
        left = _natural(p, v, friction[contact], scale[contact])
        for axis in range(pressed.shape[1]):
            found[contact, axis] = left[axis]
    return found


@compiled(error_model="numpy")
def curnier(
    impulse: FloatArray, velocity: FloatArray, friction: FloatArray, rho: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, Mask, Mask]:
    """The Alart–Curnier function F(p, v) and its derivatives.

    With x = p − ρ v: F_N = p_N − max(x_N, 0), F_T = p_T − P_disk(μ max(x_N, 0))(x_T); zero where Signorini's
    and Coulomb's graphs both hold.

    Parameters
    ----------
    impulse, velocity : p and v, shape (c, d). friction : μ, shape (c,). rho : ρ > 0, shape (c,) [kg].

    Returns
    -------
    F (c, d), ∂F/∂p (c, d, d), ∂F/∂v over ρ (c, d, d): of the generalised Jacobian the branch that is closed
    and sticks, where a contact is on an edge. Contacts that are open, with F = p, and those that stick, with
    F = ρ v, both (c,).
    """
    count, d = impulse.shape
    residual = np.empty((count, d))
    by_impulse, by_velocity = np.empty((count, d, d)), np.empty((count, d, d))
    is_open, sticks = np.empty(count, dtype=np.bool_), np.empty(count, dtype=np.bool_)
    for contact in range(count):
        p, v = _three(impulse, contact), _three(velocity, contact)
        mu, r = friction[contact], rho[contact]
        normal, first, second = p[0] - r * v[0], p[1] - r * v[1], p[2] - r * v[2]
        size, radius = _length(first, second), mu * normal
        is_open[contact] = not normal >= 0
        sticks[contact] = normal >= 0 and not size > radius
        if is_open[contact] or sticks[contact]:
            share = 1.0 if sticks[contact] else 0.0
            for i in range(d):
                # r v itself where it sticks would show velocities that are rounding beside the impulse
                residual[contact, i] = p[i] - (p[i] - r * v[i]) if sticks[contact] else p[i]
                for j in range(d):
                    by_velocity[contact, i, j] = share if i == j else 0.0
                    by_impulse[contact, i, j] = 1.0 - share if i == j else 0.0
            continue
        residual[contact, 0] = p[0] - normal
        by_velocity[contact, 0, 0], by_impulse[contact, 0, 0] = 1.0, 0.0
        for i in range(1, d):
            along = (first if i == 1 else second) / size
            residual[contact, i] = p[i] - radius * along
            by_velocity[contact, 0, i], by_impulse[contact, 0, i] = 0.0, 0.0
            by_velocity[contact, i, 0], by_impulse[contact, i, 0] = mu * along, -mu * along
            for j in range(1, d):
                same = 1.0 if i == j else 0.0
                slope = radius / size * (same - along * ((first if j == 1 else second) / size))
                by_velocity[contact, i, j], by_impulse[contact, i, j] = slope, same - slope
    return residual, by_impulse, by_velocity, is_open, sticks


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
    block, square = np.empty((d, d)), np.empty((d, d))
    for contact in range(count):
        size = 0.0  # squares must not leave the range of floats
        for i in range(d):
            for j in range(d):
                size = _larger(size, abs(blocks[contact, i, j]))
        for i in range(d):
            for j in range(d):
                block[i, j] = blocks[contact, i, j] / (size if size > 0 else 1.0)
        mean = deviation = 0.0
        for i in range(d):
            for j in range(i + 1):
                total = 0.0
                for k in range(d):
                    total += block[k, i] * block[k, j]
                square[i, j] = square[j, i] = total
            mean += square[i, i] / d
        for i in range(d):
            square[i, i] -= mean
            for j in range(d):
                deviation += square[i, j] * square[i, j]
        spread = math.sqrt(deviation / (d * (d - 1)))
        largest = mean + spread
        if d == 3 and spread > 0:  # the cubic's largest root by cosines
            for i in range(d):
                for j in range(d):
                    square[i, j] /= spread
            third = (
                square[0, 0] * (square[1, 1] * square[2, 2] - square[1, 2] * square[2, 1])
                - square[0, 1] * (square[1, 0] * square[2, 2] - square[1, 2] * square[2, 0])
                + square[0, 2] * (square[1, 0] * square[2, 1] - square[1, 1] * square[2, 0])
            ) / 2
            largest = mean + 2 * spread * math.cos(math.acos(min(max(third, -1.0), 1.0)) / 3)
        norms[contact] = size * math.sqrt(largest)
    return norms


@compiled(inline="always")
def _natural(
    p: tuple[float, float, float], v: tuple[float, float, float], mu: float, w: float
) -> tuple[float, float, float]:
    """The natural map of one contact, from p̃, v, μ and w."""
    motion = ((v[0] + mu * _length(v[1], v[2])) / w, v[1] / w, v[2] / w)
    trial = (p[0] - motion[0], p[1] - motion[1], p[2] - motion[2])
    normal, tangent = trial[0], _length(trial[1], trial[2])
    if mu * tangent <= -normal:  # within the polar cone
        return p
    if tangent > mu * normal:
        excess = (tangent - mu * normal) / (1.0 + mu * mu)
        share = excess / tangent
        return (motion[0] - mu * excess, motion[1] + share * trial[1], motion[2] + share * trial[2])
    return motion


@compiled(inline="always")
def _three(vectors: FloatArray, row: int) -> tuple[float, float, float]:
    """A row (d,) of an array, with 0 where it has no third number."""
    return vectors[row, 0], vectors[row, 1], vectors[row, 2] if vectors.shape[1] == 3 else 0.0


@compiled(inline="always")
def _length(one: float, other: float) -> float:
    """√(x² + y²), also where squares leave the range of floats."""
    square = one * one + other * other
    return math.sqrt(square) if _LEAST < square < _MOST else math.hypot(one, other)


@compiled(inline="always")
def _larger(one: float, other: float) -> float:
    """The larger of two numbers; nan where one is."""
    return one if other <= one or one != one else other  # noqa: PLR0124 - nan
