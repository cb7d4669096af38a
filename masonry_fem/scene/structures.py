"""Structure: a family of blocks made by one generator or read from one file; one record each."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.scene.record import (
    Angle,
    Axis,
    Count,
    Degrees,
    Distance,
    Divisions,
    Element,
    Fidelity,
    FilePath,
    Length,
    Metres,
    Name,
    Point,
    Positive,
    Sizes,
    Spec,
)


class MeshSettings(Spec, frozen=True, kw_only=True):
    """Elements of elastic blocks: an element kind and either a size or numbers of divisions."""

    element: Element = "Q1"
    size: Length | None = None
    divisions: Divisions | None = None


class Structure(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """What every structure has."""

    name: Name
    material: str
    fidelity: Fidelity | None = None
    mesh: MeshSettings | None = None


class BlockStructure(Structure, frozen=True, kw_only=True, tag="block"):
    """One box, ``size`` [m] along the axes, lower corner at ``position``, turned by ``rotation``.

    ``rotation`` is an angle [deg] about ``axis`` (2D: about z) through the lower corner.
    """

    size: Sizes
    position: Point | None = None
    rotation: Degrees = 0.0
    axis: Axis | None = None
    support: bool = False


class StackStructure(Structure, frozen=True, kw_only=True, tag="stack"):
    """``count`` boxes one on another, each moved by ``offset`` along x over the one below."""

    size: Sizes
    count: Count
    position: Point | None = None
    offset: Metres = 0.0
    gap: Distance = 0.0
    ground: bool = True


class WallStructure(Structure, frozen=True, kw_only=True, tag="wall"):
    """Running-bond wall: ``courses`` courses of ``columns`` bricks, half bricks closing every other.

    Where ``columns`` ends in a half, each course has one half brick, at alternate ends. With ``cut`` each
    brick is two halves whose joint, labelled ``brick``, lets it crack in the middle.
    """

    brick: Sizes
    columns: Annotated[float, Meta(ge=1, multiple_of=0.5)]
    courses: Count
    position: Point | None = None
    half_bricks: Literal["even", "odd", "none"] = "even"
    cut: bool = False
    ground: bool = True


class ArchStructure(Structure, frozen=True, kw_only=True, tag="arch"):
    """Circular arch of ``voussoirs`` equal stones about the mean ``radius``; springings as supports.

    ``embrace`` is the full opening angle [deg]. ``straight`` voussoirs have chords for arcs.
    """

    radius: Length
    thickness: Length
    voussoirs: Count
    embrace: Angle = 180.0
    depth: Length = 1.0
    centre: Point | None = None
    straight: bool = False
    springings: bool = True


class DomeStructure(Structure, frozen=True, kw_only=True, tag="dome"):
    """Spherical dome about the mean ``radius``: ``rings`` of ``slices`` equal stones, all faces flat.

    ``springing`` and ``oculus`` are the angles [deg] of base and eye from the crown; without an oculus a
    crown stone closes the dome. ``staggered`` turns every other ring by half a stone. A ``sweep`` below
    360 deg makes a sector, from the x axis on, with ``sides`` between two supports.
    """

    radius: Length
    thickness: Length
    rings: Count
    slices: Count
    springing: Angle = 90.0
    oculus: Annotated[float, Meta(ge=0, lt=180, extra={"unit": "deg"})] = 0.0
    centre: Point | None = None
    staggered: bool = False
    base: bool = True
    sweep: Angle = 360.0
    sides: bool = False


class FileStructure(Structure, frozen=True, kw_only=True, tag="file"):
    """Blocks read from ``.msh``, ``.geo``, ``.step``: volume groups are blocks, surface groups faces."""

    path: FilePath
    scale: Positive = 1.0
    supports: tuple[str, ...] = ()


AnyStructure = BlockStructure | StackStructure | WallStructure | ArchStructure | DomeStructure | FileStructure
