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
Vector = tuple[float, float, float]

# Least square of a radius that is as exact as others, and the share of it below which rounding decides
# nothing: with any share below 1 results are the same, and more or fewer of them take a square root.
_LEAST = 1e-280
_CERTAIN = 0.999


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
        augmented = v[0] + mu * math.hypot(v[1], v[2])
        left = _natural(p, (augmented / scale[contact], v[1] / scale[contact], v[2] / scale[contact]), mu)
        natural[contact] = math.sqrt(left[0] * left[0] + left[1] * left[1] + left[2] * left[2])
        penetration = _larger(penetration, -v[0])
        tension = _larger(tension, -p[0])
        work = _larger(work, abs(p[0] * augmented + p[1] * v[1] + p[2] * v[2]))
        if not _within(p, mu * p[0]):
            violation = _larger(violation, math.hypot(p[1], p[2]) - mu * p[0])
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
        mu, w = friction[contact], scale[contact]
        left = _natural(p, ((v[0] + mu * math.hypot(v[1], v[2])) / w, v[1] / w, v[2] / w), mu)
        for axis in range(pressed.shape[1]):
            found[contact, axis] = left[axis]
    return found


@compiled(error_model="numpy")
def curnier(
    impulse: FloatArray, velocity: FloatArray, friction: FloatArray, rho: FloatArray
) -> tuple[FloatArray, Mask, Mask]:
    """The Alart–Curnier function F(p, v).

    With x = p − ρ v: F_N = p_N − max(x_N, 0), F_T = p_T − P_disk(μ max(x_N, 0))(x_T); zero where Signorini's
    and Coulomb's graphs both hold.

    Parameters
    ----------
    impulse, velocity : p and v, shape (c, d). friction : μ, shape (c,). rho : ρ > 0, shape (c,) [kg].

    Returns
    -------
    F (c, d); contacts that are open, with F = p, and those that stick, with F = p − (p − ρ v), both (c,).
    """
    count, d = impulse.shape
    residual = np.empty((count, d))
    is_open, sticks = np.empty(count, dtype=np.bool_), np.empty(count, dtype=np.bool_)
    for contact in range(count):
        p, mu = _three(impulse, contact), friction[contact]
        trial, size = _trial(p, _three(velocity, contact), mu, rho[contact])
        is_open[contact] = not trial[0] >= 0
        sticks[contact] = trial[0] >= 0 and not size > mu * trial[0]
        for i in range(d):  # r v itself would show velocities that are rounding beside the impulse
            left = p[i] if is_open[contact] else p[i] - trial[i]
            slides = i > 0 and not (is_open[contact] or sticks[contact])
            residual[contact, i] = p[i] - mu * trial[0] * (trial[i] / size) if slides else left
    return residual, is_open, sticks


