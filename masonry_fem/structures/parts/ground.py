"""Ground: the slab that a structure stands on, a support."""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.assembly import Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose


def slab(name: str, low: FloatArray, high: FloatArray, thickness: float) -> Polytope:
    """Box under the footprint ``low`` to ``high``, its top at ``low``'s height, a third wider."""
    margin = (high[:-1] - low[:-1]) / 6 + thickness
    bottom = np.append(low[:-1] - margin, low[-1] - thickness)
    top = np.append(high[:-1] + margin, low[-1])
    return Polytope.box(tuple(bottom), tuple(top))


def ground(
    structure: str, shape: int, low: FloatArray, high: FloatArray, thickness: float
) -> tuple[Shape, Block]:
    """The slab's shape and block (number ``shape`` among the structure's shapes)."""
    solid = slab(structure, low, high, thickness)
    name = f"{structure}.ground"
    return Shape(name, solid), Block(name, shape, Pose.identity(len(low)), (structure,), support=True)
