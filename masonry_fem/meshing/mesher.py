"""Meshing: structured elements for a solid with six sides (four in 2D), straight, with arcs or in facets.

Divisions count along the shape's own axes: x, (y,) z for boxes; tangential, (depth,) radial for
voussoirs. Nodes are computed, not searched, so that equal bricks have equal nodes.
"""

from __future__ import annotations

import math
from itertools import permutations, product

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.meshing.cells import HEXAHEDRON, QUAD, TETRA_EDGES, TRIANGLE_EDGES, boundary_facets
from masonry_fem.records.structure import MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

DEFAULT_DIVISIONS = 2
DIVISIONS = 4  # elements along the longest side of an unstructured mesh, if the scene gives no size
MOST = 1e7  # elements of one shape: their matrices would take some ten gigabytes
CONCAVE = 0.05  # of its size: how far a corner of a six-sided solid stands out of a face to be concave


def refuse_many(shape: Shape, count: float) -> None:
    """Refuse so many elements of one shape that no memory holds them.

    Raises
    ------
    GeometryError : There would be so many.
    """
    if not count <= MOST:
        raise GeometryError(
            f"shape '{shape.name}' would have {count:.1e} elements, expected at most {MOST:.0e}; raise "
            "mesh.size, or lower mesh.divisions"
        )


def foreseen_cells(shape: Shape, settings: MeshSettings) -> float:
    """Expected number of cells of a shape; for simplices, the number of hexahedra that would fill it.

    Parameters
    ----------
    shape : The shape to mesh.
    settings : Element, and size or divisions.

    Raises
    ------
    GeometryError : The number exceeds any memory.
    """
    if _is_structured(shape):
        count = float(math.prod(_counts(shape, _corners(shape), settings)))
    else:
        longest = float(np.ptp(shape.solid.vertices, axis=0).max())
        size = settings.size or longest / (max(settings.divisions) if settings.divisions else DIVISIONS)
        count = float(shape.solid.mass_properties().volume)
        for _ in range(shape.solid.dimension):
            count /= size
    refuse_many(shape, count)
    return count


def mesh_shape(shape: Shape, settings: MeshSettings, dimension: int, faces: Polytope | None = None) -> Mesh:
    """Elements of one shape; the nodes on its arcs lie on the true arcs.

    Shapes with six faces (in 2D four sides) are meshed in a structured way. Other prisms and frusta get
    hexahedra if Q elements are wanted; all other solids get simplices from gmsh.

    Parameters
    ----------
    shape : The shape to mesh.
    settings : Element, and size or divisions.
    dimension : 2 or 3.
    faces : The solid whose faces facets lie on, if it is not the shape's own (``faceted``).

    Raises
    ------
    GeometryError : There would be more cells than any memory holds, or gmsh failed.
    """
    foreseen_cells(shape, settings)
    if not _is_structured(shape):
        if settings.elements[0] == "Q":
            from masonry_fem.meshing.extrusion import hexahedra_of, prism_of  # noqa: PLC0415  brings gmsh

            body = prism_of(shape.solid)
            if body is not None:
                return hexahedra_of(shape, body, settings)
        from masonry_fem.meshing.unstructured import simplices_of  # noqa: PLC0415  brings gmsh

        return simplices_of(shape, settings)
    order, simplices = int(settings.elements[1]), settings.elements[0] == "P"
    corners = _corners(shape)
    counts = _counts(shape, corners, settings)
    cells, grid = _cells(counts, order, simplices)
    points = _mapped(shape, corners, grid)
    used, inverse = np.unique(cells, return_inverse=True)
    points, cells = points[used], inverse.reshape(cells.shape)
    cell = {
        (2, 1, 0): "quad", (2, 2, 0): "quad9", (2, 1, 1): "triangle", (2, 2, 1): "triangle6",
        (3, 1, 0): "hexahedron", (3, 2, 0): "hexahedron27", (3, 1, 1): "tetra", (3, 2, 1): "tetra10",
    }[dimension, order, int(simplices)]  # fmt: skip
    facets = boundary_facets(cells, cell)
    return Mesh(points, cell, cells, facets, _faces_of(faces or shape.solid, points, facets, simplices))


def is_curved(shape: Shape) -> bool:
    """Whether the shape has curves that elements follow."""
    return bool(shape.arcs or shape.rails)


def divisions_along(shape: Shape, settings: MeshSettings) -> int:
    """Elements along the curves of a shape.

    Parameters
    ----------
    shape : One with curves.
    settings : Element, and size or divisions.
    """
    return _counts(shape, _corners(shape), settings)[0]