@compiled(error_model="numpy")
def curnier_derivatives(
    impulse: FloatArray, velocity: FloatArray, friction: FloatArray, rho: FloatArray, over: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """∂F/∂p and ∂F/∂v divided, both (c, d, d).

    Of the generalised Jacobian the branch that is closed and sticks, where a contact is on an edge.

    Parameters
    ----------
    impulse, velocity, friction, rho : As for ``curnier``. over : What ∂F/∂v is divided by, shape (c,).
    """
    count, d = impulse.shape
    by_impulse, by_velocity = np.empty((count, d, d)), np.empty((count, d, d))
    for contact in range(count):
        mu, r, unit = friction[contact], rho[contact], over[contact]
        trial, size = _trial(_three(impulse, contact), _three(velocity, contact), mu, r)
        radius = mu * trial[0]
        if not trial[0] >= 0 or not size > radius:
            kept, gone = (0.0, r / unit) if trial[0] >= 0 else (1.0, 0.0)
            for i in range(d):
                for j in range(d):
                    by_impulse[contact, i, j] = kept if i == j else 0.0
                    by_velocity[contact, i, j] = gone if i == j else 0.0
            continue
        by_impulse[contact, 0, 0], by_velocity[contact, 0, 0] = 0.0, r / unit
        for i in range(1, d):
            along = trial[i] / size
            by_impulse[contact, 0, i], by_velocity[contact, 0, i] = 0.0, 0.0
            by_impulse[contact, i, 0], by_velocity[contact, i, 0] = 0.0 - mu * along, r * (mu * along) / unit
            for j in range(1, d):
                same = 1.0 if i == j else 0.0
                slope = radius / size * (same - along * (trial[j] / size))
                by_impulse[contact, i, j], by_velocity[contact, i, j] = same - slope, r * slope / unit
    return by_impulse, by_velocity


@compiled(error_model="numpy")
def own_derivatives(
    by_impulse: FloatArray, rho: FloatArray, weight: FloatArray, by_velocity: FloatArray
) -> FloatArray:
    """A / ρ + w Bc: the derivative by a contact's own impulse where it also moves by w p, shape (c, d, d).

    Parameters
    ----------
    by_impulse, by_velocity : A and Bc, shape (c, d, d). rho, weight : ρ and w, shape (c,).
    """
    own = np.empty(by_impulse.shape)
    for contact in range(len(own)):
        for i in range(own.shape[1]):
            for j in range(own.shape[2]):
                moved = weight[contact] * by_velocity[contact, i, j]
                own[contact, i, j] = by_impulse[contact, i, j] / rho[contact] + moved
    return own


@compiled
def held(moved: FloatArray, weight: FloatArray, impulse: FloatArray, centre: FloatArray) -> FloatArray:
    """V + w (p − p_k), shape (c, d).

    Parameters
    ----------
    moved, impulse, centre : v, p and p_k, shape (c, d). weight : w, shape (c,).
    """
    velocity = np.empty(moved.shape)
    for contact in range(len(moved)):
        for i in range(moved.shape[1]):
            away = impulse[contact, i] - centre[contact, i]
            velocity[contact, i] = moved[contact, i] + weight[contact] * away
    return velocity


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
def _natural(p: Vector, motion: Vector, mu: float) -> Vector:
    """The natural map of one contact, from p̃, v̂/w and μ."""
    trial = (p[0] - motion[0], p[1] - motion[1], p[2] - motion[2])
    if _within(trial, mu * trial[0]):
        return motion
    normal, tangent = trial[0], math.hypot(trial[1], trial[2])
    if mu * tangent <= -normal:  # within the polar cone
        return p
    if tangent > mu * normal:
        excess = (tangent - mu * normal) / (1.0 + mu * mu)
        share = excess / tangent
        return (motion[0] - mu * excess, motion[1] + share * trial[1], motion[2] + share * trial[2])
    return motion


@compiled(inline="always")
def _trial(p: Vector, v: Vector, mu: float, rho: float) -> tuple[Vector, float]:
    """The trial point x = p − ρ v and ‖x_T‖, which is told as 0 where it is within μ x_N for certain."""
    trial = (p[0] - rho * v[0], p[1] - rho * v[1], p[2] - rho * v[2])
    return trial, 0.0 if _within(trial, mu * trial[0]) else math.hypot(trial[1], trial[2])


@compiled(inline="always")
def _within(vector: Vector, radius: float) -> bool:
    """True only where ‖x_T‖ < radius for certain: a square root and its rounding can be spared."""
    bound, square = radius * radius, vector[1] * vector[1] + vector[2] * vector[2]
    return radius > 0 and bound > _LEAST and square < _CERTAIN * bound


@compiled(inline="always")
def _three(vectors: FloatArray, row: int) -> Vector:
    """A row (d,) of an array, with 0 where it has no third number."""
    return vectors[row, 0], vectors[row, 1], vectors[row, 2] if vectors.shape[1] == 3 else 0.0


@compiled(inline="always")
def _larger(one: float, other: float) -> float:
    """The larger of two numbers; nan where one is."""
    return one if other <= one or one != one else other  # noqa: PLR0124 - nan
