"""Motions: compiled loops over undeformed blocks and over the contact sides that touch them.

A step asks for them several times. On some dozens of blocks NumPy's calls cost more than the arithmetic.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@compiled
def spun(
    axes: FloatArray, scale: FloatArray, start: FloatArray, step: float, theta: float, most: int, near: float
) -> FloatArray:
    """Scaled spins at the end of a step in which nothing acts on the blocks, shape (b, 3) [kg^½ m/s].

    The angular momentum L = E √J U_r is constant while the axes E turn with the θ-mean of the spin. This
    implicit equation is solved by a fixed point, a contraction of ratio about hω/2.

    Parameters
    ----------
    axes : Principal axes E at the start, as columns, shape (b, 3, 3).
    scale : √J, shape (b, 3) [kg^½ m].
    start : Scaled spins U_r at the start, shape (b, 3) [kg^½ m/s].
    step : Length h of the step [s].
    theta : Weight θ of its end.
    most : Iterations at most: where a block turns by more than a radian they may not settle, and the step is
        merely less accurate.
    near : Change, of the largest spin of the block, that ends them.
    """
    end = np.empty_like(start)
    momentum, turn, turned = np.empty(3), np.empty(3), np.empty(3)
    for block in range(len(start)):
        own = axes[block]
        for r in range(3):
            momentum[r] = 0.0
            for i in range(3):
                momentum[r] += own[r, i] * scale[block, i] * start[block, i]
        spin = start[block].copy()
        for _ in range(most):
            for r in range(3):
                turn[r] = 0.0
                for i in range(3):
                    mean = (1 - theta) * start[block, i] + theta * spin[i]
                    turn[r] += step * own[r, i] * mean / scale[block, i]
            _turned_back(turn, momentum, turned)
            missed = largest = 0.0
            for i in range(3):
                updated = 0.0
                for r in range(3):
                    updated += own[r, i] * turned[r]
                updated /= scale[block, i]
                missed = max(missed, abs(updated - spin[i]))
                largest = max(largest, abs(updated))
                spin[i] = updated
            if missed <= near * largest:
                break
        end[block] = spin
    return end


@compiled
def _turned_back(turn: FloatArray, vector: FloatArray, out: FloatArray) -> None:
    """Rᵀ x into ``out``, R being the rotation by a vector (3,) [rad] (Rodrigues)."""
    sine, versine = _shares(turn)
    x = turn[1] * vector[2] - turn[2] * vector[1]
    y = turn[2] * vector[0] - turn[0] * vector[2]
    z = turn[0] * vector[1] - turn[1] * vector[0]
    out[0] = vector[0] - sine * x + versine * (turn[1] * z - turn[2] * y)
    out[1] = vector[1] - sine * y + versine * (turn[2] * x - turn[0] * z)
    out[2] = vector[2] - sine * z + versine * (turn[0] * y - turn[1] * x)


@compiled
def _shares(turn: FloatArray) -> tuple[float, float]:
    """sin(a)/a and (1 − cos a)/a² of a rotation vector as long as a [rad]; nothing cancels in them."""
    angle = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
    if angle == 0:
        return 1.0, 0.5
    half = math.sin(0.5 * angle) / (0.5 * angle)
    return math.sin(angle) / angle, 0.5 * half * half


@compiled
def turns(vectors: FloatArray) -> FloatArray:
    """R − 1 of rotation vectors in 3D, shape (k, 3, 3) for (k, 3) [rad]."""
    changed = np.empty((len(vectors), 3, 3))
    axial = np.zeros((3, 3))
    for row in range(len(vectors)):
        vector = vectors[row]
        sine, versine = _shares(vector)
        axial[0, 1], axial[0, 2], axial[1, 2] = -vector[2], vector[1], -vector[0]
        axial[1, 0], axial[2, 0], axial[2, 1] = vector[2], -vector[1], vector[0]
        for i in range(3):
            for j in range(3):
                square = 0.0
                for k in range(3):
                    square += axial[i, k] * axial[k, j]
                changed[row, i, j] = sine * axial[i, j] + versine * square
    return changed


@compiled
def side_maps(
    frames: FloatArray, arms: FloatArray, axes: FloatArray, scale: FloatArray, body: IntArray
) -> FloatArray:
    """Velocity, in the frames, at contact sides for unit U of their blocks, shape (k, d, m).

    Parameters
    ----------
    frames : Rows (n, t1[, t2]) of each side, shape (k, d, d).
    arms : From the block's centre to the contact, world axes, shape (k, d) [m].
    axes : Axes that spins are about, as columns, shape (b, 3, 3); in 2D not used.
    scale : √ of the diagonal of the mass matrix of velocities and spins, shape (b, m).
    body : Block of each side, shape (k,).
    """
    k, d = arms.shape
    m = scale.shape[1]
    maps = np.empty((k, d, m))
    about = np.empty(3)
    for side in range(k):
        own, arm, frame, block = scale[body[side]], arms[side], frames[side], body[side]
        for row in range(d):
            n = frame[row]
            for column in range(d):
                maps[side, row, column] = n[column] / own[column]
            if d == 2:
                maps[side, row, 2] = (n[1] * arm[0] - n[0] * arm[1]) / own[2]
                continue
            about[0] = arm[1] * n[2] - arm[2] * n[1]
            about[1] = arm[2] * n[0] - arm[0] * n[2]
            about[2] = arm[0] * n[1] - arm[1] * n[0]
            for column in range(3):
                total = 0.0
                for axis in range(3):
                    total += about[axis] * axes[block, axis, column]
                maps[side, row, 3 + column] = total / own[3 + column]
    return maps


@compiled
def add_velocities(
    velocity: FloatArray,
    contact: IntArray,
    side: IntArray,
    body: IntArray,
    maps: FloatArray,
    rigid: FloatArray,
) -> None:
    """Add what rigid velocities of blocks give at contact sides to velocities (c, d) of the contacts.

    Parameters
    ----------
    velocity : What is added to, shape (c, d) [m/s].
    contact, side, body : Of each of the sides, shape (k,).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    rigid : U of the blocks, shape (b, m).
    """
    _, _, d, m = maps.shape
    for k in range(len(contact)):
        own, given = maps[contact[k], side[k]], rigid[body[k]]
        for i in range(d):
            total = 0.0
            for a in range(m):
                total += own[i, a] * given[a]
            velocity[contact[k], i] += total


@compiled
def given_impulses(
    contact: IntArray, side: IntArray, body: IntArray, maps: FloatArray, impulse: FloatArray, count: int
) -> FloatArray:
    """Bᵀ p on ``count`` blocks, of the contact sides that are theirs, shape (b, m).

    Parameters
    ----------
    contact, side, body : Of each of the sides, shape (k,).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    impulse : p, shape (c, d) [N s].
    """
    _, _, d, m = maps.shape
    total = np.zeros((count, m))
    for k in range(len(contact)):
        own, push = maps[contact[k], side[k]], impulse[contact[k]]
        for a in range(m):
            given = 0.0
            for i in range(d):
                given += own[i, a] * push[i]
            total[body[k], a] += given
    return total


@compiled
def carried(turned: FloatArray, shift: FloatArray, arms: FloatArray, body: IntArray) -> FloatArray:
    """How far material points of blocks have gone, shift + (R − 1) arm, shape (k, d) [m].

    Parameters
    ----------
    turned : R − 1 of the blocks, shape (b, d, d). shift : How far their centres have gone, (b, d) [m].
    arms : From the centre to the point in the reference, shape (k, d) [m].
    body : Block of each point, shape (k,).
    """
    k, d = arms.shape
    moved = np.empty((k, d))
    for point in range(k):
        for i in range(d):
            total = 0.0
            for j in range(d):
                total += turned[body[point], i, j] * arms[point, j]
            moved[point, i] = shift[body[point], i] + total
    return moved


@compiled
def by_block(matrices: FloatArray, blocks: IntArray, vectors: FloatArray) -> FloatArray:
    """Products of the blocks' matrices with vectors, each with that of its block, shape (k, i).

    Parameters
    ----------
    matrices : Of the blocks, shape (b, i, j). blocks : Of each vector, shape (k,). vectors : Shape (k, j).
    """
    (k, columns), rows = vectors.shape, matrices.shape[1]
    products = np.empty((k, rows))
    for number in range(k):
        for i in range(rows):
            total = 0.0
            for j in range(columns):
                total += matrices[blocks[number], i, j] * vectors[number, j]
            products[number, i] = total
    return products


@compiled
def each_turned(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Products of blocks' matrices with vectors of their own, shape (b, n, d).

    Parameters
    ----------
    matrices : Shape (b, d, d). vectors : Shape (b, n, d).
    """
    b, n, d = vectors.shape
    products = np.empty((b, n, d))
    for block in range(b):
        for row in range(n):
            for i in range(d):
                total = 0.0
                for j in range(d):
                    total += matrices[block, i, j] * vectors[block, row, j]
                products[block, row, i] = total
    return products


