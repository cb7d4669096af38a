"""Block: one box, turned about its lower corner."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from masonry_fem.errors import GeometryError
from masonry_fem.scene.specs import BlockStructure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose


def build(spec: BlockStructure, dimension: int) -> Assembly:
    """One block that bears the structure's name."""
    solid = Polytope.box((0.0,) * dimension, spec.size)
    corner = np.zeros(dimension) if spec.position is None else np.array(spec.position, dtype=float)
    pose = Pose(_turn(spec, dimension), corner)
    block = Block(spec.name, 0, pose, (spec.name,), support=spec.support)
    return Assembly(dimension, (Shape(spec.name, solid),), (block,))


def _turn(spec: BlockStructure, dimension: int) -> FloatArray:
    angle = np.radians(spec.rotation)
    if angle == 0:
        return np.eye(dimension)
    if dimension == 2:
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s], [s, c]])
    axis = np.array((0.0, 0.0, 1.0) if spec.axis is None else spec.axis, dtype=float)
    length = np.linalg.norm(axis)
    if length == 0:
        raise GeometryError(
            f"structures.{spec.name}.axis is {tuple(axis)}, expected a direction; give e.g. [0, 1, 0]"
        )
    return np.asarray(Rotation.from_rotvec(angle * axis / length).as_matrix())
