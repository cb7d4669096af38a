"""Motion: how something varies in time, and what holds or moves the blocks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.records.record import (
    Count,
    FilePath,
    Frequency,
    Instant,
    Point,
    Radians,
    RotationVector,
    Seconds,
    Selector,
    Spec,
    turn_faults,
)


class Table(Spec, frozen=True, kw_only=True, tag_field="kind", tag="table"):
    """Piecewise-linear factor through (time [s], value) points, constant before the first and after the last.

    Attributes
    ----------
    points : pairs (time, value)
    repeats : after the last point it begins anew at the first, for ever
    """

    points: Annotated[tuple[tuple[Instant, float], ...], Meta(min_length=1)]
    repeats: bool = False

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Times that do not increase."""
        for index, (before, after) in enumerate(pairwise(self.points), start=1):
            if after[0] <= before[0]:
                yield f"points.{index}.0", f"a time after the one before ({before[0]:g} s)"


class Sine(Spec, frozen=True, kw_only=True, tag_field="kind", tag="sine"):
    """The factor amplitude · sin(2π · frequency · t + phase).

    Attributes
    ----------
    frequency : cycles per second
    amplitude : the largest value of the factor
    phase : the sine's angle at t = 0
    """

    frequency: Frequency
    amplitude: float = 1.0
    phase: Radians = 0.0


class Pulse(Spec, frozen=True, kw_only=True, tag_field="kind", tag="pulse"):
    """A pulse, or several: the factor is 0 before, between and after them.

    Attributes
    ----------
    start : when the first one begins
    duration : of one pulse
    shape : ``half_sine``, ``triangle`` and ``rectangle`` are of one sign, ``full_sine`` goes to both sides;
        steps ought to be short beside the sides of a rectangle, which are steep
    amplitude : the largest value of the factor
    every : time from the start of one pulse to that of the next, not shorter than a pulse
    count : how many there are with ``every``, by default without end; without ``every`` there is one
    """

    duration: Seconds
    start: Instant = 0.0
    shape: Literal["half_sine", "full_sine", "triangle", "rectangle"] = "half_sine"
    amplitude: float = 1.0
    every: Seconds | None = None
    count: Count | None = None


class Record(Spec, frozen=True, kw_only=True, tag_field="kind", tag="record"):
    """A factor from two columns (time, value) of a CSV file, linear between the rows.

    The first line may hold titles, and ``#`` begins a comment. Every other line has two finite numbers, or
    with ``column`` as many as there are titles; time is the first of them.

    Attributes
    ----------
    path : the CSV file, relative to the scene file
    scale : multiplies the file's values
    column : title of the column that holds the values
    unit : of the values, as ``"kN"``: they become numbers in SI units, so that a vector that they multiply is
        a direction
    time_unit : of the times, as ``"ms"``; seconds by default
    repeats : after the last row it begins anew at the first, for ever
    """

    path: FilePath
    scale: float = 1.0
    column: str | None = None
    unit: str | None = None
    time_unit: str | None = None
    repeats: bool = False


TimeFunction = Table | Sine | Pulse | Record


class Motion(Spec, frozen=True, kw_only=True):
    """Prescribed motion of a support: a displacement [m], and a rotation [rad] about a pivot.

    Both are multiplied by the factor ``time``.

    Attributes
    ----------
    displacement : the displacement where the factor ``time`` is 1
    rotation : a rotation vector in 3D, an angle in 2D, where the factor ``time`` is 1
    pivot : point that the rotation is about; by default the middle of the block or face, if it is a single
        one
    time : factor as a function of time, 1 by default. In statics, time is the load factor from 0 to 1
    """

    displacement: Point | None = None
    rotation: RotationVector | Radians | None = None
    pivot: Point | None = None
    time: TimeFunction | None = None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A rotation of the other dimension."""
        return turn_faults("rotation", self.rotation, dimension, "rad")


class Support(Spec, frozen=True, kw_only=True):
    """Blocks, or faces (``blocks/face``), that are held or moved.

    A held block becomes a support; a held face of an elastic block is clamped on the mesh.

    Attributes
    ----------
    on : selector of blocks or of faces
    components : the axes along which they are held; all by default
    motion : prescribed motion; they stay at rest by default
    """

    on: Selector
    components: Annotated[tuple[Literal["x", "y", "z"], ...], Meta(min_length=1)] | None = None
    motion: Motion | None = None

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A third axis in the plane."""
        if dimension == 2 and "z" in (self.components or ()):
            yield "components", "only 'x' and 'y' in a 2D scene"
