"""Clamp: a face of an elastic block whose nodes are held, or moved as prescribed.

Held degrees of freedom are no unknowns; the forces that they exert enter the right-hand side of the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.rotation import exponential
from masonry_fem.bodies.support import Motion
from masonry_fem.errors import GeometryError
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Faces = tuple[tuple[int, tuple[int, ...]], ...]

FIRST_STEP = 1e-6  # time over which a motion is differentiated where no step is known yet [s]


@dataclass(frozen=True, slots=True)
class Holds:
    """Which dofs of a shape its clamps hold; alike for all blocks of a group.

    Attributes
    ----------
    dofs : Held dofs, ascending, shape (c,).
    owner : Index of the clamp that holds each, the first that does, shape (c,).
    free : All other dofs, ascending.
    """

    dofs: IntArray
    owner: IntArray
    free: IntArray


def holds(mesh: Mesh, clamps: Faces, name: str) -> Holds:
    """The degrees of freedom that clamped faces of a block hold.

    Parameters
    ----------
    mesh : Elements of the block.
    clamps : Pairs (face number, held components); where two share a node, the first one holds it.
    name : Name of the block, for the error message.

    Raises
    ------
    GeometryError : A clamped face has no mesh facets.
    """
    total, d = mesh.points.size, mesh.dimension
    owner = np.full(total, -1)
    for index in reversed(range(len(clamps))):
        face, components = clamps[index]
        nodes = np.unique(mesh.facets[mesh.facet_face == face])
        if not nodes.size:
            raise GeometryError(
                f"block '{name}': clamped face {face} has no mesh facets, expected at least one; check that "
                "the mesh assigns its facets to the faces of the solid"
            )
        owner[(nodes[:, None] * d + np.array(components)).ravel()] = index
    dofs = np.flatnonzero(owner >= 0)
    return Holds(dofs, owner[dofs], np.flatnonzero(owner < 0))


class Clamping:
    """The clamps of a group of blocks and their prescribed motions.

    Parameters
    ----------
    mesh : The blocks' mesh.
    clamps : Held faces as (face, components in shape axes), alike for all blocks.
    motions : For each block one motion a clamp (None: held); None: all are held.
    rotation, translation : Poses of the blocks, shapes (b, d, d) and (b, d).
    name : Of the first block, for messages.

    Notes
    -----
    A motion is followed exactly in displacement for θ > ½; for θ = ½ that would leave an undamped
    zigzag in the velocity after each kink, so there the velocity is the central difference of the
    motion and the displacement follows it to O(h²).
    """

    def __init__(
        self,
        mesh: Mesh,
        clamps: Faces,
        motions: Sequence[Sequence[Motion | None]] | None,
        rotation: FloatArray,
        translation: FloatArray,
        name: str,
    ) -> None:
        self.faces = clamps
        self.holds = holds(mesh, clamps, name)
        self._start = np.zeros((len(rotation), len(self.holds.dofs)))
        self._moving = [
            _Moving.of(
                mesh, self.holds, clamps[index][0], index, row, motion, rotation[row], translation[row]
            )
            for row, own in enumerate(motions or ())
            for index, motion in enumerate(own)
            if motion is not None
        ]

    def starting_at(self, displacement: FloatArray) -> Clamping:
        """The same clamps with motions that go on from displacements of the held dofs, shape (b, c) [m]."""
        clamping = copy(self)
        clamping._start = displacement
        return clamping

    @property
    def moving(self) -> bool:
        """Whether any clamp moves."""
        return bool(self._moving)

    def displacement(self, time: float) -> FloatArray:
        """Prescribed displacement of the held dofs, shape axes, shape (b, c) [m]."""
        given = self._start.copy()
        for one in self._moving:
            given[one.row, one.columns] += one.displacement(time)
        return given

    def first_velocity(self) -> FloatArray:
        """Velocity of the held dofs just after time 0, shape (b, c) [m/s]."""
        return (self.displacement(FIRST_STEP) - self.displacement(0.0)) / FIRST_STEP

    def velocity(
        self, time: float, displacement: FloatArray, velocity: FloatArray, scheme: Scheme
    ) -> FloatArray:
        """Velocity of the held dofs at the end of a step from ``time``, shape (b, c) [m/s].

        ``displacement`` and ``velocity`` are theirs before it, shape (b, c).
        """
        h, theta = scheme.step, scheme.theta
        if not self._moving:
            return np.zeros_like(velocity)
        if theta == 0.5:
            return (self.displacement(time + 2 * h) - self.displacement(time)) / (2 * h)
        mean = (self.displacement(time + h) - displacement) / h
        return (mean - (1 - theta) * velocity) / theta


@dataclass(frozen=True, slots=True)
class _Moving:
    """One moving clamp of one block.

    Attributes
    ----------
    motion : How it moves. row : Block. rotation : Its pose's.
    columns : Which of the held dofs move with it. points : Their nodes, world axes, shape (k, d).
    components : Their components. pivot : About which it turns.
    """

    motion: Motion
    row: int
    rotation: FloatArray
    columns: IntArray
    points: FloatArray
    components: IntArray
    pivot: FloatArray

    @classmethod
    def of(
        cls,
        mesh: Mesh,
        held: Holds,
        face: int,
        index: int,
        row: int,
        motion: Motion,
        rotation: FloatArray,
        translation: FloatArray,
    ) -> Self:
        world = mesh.points @ rotation.T + translation
        columns = np.flatnonzero(held.owner == index)
        nodes, components = np.divmod(held.dofs[columns], mesh.dimension)
        everything = np.unique(mesh.facets[mesh.facet_face == face])
        pivot = (
            world[everything].mean(axis=0) if motion.pivot is None else np.asarray(motion.pivot, dtype=float)
        )
        return cls(motion, row, rotation, columns, world[nodes], components, pivot)

    def displacement(self, time: float) -> FloatArray:
        """Displacement of its dofs, shape axes, shape (k,) [m]."""
        shift = np.zeros_like(self.points)
        if self.motion.rotation is not None:
            turn = exponential(np.atleast_1d(np.asarray(self.motion.rotation(time), dtype=float)))
            shift += (self.points - self.pivot) @ (turn - np.eye(len(turn))).T
        if self.motion.displacement is not None:
            shift += np.asarray(self.motion.displacement(time), dtype=float)
        local: FloatArray = (shift @ self.rotation)[np.arange(len(shift)), self.components]
        return local
