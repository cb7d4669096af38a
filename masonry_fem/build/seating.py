"""Seating: stones that are new in a structure are set down where the stones that they touch have moved.

    bodies = seated(model, bodies, known)

Each is moved as a rigid body that fits the motion of what it touches best, in the mean over its contacts, so
that it lies flush and has no strain. What touches only new stones follows once these are set down.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.march.coupling import Coupling, connect
from masonry_fem.march.model import Model

SLIGHT = 1e-6  # of a contact's place: the turn of the stone there, which decides where places do not


@dataclass(frozen=True, slots=True)
class _Touched:
    """What k contacts tell of stones that are still to be set down.

    Attributes
    ----------
    block : The stone, shape (k,). point : Of it in the reference, shape (k, d) [m].
    place : Where the other stone's motion takes it, shape (k, d) [m]. turn : Of the other stone, (k, d, d).
    """

    block: IntArray
    point: FloatArray
    place: FloatArray
    turn: FloatArray


def seated(model: Model, bodies: tuple[Any, ...], known: NDArray[np.bool_]) -> tuple[Any, ...]:
    """Body states with all stones set down that touch others, directly or through new ones.

    Parameters
    ----------
    model : The structure of b blocks.
    bodies : States of its groups, new stones in their reference places.
    known : Blocks whose place is known, shape (b,); supports always are.
    """
    placed = known.copy()
    for group in model.groups:
        if group.prescribed:
            placed[group.blocks] = True
    coupling = connect(model)
    while not placed.all():
        told = _touched(coupling, bodies, placed)
        fresh = np.unique(told.block)
        if not len(fresh):
            break  # they touch nothing that has moved
        rotation, shift = _fitted(told, fresh, model.length)
        where = np.full(len(placed), -1)
        where[fresh] = np.arange(len(fresh))
        states = []
        for group, state in zip(model.groups, bodies, strict=True):
            rows = np.flatnonzero(where[group.blocks] >= 0)
            own = where[group.blocks[rows]]
            states.append(group.set_down(state, rows, rotation[own], shift[own]) if len(rows) else state)
        bodies = tuple(states)
        placed[fresh] = True
    return bodies


def _touched(coupling: Coupling, bodies: tuple[Any, ...], placed: NDArray[np.bool_]) -> _Touched:
    """Contacts of stones that are not placed with others that are."""
    contacts = coupling.model.contacts
    d = contacts.dimension
    moved = np.zeros((contacts.count, 2, d))
    turned = np.zeros((contacts.count, 2, d, d))
    for sides, attachment, state in zip(coupling.sides, coupling.attachments, bodies, strict=True):
        moved[sides.contact, sides.side] = attachment.displacements(state)
        turned[sides.contact, sides.side] = attachment.rotations(state)
    parts = []
    for own, other in ((0, 1), (1, 0)):
        met = ~placed[contacts.blocks[:, own]] & placed[contacts.blocks[:, other]]
        point = contacts.points[met, own]
        parts.append((contacts.blocks[met, own], point, point + moved[met, other], turned[met, other]))
    return _Touched(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _fitted(told: _Touched, blocks: IntArray, length: float) -> tuple[FloatArray, FloatArray]:
    """The rigid motions x = R X + t of stones that take their contacts nearest to their places.

    Parameters
    ----------
    told : Contacts of the stones. blocks : Their numbers in order, shape (s,).
    length : Size of a block [m].

    Returns
    -------
    Shapes (s, d, d) and (s, d) [m].

    References
    ----------
    W. Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Cryst. A 32 (1976).
    """
    row, d = np.searchsorted(blocks, told.block), told.point.shape[1]
    count = np.bincount(row, minlength=len(blocks)).astype(float)

    def mean(values: FloatArray) -> FloatArray:
        total = np.zeros((len(blocks), *values.shape[1:]))
        np.add.at(total, row, values)
        averaged: FloatArray = total / count.reshape(-1, *[1] * (values.ndim - 1))
        return averaged

    before, after = mean(told.point), mean(told.place)
    spread = (told.place - after[row])[:, :, None] * (told.point - before[row])[:, None, :]
    left, _, right = np.linalg.svd(mean(spread + SLIGHT * length**2 * told.turn))
    mirror = np.ones((len(blocks), d))
    mirror[:, -1] = np.sign(np.linalg.det(left) * np.linalg.det(right))
    rotation = (left * mirror[:, None, :]) @ right
    return rotation, after - np.einsum("sij,sj->si", rotation, before)
