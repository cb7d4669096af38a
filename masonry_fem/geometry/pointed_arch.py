"""Pointed arch: stones between two arcs that meet at the crown, with a keystone or a joint there."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from masonry_fem.geometry.curve import Circle, Offset
from masonry_fem.geometry.voussoir import Run, Voussoir, arch_of
from masonry_fem.scene.specs import PointedArchStructure
from masonry_fem.solid.assembly import Assembly


def build(spec: PointedArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    return arch_of(spec, stones_of(spec), dimension, spec.straight)


def stones_of(spec: PointedArchStructure) -> list[Voussoir]:
    """All stones from the left; joints cut the mean line into equal lengths."""
    count, crown = spec.voussoirs, -spec.crown
    joints = -np.pi / 2 + np.arange(count // 2 + 1) * (crown + np.pi / 2) / (count / 2)
    left, right = (
        [Offset(Circle(spec.arc, x), side * spec.thickness / 2) for side in (-1, 1)]
        for x in (spec.offset, -spec.offset)
    )
    tops = [-float(np.arcsin(spec.offset / (spec.arc + curve.by))) for curve in left]
    pairs = [(angle, angle) for angle in joints]
    if count % 2 == 0:  # the joint at the crown is vertical
        pairs[-1] = (tops[0], tops[1])
    stones = [Voussoir.between(left, a, b) for a, b in pairwise(pairs)]
    mirrored = [Voussoir.between(right, [-p for p in b], [-p for p in a]) for a, b in pairwise(pairs)]
    if count % 2:
        faces = [
            (Run(one, pairs[-1][k], tops[k]), Run(two, -tops[k], -pairs[-1][k]))
            for k, (one, two) in enumerate(zip(left, right, strict=True))
        ]
        stones.append(Voussoir(faces[0], faces[1]))
    return [*stones, *mirrored[::-1]]