@compiled
def turned_frames(frames: FloatArray, matrices: FloatArray, blocks: IntArray) -> FloatArray:
    """Products of frames with the matrices of their blocks, shape (k, d, d).

    Parameters
    ----------
    frames : Shape (k, d, d). matrices : Of the blocks, shape (b, d, d). blocks : Of each frame, shape (k,).
    """
    k, d, _ = frames.shape
    turned = np.empty((k, d, d))
    for number in range(k):
        for i in range(d):
            for j in range(d):
                total = 0.0
                for inner in range(d):
                    total += frames[number, i, inner] * matrices[blocks[number], inner, j]
                turned[number, i, j] = total
    return turned


@compiled
def put_maps(maps: FloatArray, contact: IntArray, side: IntArray, local: FloatArray) -> None:
    """Put what blocks give at contact sides into the rigid map, negative at antagonists.

    Parameters
    ----------
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    contact, side : Of each of the sides, shape (k,). local : Without signs, shape (k, d, m).
    """
    k, d, m = local.shape
    for number in range(k):
        sign = 1.0 - 2.0 * side[number]
        for i in range(d):
            for a in range(m):
                maps[contact[number], side[number], i, a] = sign * local[number, i, a]


@compiled
def add_signed(velocity: FloatArray, contact: IntArray, side: IntArray, local: FloatArray) -> None:
    """Add velocities of contact sides (k, d) to those of contacts (c, d), negative at antagonists.

    Parameters
    ----------
    velocity : What is added to, shape (c, d). contact, side : Of each of the sides, shape (k,).
    local : Shape (k, d).
    """
    for number in range(len(contact)):
        sign = 1.0 - 2.0 * side[number]
        for i in range(local.shape[1]):
            velocity[contact[number], i] += sign * local[number, i]