def along_curves(shape: Shape, shares: FloatArray) -> FloatArray:
    """Points of a shape's curves at shares of their length, in the order of its rails or arcs.

    Parameters
    ----------
    shape : One with curves, c in number.
    shares : Shape (s,).

    Returns
    -------
    Shape (c, s, d) [m].
    """
    corners = _corners(shape)
    d = corners.ndim
    at = []
    ends_of = [(rail[0], rail[-1]) for rail in shape.rails] or [(a, b) for a, b, _ in shape.arcs]
    for first, last in ends_of:
        one, two = np.argwhere(corners == first)[0], np.argwhere(corners == last)[0]
        grid = one + shares[:, None] * (two - one)
        at.append(_mapped(shape, corners, grid))
    return np.array(at).reshape(len(ends_of), len(shares), d)


def _is_structured(shape: Shape) -> bool:
    """Whether the shape is a (curved) hexahedron or quadrilateral."""
    solid, d = shape.solid, shape.solid.dimension
    sides = 2 * (d - 1)
    return bool(shape.arcs or shape.rails) or (
        len(solid.vertices) == 2**d
        and len(solid.faces) == 2 * d
        and all(len(face) == max(2, sides) for face in solid.faces)
        and _is_convex(solid)
    )


def _is_convex(solid: Polytope) -> bool:
    """Whether no corner stands out of a face's plane, but for warped faces."""
    size = float(np.ptp(solid.vertices, axis=0).max())
    return all(
        ((solid.vertices - solid.face_points(face)[0]) @ solid.normal(face)).max() <= CONCAVE * size
        for face in range(len(solid.faces))
    )


def _corners(shape: Shape) -> IntArray:
    """Vertex at each corner of the unit cell, shape (2,) * d."""
    solid, d = shape.solid, shape.solid.dimension
    ends_of = [(rail[0], rail[-1]) for rail in shape.rails]
    for (a, b, _), (c, e, _) in zip(shape.arcs[::2], shape.arcs[1::2], strict=True):
        ends_of += [(a, b), (e, c)]
    if ends_of:  # by depth, radial, tangential
        curved = np.array(ends_of).reshape(-1, 2, 2)
        return curved[0].T if d == 2 else curved.transpose(2, 0, 1)
    return _box_corners(solid)


def _box_corners(solid: Polytope) -> IntArray:
    """Vertex at each corner of the unit cell of a solid with as many vertices, shape (2,) * d."""
    d = solid.dimension
    beside: dict[int, set[int]] = {vertex: set() for vertex in range(2**d)}
    for face in solid.faces:
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            beside[a].add(b)
            beside[b].add(a)
    first = int(np.argmin((solid.vertices / np.ptp(solid.vertices, axis=0)).sum(axis=1)))
    along = solid.vertices - solid.vertices[first]
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    near = max(permutations(sorted(beside[first])), key=lambda p: sum(along[v, i] for i, v in enumerate(p)))
    corners = np.full((2,) * d, first)
    for axis, vertex in enumerate(near):
        corners[tuple(np.eye(d, dtype=int)[axis])] = vertex
    known = {first, *near}
    for place in sorted(product((0, 1), repeat=d), key=sum)[1 + d :]:
        lower = (corners[*place[:i], 0, *place[i + 1 :]] for i in range(d) if place[i])
        (corners[place],) = set.intersection(*(beside[int(vertex)] for vertex in lower)) - known
        known.add(int(corners[place]))
    return corners


def _counts(shape: Shape, corners: IntArray, settings: MeshSettings) -> tuple[int, ...]:
    d = corners.ndim
    if settings.divisions is not None:
        if len(settings.divisions) != d:
            raise GeometryError(
                f"mesh.divisions is {settings.divisions}, expected {d} numbers; give one for each axis"
            )
        return _whole_parts(shape, tuple(settings.divisions))
    if settings.size is None:
        return _whole_parts(shape, (DEFAULT_DIVISIONS,) * d)
    places = shape.solid.vertices[corners]
    lengths = [float(np.linalg.norm(np.diff(places, axis=i), axis=-1).max()) for i in range(d)]
    if shape.arcs:
        a, b, centre = shape.arcs[1]
        chord = np.linalg.norm(shape.solid.vertices[a] - shape.solid.vertices[b])
        radius = np.linalg.norm(shape.solid.vertices[a] - np.array(centre))
        lengths[0] = float(2 * radius * np.arcsin(min(1.0, chord / (2 * radius))))
    if shape.rails:
        steps = [np.diff(shape.solid.vertices[list(rail)], axis=0) for rail in shape.rails]
        lengths[0] = max(float(np.linalg.norm(step, axis=1).sum()) for step in steps)
    refuse_many(shape, math.prod(max(1.0, length / settings.size) for length in lengths))
    counts = tuple(max(1, int(np.ceil(length / settings.size - 1e-9))) for length in lengths)
    return _whole_parts(shape, counts)


