"""What a user describes, one frozen record a noun, the same in TOML and in Python.

A field's unit and range stand in its annotation and are checked on reading. Selectors are
shell-style patterns matched against block and group names (``wall.*``); a face selector is
``block-selector/face`` (``wall.c5.*/top``). Structures stand in ``masonry_fem.structures``, what holds
and pushes them in ``actions``; this module has the rest and gathers all names.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Union

from msgspec import Meta

from masonry_fem.records.mesh_settings import MeshSettings
from masonry_fem.records.reading_limits import Reading
from masonry_fem.records.record import (
    AngularVelocity,
    Axis,
    BlockSelector,
    Count,
    Density,
    Element,
    Fidelity,
    Fraction,
    Inclination,
    Length,
    Name,
    NonNegative,
    Point,
    Positive,
    Pressure,
    Seconds,
    Spec,
    SpinVector,
    Unit,
    VelocityVector,
)
from masonry_fem.records.structure import Structure
from masonry_fem.scene.actions import (
    Acceleration,
    LineForce,
    Loads,
    Motion,
    PointForce,
    Record,
    Sine,
    Support,
    Table,
    TimeFunction,
    Traction,
)
from masonry_fem.scene.laws import (
    AnyLaw,
    Bilinear,
    ConstantThreshold,
    Dilatancy,
    ElasticBrittle,
    ElasticJoint,
    Exponential,
    FremondCangemi,
    MohrCoulomb,
    MonerieAcary,
    Mortar,
    PythonLaw,
    Scatter,
    Trapezoidal,
)
from masonry_fem.structures import kinds
from masonry_fem.structures.parts.opening import Opening

__all__ = [
    "Acceleration",
    "Analysis",
    "AnyLaw",
    "AnyStructure",
    "Bilinear",
    "ConstantThreshold",
    "Contact",
    "Cut",
    "Damping",
    "Dilatancy",
    "Dynamics",
    "ElasticBrittle",
    "ElasticJoint",
    "Element",
    "Equilibrium",
    "Exponential",
    "Fidelity",
    "FremondCangemi",
    "Initial",
    "Joint",
    "LineForce",
    "Loads",
    "Material",
    "MeshSettings",
    "MohrCoulomb",
    "MonerieAcary",
    "Mortar",
    "Motion",
    "Opening",
    "Output",
    "Override",
    "PointForce",
    "Probe",
    "PythonLaw",
    "Reading",
    "Record",
    "Scatter",
    "Scene",
    "Sine",
    "Solver",
    "Spec",
    "Statics",
    "Structure",
    "Support",
    "Table",
    "TimeFunction",
    "Traction",
    "Trapezoidal",
]

# what ``structures`` of a scene may be: told from the files there; their records are known here, too
if TYPE_CHECKING:
    AnyStructure = Structure
else:
    STRUCTURES = {kind.record.__name__: kind.record for kind in kinds().values()}
    AnyStructure = Union[tuple(STRUCTURES.values())]  # noqa: UP007  made while running
    globals().update(STRUCTURES)
    __all__ += list(STRUCTURES)

# μ of joints that do not slip: only what is about to open has less pressure than a hundredth of its shear
NO_SLIP = 1e2


class Damping(Spec, frozen=True, kw_only=True):
    """Rayleigh damping C = mass · M + stiffness · K."""

    mass: Annotated[float, Meta(ge=0, extra={"unit": "1/s"})] = 0.0
    stiffness: Annotated[float, Meta(ge=0, extra={"unit": "s"})] = 0.0


class Material(Spec, frozen=True, kw_only=True):
    """Isotropic linear-elastic stone."""

    density: Density
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] = 0.2
    damping: Damping = Damping()


class Override(Spec, frozen=True, kw_only=True):
    """Fidelity, material or elements of the selected blocks, against what their structure says."""

    blocks: BlockSelector
    fidelity: Fidelity | None = None
    material: str | None = None
    mesh: MeshSettings | None = None


class Joint(Spec, frozen=True, kw_only=True):
    """Contact law of the selected interfaces; the last joint that matches an interface holds.

    ``interface`` matches the joint label of the faces (bed, head, radial ...), ``between`` the
    two blocks, in either order, and ``inclination`` the angle of the joint to the horizontal, for
    blocks without labels: beds have 0, heads 90.

    ``inset`` is the slides' ξ of the ``corners`` rule; ``density`` is the number of subdivisions of
    the ``gauss`` rule. A ``law`` adds cohesion; its strengths and stiffnesses are per area, and each
    contact point has its share of the face. A ``mortar`` gives way under pressure and shear before
    the faces do anything; ``dilatancy`` opens what slides. ``friction = "no slip"`` is contact that
    opens but never slides.
    """

    friction: NonNegative | Literal["no slip"] = 0.6
    law: AnyLaw | None = None
    mortar: Mortar | None = None
    dilatancy: Dilatancy | None = None
    scatter: Scatter | None = None
    dynamic_friction: NonNegative | None = None
    restitution: Unit = 0.0
    tangential_restitution: Unit = 0.0
    form: Literal["gap", "velocity"] = "gap"
    placement: Literal["corners", "gauss", "nodes"] | None = None
    inset: Fraction = 1.0
    density: Count = 1
    interface: str = "*"
    between: tuple[BlockSelector, BlockSelector] = ("*", "*")
    inclination: tuple[Inclination, Inclination] = (0.0, 90.0)

    @property
    def coefficient(self) -> float:
        """Coulomb's μ of a joint at rest."""
        return NO_SLIP if self.friction == "no slip" else float(self.friction)

    @property
    def dry(self) -> bool:
        """True where contact and friction are all there is."""
        return self.law is None and self.mortar is None and self.dilatancy is None


