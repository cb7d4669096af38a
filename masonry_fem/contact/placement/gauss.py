"""Gauss: quadrature points of the polygon, with their weights as tributary areas.

Where sides are meshed the points lie on the pieces that the meshes cut out of the polygon, so
that a uniform pressure gives both sides its exact consistent nodal forces.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.quadrature import quadrature
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.errors import GeometryError
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def points(patch: Patch, rule: Rule) -> Spots:
    """Quadrature points of an interface; its corners where blocks touch only at a point or along an edge.

    Parameters
    ----------
    patch : The interface.
    rule : Its ``density`` subdivides the face where neither side is meshed.

    Raises
    ------
    GeometryError : Mesh facets do not cover the interface.
    """
    if patch.degenerate:
        return corners.points(patch, Rule())
    placed, area, facets, _ = on_pieces(patch, (True, True), rule.density)
    return Spots(patch, placed, area, facets)


def on_pieces(
    patch: Patch, use: tuple[bool, bool], density: int
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Quadrature points on the pieces that meshes cut out of an interface.

    Parameters
    ----------
    patch : The interface.
    use : Whether to cut by the mesh of the candidate, and of the antagonist.
    density : Subdivisions of the face where no mesh cuts it.

    Returns
    -------
    Points in the common plane (m, d − 1), weights (m,), which sum to the interface's area, mesh facets (m,
    2) and their rows within the face (m, 2).

    Raises
    ------
    GeometryError : Mesh facets do not cover the interface.
    """
    meshed = [used and side.mesh is not None for used, side in zip(use, patch.sides, strict=True)]
    polygons = [patch.facet_polygons(side) if meshed[side] else patch.polygon[None] for side in (0, 1)]
    kinds = {side.mesh.facet for side, own in zip(patch.sides, meshed, strict=True) if own and side.mesh}
    degree = 2 if kinds <= {"triangle"} else 4
    quadratic = bool(kinds & {"line3", "triangle6", "quad9"})
    placed, area, rows = quadrature(
        patch.polygon, polygons[0], polygons[1], degree, quadratic, 1 if any(meshed) else density
    )
    whole = patch.interface.area
    if not abs(area.sum() - whole) <= 0.01 * whole:
        names = "' and '".join(side.surface.name for side in patch.sides)
        raise GeometryError(
            f"shapes '{names}', faces {patch.interface.faces}: their mesh facets cover {area.sum():.6g} "
            f"of an interface of {whole:.6g}; expected all of it; mesh the shapes again"
        )
    return placed, area * (whole / area.sum()), _facets(patch, meshed, rows), rows


def _facets(patch: Patch, meshed: list[bool], rows: IntArray) -> IntArray:
    """Mesh facets by their rows within the face, (m, 2); −1 on a side that no mesh cuts."""
    each = zip(patch.sides, meshed, rows.T, strict=True)
    return np.stack(
        [side.facets.facets[row] if cut else np.full(len(row), -1) for side, cut, row in each], axis=1
    )
