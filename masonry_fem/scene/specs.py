"""What a user describes, one frozen record a noun, the same in TOML and in Python.

A field's unit and range stand in its annotation and are checked on reading. Selectors are
shell-style patterns matched against block and group names (``wall.*``); a face selector is
``block-selector/face`` (``wall.c5.*/top``).
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

Metres = Annotated[float, Meta(extra={"unit": "m"})]
Length = Annotated[float, Meta(gt=0, extra={"unit": "m"})]
Seconds = Annotated[float, Meta(gt=0, extra={"unit": "s"})]
Pressure = Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
Angle = Annotated[float, Meta(gt=0, le=360, extra={"unit": "deg"})]
Count = Annotated[int, Meta(ge=1)]
Fraction = Annotated[float, Meta(gt=0, le=1)]
NonNegative = Annotated[float, Meta(ge=0)]
Vector = Annotated[tuple[float, ...], Meta(min_length=2, max_length=3)]
Fidelity = Literal["rigid", "elastic"]
Element = Literal["Q1", "P1", "Q2", "P2"]


class Spec(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, omit_defaults=True):
    """Base of all records: frozen, keyword-only, unknown keys refused."""


# --- time functions ---------------------------------------------------------------------------


class Table(Spec, frozen=True, kw_only=True, tag_field="kind", tag="table"):
    """Piecewise-linear factor through (time [s], value) points, constant outside them."""

    points: tuple[tuple[float, float], ...]


class Sine(Spec, frozen=True, kw_only=True, tag_field="kind", tag="sine"):
    """amplitude · sin(2π frequency t + phase), frequency in Hz, phase in rad."""

    frequency: Annotated[float, Meta(gt=0, extra={"unit": "Hz"})]
    amplitude: float = 1.0
    phase: float = 0.0


class Record(Spec, frozen=True, kw_only=True, tag_field="kind", tag="record"):
    """Two columns (time, value) of a CSV file, linear between; path relative to the scene."""

    path: str
    scale: float = 1.0


TimeFunction = Table | Sine | Record


# --- materials and mesh -----------------------------------------------------------------------


class Damping(Spec, frozen=True, kw_only=True):
    """Rayleigh damping C = mass · M + stiffness · K."""

    mass: Annotated[float, Meta(ge=0, extra={"unit": "1/s"})] = 0.0
    stiffness: Annotated[float, Meta(ge=0, extra={"unit": "s"})] = 0.0


class Material(Spec, frozen=True, kw_only=True):
    """Isotropic linear-elastic stone."""

    density: Annotated[float, Meta(gt=0, extra={"unit": "kg/m^3"})]
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] = 0.2
    damping: Damping = Damping()


class MeshSettings(Spec, frozen=True, kw_only=True):
    """Elements of elastic blocks: an element kind and either a size or numbers of divisions."""

    element: Element = "Q1"
    size: Length | None = None
    divisions: tuple[Count, ...] | None = None


# --- structures: one record a generator ---------------------------------------------------------


class Structure(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """What every structure has."""

    name: str
    material: str
    fidelity: Fidelity | None = None
    mesh: MeshSettings | None = None


class BlockStructure(Structure, frozen=True, kw_only=True, tag="block"):
    """One box, ``size`` [m] along the axes, lower corner at ``position``, turned by ``rotation``.

    ``rotation`` is an angle [deg] about ``axis`` (2D: about z) through the lower corner.
    """

    size: Vector
    position: Vector | None = None
    rotation: float = 0.0
    axis: Vector | None = None
    support: bool = False


class StackStructure(Structure, frozen=True, kw_only=True, tag="stack"):
    """``count`` boxes one on another, each moved by ``offset`` along x over the one below."""

    size: Vector
    count: Count
    position: Vector | None = None
    offset: Metres = 0.0
    gap: Annotated[float, Meta(ge=0, extra={"unit": "m"})] = 0.0
    ground: bool = True


class WallStructure(Structure, frozen=True, kw_only=True, tag="wall"):
    """Running-bond wall: ``courses`` courses of ``columns`` bricks, half bricks closing every other."""

    brick: Vector
    columns: Count
    courses: Count
    position: Vector | None = None
    half_bricks: Literal["even", "odd", "none"] = "even"
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
    centre: Vector | None = None
    straight: bool = False
    springings: bool = True


class FileStructure(Structure, frozen=True, kw_only=True, tag="file"):
    """Blocks read from ``.msh``, ``.geo``, ``.step``: volume groups are blocks, surface groups faces."""

    path: str
    scale: Annotated[float, Meta(gt=0)] = 1.0
    supports: tuple[str, ...] = ()


AnyStructure = BlockStructure | StackStructure | WallStructure | ArchStructure | FileStructure


class Override(Spec, frozen=True, kw_only=True):
    """Fidelity or material of the selected blocks, against what their structure says."""

    blocks: str
    fidelity: Fidelity | None = None
    material: str | None = None


# --- joints, supports, loads --------------------------------------------------------------------


class Joint(Spec, frozen=True, kw_only=True):
    """Contact law of the selected interfaces; the last joint that matches an interface holds.

    ``interface`` matches the joint label of the faces (bed, head, radial ...) and ``between`` the
    two blocks, in either order. ``inset`` is the slides' ξ of the ``corners`` rule; ``density`` is
    the number of subdivisions of the ``gauss`` rule.
    """

    friction: NonNegative = 0.6
    dynamic_friction: NonNegative | None = None
    restitution: Annotated[float, Meta(ge=0, le=1)] = 0.0
    tangential_restitution: Annotated[float, Meta(ge=0, le=1)] = 0.0
    form: Literal["gap", "velocity"] = "gap"
    placement: Literal["corners", "gauss", "nodes"] | None = None
    inset: Fraction = 1.0
    density: Count = 1
    interface: str = "*"
    between: tuple[str, str] = ("*", "*")


class Motion(Spec, frozen=True, kw_only=True):
    """Prescribed displacement of a support along ``direction`` [m] and turn about ``pivot`` [rad]."""

    displacement: Vector | None = None
    rotation: Vector | float | None = None
    pivot: Vector | None = None
    time: TimeFunction | None = None


class Support(Spec, frozen=True, kw_only=True):
    """Blocks, or faces (``blocks/face``), that are held or moved; ``components`` limits which axes.

    A held block becomes a support; a held face of an elastic block is clamped on the mesh.
    """

    on: str
    components: tuple[Literal["x", "y", "z"], ...] | None = None
    motion: Motion | None = None


class Acceleration(Spec, frozen=True, kw_only=True):
    """Body force by a uniform acceleration of everything [m/s²] (an earthquake's is −ü_ground)."""

    vector: Vector
    time: TimeFunction | None = None


class Traction(Spec, frozen=True, kw_only=True):
    """Uniform traction [Pa] (2D: Pa per metre of depth) on faces ``blocks/face``."""

    on: str
    vector: Vector
    time: TimeFunction | None = None


class PointForce(Spec, frozen=True, kw_only=True):
    """Force [N] on a block at a point [m]; at its centroid where no point is given."""

    block: str
    vector: Vector
    point: Vector | None = None
    time: TimeFunction | None = None


class LineForce(Spec, frozen=True, kw_only=True):
    """Force per length [N/m] spread along the segment from ``start`` to ``end`` [m] on a block."""

    block: str
    vector: Vector
    start: Vector
    end: Vector
    time: TimeFunction | None = None


class Loads(Spec, frozen=True, kw_only=True):
    """What acts on the blocks."""

    gravity: Vector | None = None
    gravity_time: TimeFunction | None = None
    accelerations: tuple[Acceleration, ...] = ()
    tractions: tuple[Traction, ...] = ()
    points: tuple[PointForce, ...] = ()
    lines: tuple[LineForce, ...] = ()


# --- analysis, solver, output -------------------------------------------------------------------


class Statics(Spec, frozen=True, kw_only=True, tag_field="kind", tag="statics"):
    """True statics: inertia left out, the loads applied in equal ``load_steps``."""

    load_steps: Count = 1


class Dynamics(Spec, frozen=True, kw_only=True, tag_field="kind", tag="dynamics"):
    """θ-scheme from 0 to ``duration`` in steps of ``step``."""

    step: Seconds
    duration: Seconds
    theta: Annotated[float, Meta(ge=0.5, le=1)] = 0.5


class Equilibrium(Spec, frozen=True, kw_only=True, tag_field="kind", tag="equilibrium"):
    """March in time towards rest by a ``strategy``; stops when the measures hold."""

    strategy: Literal["numerical_viscosity", "brutal_damping", "linear_damping", "large_step"]
    step: Seconds
    theta: Annotated[float, Meta(ge=0.5, le=1)] = 1.0
    max_steps: Count = 1000
    velocity_factor: Annotated[float, Meta(ge=0, lt=1)] = 0.9
    tolerance: Annotated[float, Meta(gt=0)] = 1e-6


Analysis = Statics | Dynamics | Equilibrium


class Initial(Spec, frozen=True, kw_only=True):
    """Starting velocity [m/s] and spin [rad/s] of the selected blocks."""

    blocks: str
    velocity: Vector | None = None
    spin: Vector | float | None = None


class Solver(Spec, frozen=True, kw_only=True):
    """How the contact problem of a step is solved, and how well."""

    method: Literal["auto", "nsgs", "newton"] = "auto"
    tolerance: Annotated[float, Meta(gt=0, lt=1)] = 1e-10
    max_iterations: Count | None = None
    time_limit: Seconds | None = None


class Contact(Spec, frozen=True, kw_only=True):
    """Which faces count as touching: at most ``reach`` [m] apart (default: 1e-3 of a block's size)."""

    reach: Length | None = None
    angle: Annotated[float, Meta(gt=0, lt=45, extra={"unit": "deg"})] = 5.0
    update_every: Count = 1


class Probe(Spec, frozen=True, kw_only=True):
    """Named material point whose displacement is recorded."""

    name: str
    block: str
    point: Vector


class Output(Spec, frozen=True, kw_only=True):
    """What is written besides ``summary.json`` and ``history.csv``."""

    fields: bool = True
    pictures: bool = True
    every: Count = 1
    amplification: Annotated[float, Meta(gt=0)] | None = None


class Scene(Spec, frozen=True, kw_only=True):
    """A whole problem: read it with ``Scene.load``-style functions of ``masonry_fem.scene``."""

    title: str = ""
    dimension: Literal[2, 3] = 3
    plane: Literal["strain", "stress"] = "strain"
    fidelity: Fidelity = "elastic"
    mesh: MeshSettings = MeshSettings()
    materials: dict[str, Material]
    structures: tuple[AnyStructure, ...]
    overrides: tuple[Override, ...] = ()
    joints: tuple[Joint, ...] = (Joint(),)
    supports: tuple[Support, ...] = ()
    loads: Loads = Loads()
    initial: tuple[Initial, ...] = ()
    analysis: Analysis = Statics()
    solver: Solver = Solver()
    contact: Contact = Contact()
    probes: tuple[Probe, ...] = ()
    output: Output = Output()
