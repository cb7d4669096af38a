"""Action: what pushes the blocks, and which of it acts together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.records.record import (
    AccelerationVector,
    AnyPressure,
    BlockSelector,
    Distance,
    FaceSelector,
    FilePath,
    ForceVector,
    Instant,
    Kelvin,
    Length,
    LineForceVector,
    Metres,
    Name,
    Point,
    Spec,
    Speed,
    TractionVector,
    UnitWeight,
)
from masonry_fem.scene.motion import TimeFunction


class Acceleration(Spec, frozen=True, kw_only=True):
    """A uniform acceleration that acts on all mass as gravity does (for an earthquake, −ü of the ground).

    Attributes
    ----------
    vector : the acceleration
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    vector: AccelerationVector
    time: TimeFunction | None = None
    case: Name | None = None


class Accelerogram(Spec, frozen=True, kw_only=True):
    """Accelerations of the ground in an earthquake, from files: [how](shaking.md).

    A file is one of PEER (``.AT2``, in g), or a CSV file of time [s] and acceleration; with more columns it
    has a line of titles, ``time, x, y, z``. Between its values it is linear, outside them zero.

    Attributes
    ----------
    x : file of the acceleration along x
    y : file of the acceleration along y
    z : file of the acceleration along z, in 3D
    scale : multiplies the accelerations
    unit : of CSV files; m/s² by default
    acts : with ``inertia`` the mass feels −ü and displacements are relative to the ground; with ``ground``
        all supports and clamped faces move by the displacement of the ground
    baseline : polynomial in time that is taken from each acceleration, so that its velocity stays nearest to
        zero
    start : time of the first value; by default 0
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    x: FilePath | None = None
    y: FilePath | None = None
    z: FilePath | None = None
    scale: float = 1.0
    unit: Literal["g", "m/s^2", "cm/s^2"] | None = None
    acts: Literal["inertia", "ground"] = "inertia"
    baseline: Literal["none", "constant", "linear", "quadratic"] = "none"
    start: Instant = 0.0
    case: Name | None = None

    @property
    def files(self) -> dict[str, str]:
        """Its files by the axes along which they act."""
        named = {axis: getattr(self, axis) for axis in "xyz"}
        return {axis: name for axis, name in named.items() if name is not None}

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """No file, one along a third axis in the plane, or a unit beside that of a file."""
        if not self.files:
            yield "x", "a file along some axis, as x = 'RSN6_180.AT2'"
        if dimension == 2 and self.z is not None:
            yield "z", "none in a 2D scene, whose axes are x and y"
        for name in self.files.values():
            if is_at2(name) and self.unit not in (None, "g"):
                yield "unit", f"none, or 'g', as '{name}' is in units of g"


def is_at2(name: str) -> bool:
    """Whether a file is named as one of PEER."""
    return name.lower().endswith(".at2")


class Traction(Spec, frozen=True, kw_only=True):
    """Uniform traction on faces ``blocks/face``.

    Attributes
    ----------
    on : selector of faces
    vector : force per area
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    on: FaceSelector
    vector: TractionVector
    time: TimeFunction | None = None
    case: Name | None = None


class PressureLoad(Spec, frozen=True, kw_only=True):
    """Pressure on faces ``blocks/face``, even or by depth as of water, which turns with the blocks.

    It acts along the normals of the faces, on rigid and on elastic blocks as these have turned by then; with
    ``contact.update = "fixed"``, and on blocks with clamped faces, along those of the undeformed structure.
    That strains turn and stretch faces, too, is left out.

    Attributes
    ----------
    on : selector of faces
    pressure : presses on the blocks where it is positive, and sucks where it is negative; with
        ``unit_weight`` that at the level
    level : height of a surface along the last axis (y in 2D, z in 3D), in the undeformed structure: nothing
        acts above it
    unit_weight : by how much the pressure grows by metre of depth below the level, as "9.81 kN/m^3" of water
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    on: FaceSelector
    pressure: AnyPressure = 0.0
    level: Metres | None = None
    unit_weight: UnitWeight = 0.0
    time: TimeFunction | None = None
    case: Name | None = None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Nothing that presses, or a depth without a level."""
        if not self.pressure and not self.unit_weight:
            yield "pressure", "a pressure, or a level and a unit_weight, as level = 3.0, unit_weight = 9810.0"
        if self.unit_weight and self.level is None:
            yield "level", "the height of the surface below which the pressure grows, as level = 3.0"


