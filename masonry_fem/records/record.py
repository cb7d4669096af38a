"""Record: what every part of a scene is, and the quantities its fields hold.

A quantity is an annotated type that carries its unit and its range; reading, unit conversion
and error messages all follow from the annotation, so a field says everything once:

    class Plank(Spec, frozen=True, kw_only=True):
        length: Length
        stiffness: Pressure | None = None
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from masonry_fem.errors import MasonryError

Metres = Annotated[float, Meta(extra={"unit": "m"})]
Length = Annotated[float, Meta(gt=0, extra={"unit": "m"})]
Distance = Annotated[float, Meta(ge=0, extra={"unit": "m"})]
Seconds = Annotated[float, Meta(gt=0, extra={"unit": "s"})]
Instant = Annotated[float, Meta(extra={"unit": "s"})]
Speed = Annotated[float, Meta(ge=0, extra={"unit": "m/s"})]
Frequency = Annotated[float, Meta(gt=0, extra={"unit": "Hz"})]
Pressure = Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
UnitWeight = Annotated[float, Meta(extra={"unit": "N/m^3"})]
AnyPressure = Annotated[float, Meta(extra={"unit": "Pa"})]
Density = Annotated[float, Meta(gt=0, extra={"unit": "kg/m^3"})]
Kelvin = Annotated[float, Meta(extra={"unit": "K"})]
Expansion = Annotated[float, Meta(ge=0, extra={"unit": "1/K"})]
Memory = Annotated[float, Meta(gt=0, extra={"unit": "B"})]
Degrees = Annotated[float, Meta(extra={"unit": "deg"})]
Angle = Annotated[float, Meta(gt=0, le=360, extra={"unit": "deg"})]
Inclination = Annotated[float, Meta(ge=0, le=90, extra={"unit": "deg"})]
Radians = Annotated[float, Meta(extra={"unit": "rad"})]
Count = Annotated[int, Meta(ge=1)]
Positive = Annotated[float, Meta(gt=0)]
NonNegative = Annotated[float, Meta(ge=0)]
Fraction = Annotated[float, Meta(gt=0, le=1)]
Unit = Annotated[float, Meta(ge=0, le=1)]

# A vector has the scene's dimension: min_length 2 and max_length 3 say so to the reader.
Vector = Annotated[tuple[float, ...], Meta(min_length=2, max_length=3)]
Sizes = Annotated[tuple[Length, ...], Meta(min_length=2, max_length=3)]
Point = Annotated[tuple[Metres, ...], Meta(min_length=2, max_length=3)]
VelocityVector = Annotated[
    tuple[Annotated[float, Meta(extra={"unit": "m/s"})], ...], Meta(min_length=2, max_length=3)
]
AccelerationVector = Annotated[
    tuple[Annotated[float, Meta(extra={"unit": "m/s^2"})], ...], Meta(min_length=2, max_length=3)
]
ForceVector = Annotated[
    tuple[Annotated[float, Meta(extra={"unit": "N"})], ...], Meta(min_length=2, max_length=3)
]
LineForceVector = Annotated[
    tuple[Annotated[float, Meta(extra={"unit": "N/m"})], ...], Meta(min_length=2, max_length=3)
]
TractionVector = Annotated[
    tuple[Annotated[float, Meta(extra={"unit": "Pa"})], ...], Meta(min_length=2, max_length=3)
]
Divisions = Annotated[tuple[Count, ...], Meta(min_length=2, max_length=3)]
Axis = Annotated[tuple[float, ...], Meta(min_length=3, max_length=3)]
RotationVector = Annotated[tuple[Radians, ...], Meta(min_length=3, max_length=3)]
AngularVelocity = Annotated[float, Meta(extra={"unit": "rad/s"})]
SpinVector = Annotated[tuple[AngularVelocity, ...], Meta(min_length=3, max_length=3)]

Name = Annotated[
    str,
    Meta(
        pattern=r"^[^\W\d][\w-]*$",
        extra={"expected": "a name of letters, digits, _ and - that begins with a letter"},
    ),
]
BlockSelector = Annotated[
    str, Meta(pattern=r"^[^/]+$", extra={"expected": "a selector of blocks such as 'wall.*' (without '/')"})
]
FaceSelector = Annotated[
    str, Meta(pattern=r"^[^/]+/[^/]+$", extra={"expected": "a selector of faces 'blocks/face'"})
]
Selector = Annotated[
    str,
    Meta(
        pattern=r"^[^/]+(/[^/]+)?$",
        extra={"expected": "a selector of blocks 'wall.*' or of faces 'wall.*/top'"},
    ),
]
FilePath = Annotated[str, Meta(min_length=1, extra={"expected": "a file's path, relative to the scene file"})]

Fidelity = Annotated[str, Meta(extra={"named in": "masonry_fem.fidelities"})]
Element = Literal["Q1", "P1", "Q2", "P2"]


class Spec(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, omit_defaults=True):
    """Base of all records: frozen, keyword-only, unknown keys refused."""

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Keys whose values do not go together, or not with the scene's dimension: (key, what was expected).

        What a single value must be stands in its annotation. A key within a table is ``openings.0.size``.
        """
        return iter(())


def turn_faults(key: str, value: object, dimension: int, unit: str) -> Iterator[tuple[str, str]]:
    """A turn is a number in the plane and a vector in space: fault of one that is not, as ``Spec.faults``.

    Parameters
    ----------
    key, value : Of the turn; None: there is none.
    dimension : Of the scene. unit : Of the turn, in words.
    """
    flat = dimension == 2
    if value is not None and isinstance(value, tuple) == flat:
        yield key, f"one number in {unit} in a 2D scene" if flat else f"3 numbers in {unit} in a 3D scene"


def check_share(name: str, value: float | str) -> None:
    """Refuse what is no number between 0 and 1.

    Parameters
    ----------
    name : What it is, for the message. value : What was given.

    Raises
    ------
    MasonryError : It is a text, or out of this range.
    """
    if isinstance(value, str) or not 0 < value < 1:
        raise MasonryError(f"{name} is {value!r}, expected a number between 0 and 1, as 0.05 for 5 %")
