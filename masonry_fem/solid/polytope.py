"""Polytope: a block's solid, bounded by flat faces (a polygon bounded by edges in 2D).

    cube = Polytope.box((0, 0, 0), (1, 1, 1))
    cube.mass_properties().volume          # 1.0
    cube.normal(0), cube.face_points(0)

It need not be convex. Faces carry names (what loads and supports refer to) and joint labels
(what joint laws refer to: ``bed``, ``head``, ``radial`` ...).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.solid.pose import FloatArray, Pose

BOX_FACES = ("left", "right", "front", "back", "bottom", "top")


@dataclass(frozen=True, slots=True)
class MassProperties:
    """Volume [m³; m² in 2D], centroid [m] and second moments about it for unit density.

    Attributes
    ----------
    volume : Measure of the solid, per unit of depth in 2D.
    centroid : shape (d,).
    inertia : Inertia tensor about the centroid for unit density, shape (3, 3); in 2D shape
        (1, 1), the polar second moment of area [m⁵; m⁴ in 2D].
    """

    volume: float
    centroid: FloatArray
    inertia: FloatArray


@dataclass(frozen=True, slots=True)
class Polytope:
    """Solid bounded by flat polygons (a polygon in 2D), in the frame of its shape.

    Attributes
    ----------
    vertices : Corner points [m], shape (v, d).
    faces : Vertex loops, counter-clockwise seen from outside in 3D; in 2D each face is an edge
        (a, b) that has the solid on its left (the outline runs counter-clockwise).
    names : Name of each face ("" where it has none), by which scenes select faces.
    labels : Joint label of each face ("" where it has none), by which scenes select joints.
    """

    vertices: FloatArray
    faces: tuple[tuple[int, ...], ...]
    names: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    dimension: int = field(init=False)

    def __post_init__(self) -> None:
        blank = ("",) * len(self.faces)
        object.__setattr__(self, "names", self.names or blank)
        object.__setattr__(self, "labels", self.labels or blank)
        object.__setattr__(self, "dimension", self.vertices.shape[1])

    @classmethod
    def box(cls, low: tuple[float, ...], high: tuple[float, ...]) -> Polytope:
        """Axis-aligned box (rectangle in 2D) with faces left, right, (front, back,) bottom and top.

        Left and right are labelled ``head``, bottom and top ``bed``.

        Parameters
        ----------
        low, high : Its corners of smallest and of largest coordinates [m].

        Raises
        ------
        GeometryError : The corners do not have two or three coordinates each.
        """
        if len(low) != len(high) or len(low) not in (2, 3):
            raise GeometryError(
                f"a box from {[*map(float, low)]} to {[*map(float, high)]}, expected corners of two or three "
                "coordinates each; correct the structure that makes it"
            )
        (a, b), d = (np.array(low, float), np.array(high, float)), len(low)
        if d == 2:
            corners = np.array([[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]])
            return cls(
                corners,
                ((3, 0), (1, 2), (0, 1), (2, 3)),
                ("left", "right", "bottom", "top"),
                ("head", "head", "bed", "bed"),
            )
        corners = np.array(
            [[(a, b)[i][0], (a, b)[j][1], (a, b)[k][2]] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
        )
        loops = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
        return cls(corners, loops, BOX_FACES, ("head", "head", "", "", "bed", "bed"))

    def face_points(self, face: int) -> FloatArray:
        """Corner points of one face in loop order, shape (k, d) [m]."""
        return self.vertices[list(self.faces[face])]

    def normal(self, face: int) -> FloatArray:
        """Outward unit normal of one face, shape (d,)."""
        area = self.area_vector(face)
        return area / np.linalg.norm(area)

    def area_vector(self, face: int) -> FloatArray:
        """Outward normal times the face's area [m²; m in 2D], shape (d,)."""
        points = self.face_points(face)
        if self.dimension == 2:
            edge = points[1] - points[0]
            return np.array([edge[1], -edge[0]])
        spokes = points - points[0]
        return 0.5 * np.cross(spokes[1:-1], spokes[2:]).sum(axis=0)

    def mass_properties(self) -> MassProperties:
        """Exact volume, centroid and inertia for unit density, by the divergence theorem."""
        origin = self.vertices.mean(axis=0)
        points = self.vertices - origin
        simplices = np.array(
            [(loop[0], *pair) for loop in self.faces for pair in pairwise(loop[1:])]
            if self.dimension == 3
            else self.faces
        )
        corners = points[simplices]  # each with the origin spans one signed simplex
        volumes = np.linalg.det(corners) / (6 if self.dimension == 3 else 2)
        volume = volumes.sum()
        total = corners.sum(axis=1)
        centroid = (volumes[:, None] * total).sum(axis=0) / (volume * (self.dimension + 1))
        # ∫ x xᵀ over a simplex with one corner at the origin: V/((d+1)(d+2)) (Σ xᵢxᵢᵀ + s sᵀ)
        d = self.dimension
        second = np.einsum("t,tia,tib->ab", volumes, corners, corners)
        second += np.einsum("t,ta,tb->ab", volumes, total, total)
        second = second / ((d + 1) * (d + 2)) - volume * np.outer(centroid, centroid)
        trace = np.trace(second)
        inertia = trace * np.eye(3) - second if d == 3 else np.array([[trace]])
        return MassProperties(float(volume), centroid + origin, inertia)

    def moved(self, pose: Pose) -> Polytope:
        """The same solid after a rigid motion."""
        return Polytope(pose.to_world(self.vertices), self.faces, self.names, self.labels)
