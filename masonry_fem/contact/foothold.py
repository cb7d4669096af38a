"""Foothold: a corner of one block on a face of another, where at least one block is not convex.

No plane separates such blocks as a whole, so corners are examined one by one. A corner is a foothold if it is
within reach of a face, inside its outline, and its edges lead away from the face (one of them may run along
it). Contacts where edge crosses edge are not found.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.clipping import depths
from masonry_fem.contact.contacts import Interface, local_frames
from masonry_fem.contact.posed import Posed
from masonry_fem.contact.surface import PosedFaces
from masonry_fem.contact.touching import INSIDE, LEVEL, standing
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def footholds(
    posed: Posed,
    faces: PosedFaces,
    pairs: IntArray,
    reach: float,
    overlap: float,
    size: float,
    rim: bool = False,
) -> list[Interface]:
    """Interfaces of one point each, between corners and faces of blocks of which one is not convex.

    Parameters
    ----------
    posed : Corners and edges of all blocks.
    faces : Their faces.
    pairs : Pairs of near blocks, shape (p, 2).
    reach : Largest distance of a corner in front of a face [m].
    overlap : Largest distance behind it [m].
    size : Typical size of a block, for tolerances [m].
    rim : Whether corners above the rim of a face stand on it: those of blocks of one depth do.
    """
    margin = (-INSIDE if rim else INSIDE) * size
    made = []
    for first, second in pairs[~posed.convex[pairs].all(axis=1)].tolist():
        for carrier, other in ((first, second), (second, first)):
            made += _on(posed, faces, carrier, other, (-overlap, reach), size, margin)
    return made


def _on(
    posed: Posed,
    faces: PosedFaces,
    carrier: int,
    other: int,
    within: tuple[float, float],
    size: float,
    margin: float,
) -> list[Interface]:
    """Corners of ``other`` that stand on faces of ``carrier``, by a ``margin`` inside of their rims."""
    rows = np.arange(faces.first[carrier], faces.first[carrier + 1])
    vertices = posed.vertices[other, : posed.count[other]]
    away = vertices[:, None] - faces.points[rows, 0]
    heights = np.einsum("vfd,fd->vf", away, faces.normal[rows])
    level = LEVEL * size
    near = (heights >= within[0] - level) & (heights <= within[1] + level)
    around = _neighbours(posed, other) if near.any() else []
    made = []
    for corner in np.flatnonzero(near.any(axis=1)).tolist():
        climbs = heights[around[corner]] - heights[corner]
        # in 3D one edge may lie on the face; if two do, a face lies on the face
        leads_away = (climbs >= -level).all(axis=0) & ((climbs <= level).sum(axis=0) <= vertices.shape[1] - 2)
        stands = np.flatnonzero(near[corner] & leads_away)
        inside = [k for k in stands.tolist() if _holds(faces, int(rows[k]), vertices[corner], margin)]
        if inside:  # take the face behind which it is least deep
            best = max(inside, key=lambda k: heights[corner, k])
            row = rows[best]
            feature = posed.vertices[other, [corner]]
            made.append(standing(posed, carrier, int(faces.face[row]), other, [corner], feature, size))
    return made


def _neighbours(posed: Posed, block: int) -> list[list[int]]:
    """Corners that edges join to each corner of a block."""
    solid = posed.solids[posed.shape[block]]
    joined: list[set[int]] = [set() for _ in solid.vertices]
    for loop in solid.faces:
        for a, b in zip(loop, (*loop[1:], loop[0]), strict=True):
            joined[a].add(b)
            joined[b].add(a)
    return [sorted(others) for others in joined]


def _holds(faces: PosedFaces, row: int, point: FloatArray, margin: float) -> bool:
    """Whether a point projects inside a face piece."""
    frame = local_frames(faces.normal[row : row + 1])[0]
    loop = faces.points[row, : faces.corners[row]]
    window, flat = (loop - loop[0]) @ frame[1:].T, (point - loop[0])[None] @ frame[1:].T
    return bool(depths(window, flat)[0] > margin)