class Statics(Spec, frozen=True, kw_only=True, tag_field="kind", tag="statics"):
    """True statics: inertia left out, the loads applied in equal ``load_steps``.

    A step in which joints give way is halved again and again, into at most so many ``substeps``.
    """

    load_steps: Count = 1
    substeps: Count = 1


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
    tolerance: Positive = 1e-6


Analysis = Statics | Dynamics | Equilibrium


class Initial(Spec, frozen=True, kw_only=True):
    """Starting velocity [m/s] and spin [rad/s] of the selected blocks (a vector in 3D, else a number)."""

    blocks: BlockSelector
    velocity: VelocityVector | None = None
    spin: SpinVector | AngularVelocity | None = None


AIM = 1e-10  # of a contact solution whose tolerance nobody set


class Solver(Spec, frozen=True, kw_only=True):
    """How the contact problem of a step is solved, and how well.

    ``relaxation`` and ``threads`` are of method "nsgs" alone. Any number of threads gives the same results.
    ``linear`` tells how the linear systems of rigid blocks are solved: "direct" by factors, "krylov" by
    iterations with multigrid, which thick masonry of ten thousands of contacts wants.

    Without a ``tolerance`` the solver aims at 1e-10; an error up to 1e-6 that nothing improves is an answer,
    too, with a warning that tells it. A ``tolerance`` that is given is held to.
    """

    method: Literal["auto", "nsgs", "newton", "interior_point", "admm", "pivoting"] = "auto"
    tolerance: Annotated[float, Meta(gt=0, lt=1)] | None = None
    max_iterations: Count | None = None
    time_limit: Seconds | None = None
    relaxation: Annotated[float, Meta(gt=0, lt=2)] = 1.0
    threads: Count | None = None
    linear: Literal["auto", "direct", "krylov"] = "auto"

    @property
    def aim(self) -> float:
        """The tolerance that is asked for, or aimed at."""
        return AIM if self.tolerance is None else self.tolerance


class Contact(Spec, frozen=True, kw_only=True):
    """Which faces count as touching: at most ``reach`` [m] apart (default: 1e-3 of a block's size).

    Blocks that overlap at the start are held where they are; with an ``expulsion`` speed the gap form
    drives them apart, no faster than that.

    With ``update`` "moving" contacts are those of the start and of blocks that meet later: their frames and
    lever arms follow the blocks, however far these go. "fixed" leaves those of the start where they were, as
    small kinematics has it, and blocks go through each other. "redetect" finds
    contacts anew ``every`` so many steps: rigid blocks may slide off each other, tumble and fall.
    """

    reach: Length | None = None
    angle: Annotated[float, Meta(gt=0, lt=45, extra={"unit": "deg"})] = 5.0
    expulsion: Annotated[float, Meta(ge=0, extra={"unit": "m/s"})] = 0.0
    update: Literal["fixed", "moving", "redetect"] = "moving"
    every: Count = 1


class Probe(Spec, frozen=True, kw_only=True):
    """Named material point whose displacement is recorded."""

    name: Name
    block: BlockSelector
    point: Point


CutField = Literal["von_mises", "vertical", "greatest", "least"]


class Cut(Spec, frozen=True, kw_only=True):
    """Picture ``cut_NAME_FIELD.png`` of the stresses on a plane through a 3D structure.

    ``von_mises``, ``vertical`` stress (zz), ``greatest`` and ``least`` principal stress; tension is
    positive. Rigid blocks are grey.
    """

    name: Name
    point: Point
    normal: Axis
    show: tuple[CutField, ...] = ("von_mises",)


class Output(Spec, frozen=True, kw_only=True):
    """What is written besides ``summary.json`` and ``history.csv``.

    With ``interfaces`` the table ``interfaces.csv`` tells what each joint carries, where, and how far it
    opened and slid; with pictures too thrust lines and maps of openings and slides are drawn, and with
    fields ``interfaces.pvd`` has them for ParaView.

    With ``determinacy`` the last step's reactions are those of least norm among all that solve it, and
    ``determinacy.csv`` tells which resultants are the same in all of them. With ``limit_analysis`` the
    summary tells what rigid blocks on the same contact points could carry.

    With ``contact_error`` the analysis is made once more with contact points placed otherwise, and the
    summary tells what changes.
    """

    fields: bool = True
    pictures: bool = True
    every: Count = 1
    interfaces: bool = False
    cuts: tuple[Cut, ...] = ()
    determinacy: bool = False
    limit_analysis: bool = False
    contact_error: bool = False
    amplification: Positive | None = None


class Scene(Spec, frozen=True, kw_only=True):
    """A whole problem: read it with ``masonry_fem.scene.load``, write it with ``save``."""

    title: str = ""
    large: bool = False
    dimension: Literal[2, 3] = 3
    plane: Literal["strain", "stress"] = "strain"
    fidelity: Fidelity = "elastic"
    mesh: MeshSettings = MeshSettings()
    mass: Literal["consistent", "lumped"] = "consistent"
    materials: dict[Name, Material]
    structures: Annotated[tuple[AnyStructure, ...], Meta(min_length=1)]
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
    reading: Reading = Reading()
