"""Ground: the slab under a structure, a support."""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.assembly import Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose


def slab(low: FloatArray, high: FloatArray, thickness: float) -> Polytope:
    """Box under a footprint, its top at the height of ``low``, a third wider than the footprint.

    Parameters
    ----------
    low, high : Opposite corners of the structure, shape (d,) [m].
    thickness : Of the slab; on every side it extends beyond the footprint by as much again [m].
    """
    margin = (high[:-1] - low[:-1]) / 6 + thickness
    bottom = np.append(low[:-1] - margin, low[-1] - thickness)
    top = np.append(high[:-1] + margin, low[-1])
    return Polytope.box(tuple(bottom), tuple(top))


def ground(
    structure: str, shape: int, low: FloatArray, high: FloatArray, thickness: float
) -> tuple[Shape, Block]:
    """Shape and block of the slab under a structure.

    Parameters
    ----------
    structure : Name of the structure.
    shape : Number that the slab's shape will have.
    low, high : Opposite corners of the structure, shape (d,) [m].
    thickness : Of the slab [m].
    """
    solid = slab(low, high, thickness)
    name = f"{structure}.ground"
    return Shape(name, solid), Block(name, shape, Pose.identity(len(low)), (structure,), support=True)
