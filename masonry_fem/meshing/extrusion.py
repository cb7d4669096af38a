"""Extrusion: hexahedra for prisms and frusta: the base is meshed with quadrilaterals, then swept in layers.

body = prism_of(shape.solid)            # None where it is no prism
mesh = hexahedra_of(shape, body, settings)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from masonry_fem.meshing.cells import HEXAHEDRON, QUAD, boundary_facets, turned
from masonry_fem.meshing.mesher import DIVISIONS
from masonry_fem.meshing.session import elements_of, node_positions, session
from masonry_fem.records.structure import MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

SAME = 1e-9  # of the sweep: by how much corners of the top may be apart from where their base is swept to
LAYERS = 2  # if the scene gives no size


@dataclass(frozen=True, slots=True)
class Prism:
    """A base swept along straight lines to a top that is its affine image, as a smaller or a tilted one is.

    Attributes
    ----------
    base, top : Faces at its ends. loop : Corners of the base, counter-clockwise seen along the sweep.
    sides : Face on each side of the loop, from corner i to i + 1.
    sweep : From the loop's first corner to the top, shape (3,) [m].
    plane : Unit vectors along and across the base, right-handed seen along the sweep, shape (2, 3).
    spread : By what the sweep changes with the way along each of them from that corner, shape (2, 3).
    """

    base: int
    top: int
    loop: tuple[int, ...]
    sides: tuple[int, ...]
    sweep: FloatArray
    plane: FloatArray
    spread: FloatArray


def prism_of(solid: Polytope) -> Prism | None:
    """Base and sweep of a prism or a frustum; of several possible bases the last face; of others None."""
    count = len(solid.vertices) // 2
    if solid.dimension == 2 or len(solid.vertices) != 2 * count or len(solid.faces) != count + 2:
        return None
    for base in reversed(range(len(solid.faces))):
        own = set(solid.faces[base])
        if len(own) != count or len(solid.faces[base]) != count:
            continue
        found = _swept(solid, base, own)
        if found is not None:
            return found
    return None


def _swept(solid: Polytope, base: int, own: set[int]) -> Prism | None:
    loop = solid.faces[base][::-1]
    top = next((face for face, other in enumerate(solid.faces) if own.isdisjoint(other)), None)
    if top is None:
        return None
    between = dict(enumerate(solid.faces))
    del between[base], between[top]
    if any(len(corners) != 4 for corners in between.values()):
        return None
    mate, side = _risen(between, own)
    if len(mate) != len(loop) or len(side) != len(loop):
        return None
    at, plane = solid.vertices[list(loop)], _plane(solid, base)
    sweep, flat = solid.vertices[[mate[v] for v in loop]] - at, (at - at[0]) @ plane.T
    spread = np.linalg.lstsq(flat, sweep - sweep[0])[0]
    if np.abs(sweep - sweep[0] - flat @ spread).max() > SAME * np.linalg.norm(sweep[0]):
        return None
    pairs = zip(loop, (*loop[1:], loop[0]), strict=True)
    sides = tuple(side[frozenset(pair)] for pair in pairs)
    return Prism(base, top, loop, sides, sweep[0], plane, spread)


def _risen(
    between: dict[int, tuple[int, ...]], own: set[int]
) -> tuple[dict[int, int], dict[frozenset[int], int]]:
    """Corner above each of the base's ``own`` ones, and face on each of its sides."""
    mate: dict[int, int] = {}
    side: dict[frozenset[int], int] = {}
    for face, corners in between.items():
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            if (a in own) != (b in own):
                below, above = (a, b) if a in own else (b, a)
                mate[below] = above
            elif a in own:
                side[frozenset((a, b))] = face
    return mate, side


