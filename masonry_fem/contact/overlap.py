"""Overlap: blocks that overlap in their initial positions."""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.depth import overlaps
from masonry_fem.contact.skin import Layout, Skin
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.polytope import Polytope


def overlapping(assembly: Assembly) -> list[tuple[int, int, float]]:
    """Pairs of blocks (numbers) that penetrate, and the depth [m].

    Supports do not move, so they may penetrate each other.
    """
    vertices = [assembly.solid(number).vertices for number in range(len(assembly.blocks))]
    start = np.cumsum([0, *(len(own) for own in vertices)])
    shapes = np.array([block.shape for block in assembly.blocks])
    used = [np.flatnonzero(shapes == shape) for shape in np.unique(shapes)]
    skin = Skin.of(assembly, [Layout(int(shapes[own[0]]), False, own, start[own]) for own in used])
    found = overlaps(skin, np.concatenate(vertices))
    return [
        (one, two, depth)
        for (one, two), depth in zip(found.pairs.tolist(), found.depth.tolist(), strict=True)
    ]


def thickness(solid: Polytope) -> float:
    """The least of the solid's extents behind its faces [m]."""
    points = solid.vertices
    return min(
        float(((points[loop[0]] - points) @ solid.normal(face)).max())
        for face, loop in enumerate(solid.faces)
    )
