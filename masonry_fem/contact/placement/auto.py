"""Auto: contacts where two meshes match are at their nodes, elsewhere weighted; rigid faces have corners.

Where the interface ends within facets of the finer mesh, weighted contacts stand inside of its rim, and
Newton's method needs some hundred steps instead of ten: there nodes are taken, and told to be less exact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.contact.placement import corners, nodes, weighted
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots

SAME = 1e-6  # of a facet's area: rounding


def points(patch: Patch, rule: Rule) -> Spots:
    """What the rule gives that is exact and has the fewest contacts.

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
    if not all(meshed) or match(patch):
        return nodes.points(patch, rule)
    if weighted.ends_with_facets(patch):
        return weighted.points(patch, rule)
    return replace(nodes.points(patch, rule), exact=False)


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