@compiled
def moments(arms: FloatArray, forces: FloatArray) -> FloatArray:
    """Moment ``arm × force``, shape (k, 1 or 3) [N m].

    Parameters
    ----------
    arms : From the centre to where the forces act, shape (k, d) [m]. forces : Shape (k, d) [N].
    """
    k, d = arms.shape
    result = np.empty((k, 1 if d == 2 else 3))
    for row in range(k):
        a, f = arms[row], forces[row]
        if d == 2:
            result[row, 0] = a[0] * f[1] - a[1] * f[0]
        else:
            result[row, 0] = a[1] * f[2] - a[2] * f[1]
            result[row, 1] = a[2] * f[0] - a[0] * f[2]
            result[row, 2] = a[0] * f[1] - a[1] * f[0]
    return result


@compiled
def turned_moments(force: FloatArray, rotation: FloatArray) -> FloatArray:
    """Moments of force arrays about the centres of blocks that have turned, shape (b, 1 or 3) [N m].

    Parameters
    ----------
    force : Force F and dyadic Σ r ⊗ f of arms in the reference, by block, shape (b, d + d²).
    rotation : R of the blocks, shape (b, d, d).
    """
    b, d, _ = rotation.shape
    result = np.empty((b, 1 if d == 2 else 3))
    dyadic = np.empty((d, d))
    for block in range(b):
        for i in range(d):
            for j in range(d):
                dyadic[i, j] = 0.0
                for k in range(d):
                    dyadic[i, j] += rotation[block, i, k] * force[block, d + d * k + j]
        if d == 2:
            result[block, 0] = dyadic[0, 1] - dyadic[1, 0]
        else:
            result[block, 0] = dyadic[1, 2] - dyadic[2, 1]
            result[block, 1] = dyadic[2, 0] - dyadic[0, 2]
            result[block, 2] = dyadic[0, 1] - dyadic[1, 0]
    return result


@compiled
def wrenches(blocks: IntArray, arms: FloatArray, force: FloatArray, count: int) -> FloatArray:
    """Forces and moments about the origin that contacts give to each of ``count`` blocks, shape (b, m).

    Parameters
    ----------
    blocks : Candidate and antagonist of each contact, shape (c, 2).
    arms : Where the force acts on each of them, shape (c, 2, d) [m].
    force : On the candidate, world axes; its opposite acts on the antagonist, shape (c, d) [N].
    """
    c, _, d = arms.shape
    total = np.zeros((count, 3 if d == 2 else 6))
    for contact in range(c):
        f = force[contact]
        for side in range(2):
            own, a, sign = total[blocks[contact, side]], arms[contact, side], 1.0 - 2.0 * side
            for axis in range(d):
                own[axis] += sign * f[axis]
            if d == 2:
                own[2] += sign * (a[0] * f[1] - a[1] * f[0])
            else:
                own[3] += sign * (a[1] * f[2] - a[2] * f[1])
                own[4] += sign * (a[2] * f[0] - a[0] * f[2])
                own[5] += sign * (a[0] * f[1] - a[1] * f[0])
    return total
