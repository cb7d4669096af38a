"""Foothold: a corner of one block on a face of another, where blocks are not convex.

No plane parts such blocks as a whole, so corners are looked at one by one: a corner within reach of
a face, inside it, whose edges lead away from it or, one of them, along it. What crosses edge over edge
is not found.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.clipping import depths
from masonry_fem.contact.contacts import Interface
from masonry_fem.contact.kinematics import local_frames
from masonry_fem.contact.posed import Posed
from masonry_fem.contact.surface import PosedFaces
from masonry_fem.contact.touching import INSIDE, LEVEL, ROUNDING
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def footholds(
    posed: Posed, faces: PosedFaces, pairs: IntArray, reach: float, overlap: float, size: float
) -> list[Interface]:
    """Interfaces of one point between corners and faces of pairs that have a block that is not convex.

    Corners at most ``reach`` off a face and ``overlap`` in it [m].
    """
    made = []
    for first, second in pairs[~posed.convex[pairs].all(axis=1)].tolist():
        for carrier, other in ((first, second), (second, first)):
            made += _on(posed, faces, carrier, other, (-overlap, reach), size)
    return made


def _on(
    posed: Posed, faces: PosedFaces, carrier: int, other: int, within: tuple[float, float], size: float
) -> list[Interface]:
    """Corners of ``other`` that stand on faces of ``carrier``."""
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
        # in space one edge may lie on the face; with two it is a face that does
        leads_away = (climbs >= -level).all(axis=0) & ((climbs <= level).sum(axis=0) <= vertices.shape[1] - 2)
        stands = np.flatnonzero(near[corner] & leads_away)
        inside = [k for k in stands.tolist() if _holds(faces, int(rows[k]), vertices[corner], INSIDE * size)]
        if inside:  # the face that it is least deep in
            best = max(inside, key=lambda k: heights[corner, k])
            made.append(_interface(posed, faces, int(rows[best]), other, corner, size))
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


def _interface(posed: Posed, faces: PosedFaces, row: int, other: int, corner: int, size: float) -> Interface:
    carrier, face, normal = int(faces.block[row]), int(faces.face[row]), faces.normal[row]
    point = posed.vertices[other, corner]
    gap = float((point - faces.points[row, 0]) @ normal)
    gap = 0.0 if abs(gap) < ROUNDING * size else gap
    own, solid = (posed.solids[posed.shape[block]] for block in (other, carrier))
    around = [f for f, loop in enumerate(own.faces) if corner in loop]
    against = max(around, key=lambda f: (-round(float(posed.normal[other, f] @ normal), 9), -f))
    labels = own.labels[against], solid.labels[face]
    return Interface(
        blocks=(other, carrier),
        faces=(against, face),
        normal=normal,
        polygon=(point - gap * normal)[None],
        gap=np.array([gap]),
        area=0.0,
        label=labels[0] if labels[0] == labels[1] else "",
    )