def _whole_parts(shape: Shape, counts: tuple[int, ...]) -> tuple[int, ...]:
    """Divisions with nodes at the kinks of a shape's rails: as many or a few more along them."""
    return (-(-counts[0] // shape.parts) * shape.parts, *counts[1:])


def _cells(counts: tuple[int, ...], order: int, simplices: bool) -> tuple[IntArray, FloatArray]:
    """Cells on the grid of corner and middle nodes, and the grid's places in the unit cell."""
    d = len(counts)
    axes = [np.arange(2 * n + 1) for n in counts]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, d)
    sizes = tuple(2 * n + 1 for n in counts)
    starts = 2 * np.stack(np.meshgrid(*[np.arange(n) for n in counts], indexing="ij"), -1).reshape(-1, d)
    local = np.array(_simplices(d, order) if simplices else [(QUAD if d == 2 else HEXAHEDRON)], int)
    if order == 1 and not simplices:
        local = local[:, : 2**d]
    places = starts[:, None, None] + local[None]
    numbers = np.ravel_multi_index(tuple(np.moveaxis(places, -1, 0)), sizes)
    return numbers.reshape(-1, local.shape[1]), grid / (2 * np.array(counts))


def _simplices(d: int, order: int) -> list[list[tuple[int, ...]]]:
    """The cell cut along its diagonal (Kuhn), each simplex positive."""
    made = []
    for path in permutations(range(d)):
        places = [np.zeros(d, int)]
        for axis in path:
            places.append(places[-1] + 2 * np.eye(d, dtype=int)[axis])
        if np.linalg.det(np.array(places[1:]) - places[0]) < 0:
            places[1], places[2] = places[2], places[1]
        middle = [(places[a] + places[b]) // 2 for a, b in (TETRA_EDGES if d == 3 else TRIANGLE_EDGES)]
        made.append([tuple(int(c) for c in p) for p in (places + middle if order == 2 else places)])
    return made


def _mapped(shape: Shape, corners: IntArray, grid: FloatArray) -> FloatArray:
    """Positions of grid places: multilinear, polar about the arcs' centre, or between rails."""
    places, d = shape.solid.vertices[corners], corners.ndim
    if shape.arcs:
        flat = [0, d - 1]  # the arch's plane; the depth is straight
        centre = np.array(shape.arcs[0][2])[flat]
        plane = places.reshape(2, -1, 2, d)[:, 0][:, :, flat] - centre
        radii = np.linalg.norm(plane[0], axis=1)
        angle = np.arctan2(plane[..., 0], plane[..., 1])[:, 0]
        radius = radii[0] * (1 - grid[:, -1]) + radii[1] * grid[:, -1]
        turn = angle[0] * (1 - grid[:, 0]) + angle[1] * grid[:, 0]
        points = np.zeros((len(grid), d))
        points[:, 0], points[:, -1] = centre[0] + radius * np.sin(turn), centre[1] + radius * np.cos(turn)
        if d == 3:
            points[:, 1] = places[0, 0, 0, 1] * (1 - grid[:, 1]) + places[0, 1, 0, 1] * grid[:, 1]
        return points
    if shape.rails:
        return _railed(shape, grid)
    points = np.zeros((len(grid), d))
    for place in product((0, 1), repeat=d):
        weight = np.prod(np.where(np.array(place), grid, 1 - grid), axis=1)
        points += weight[:, None] * places[place]
    return points


def _railed(shape: Shape, grid: FloatArray) -> FloatArray:
    """Positions of grid places: along the rails by their vertices, linear between the rails."""
    points = np.zeros(grid.shape)
    for rail, place in zip(shape.rails, product((0, 1), repeat=grid.shape[1] - 1), strict=True):
        chain = shape.solid.vertices[list(rail)]
        along = grid[:, 0] * (len(chain) - 1)
        first = np.minimum(along.astype(int), len(chain) - 2)
        rest = (along - first)[:, None]
        weight = np.prod(np.where(np.array(place), grid[:, 1:], 1 - grid[:, 1:]), axis=1)
        points += weight[:, None] * ((1 - rest) * chain[first] + rest * chain[first + 1])
    return points


def _faces_of(solid: Polytope, points: FloatArray, facets: IntArray, simplices: bool) -> IntArray:
    """Face whose plane each facet lies on; on arcs the flat facet nearest in direction."""
    d = solid.dimension
    corner = points[facets[:, : d if simplices else 2 ** (d - 1)]]
    if d == 2:
        edge = corner[:, 1] - corner[:, 0]
        normal = np.column_stack([edge[:, 1], -edge[:, 0]])
    else:
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, -1] - corner[:, 0])
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    faces = range(len(solid.faces))
    outward = np.array([solid.normal(f) for f in faces])
    middle = np.array([solid.face_points(f).mean(axis=0) for f in faces])
    away = corner.mean(axis=1)[:, None] - middle[None]
    size = np.ptp(solid.vertices, axis=0).max()
    score = (1 - normal @ outward.T) * size + np.abs(np.einsum("fgd,gd->fg", away, outward))
    return np.asarray(np.argmin(score + 1e-6 * np.linalg.norm(away, axis=2), axis=1))
