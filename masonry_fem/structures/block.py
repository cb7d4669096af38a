"""Block: one box, rotated about its lower corner."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Axis, Degrees, Point, Sizes
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose


class BlockStructure(Structure, frozen=True, kw_only=True, tag="block"):
    """One box of a ``size``, with its lower corner at ``position``, rotated about this corner.

    Attributes
    ----------
    size : lengths along its axes
    position : lower left front corner [m]; the origin by default
    rotation : angle about ``axis`` through the lower corner; in 2D about the normal of the plane
    axis : axis of the rotation, needed for one in 3D
    support : the block is a support

    Examples
    --------
    kind = "block"
    name = "block"
    material = "stone"
    size = [1.0, 0.5, 0.5]
    """

    size: Sizes
    position: Point | None = None
    rotation: Degrees = 0.0
    axis: Axis | None = None
    support: bool = False

    @property
    def carries(self) -> bool:
        """Whether it is a support."""
        return self.support

    def foreseen(self, dimension: int) -> Foreseen:
        """One."""
        return Foreseen(1, ())

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """An axis that means nothing, or that lacks."""
        if dimension == 2 and self.axis is not None:
            yield "axis", "no axis in a 2D scene (rotation is about z)"
        if dimension == 3 and self.rotation and self.axis is None:
            yield "axis", "3 numbers: in 3D a rotation has an axis"
        if self.axis is not None and not any(self.axis):
            yield "axis", "an axis that is not zero"


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
    from scipy.spatial.transform import Rotation  # noqa: PLC0415  slow to load

    return np.asarray(Rotation.from_rotvec(angle * axis / length).as_matrix())
