"""Motion: rigid velocities of all blocks of a model at an instant, the mean ones of blocks that deform.

    motion = BlockMotion.of_step(march.last, march.model)
    motion.velocity[k], motion.spin[k]        # of block k, at motion.centre[k]

``PointMotion`` takes them to the contact points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import by_block
from masonry_fem.bodies.rotation import lever, spin_count
from masonry_fem.march.model import Model
from masonry_fem.march.step import Increment
from masonry_fem.nscd.graphs import lengths

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class BlockMotion:
    """Velocities of the b blocks of an assembly, supports included.

    Attributes
    ----------
    centre : Points that they are of, shape (b, d) [m].
    velocity : shape (b, d) [m/s]. spin : shape (b, 1 or 3) [rad/s].
    held : True for supports, shape (b,).
    corners : Corners or nodes of each block, where they are, shapes (n, d) [m].
    """

    centre: FloatArray
    velocity: FloatArray
    spin: FloatArray
    held: NDArray[np.bool_]
    corners: tuple[FloatArray, ...]

    @classmethod
    def of_step(cls, made: Increment, model: Model) -> BlockMotion:
        """Velocities that a step ended with, at the places where it began: a fall may lead far."""
        return cls.of(model, made.after.bodies, made.before.bodies)

    @classmethod
    def of(cls, model: Model, bodies: Sequence[Any], places: Sequence[Any]) -> BlockMotion:
        """Velocities of given body states, with the blocks where they are in the states ``places``."""
        count, d = len(model.assembly.blocks), model.assembly.dimension
        centre, velocity = np.zeros((count, d)), np.zeros((count, d))
        spin, held = np.zeros((count, spin_count(d))), np.zeros(count, dtype=bool)
        corners: list[FloatArray] = [np.zeros((0, d))] * count
        for group, state, place in zip(model.groups, bodies, places, strict=True):
            own, points = group.blocks, group.positions(place)
            held[own] = group.prescribed
            for block, part in zip(own.tolist(), by_block(group, points), strict=True):
                corners[block] = part
            sizes = np.array([len(corners[block]) for block in own.tolist()])
            centre[own], velocity[own], spin[own] = _rigid(points, group.velocities(state, place), sizes)
        return cls(centre, velocity, spin, held, tuple(corners))

    def at(self, blocks: IntArray, points: FloatArray) -> FloatArray:
        """Velocity of ``blocks`` (k,) at points (k, d), shape (k, d) [m/s]."""
        arms = lever(points - self.centre[blocks])
        moved: FloatArray = self.velocity[blocks] + np.einsum("kij,kj->ki", arms, self.spin[blocks])
        return moved

    def speeds(self) -> FloatArray:
        """Speed of the fastest corner of each block, shape (b,) [m/s]."""
        found = np.zeros(len(self.centre))
        for block, corners in enumerate(self.corners):
            own = np.full(len(corners), block)
            found[block] = lengths(self.at(own, corners)).max(initial=0.0)
        return found

    def fastest(self) -> float:
        """Speed of the fastest corner of all [m/s]."""
        return float(self.speeds().max(initial=0.0))

    def moves(self, rest: float) -> NDArray[np.bool_]:
        """Blocks with a corner faster than ``rest``, shape (b,)."""
        moving: NDArray[np.bool_] = self.speeds() > rest
        return moving

    def scaled(self, factor: float) -> BlockMotion:
        """The same motion, ``factor`` times as fast."""
        return replace(self, velocity=factor * self.velocity, spin=factor * self.spin)


@dataclass(frozen=True, slots=True)
class PointMotion:
    """Contact points that a motion is looked at: where, in which frames, and which are not open.

    Attributes
    ----------
    at : shape (c, d) [m]. frame : rows (n, t1[, t2]), shape (c, d, d).
    active : False where a point stands open before the motion begins, shape (c,).
    """

    at: FloatArray
    frame: FloatArray
    active: NDArray[np.bool_]

    def relative(self, motion: BlockMotion, blocks: IntArray) -> FloatArray:
        """Velocity of the first of the ``blocks`` (c, 2) against the second, local frames, (c, d) [m/s]."""
        jump = motion.at(blocks[:, 0], self.at) - motion.at(blocks[:, 1], self.at)
        local: FloatArray = np.einsum("cij,cj->ci", self.frame, jump)
        return local


def greatest_shift(model: Model, before: Sequence[Any], after: Sequence[Any]) -> float:
    """How far the fastest corner of the free blocks goes from one set of body states to another [m].

    Parameters
    ----------
    model : The structure.
    before, after : Body states, one a group in the model's order.
    """
    far = 0.0
    for group, old, new in zip(model.groups, before, after, strict=True):
        if not group.prescribed:
            shift = group.displacements(new) - group.displacements(old)
            far = max(far, float(lengths(shift).max(initial=0.0)))
    return far


def _rigid(
    points: FloatArray, field: FloatArray, sizes: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Middles of the points of b blocks, (b, d), and the rigid motions nearest to fields on them.

    Points and field have shape (v, d), ``sizes`` (b,) of them a block; the motions are velocities of the
    middles, (b, d), and spins, (b, 1 or 3).
    """
    starts, owner = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(sizes)), sizes)
    middle, mean = (np.add.reduceat(values, starts) / sizes[:, None] for values in (points, field))
    arms = lever(points - middle[owner])
    matrix = np.add.reduceat(np.einsum("vij,vik->vjk", arms, arms), starts)
    right = np.add.reduceat(np.einsum("vij,vi->vj", arms, field - mean[owner]), starts)
    return middle, mean, np.linalg.solve(matrix, right[..., None])[..., 0]


def nearest_motions(model: Model, bodies: tuple[Any, ...]) -> tuple[FloatArray, FloatArray]:
    """The rigid motions x = R X + t that come nearest to what blocks have done, (b, d, d), (b, d) [m].

    Parameters
    ----------
    model : The structure of b blocks.
    bodies : Body states, one a group.
    """
    count, d = len(model.assembly.blocks), model.assembly.dimension
    rotation, translation = np.tile(np.eye(d), (count, 1, 1)), np.zeros((count, d))
    for group, state in zip(model.groups, bodies, strict=True):
        rotation[group.blocks], translation[group.blocks] = group.motion(state)
    return rotation, translation
