"""Patch: an interface in its common plane, with the mesh facets of its two sides.

Plane coordinates are taken along (t1[, t2]) from the first corner of the interface's polygon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.clipping import depths, locate
from masonry_fem.contact.contacts import Interface, local_frames
from masonry_fem.contact.surface import FaceMesh, Surface
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.pose import FloatArray, Pose

TOLERANCE = 1e-6  # of the patch's size: how far outside a node still is on its edge


@dataclass(frozen=True, slots=True)
class Side:
    """One block at an interface.

    Attributes
    ----------
    block : Its number. surface : Its boundary. pose : Where it stands. face : The face that touches.
    """

    block: int
    surface: Surface
    pose: Pose
    face: int

    @property
    def mesh(self) -> Mesh | None:
        """Mesh of the block's shape."""
        return self.surface.mesh

    @property
    def facets(self) -> FaceMesh:
        """Mesh facets of the face."""
        return self.surface.face_meshes[self.face]


@dataclass(frozen=True, slots=True)
class Patch:
    """Interface in its common plane.

    Attributes
    ----------
    interface : What it shows.
    sides : Candidate and antagonist.
    frame : Rows (n, t1[, t2]), n from antagonist to candidate, shape (d, d).
    origin : Origin of the plane coordinates [m], shape (d,).
    polygon : Corners in plane coordinates, counter-clockwise (two ends in 2D), (k, d - 1) [m].
    """

    interface: Interface
    sides: tuple[Side, Side]
    frame: FloatArray
    origin: FloatArray
    polygon: FloatArray

    @classmethod
    def of(
        cls, assembly: Assembly, surfaces: tuple[Surface, ...], interface: Interface, frame: FloatArray
    ) -> Patch:
        """The patch of an interface."""
        first, second = (
            Side(block, surfaces[assembly.blocks.shape[block]], assembly.blocks[block].pose, face)
            for block, face in zip(interface.blocks, interface.faces, strict=True)
        )
        origin = interface.polygon[0]
        return cls(interface, (first, second), frame, origin, (interface.polygon - origin) @ frame[1:].T)

    def exchanged(self) -> Patch:
        """The same patch with candidate and antagonist exchanged."""
        return exchanged_all([self])[0]

    @property
    def size(self) -> float:
        """Largest extent of the polygon [m]."""
        return float((self.polygon.max(axis=0) - self.polygon.min(axis=0)).max())

    @property
    def degenerate(self) -> bool:
        """True where the blocks touch at a point or, in 3D, along an edge."""
        return self.interface.area == 0

    def flat(self, side: int, points: FloatArray) -> FloatArray:
        """Plane coordinates of points of one side's shape, shape (..., d - 1)."""
        result: FloatArray = (self.sides[side].pose.to_world(points) - self.origin) @ self.frame[1:].T
        return result

    def facet_polygons(self, side: int) -> FloatArray:
        """One side's mesh facets in the plane, counter-clockwise, shape (f, k, d - 1)."""
        polygons = self.flat(side, self.sides[side].facets.corners)
        # a candidate's facets look against the normal
        return np.ascontiguousarray(polygons[:, ::-1] if side == 0 else polygons)

    def facets_at(self, points: FloatArray) -> IntArray:
        """Mesh facets of both sides that carry plane points, −1 where unmeshed, shape (m, 2)."""
        return np.stack([self.facets_of_side(side, points) for side in (0, 1)], axis=1)

    def facets_of_side(self, side: int, points: FloatArray) -> IntArray:
        """Mesh facets of one side that carry plane points, −1 where unmeshed, shape (m,)."""
        if self.sides[side].mesh is None or len(self.sides[side].facets.facets) == 0:
            return np.full(len(points), -1)
        polygons = self.facet_polygons(side)
        rows = locate(polygons, np.ascontiguousarray(points), 1e-9 * float(np.abs(polygons).max()))
        facets: IntArray = self.sides[side].facets.facets[rows]
        return facets

    def holds(self, points: FloatArray) -> np.ndarray:
        """Whether plane points lie in the polygon or on its boundary, shape (m,)."""
        inside: np.ndarray = depths(self.polygon, np.ascontiguousarray(points)) >= -TOLERANCE * self.size
        return inside

    def nearest(self, points: FloatArray) -> FloatArray:
        """The points of the polygon's boundary nearest to plane points outside, shape (m, d - 1)."""
        if self.polygon.shape[1] == 1:
            return np.clip(points, self.polygon.min(axis=0), self.polygon.max(axis=0))
        along = np.roll(self.polygon, -1, axis=0) - self.polygon
        square = (along**2).sum(axis=1)
        away = points[:, None] - self.polygon
        share = np.einsum("mkp,kp->mk", away, along) / np.where(square > 0, square, 1.0)
        feet = self.polygon + np.clip(share, 0.0, 1.0)[:, :, None] * along
        best = np.linalg.norm(points[:, None] - feet, axis=2).argmin(axis=1)
        chosen: FloatArray = feet[np.arange(len(points)), best]
        return chosen


def exchanged_all(patches: Sequence[Patch]) -> list[Patch]:
    """Patches with candidates and antagonists exchanged."""
    frames = local_frames(-np.array([patch.frame[0] for patch in patches]))
    return [
        Patch(
            interface=patch.interface,
            sides=(patch.sides[1], patch.sides[0]),
            frame=frame,
            origin=patch.origin,
            polygon=(patch.interface.polygon[::-1] - patch.origin) @ frame[1:].T,
        )
        for patch, frame in zip(patches, frames, strict=True)
    ]
