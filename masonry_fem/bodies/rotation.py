"""Rotations: proper orthogonal matrices and the rotation vectors that make them, as arrays.

A rotation vector points along the axis and is as long as the angle [rad]; in 2D it is the angle
itself, shape (..., 1). All functions take any leading shape and both dimensions.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

IDENTITY = {2: np.eye(2), 3: np.eye(3)}  # by dimension
SPIN_ITERATIONS = 40
SPIN_TOLERANCE = 1e-15


def spin_count(dimension: int) -> int:
    """Number of angular velocities of a body: 1 in 2D, 3 in 3D."""
    return 1 if dimension == 2 else 3


def cross_matrix(vectors: FloatArray) -> FloatArray:
    """Matrices of ``v ×``, shape (..., 3, 3) for vectors of shape (..., 3)."""
    matrix = np.zeros((*vectors.shape, 3))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = z, -y, x
    return matrix


def lever(arms: FloatArray) -> FloatArray:
    """Velocity at ``arms`` from the centre for unit spins, shape (..., d, 1 or 3) for (..., d) [m].

    Its transpose turns a force at the arm into a moment about the centre.
    """
    if arms.shape[-1] == 3:
        return -cross_matrix(arms)
    return np.stack([-arms[..., 1], arms[..., 0]], axis=-1)[..., None]


def moment(arms: FloatArray, forces: FloatArray) -> FloatArray:
    """Moment ``arm × force``, shape (..., 1 or 3) [N m].

    Parameters
    ----------
    arms : From the centre to where the forces act, shape (..., d) [m].
    forces : Forces, shape (..., d) [N].
    """
    from masonry_fem.bodies.motions import moments  # noqa: PLC0415 - Numba is slow to import

    if arms.shape != forces.shape:
        arms, forces = np.broadcast_arrays(arms, forces)
    # copies, since Numba compiles anew for arrays that are read-only
    rows = (np.array(one, dtype=float, order="C").reshape(-1, one.shape[-1]) for one in (arms, forces))
    found: FloatArray = moments(*rows)
    return found.reshape(*arms.shape[:-1], found.shape[-1])


def resultants(arms: FloatArray, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sums of n forces on each of b blocks, (b, d) [N], and of their moments, (b, 1 or 3) [N m].

    Parameters
    ----------
    arms : From the centre to where the forces act, shape (n, d), or (b, n, d) [m].
    forces : Forces, shape (b, n, d) [N].
    """
    return summed(forces), summed(moment(arms, forces))


def summed(vectors: FloatArray) -> FloatArray:
    """Sums of n vectors of each of b blocks, one after the other, shape (b, d).

    Parameters
    ----------
    vectors : Shape (b, n, d).
    """
    total: FloatArray = np.einsum("bnd->bd", vectors)  # in a quarter of the time that ``sum`` takes
    return total


