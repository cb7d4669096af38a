"""Pointed arch: stones between two arcs that meet at the crown, with a keystone or a joint there."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from masonry_fem.scene.specs import PointedArchStructure
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.curve import Circle, Offset, crossing
from masonry_fem.structures.quarry import arch_of
from masonry_fem.structures.voussoir import Run, Voussoir


def build(spec: PointedArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    return arch_of(spec, stones_of(spec), dimension, spec.straight)


def stones_of(spec: PointedArchStructure) -> list[Voussoir]:
    """All stones from the left."""
    left, right = (
        [Offset(Circle(spec.arc, x), side * spec.thickness / 2) for side in (-1, 1)]
        for x in (spec.offset, -spec.offset)
    )
    tops = [-float(np.arcsin(spec.offset / (spec.arc + curve.by))) for curve in left]
    joints = _joints(spec, left, tops)
    labels = ["radial", *[spec.cut] * (len(joints) - 1)]
    halves = list(zip(pairwise(joints), pairwise(labels), strict=True))
    stones = [Voussoir.between(left, a, b, *names) for (a, b), names in halves]
    mirrored = [
        Voussoir.between(right, [-p for p in b], [-p for p in a], *names[::-1]) for (a, b), names in halves
    ]
    if spec.voussoirs % 2:
        low, high = (
            (Run(one, joints[-1][k], tops[k]), Run(two, -tops[k], -joints[-1][k]))
            for k, (one, two) in enumerate(zip(left, right, strict=True))
        )
        stones.append(Voussoir(low, high, labels[-1], labels[-1]))
    return [*stones, *mirrored[::-1]]


def _joints(spec: PointedArchStructure, faces: list[Offset], tops: list[float]) -> list[tuple[float, float]]:
    """Parameters of the left half's joints on its intrados and extrados, which end at ``tops``."""
    half, first = spec.voussoirs / 2, -np.pi / 2
    count = int(half)
    if spec.cut == "radial":  # equal parts of the mean line
        angles = first + np.arange(count + 1) * (-spec.crown - first) / half
        joints = [(float(angle), float(angle)) for angle in angles]
    else:
        inner = (spec.span - spec.thickness) / 2
        places = [np.array([inner * (k / half - 1), 0.0]) for k in range(1, count + 1)]
        joints = [(first, first)]
        for place in places[: count if spec.voussoirs % 2 else count - 1]:
            low, high = (
                crossing(face, first, top, place, np.array([1.0, 0.0]))
                for face, top in zip(faces, tops, strict=True)
            )
            joints.append((low, high))
        if spec.voussoirs % 2 == 0:
            joints.append((0.0, 0.0))
    if spec.voussoirs % 2 == 0:  # the joint at the crown is vertical
        joints[-1] = (tops[0], tops[1])
    return joints
