"""Scatter: compiled additions of dense contributions to block-sparse matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled


@compiled
def add_dense(
    indptr: NDArray[np.int32],
    indices: NDArray[np.int32],
    data: NDArray[np.float64],
    contacts: NDArray[np.int64],
    matrix: NDArray[np.float64],
    symmetric: bool,
) -> None:
    """Add a matrix between s contacts, or its symmetric part, to its (d, d) blocks.

    Parameters
    ----------
    indptr, indices, data : Block-sparse matrix that is added to, its columns sorted; ``data`` (k, d, d).
    contacts : Contacts that the matrix is of, shape (s,).
    matrix : What is added, shape (s d, s d). symmetric : Only its symmetric part.
    """
    d = data.shape[1]
    for a in range(len(contacts)):
        first, last = indptr[contacts[a]], indptr[contacts[a] + 1]
        row = indices[first:last]
        for b in range(len(contacts)):
            at = first + np.searchsorted(row, contacts[b])
            for i in range(d):
                for j in range(d):
                    there, back = matrix[a * d + i, b * d + j], matrix[b * d + j, a * d + i]
                    data[at, i, j] += 0.5 * (there + back) if symmetric else there


@compiled
def take_dense(
    indptr: NDArray[np.int32],
    indices: NDArray[np.int32],
    data: NDArray[np.float64],
    contacts: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Dense matrices between the contacts of each of n sets, zero where nothing is stored, (n, k d, k d).

    Parameters
    ----------
    indptr, indices, data : Block-sparse matrix, its columns sorted; ``data`` (stored, d, d).
    contacts : The sets, shape (n, k).
    """
    n, k = contacts.shape
    d = data.shape[1]
    taken = np.zeros((n, k * d, k * d))
    for number in range(n):
        for a in range(k):
            first, last = indptr[contacts[number, a]], indptr[contacts[number, a] + 1]
            row = indices[first:last]
            for b in range(k):
                at = np.searchsorted(row, contacts[number, b])
                if at < len(row) and row[at] == contacts[number, b]:
                    for i in range(d):
                        for j in range(d):
                            taken[number, a * d + i, b * d + j] = data[first + at, i, j]
    return taken


@compiled
def add_within(
    taken: NDArray[np.float64],
    number: NDArray[np.int64],
    place: NDArray[np.int64],
    turns: NDArray[np.float64],
    matrices: NDArray[np.float64],
    kind: NDArray[np.int64],
) -> None:
    """Add T M Tᵀ of stones to dense matrices of sets of contacts, within each set.

    Parameters
    ----------
    taken : What is added to, a matrix for each set, shape (g, k d, k d).
    number, place : Set of each stone's s contacts, −1 for those in none, and place in it, shape (n, s).
    turns : T of each contact, shape (n, s, d, d).
    matrices : M by kind of stone, shape (m, s d, s d). kind : Of each stone, shape (n,).
    """
    n, s, d, _ = turns.shape
    for stone in range(n):
        matrix = matrices[kind[stone]]
        for a in range(s):
            at = number[stone, a]
            if at < 0:
                continue
            for b in range(s):
                if number[stone, b] != at:
                    continue
                row, column = d * place[stone, a], d * place[stone, b]
                block = taken[at, row : row + d, column : column + d]
                if d == 3:  # the compiler unrolls loops whose length it knows: half the time
                    _add_turned(block, turns, matrix, stone, a, b, 3)
                else:
                    _add_turned(block, turns, matrix, stone, a, b, 2)


@compiled
def add_own(
    blocks: NDArray[np.float64],
    contacts: NDArray[np.int64],
    turns: NDArray[np.float64],
    matrices: NDArray[np.float64],
    kind: NDArray[np.int64],
) -> None:
    """Add T M Tᵀ of stones to the contacts' own blocks.

    Parameters
    ----------
    blocks : What is added to, shape (c, d, d).
    contacts : At the s sides of each stone, −1 for none, shape (n, s).
    turns, matrices, kind : As for ``add_within``.
    """
    n, s, d, _ = turns.shape
    for stone in range(n):
        matrix = matrices[kind[stone]]
        for side in range(s):
            if contacts[stone, side] >= 0:
                _add_turned(blocks[contacts[stone, side]], turns, matrix, stone, side, side, d)


@compiled(inline="always")
def _add_turned(
    block: NDArray[np.float64],
    turns: NDArray[np.float64],
    matrix: NDArray[np.float64],
    stone: int,
    a: int,
    b: int,
    d: int,
) -> None:
    """Add T_a M_ab T_bᵀ of two sides of a stone to a block (d, d)."""
    for i in range(d):
        for q in range(d):
            turned = 0.0
            for p in range(d):
                turned += turns[stone, a, i, p] * matrix[a * d + p, b * d + q]
            for j in range(d):
                block[i, j] += turned * turns[stone, b, j, q]


@compiled
def put_blocks(
    values: NDArray[np.float64],
    first: NDArray[np.int64],
    length: NDArray[np.int64],
    blocks: NDArray[np.float64],
) -> None:
    """Write dense blocks into the values of a sparse matrix whose rows are stored one after another.

    Parameters
    ----------
    values : Those of the matrix.
    first : Where each block's first entry stands in them, shape (k,).
    length : Stored entries of its rows, shape (k,).
    blocks : Shape (k, height, width).
    """
    for k in range(len(first)):
        for i in range(blocks.shape[1]):
            at = first[k] + i * length[k]
            for j in range(blocks.shape[2]):
                values[at + j] = blocks[k, i, j]


@compiled
def put_columns(
    indices: NDArray[np.int32],
    first: NDArray[np.int64],
    length: NDArray[np.int64],
    columns: NDArray[np.int64],
    height: int,
    width: int,
) -> None:
    """Write the columns of dense blocks into the indices of a sparse matrix.

    Parameters
    ----------
    indices : Those of the matrix.
    first, length : As for ``put_blocks``, shape (k,).
    columns : Of the blocks' first entries, shape (k,).
    height, width : Size of the blocks.
    """
    for k in range(len(first)):
        for i in range(height):
            at = first[k] + i * length[k]
            for j in range(width):
                indices[at + j] = columns[k] + j