def turned(rotations: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors of b blocks, or n that all have, times the blocks' matrices, shape (b, n, d).

    Parameters
    ----------
    rotations : Shape (b, d, d). vectors : Shape (b, n, d) or (n, d).
    """
    from masonry_fem.bodies.motions import each_turned  # noqa: PLC0415 - Numba is slow to import

    if vectors.ndim == 2:
        vectors = np.tile(vectors, (len(rotations), 1, 1))
    found: FloatArray = each_turned(np.ascontiguousarray(rotations), np.ascontiguousarray(vectors))
    return found


def exponential(vectors: FloatArray) -> FloatArray:
    """Rotation matrices of rotation vectors (Rodrigues), (..., d, d) for (..., 1 or 3) [rad]."""
    rotation: FloatArray = np.eye(2 if vectors.shape[-1] == 1 else 3) + change(vectors)
    return rotation


def change(vectors: FloatArray) -> FloatArray:
    """R − 1 of rotation vectors, all digits kept however small the turn, (..., d, d) for (..., 1 or 3)."""
    if vectors.shape[-1] == 1:
        angle = vectors[..., 0]
        sine, versine = np.sin(angle), -2.0 * np.sin(0.5 * angle) ** 2
        return np.stack([np.stack([versine, -sine], -1), np.stack([sine, versine], -1)], -2)
    from masonry_fem.bodies.motions import turns  # noqa: PLC0415 - Numba is slow to import

    changed: FloatArray = turns(np.ascontiguousarray(vectors).reshape(-1, 3))
    return changed.reshape(*vectors.shape, 3)


def first_order(changed: FloatArray) -> FloatArray:
    """Spins of turns R − 1 (..., d, d) to first order, of their odd parts, (..., 1 or 3)."""
    pairs = ((1, 0),) if changed.shape[-1] == 2 else ((2, 1), (0, 2), (1, 0))
    return np.stack([0.5 * (changed[..., i, j] - changed[..., j, i]) for i, j in pairs], axis=-1)


def chained(first: FloatArray, second: FloatArray) -> FloatArray:
    """R − 1 of a turn after another, shape (..., d, d).

    What rounding takes from a rotation is put back: R becomes R (3 − RᵀR)/2.

    Parameters
    ----------
    first, second : R − 1 of both, shape (..., d, d).
    """
    total = first + second + second @ first
    across = np.swapaxes(total, -1, -2)
    skewed: FloatArray = total + across + across @ total  # RᵀR − 1
    mended: FloatArray = total - 0.5 * (skewed + total @ skewed)
    return mended


def between(first: FloatArray, second: FloatArray) -> FloatArray:
    """R − 1 of the turn that leads from one rotation to another, shape (..., d, d).

    Parameters
    ----------
    first, second : R − 1 of both, shape (..., d, d).
    """
    across = np.swapaxes(first, -1, -2)
    way: FloatArray = second + across + second @ across
    return way


def turned_by(changed: FloatArray) -> FloatArray:
    """Rotation vectors of R − 1, all digits kept however small the turn, (..., 1 or 3) for (..., d, d)."""
    whole = logarithm(np.eye(changed.shape[-1]) + changed)
    if changed.shape[-1] == 2:
        return whole
    axial = first_order(changed)
    sine = np.linalg.norm(axial, axis=-1, keepdims=True)
    angle = np.arcsin(np.minimum(sine, 1.0))
    small = np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0) * axial
    # past a right angle the sine falls again, next to it it says little of the angle
    return np.where(np.linalg.norm(whole, axis=-1, keepdims=True) < 1.0, small, whole)


def logarithm(rotations: FloatArray) -> FloatArray:
    """Rotation vectors of rotation matrices, angle in [0, π], (..., 1 or 3) for (..., d, d) [rad]."""
    if rotations.shape[-1] == 2:
        angles: FloatArray = np.arctan2(rotations[..., 1, 0], rotations[..., 0, 0])[..., None]
        return angles
    quaternion = _quaternion(rotations)
    scalar, vector = quaternion[..., :1], quaternion[..., 1:]
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2 * np.arctan2(length, scalar)
    vectors: FloatArray = np.where(length > 0, angle / np.where(length > 0, length, 1.0), 2.0) * vector
    return vectors


def _quaternion(rotations: FloatArray) -> FloatArray:
    """Unit quaternions (scalar first, ≥ 0), from the largest of four candidate components."""
    diagonal = np.diagonal(rotations, axis1=-2, axis2=-1)
    trace = diagonal.sum(-1)
    # 4 q qᵀ, which is linear in the matrix; any of its columns is parallel to q
    square = np.empty((*rotations.shape[:-2], 4, 4))
    square[..., 0, 0] = 1 + trace
    square[..., 1:, 1:] = rotations + np.swapaxes(rotations, -1, -2)
    square[..., [1, 2, 3], [1, 2, 3]] = 1 - trace[..., None] + 2 * diagonal
    axial = 2.0 * first_order(rotations)
    square[..., 0, 1:] = square[..., 1:, 0] = axial
    largest = np.argmax(np.diagonal(square, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(square, largest[..., None, None], axis=-1)[..., 0]
    column = column * np.where(column[..., :1] < 0, -1.0, 1.0)
    unit: FloatArray = column / np.linalg.norm(column, axis=-1, keepdims=True)
    return unit


def settled_spin(start: FloatArray, following: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Fixed point of a free block's spin at the end of a step, shape (b, k).

    A contraction of ratio about hω/2; where a block turns by more than a radian in a step the limit ends the
    iteration, and the step is merely less accurate.

    Parameters
    ----------
    start : Spins that it begins with, shape (b, k).
    following : Spins at the end by the turn that spins (b, k) make.
    """
    spin = start
    for _ in range(SPIN_ITERATIONS):
        updated = following(spin)
        missed, spin = np.abs(updated - spin).max(initial=0.0), updated
        if missed <= SPIN_TOLERANCE * np.abs(spin).max(initial=0.0):
            break
    return spin
