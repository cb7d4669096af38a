"""Macroblocks: hundreds of blocks that move a little apart, as the few bodies that one sees moving.

    found = macroblocks(points, velocity, owner)
    found.member[k]       # of block k: the group that it moves with; -1: by itself

Just above a collapse nearly every joint of a wall opens or slides a little, and parts that move exactly as
one are single stones. What engineers call macro-blocks moves nearly as one: few rigid motions, to each of
which many blocks come within a share of the fastest corner's speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.rotation import lever
from masonry_fem.nscd.graphs import lengths

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

ALIKE = 0.1  # of the greatest speed: what comes so near to a rigid motion takes part in it
MOST = 6  # groups that one can keep in mind
LEFT = 0.05  # of the blocks: so few may move by themselves
LEADERS = 50  # blocks whose motions are tried for a group of its own
ROUNDS = 12  # of fitting motions and choosing among them anew


@dataclass(frozen=True, slots=True)
class Macroblocks:
    """Groups of b blocks, the largest first.

    Attributes
    ----------
    member : Group of each block, −1 where it moves by itself, shape (b,).
    velocity : Of the groups' points that lie at the origin, shape (g, d) [m/s].
    spin : Of the groups, shape (g, 1 or 3) [rad/s].
    """

    member: IntArray
    velocity: FloatArray
    spin: FloatArray


def macroblocks(points: FloatArray, velocity: FloatArray, owner: IntArray) -> Macroblocks:
    """As few groups as nearly all blocks move with to ``ALIKE``, at most ``MOST``, the largest first.

    Parameters
    ----------
    points : Corners of the blocks, shape (n, d) [m]. velocity : There, shape (n, d) [m/s].
    owner : Block of each corner, 0 to b − 1, every one at least once, shape (n,).
    """
    count = int(owner.max()) + 1
    middle = points.mean(axis=0)
    size = float(lengths(points - middle).max()) or 1.0
    field = _field((points - middle) / size)
    fastest = float(lengths(velocity).max()) or 1.0
    flat = velocity / fastest
    motions = np.stack([_fit(field, flat)])
    while True:
        motions, member, misfit = _settled(field, flat, owner, motions, count)
        strays = misfit > ALIKE
        if strays.sum() <= LEFT * count or len(motions) == MOST:
            break
        motions = np.concatenate([motions, _leader(field, flat, owner, strays)[None]])
    member[strays] = -1
    group, number = np.unique(member[~strays], return_counts=True)
    group = group[number > 1]
    order = group[np.argsort(-number[number > 1], kind="stable")]
    rank = np.full(len(motions) + 1, -1)  # the last for those by themselves
    rank[order] = np.arange(len(order))
    motions = fastest * motions[order]
    d = points.shape[1]
    spin = motions[:, d:] / size
    at_origin = motions[:, :d] - np.einsum("ij,kj->ki", lever(middle), spin)
    return Macroblocks(rank[member], at_origin, spin)


def _leader(field: FloatArray, velocity: FloatArray, owner: IntArray, strays: Mask) -> FloatArray:
    """The motion of that stray which most of the others follow."""
    own = strays[owner]
    field, velocity, owner = field[own], velocity[own], owner[own]
    numbers = np.flatnonzero(strays)
    best, most = np.zeros(field.shape[2]), 0
    for lead in numbers[:: max(1, len(numbers) // LEADERS)].tolist():
        motion = _fit(field[owner == lead], velocity[owner == lead])
        apart = np.zeros(len(strays))
        np.maximum.at(apart, owner, lengths(velocity - field @ motion))
        followers = int((apart[numbers] <= ALIKE).sum())
        if followers > most:
            best, most = motion, followers
    return best


def _field(points: FloatArray) -> FloatArray:
    """What unit velocities and spins give at points, shape (n, d, d + 1 or 3)."""
    n, d = points.shape
    return np.concatenate([np.broadcast_to(np.eye(d), (n, d, d)), lever(points)], axis=2)


def _fit(field: FloatArray, velocity: FloatArray) -> FloatArray:
    """The rigid motion nearest to velocities, shape (d + 1 or 3,)."""
    columns = field.shape[2]
    motion: FloatArray = np.linalg.lstsq(field.reshape(-1, columns), velocity.ravel(), rcond=None)[0]
    return motion


def _settled(
    field: FloatArray, velocity: FloatArray, owner: IntArray, motions: FloatArray, count: int
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Each block with the motion nearest to its own, and motions that fit their blocks."""
    member = np.full(count, -1)
    for _ in range(ROUNDS):
        apart = np.zeros((len(motions), count))
        for group, motion in enumerate(motions):
            np.maximum.at(apart[group], owner, lengths(velocity - field @ motion))
        before, member = member, apart.argmin(axis=0)
        if np.array_equal(before, member):
            break
        near = apart[member, np.arange(count)] <= 2 * ALIKE  # strays do not pull at a motion
        for group in range(len(motions)):
            own = ((member == group) & near)[owner]
            if own.any():
                motions[group] = _fit(field[own], velocity[own])
    return motions, member, apart[member, np.arange(count)]
