"""Unstructured: simplices for any flat-faced solid, by gmsh."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.meshing.cells import boundary_facets, corner_count
from masonry_fem.meshing.mesher import DIVISIONS
from masonry_fem.meshing.session import elements_of, node_positions, session
from masonry_fem.records.remark import remark
from masonry_fem.records.structure import MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.mesh import IntArray, Mesh


def simplices_of(shape: Shape, settings: MeshSettings) -> Mesh:
    """Triangles or tetrahedra of a shape; if Q elements are wanted, P elements replace them, with a warning.

    Parameters
    ----------
    shape : The shape to mesh.
    settings : Element, and size or divisions.

    Raises
    ------
    GeometryError : gmsh failed.
    """
    solid, d = shape.solid, shape.solid.dimension
    if settings.elements.startswith("Q"):
        remark(
            "tetrahedra",
            f"shape '{shape.name}' is not six-sided, so it is meshed with P{settings.elements[1]} "
            f"instead of {settings.elements} elements",
        )
    longest = float(np.ptp(solid.vertices, axis=0).max())
    divisions = max(settings.divisions) if settings.divisions else DIVISIONS
    size = settings.size or longest / divisions
    with session(f"shape '{shape.name}'") as gmsh:
        faces = _draw(gmsh, shape)
        for name in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
            gmsh.option.setNumber(name, size)
        gmsh.model.mesh.generate(d)
        gmsh.model.mesh.setOrder(int(settings.elements[1]))
        cells = elements_of(gmsh, d, [tag for _, tag in gmsh.model.getEntities(d)], shape.name)
        assert cells is not None  # gmsh fails rather than leave a solid empty
        tags, points = node_positions(gmsh)
        on_face = [
            {tuple(sorted(row)) for row in _corners(gmsh, d - 1, entity, shape.name).tolist()}
            for entity in faces
        ]
    used = np.unique(cells.nodes)
    numbers = np.searchsorted(used, cells.nodes)
    facets = boundary_facets(numbers, cells.kind)
    keys = np.sort(used[facets[:, :d]], axis=1).tolist()
    face_of = {key: face for face, rows in enumerate(on_face) for key in rows}
    owner = np.array([face_of[tuple(key)] for key in keys])
    return Mesh(points[np.searchsorted(tags, used), :d], cells.kind, numbers, facets, owner)


def _corners(gmsh: Any, dimension: int, entity: int, what: str) -> IntArray:
    found = elements_of(gmsh, dimension, [entity], what)
    assert found is not None
    return found.nodes[:, : corner_count(found.kind)]


def _draw(gmsh: Any, shape: Shape) -> list[int]:
    """The solid in gmsh's own kernel; the entity of each face."""
    solid, geo = shape.solid, gmsh.model.geo
    points = [geo.addPoint(*vertex, *[0.0] * (3 - solid.dimension)) for vertex in solid.vertices]
    lines: dict[tuple[int, int], int] = {}

    def line(a: int, b: int) -> int:
        if (b, a) in lines:
            return -lines[b, a]
        if (a, b) not in lines:
            lines[a, b] = geo.addLine(points[a], points[b])
        return lines[a, b]

    if solid.dimension == 2:
        faces = [line(a, b) for a, b in solid.faces]
        geo.addPlaneSurface([geo.addCurveLoop(faces, reorient=True)])
    else:
        faces = []
        for face in solid.faces:
            loop = [line(a, b) for a, b in zip(face, (*face[1:], face[0]), strict=True)]
            faces.append(geo.addPlaneSurface([geo.addCurveLoop(loop)]))
        geo.addVolume([geo.addSurfaceLoop(faces)])
    geo.synchronize()
    return [abs(face) for face in faces]
