"""Auto: contacts at the nodes of the finer mesh, at corners between rigid faces.

It tells where meshes do not match. There ``weighted`` would be exact, but Newton's method may need ten
times as many steps with it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.contact.placement import corners, nodes
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots

SAME = 1e-6  # of a facet's area: rounding


def points(patch: Patch, rule: Rule) -> Spots:
    """Nodes, where a side is meshed, else corners.

    Parameters
    ----------
    patch : The interface.
    rule : Its ``inset`` is that of ``corners``.

    Raises
    ------
    GeometryError : Mesh facets do not cover the interface.
    """
    meshed = [side.mesh is not None for side in patch.sides]
    if patch.degenerate or not any(meshed):
        return corners.points(patch, rule)
    return replace(nodes.points(patch, rule), exact=not all(meshed) or match(patch))


def match(patch: Patch) -> bool:
    """Whether both meshes divide the interface into the same facets, of one kind, of which none is cut."""
    first, second = (side.mesh.facet for side in patch.sides if side.mesh is not None)
    if first != second:
        return False
    _, weight, _, rows = on_pieces(patch, (True, True), 1)
    start = np.flatnonzero(np.append(True, (rows[1:] != rows[:-1]).any(axis=1)))
    area = np.add.reduceat(weight, start)
    whole = [patch.facet_areas(side)[rows[start, side]] for side in (0, 1)]
    return all(bool((np.abs(own - area) <= SAME * own).all()) for own in whole)