class PointForce(Spec, frozen=True, kw_only=True):
    """Force on a block, at a point of it.

    Attributes
    ----------
    block : selector that matches one block
    vector : the force, in 2D for each metre of depth
    point : where it acts, in world coordinates of the undeformed structure; the block's centroid by default
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    block: BlockSelector
    vector: ForceVector
    point: Point | None = None
    time: TimeFunction | None = None
    case: Name | None = None


class LineForce(Spec, frozen=True, kw_only=True):
    """Force per length, spread along a segment on a block.

    Attributes
    ----------
    block : selector that matches one block
    vector : force per length
    start : one end of the segment, in world coordinates of the undeformed structure
    end : the other end
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    block: BlockSelector
    vector: LineForceVector
    start: Point
    end: Point
    time: TimeFunction | None = None
    case: Name | None = None


class MovingLoad(Spec, frozen=True, kw_only=True):
    """Forces that move along a path over faces, such as the axles of a vehicle: [how](moving.md).

    Each force is moved along its own direction to the first of the faces, and acts there. One that meets none
    of them acts on nothing.

    Attributes
    ----------
    on : selector of the faces that it moves over
    path : points of a line along which the load moves, in world coordinates of the undeformed structure;
        before the first point and after the last one it continues straight
    vector : force of each axle
    axles : how far each axle is behind the first one
    spread : length along the path that each force is spread over; by default it acts at a point
    width : width across the path that each force is spread over, in 3D; by default it acts on a line
    begin : where the first axle begins, and stays in analyses that do not move it: distance along the path
        from its first point
    speed : of the load along its path, in a march in time
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    on: FaceSelector
    path: Annotated[tuple[Point, ...], Meta(min_length=2)]
    vector: ForceVector
    axles: Annotated[tuple[Distance, ...], Meta(min_length=1)] = (0.0,)
    spread: Length | None = None
    width: Length | None = None
    begin: Metres = 0.0
    speed: Speed = 0.0
    time: TimeFunction | None = None
    case: Name | None = None


class Temperature(Spec, frozen=True, kw_only=True):
    """A change of temperature of whole blocks from the state without stress; several on a block add up.

    Blocks expand by their material's ``thermal_expansion``. Rigid ones cannot, and are refused.

    Attributes
    ----------
    on : selector of blocks, by default all; supports among them stay as they are
    material : name of a material: only blocks of it among these
    change : the change of temperature where the factor ``time`` is 1
    time : factor as a function of time; by default it grows from 0 to 1 over the analysis. In statics, time
        is the load factor from 0 to 1
    case : load case, whose factor [combinations](combinations.md) give; without one it acts in all as it is
    """

    on: BlockSelector = "*"
    material: str | None = None
    change: Kelvin
    time: TimeFunction | None = None
    case: Name | None = None


class Loads(Spec, frozen=True, kw_only=True):
    """What acts on the blocks.

    Attributes
    ----------
    gravity : acceleration of gravity; none by default
    gravity_time : factor of gravity as a function of time, 1 by default
    accelerations : uniform accelerations besides gravity
    accelerograms : accelerations of the ground from files
    tractions : forces per area on faces, which keep their direction
    pressures : pressures on faces, which turn with them
    points : forces at points
    lines : forces per length along segments
    moving : forces that move along a path over faces
    temperatures : changes of temperature of blocks
    """

    gravity: AccelerationVector | None = None
    gravity_time: TimeFunction | None = None
    accelerations: tuple[Acceleration, ...] = ()
    accelerograms: tuple[Accelerogram, ...] = ()
    tractions: tuple[Traction, ...] = ()
    pressures: tuple[PressureLoad, ...] = ()
    points: tuple[PointForce, ...] = ()
    lines: tuple[LineForce, ...] = ()
    moving: tuple[MovingLoad, ...] = ()
    temperatures: tuple[Temperature, ...] = ()


class Combination(Spec, frozen=True, kw_only=True):
    """A [load combination](combinations.md): a run of its own, in which load cases are multiplied by factors.

    Attributes
    ----------
    name : name of the folder with its results
    factors : factor of each load case by name, ``gravity`` for ``loads.gravity``; cases that are not named do
        not act
    """

    name: Name
    factors: dict[Name, float]
