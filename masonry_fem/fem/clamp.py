"""Clamp: a face of an elastic block whose nodes are held, or moved as prescribed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.rotation import exponential
from masonry_fem.bodies.support import Motion
from masonry_fem.errors import GeometryError
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Clamp:
    """A held face of an elastic block.

    Attributes
    ----------
    face : Polytope face.
    components : Held world axes; None: all.
    motion : How it moves (about the mean of the face's nodes unless it has a pivot); None: not.
    """

    face: int
    components: tuple[int, ...] | None = None
    motion: Motion | None = None


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


def holds(mesh: Mesh, clamps: tuple[tuple[int, tuple[int, ...]], ...], name: str) -> Holds:
    """The dofs held by clamps given as (face, components).

    Raises
    ------
    GeometryError
        If a clamped face has no mesh facets; ``name`` is the block's, for the message.
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


def moved(motion: Motion, points: FloatArray, time: float) -> FloatArray:
    """Displacement of world points (k, d) under a prescribed motion [m]."""
    shift = np.zeros_like(points)
    if motion.rotation is not None:
        pivot = points.mean(axis=0) if motion.pivot is None else motion.pivot
        turn = exponential(np.atleast_1d(np.asarray(motion.rotation(time), dtype=float)))
        shift += (points - pivot) @ (turn - np.eye(points.shape[1])).T
    if motion.displacement is not None:
        shift += np.asarray(motion.displacement(time), dtype=float)
    return shift
