"""Action: what holds, moves or pushes the blocks, and how it varies in time."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.records.record import (
    AccelerationVector,
    BlockSelector,
    FaceSelector,
    FilePath,
    ForceVector,
    Frequency,
    Instant,
    LineForceVector,
    Point,
    Radians,
    RotationVector,
    Selector,
    Spec,
    TractionVector,
)


class Table(Spec, frozen=True, kw_only=True, tag_field="kind", tag="table"):
    """Piecewise-linear factor through (time [s], value) points, constant outside them."""

    points: Annotated[tuple[tuple[Instant, float], ...], Meta(min_length=1)]


class Sine(Spec, frozen=True, kw_only=True, tag_field="kind", tag="sine"):
    """amplitude · sin(2π frequency t + phase), frequency in Hz, phase in rad."""

    frequency: Frequency
    amplitude: float = 1.0
    phase: Radians = 0.0


class Record(Spec, frozen=True, kw_only=True, tag_field="kind", tag="record"):
    """Two columns (time, value) of a CSV file, linear between; path relative to the scene.

    One line of titles may come first; ``#`` begins a remark. Any other line has two finite numbers.
    """

    path: FilePath
    scale: float = 1.0


TimeFunction = Table | Sine | Record


class Motion(Spec, frozen=True, kw_only=True):
    """Prescribed ``displacement`` [m] of a support and turn about ``pivot`` [rad].

    ``rotation`` is a rotation vector in 3D and an angle in 2D; both are multiplied by ``time``.
    """

    displacement: Point | None = None
    rotation: RotationVector | Radians | None = None
    pivot: Point | None = None
    time: TimeFunction | None = None


class Support(Spec, frozen=True, kw_only=True):
    """Blocks, or faces (``blocks/face``), that are held or moved; ``components`` limits which axes.

    A held block becomes a support; a held face of an elastic block is clamped on the mesh.
    """

    on: Selector
    components: Annotated[tuple[Literal["x", "y", "z"], ...], Meta(min_length=1)] | None = None
    motion: Motion | None = None


class Acceleration(Spec, frozen=True, kw_only=True):
    """Body force by a uniform acceleration of everything [m/s²] (an earthquake's is −ü_ground)."""

    vector: AccelerationVector
    time: TimeFunction | None = None


class Traction(Spec, frozen=True, kw_only=True):
    """Uniform traction [Pa] on faces ``blocks/face``."""

    on: FaceSelector
    vector: TractionVector
    time: TimeFunction | None = None


class PointForce(Spec, frozen=True, kw_only=True):
    """Force [N] on a block at a point [m]; at its centroid where no point is given."""

    block: BlockSelector
    vector: ForceVector
    point: Point | None = None
    time: TimeFunction | None = None


class LineForce(Spec, frozen=True, kw_only=True):
    """Force per length [N/m] spread along the segment from ``start`` to ``end`` [m] on a block."""

    block: BlockSelector
    vector: LineForceVector
    start: Point
    end: Point
    time: TimeFunction | None = None


class Loads(Spec, frozen=True, kw_only=True):
    """What acts on the blocks."""

    gravity: AccelerationVector | None = None
    gravity_time: TimeFunction | None = None
    accelerations: tuple[Acceleration, ...] = ()
    tractions: tuple[Traction, ...] = ()
    points: tuple[PointForce, ...] = ()
    lines: tuple[LineForce, ...] = ()
