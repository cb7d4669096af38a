"""Voronoi: a box divided among points; each cell is the part of the box that is nearest to its point.

    tiling = Tiling.of(points, size)
    tiling.solid(0)                    # convex polytope of the first cell

Points are mirrored at the box's sides, so that the sides become faces of cells; cells share vertices.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import BOX_FACES, Polytope
from masonry_fem.solid.pose import FloatArray

SAME = 1e-9  # of the box: vertices that are nearer to each other are merged
INNER = "rubble"  # label of joints between cells
SIDES = {2: ("left", "right", "bottom", "top"), 3: BOX_FACES}
LABELS = {"left": "head", "right": "head", "bottom": "bed", "top": "bed"}


@dataclass(frozen=True, slots=True)
class Tiling:
    """A box, its lower corner at the origin, in convex cells.

    Attributes
    ----------
    points : What the cells belong to, shape (n, d) [m]. size : Of the box, shape (d,) [m].
    vertices : Corners of cells, shape (v, d) [m].
    faces : Loop of vertices of each face; in 3D about the normal from the first cell to the second.
    sides : Cells on both sides of each face, shape (f, 2); beyond the box's side s stands -1 - s, sides
        counted as left, right, (front, back,) bottom, top.
    """

    points: FloatArray
    size: FloatArray
    vertices: FloatArray
    faces: tuple[tuple[int, ...], ...]
    sides: IntArray

    @classmethod
    def of(cls, points: FloatArray, size: FloatArray) -> Tiling:
        """The tiling of points inside a box."""
        from scipy.spatial import Voronoi  # noqa: PLC0415  slow to load

        count, d = points.shape
        images = [points]
        for axis in range(d):
            for wall in (0.0, size[axis]):
                image = points.copy()
                image[:, axis] = 2 * wall - image[:, axis]
                images.append(image)
        diagram = Voronoi(np.concatenate(images))
        inside = diagram.ridge_points.min(axis=1) < count
        of_ridge = [diagram.ridge_vertices[i] for i in np.flatnonzero(inside)]
        pairs = np.sort(diagram.ridge_points[inside], axis=1)
        vertices, number = _merged(diagram.vertices, np.unique(np.concatenate(of_ridge)), size)
        faces, sides = [], []
        for ridge, (one, two) in zip(of_ridge, pairs.tolist(), strict=True):
            loop = np.array(sorted(set(number[ridge].tolist())))
            if len(loop) >= d:
                faces.append(in_order(vertices, loop, diagram.points[two] - diagram.points[one]))
                sides.append((one, two if two < count else -(two // count)))
        return cls(points, size, vertices, tuple(faces), np.array(sides))

    @property
    def cell_size(self) -> float:
        """The d-th root of a cell's mean volume [m]."""
        return float((self.size.prod() / len(self.points)) ** (1 / len(self.size)))

    def solids(self) -> list[Polytope]:
        """The cells, in the box's frame."""
        own: dict[int, list[tuple[tuple[int, ...], int]]] = defaultdict(list)
        for loop, (one, two) in zip(self.faces, self.sides.tolist(), strict=True):
            own[one].append((loop, two))
            if two >= 0:
                own[two].append((loop[::-1], one))
        names = SIDES[len(self.size)]
        return [self._solid(own[cell], names) for cell in range(len(self.points))]

    def _solid(self, faces: list[tuple[tuple[int, ...], int]], names: tuple[str, ...]) -> Polytope:
        used = sorted({vertex for loop, _ in faces for vertex in loop})
        number = {vertex: index for index, vertex in enumerate(used)}
        loops = tuple(tuple(number[vertex] for vertex in loop) for loop, _ in faces)
        called = tuple(names[-1 - other] if other < 0 else "" for _, other in faces)
        labels = tuple(LABELS.get(name, "") if name else INNER for name in called)
        return Polytope(self.vertices[used], loops, called, labels)

    def edges(self) -> IntArray:
        """Pairs of vertices that an edge of a cell joins, shape (e, 2)."""
        pairs = [
            pair for loop in self.faces for pair in zip(loop, (*loop[1:], loop[0]), strict=True)
        ]  # fmt: skip
        return np.unique(np.sort(np.array(pairs), axis=1), axis=0)


def _merged(vertices: FloatArray, used: IntArray, size: FloatArray) -> tuple[FloatArray, IntArray]:
    """Distinct vertices, exactly on the box's sides where they lie there; and the new number of each."""
    from scipy.sparse import coo_array  # noqa: PLC0415  slow to load
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415
    from scipy.spatial import cKDTree  # noqa: PLC0415

    places = vertices[used]
    for side in (np.zeros_like(size), size):
        places = np.where(np.abs(places - side) < SAME * size, side, places)
    near = cKDTree(places).query_pairs(SAME * float(size.max()), output_type="ndarray")
    graph = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(used), len(used)))
    count, label = connected_components(graph, directed=False)
    first = np.full(count, len(used))
    np.minimum.at(first, label, np.arange(len(used)))
    number = np.full(len(vertices), -1)
    number[used] = label
    return places[first], number


def in_order(vertices: FloatArray, loop: IntArray, outward: FloatArray) -> tuple[int, ...]:
    """Corners of a convex face in order, counter-clockwise as seen from outside.

    Parameters
    ----------
    vertices : All vertices, shape (v, d) [m].
    loop : Vertex numbers of the face in any order.
    outward : Outward normal, shape (d,).
    """
    places = vertices[loop]
    if len(outward) == 2:
        edge = places[1] - places[0]
        ahead = edge[1] * outward[0] - edge[0] * outward[1] > 0
        return tuple(int(v) for v in (loop if ahead else loop[::-1]))
    # projected along the largest component of its normal, the face stays convex
    across = int(np.argmax(np.abs(outward)))
    spokes = places - places.sum(axis=0) / len(places)
    angles = np.arctan2(spokes[:, across - 1], spokes[:, across - 2])
    order = np.argsort(angles if outward[across] > 0 else -angles)
    return tuple(loop[order].tolist())