def hexahedra_of(shape: Shape, body: Prism, settings: MeshSettings) -> Mesh:
    """Hexahedra of a prism or frustum: gmsh meshes its base with quadrilaterals, which are swept in layers.

    Parameters
    ----------
    shape : The shape to mesh.
    body : Its base and sweep, from ``prism_of``.
    settings : Element order, and size or divisions.

    Raises
    ------
    GeometryError : gmsh failed.
    """
    order = int(settings.elements[1])
    size, layers = _sizes(shape.solid, body, settings)
    origin = shape.solid.vertices[body.loop[0]]
    flat = (shape.solid.vertices[list(body.loop)] - origin) @ body.plane.T
    with session(f"shape '{shape.name}'") as gmsh:
        lines = _quadrilaterals(gmsh, flat, size, order)
        found = elements_of(gmsh, 2, [tag for _, tag in gmsh.model.getEntities(2)], shape.name)
        assert found is not None  # gmsh fails rather than leave a polygon empty
        tags, points = node_positions(gmsh)
        side_of = {
            tuple(sorted(row)): side
            for side, line in zip(body.sides, lines, strict=True)
            for row in _ends(gmsh, line, shape.name)
        }
    used, quads = np.unique(found.nodes, return_inverse=True)
    quads = quads.reshape(found.nodes.shape)
    base = points[np.searchsorted(tags, used), :2]
    quads = _upright(quads, base, found.kind)
    cells = _layered(quads, len(base), layers, order)
    levels = np.arange(order * layers + 1) / (order * layers)
    nodes = origin + base @ body.plane + levels[:, None, None] * (body.sweep + base @ body.spread)
    cell = "hexahedron" if order == 1 else "hexahedron27"
    facets = boundary_facets(cells, cell)
    owner = _owners(facets[:, :4], used, order * layers, body, side_of)
    return Mesh(nodes.reshape(-1, 3), cell, cells, facets, owner)


def _sizes(solid: Polytope, body: Prism, settings: MeshSettings) -> tuple[float, int]:
    """Wanted edge of the base's elements [m], and number of layers."""
    longest = float(np.ptp(solid.vertices[list(body.loop)], axis=0).max())
    depth = float(np.linalg.norm(body.sweep))
    if settings.divisions is not None and len(settings.divisions) == 3:
        axis = int(np.abs(body.sweep).argmax())
        across = [number for at, number in enumerate(settings.divisions) if at != axis]
        return longest / max(across), settings.divisions[axis]
    if settings.size is not None:
        return settings.size, max(1, int(np.ceil(depth / settings.size - 1e-9)))
    return longest / DIVISIONS, LAYERS


def _plane(solid: Polytope, base: int) -> FloatArray:
    """Unit vectors along and across a face, right-handed seen from behind it, shape (2, 3)."""
    normal = -solid.normal(base)
    first = np.cross(np.eye(3)[int(np.abs(normal).argmin())], normal)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def _quadrilaterals(gmsh: Any, flat: FloatArray, size: float, order: int) -> list[int]:
    """Mesh a polygon; its lines. Elements are halved to be quadrilaterals, so they begin twice as large."""
    geo = gmsh.model.geo
    points = [geo.addPoint(float(x), float(y), 0.0) for x, y in flat]
    lines = [geo.addLine(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    geo.synchronize()
    for name in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
        gmsh.option.setNumber(name, 2 * size)
    gmsh.option.setNumber("Mesh.Algorithm", 8)
    gmsh.option.setNumber("Mesh.SubdivisionAlgorithm", 1)
    gmsh.model.mesh.setRecombine(2, surface)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(order)
    return lines


def _ends(gmsh: Any, line: int, what: str) -> list[list[int]]:
    found = elements_of(gmsh, 1, [line], what)
    assert found is not None
    rows: list[list[int]] = found.nodes[:, :2].tolist()
    return rows


def _upright(quads: IntArray, base: FloatArray, kind: str) -> IntArray:
    """The quadrilaterals, all counter-clockwise."""
    x, y = np.moveaxis(base[quads[:, :4]], 2, 0)
    area = (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    return np.where((area > 0)[:, None], quads, quads[:, turned(kind)])


def _layered(quads: IntArray, count: int, layers: int, order: int) -> IntArray:
    """Cells on ``count`` nodes a level, shape (layers * q, 8 or 27)."""
    places = HEXAHEDRON if order == 2 else HEXAHEDRON[:8]
    column = [QUAD.index((x, y)) for x, y, _ in places]
    level = np.array([z if order == 2 else z // 2 for _, _, z in places])
    return np.concatenate(
        [quads[:, column] + count * (level + order * layer) for layer in range(layers)]
    ).astype(np.int64)


def _owners(
    corners: IntArray, used: IntArray, highest: int, body: Prism, side_of: dict[tuple[int, ...], int]
) -> IntArray:
    """Face of the solid that each facet lies on, by the levels and the base nodes of its corners."""
    level, node = corners // len(used), used[corners % len(used)]
    owner = np.empty(len(corners), dtype=np.int64)
    for facet in range(len(corners)):
        if level[facet].max() == 0:
            owner[facet] = body.base
        elif level[facet].min() == highest:
            owner[facet] = body.top
        else:
            owner[facet] = side_of[tuple(sorted(set(node[facet].tolist())))]
    return owner
