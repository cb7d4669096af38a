"""Transfer: the compiled products with blocks, with the rigid map B and between axes, contact after contact.

A solver makes several of each every step, and the blocks are too small for BLAS.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@compiled
def block_inverses(blocks: FloatArray) -> tuple[FloatArray, bool]:
    """Inverses of small blocks by elimination with pivots from their columns, and whether all have one.

    Parameters
    ----------
    blocks : Shape (n, d, d).
    """
    n, d, _ = blocks.shape
    inverse, left = np.zeros((n, d, d)), np.empty((d, d))
    for number in range(n):
        own = inverse[number]
        for i in range(d):
            own[i, i] = 1.0
            for j in range(d):
                left[i, j] = blocks[number, i, j]
        for k in range(d):
            pivot = k
            for i in range(k + 1, d):
                if abs(left[i, k]) > abs(left[pivot, k]):
                    pivot = i
            if left[pivot, k] == 0.0:
                return inverse, False
            for j in range(d):
                left[k, j], left[pivot, j] = left[pivot, j], left[k, j]
                own[k, j], own[pivot, j] = own[pivot, j], own[k, j]
            scale = 1.0 / left[k, k]
            for j in range(d):
                left[k, j] *= scale
                own[k, j] *= scale
            for i in range(d):
                factor = left[i, k]
                if i != k and factor != 0.0:
                    for j in range(d):
                        left[i, j] -= factor * left[k, j]
                        own[i, j] -= factor * own[k, j]
    return inverse, True


@compiled
def block_products(first: FloatArray, second: FloatArray) -> FloatArray:
    """What ``products.multiplied`` explains, shape (n, r, t).

    Parameters
    ----------
    first : Shape (n, r, s). second : Shape (n, s, t).
    """
    n, r, s = first.shape
    t = second.shape[2]
    product = np.empty((n, r, t))
    for number in range(n):
        for i in range(r):
            for j in range(t):
                total = 0.0
                for k in range(s):
                    total += first[number, i, k] * second[number, k, j]
                product[number, i, j] = total
    return product


@compiled
def to_contacts(bodies: IntArray, maps: FloatArray, motion: FloatArray) -> FloatArray:
    """B U of body velocities, shape (c, d).

    Parameters
    ----------
    bodies : Bodies at the two sides, −1 for none, shape (c, 2).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    motion : U, shape (b, m).
    """
    velocity = np.zeros((len(maps), maps.shape[2]))
    add_moved(bodies, maps, motion, velocity)
    return velocity


@compiled
def add_moved(bodies: IntArray, maps: FloatArray, motion: FloatArray, velocity: FloatArray) -> None:
    """Add B U of body velocities.

    Parameters
    ----------
    bodies, maps, motion : As for ``to_contacts``. velocity : Of contacts; it is added to, shape (c, d).
    """
    c, _, d, m = maps.shape
    moved = np.empty(d)  # first the sum of both sides: a motion that they share leaves nothing
    for contact in range(c):
        moved[:] = 0.0
        for side in range(2):
            body = bodies[contact, side]
            if body < 0:
                continue
            of_side, of_body = maps[contact, side], motion[body]
            for i in range(d):
                total = 0.0
                for a in range(m):
                    total += of_side[i, a] * of_body[a]
                moved[i] += total
        for i in range(d):
            velocity[contact, i] += moved[i]


@compiled
def to_bodies(bodies: IntArray, maps: FloatArray, impulse: FloatArray, count: int) -> FloatArray:
    """Bᵀ p of contact impulses, shape (b, m).

    Parameters
    ----------
    bodies : Bodies at the two sides, −1 for none, shape (c, 2).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    impulse : p, shape (c, d).
    count : Number b of bodies.
    """
    c, _, d, m = maps.shape
    total = np.zeros((count, m))
    for contact in range(c):
        for side in range(2):
            body = bodies[contact, side]
            if body < 0:
                continue
            for a in range(m):
                given = 0.0
                for i in range(d):
                    given += maps[contact, side, i, a] * impulse[contact, i]
                total[body, a] += given
    return total


@compiled
def _to_stones(contacts: IntArray, turns: FloatArray, impulse: FloatArray) -> tuple[FloatArray, IntArray]:
    """Impulses at the sides of stones in the stones' axes, 0 where no contact takes part, and on which.

    Parameters
    ----------
    contacts : Contacts at the s sides of each of n stones, −1 for none, shape (n, s).
    turns : From the stone's axes to the contact's frame, shape (n, s, d, d).
    impulse : In the contacts' frames, shape (c, d).

    Returns
    -------
    Those of the k stones that have some, shape (k, s d), and the numbers of these, shape (k,).
    """
    n, s, d, _ = turns.shape
    turned, pushed, count = np.zeros((n, s * d)), np.empty(n, dtype=np.int64), 0
    for stone in range(n):
        some = False
        for side in range(s):
            contact = contacts[stone, side]
            if contact < 0:
                continue
            for j in range(d):
                total = 0.0
                for i in range(d):
                    total += impulse[contact, i] * turns[stone, side, i, j]
                turned[count, side * d + j] = total
                some |= total != 0.0
        if some:
            pushed[count] = stone
            count += 1
    return turned[:count], pushed[:count]


@compiled
def _add_from_stones(
    contacts: IntArray, turns: FloatArray, stones: IntArray, moved: FloatArray, velocity: FloatArray
) -> None:
    """Add velocities at the sides of stones to those of contacts.

    Parameters
    ----------
    contacts, turns : As for ``_to_stones``. stones : Numbers of some stones, shape (k,).
    moved : Of these in the stones' axes, shape (k, s d).
    velocity : In the contacts' frames; it is added to, shape (c, d).
    """
    s, d = turns.shape[1:3]
    for row in range(len(stones)):
        stone = stones[row]
        for side in range(s):
            contact = contacts[stone, side]
            if contact < 0:
                continue
            for i in range(d):
                total = 0.0
                for j in range(d):
                    total += turns[stone, side, i, j] * moved[row, side * d + j]
                velocity[contact, i] += total


@compiled
def add_products(
    contacts: IntArray,
    turns: FloatArray,
    matrices: FloatArray,
    kind: IntArray,
    impulse: FloatArray,
    velocity: FloatArray,
) -> None:
    """Add velocities of contacts from the impulses on each of n stones with s sides.

    Parameters
    ----------
    contacts, turns : As for ``_to_stones``.
    matrices : Velocities from impulses by kind of stone, shape (k, s d, s d).
    kind : Of each stone, those of one kind one after another, shape (n,).
    impulse : In the contacts' frames, shape (c, d).
    velocity : The same; it is added to.
    """
    first = 0
    while first < len(kind):
        last = first + 1
        while last < len(kind) and kind[last] == kind[first]:
            last += 1
        its = contacts[first:last], turns[first:last]
        pressed, stones = _to_stones(*its, impulse)
        matrix = matrices[kind[first]]
        if len(stones) == 1:
            _add_from_stones(*its, stones, np.dot(matrix, pressed[0]).reshape(1, -1), velocity)
        elif len(stones):
            _add_from_stones(*its, stones, np.dot(pressed, matrix.T), velocity)
        first = last


@compiled
def largest_side(maps: FloatArray, impulse: FloatArray) -> float:
    """Largest ‖B_isᵀ p_i‖, what a contact gives to the rigid modes on one of its sides; nan where one is.

    Parameters
    ----------
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    impulse : p, shape (c, d).
    """
    largest = 0.0
    for contact in range(len(impulse)):
        for side in range(2):
            square = _side_square(maps[contact, side], impulse[contact])
            if not square <= largest:
                largest = square
            if largest != largest:  # noqa: PLR0124 - nan
                return largest
    return math.sqrt(largest)


@compiled
def side_size(maps: FloatArray, impulse: FloatArray) -> float:
    """Norm of what all contacts give to the rigid modes on all sides.

    Parameters
    ----------
    maps, impulse : As for ``largest_side``.
    """
    total = 0.0
    for contact in range(len(impulse)):
        for side in range(2):
            total += _side_square(maps[contact, side], impulse[contact])
    return math.sqrt(total)


@compiled(inline="always")
def _side_square(maps: FloatArray, impulse: FloatArray) -> float:
    """‖Bᵀ p‖² of a side, from B (d, m) and p (d,)."""
    square = 0.0
    for a in range(maps.shape[1]):
        given = 0.0
        for i in range(maps.shape[0]):
            given += maps[i, a] * impulse[i]
        square += given * given
    return square


@compiled
def column_squares(bodies: IntArray, maps: FloatArray, count: int) -> FloatArray:
    """Squares of the lengths of the columns of B, shape (b, m).

    Parameters
    ----------
    bodies, maps, count : As for ``to_bodies``.
    """
    c, _, d, m = maps.shape
    total = np.zeros((count, m))
    for contact in range(c):
        for side in range(2):
            body = bodies[contact, side]
            if body < 0:
                continue
            for a in range(m):
                square = 0.0  # of one side: its sum is rounded before it is added
                for i in range(d):
                    square += maps[contact, side, i, a] * maps[contact, side, i, a]
                total[body, a] += square
    return total


@compiled
def longest(rows: FloatArray) -> float:
    """Euclidean length of the longest row of an array (n, k), 0 of none; nan where one is."""
    count, columns = rows.shape
    largest = 0.0
    for row in range(count):
        square = 0.0
        for column in range(columns):
            square += rows[row, column] * rows[row, column]
        if not square <= largest:
            largest = square
        if largest != largest:  # noqa: PLR0124 - nan
            return largest
    return math.sqrt(largest)


@compiled
def row_lengths(rows: FloatArray) -> FloatArray:
    """Euclidean lengths of the rows of an array (n, k), shape (n,)."""
    count, columns = rows.shape
    found = np.empty(count)
    for row in range(count):
        square = 0.0
        for column in range(columns):
            square += rows[row, column] * rows[row, column]
        found[row] = math.sqrt(square)
    return found


@compiled
def rigid_blocks(bodies: IntArray, maps: FloatArray, mass: FloatArray) -> FloatArray:
    """Diagonal blocks of B M_r⁻¹ Bᵀ with unit mass where M_r = 0, shape (c, d, d).

    Parameters
    ----------
    bodies : Bodies at the two sides, −1 for none, shape (c, 2).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    mass : Diagonal of M_r, shape (b, m).
    """
    c, _, d, m = maps.shape
    blocks = np.zeros((c, d, d))
    for contact in range(c):
        for side in range(2):
            body = bodies[contact, side]
            if body < 0:
                continue
            for i in range(d):
                for j in range(d):
                    total = 0.0
                    for a in range(m):
                        inverse = 1.0 / mass[body, a] if mass[body, a] > 0 else 1.0
                        total += maps[contact, side, i, a] * inverse * maps[contact, side, j, a]
                    blocks[contact, i, j] += total
    return blocks
