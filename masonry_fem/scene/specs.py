"""What a user describes, one frozen record a noun, the same in TOML and in Python.

A field's unit and range stand in its annotation and are checked on reading. Selectors are
shell-style patterns matched against block and group names (``wall.*``); a face selector is
``block-selector/face`` (``wall.c5.*/top``). Structures stand in their files in ``masonry_fem.structures``,
laws in ``masonry_fem.joints.laws``, what holds and pushes in ``actions``; this module has the rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, Union, cast

from msgspec import Meta, defstruct

from masonry_fem.contact.placement import names as placements
from masonry_fem.fem.material_kinds import MaterialRecord, material_kinds, material_record
from masonry_fem.march.equilibrium import Strategy
from masonry_fem.march.equilibrium import kinds as strategies
from masonry_fem.march.equilibrium.dynamics import Dynamics
from masonry_fem.march.equilibrium.equilibrium import Equilibrium
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.nscd.methods import GONE
from masonry_fem.nscd.methods import names as methods
from masonry_fem.output import asked
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
    Dilatancy,
    Mortar,
    PythonLaw,
    PythonMaterial,
    Scatter,
    law_record,
)
from masonry_fem.structures import kinds
from masonry_fem.structures.parts.opening import Opening

__all__ = [
    "Acceleration",
    "Analysis",
    "AnyLaw",
    "AnyStructure",
    "Contact",
    "Cut",
    "Damping",
    "Dilatancy",
    "Dynamics",
    "Element",
    "Equilibrium",
    "Fidelity",
    "Initial",
    "Joint",
    "LineForce",
    "Loads",
    "Material",
    "MeshSettings",
    "Mortar",
    "Motion",
    "Opening",
    "Output",
    "Override",
    "PointForce",
    "Probe",
    "PythonLaw",
    "PythonMaterial",
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
    "law_record",
    "material_record",
]

# what ``structures``, ``analysis``, ``placement``, ``method`` and ``inelastic`` of a scene may be: told from
# the files there
if TYPE_CHECKING:
    AnyStructure = Structure
    Analysis = Strategy
    PlacementName = str
    MethodName = str
    AnyMaterialLaw = MaterialRecord
else:
    AnyMaterialLaw = Union[(*(kind.record for kind in material_kinds().values()), PythonMaterial)]
    MethodName = Literal["auto", *methods()]
    PlacementName = Literal[placements()]
    Analysis = Union[tuple(strategies().values())]  # noqa: UP007
    AnyStructure = Union[tuple(kind.record for kind in kinds().values())]  # noqa: UP007  made while running

# μ of joints that do not slip: only what is about to open has less pressure than a hundredth of its shear
NO_SLIP = 1e2


class Damping(Spec, frozen=True, kw_only=True):
    """Rayleigh damping: the damping matrix is C = α M + β K; of rigid blocks C = α M.

    Attributes
    ----------
    mass : α, the factor of the mass matrix M
    stiffness : β, the factor of the stiffness matrix K
    """

    mass: Annotated[float, Meta(ge=0, extra={"unit": "1/s"})] = 0.0
    stiffness: Annotated[float, Meta(ge=0, extra={"unit": "s"})] = 0.0


class Material(Spec, frozen=True, kw_only=True):
    """Isotropic stone: linear-elastic, and with a law of its own where blocks are inelastic.

    Attributes
    ----------
    density : mass density
    young : Young's modulus; needed by elastic and inelastic blocks
    poisson : Poisson's ratio
    damping : Rayleigh damping
    inelastic : how the stone yields, chosen by ``law``; needed by inelastic blocks, those of fidelity
        ``auto`` without it stay elastic, rigid and elastic ones ignore it
    promote_at : share of the stress of first yield at which blocks of fidelity ``auto`` become inelastic
    """

    density: Density
    young: Pressure | None = None
    poisson: Annotated[float, Meta(gt=-1, lt=0.5)] = 0.2
    damping: Damping = Damping()
    inelastic: AnyMaterialLaw | None = None
    promote_at: Annotated[float, Meta(gt=0, le=1)] = 0.9


class Override(Spec, frozen=True, kw_only=True):
    """Fidelity, material or elements of selected blocks, in place of what their structure says.

    Attributes
    ----------
    blocks : selector of blocks
    fidelity : rigid, elastic, inelastic or auto
    material : name of a table in ``materials``
    mesh : elements, with the keys of the scene's ``mesh``; ``run --refine-to`` writes such entries
    """

    blocks: BlockSelector
    fidelity: Fidelity | None = None
    material: str | None = None
    mesh: MeshSettings | None = None


class Joint(Spec, frozen=True, kw_only=True):
    """What the selected joints do: friction, and a cohesive law, mortar or dilatancy where wanted.

    If several entries match a joint, the last one applies. Entries select joints by ``interface`` (their
    label: bed, head, radial ...), ``between`` (the two blocks) and ``inclination`` (the angle to the
    horizontal, for blocks without labels: bed joints have 0°, head joints 90°).

    The strengths and stiffnesses of a ``law`` are per area, and each contact point has its share of the
    face. A ``mortar`` is an elastic layer in series with the contact: it deforms under pressure and shear
    even where the faces neither open nor slide. With ``dilatancy`` a joint that slides also opens.

    Attributes
    ----------
    friction : Coulomb's μ; with ``no slip`` the joint can open but never slides
    law : cohesive law, chosen by ``kind``; without it the joint is dry
    mortar : elastic layer in series with the contact; none by default
    dilatancy : opening that sliding causes; none by default
    scatter : properties that vary from joint to joint; none by default
    dynamic_friction : μ of a point that slides; equal to ``friction`` by default
    restitution : Newton's coefficient e of the normal velocity; only with ``form = "velocity"``
    tangential_restitution : the same for the tangential velocity
    form : ``gap`` demands that blocks do not penetrate at the end of a step; ``velocity`` is an impact law
    placement : where the contact points lie: at the ``nodes`` of the finer mesh (default where a block is
        elastic), at the ``corners`` of the common face (default between rigid blocks), or at its ``gauss``
        points
    inset : for ``corners``: the points lie at this share of the half-thickness, 1 being the edge
    density : for ``gauss``: number of subdivisions of the face
    interface : pattern of the joint's label: ``bed``, ``head``, ``radial``, a file's surface group
    between : selectors of the two blocks, in either order
    inclination : smallest and largest angle between the joint's plane and the horizontal
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
    placement: PlacementName | None = None
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


class Initial(Spec, frozen=True, kw_only=True):
    """Velocity and spin of selected blocks at the start.

    Attributes
    ----------
    blocks : selector of blocks
    velocity : velocity of the centroid
    spin : angular velocity about the centroid: a vector in 3D, a number in 2D
    """

    blocks: BlockSelector
    velocity: VelocityVector | None = None
    spin: SpinVector | AngularVelocity | None = None


AIM = 1e-10  # of a contact solution whose tolerance nobody set


class Solver(Spec, frozen=True, kw_only=True):
    """How the contact problem of each step is solved, and how accurately.

    Without a ``tolerance`` the solver aims at 1e-10; if it gets stuck at an error of up to 1e-6, it accepts
    the answer and warns, stating the error. A ``tolerance`` that is given must be met.

    Attributes
    ----------
    method : sweeps by nonlinear Gauss-Seidel (``nsgs``), proximal Newton, interior point or pivoting
        (plane scenes of up to 400 contacts); ``auto`` chooses by the problem
    tolerance : bound on the relative contact error
    max_iterations : largest number of sweeps or Newton steps
    time_limit : wall-clock time for the contact problem of one step
    relaxation : for ``nsgs``: how far a sweep moves a contact towards the solution of its local problem,
        1 being all the way
    threads : for ``nsgs``: number of threads that share a sweep, colour by colour. By default one thread
        sweeps in a shuffled order. Any number of threads gives the same results; see
        [which contact solver](solvers.md)
    linear : how linear systems of rigid blocks are solved: ``direct`` by factorisation, ``krylov`` by
        iterations with multigrid (for thick masonry with tens of thousands of contacts), ``auto`` by
        whichever is expected to cost less; see [which contact solver](solvers.md)
    """

    method: Annotated[MethodName, Meta(extra={"gone": GONE})] = "auto"
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
    """Which faces count as touching, and how contacts follow blocks that move.

    Blocks that overlap at the start stay where they are, unless ``expulsion`` is positive.

    Attributes
    ----------
    reach : largest gap between faces that are in contact; 1e-3 of a block's size by default
    angle : largest angle between faces that are in contact
    expulsion : largest speed at which blocks that overlap at the start are driven apart, in the gap form;
        with 0 they are not
    update : ``moving``: contacts of the start, and of blocks that meet later; their frames and lever arms
        follow the blocks, however far these go. ``fixed``: contacts stay as they are at the start and elastic
        blocks balance where they were (small displacements), and blocks that meet later go through each
        other. ``redetect``: contacts are detected
        anew, so that rigid blocks may slide off each other, tumble and fall
    every : for ``redetect``: number of steps between two detections
    """

    reach: Length | None = None
    angle: Annotated[float, Meta(gt=0, lt=45, extra={"unit": "deg"})] = 5.0
    expulsion: Annotated[float, Meta(ge=0, extra={"unit": "m/s"})] = 0.0
    update: Literal["fixed", "moving", "redetect"] = "moving"
    every: Count = 1


class Probe(Spec, frozen=True, kw_only=True):
    """A material point whose displacement is recorded.

    Attributes
    ----------
    name : name of its columns in results
    block : selector that matches one block
    point : in world coordinates of the undeformed structure
    """

    name: Name
    block: BlockSelector
    point: Point


CutField = Literal["von_mises", "vertical", "greatest", "least"]


class Cut(Spec, frozen=True, kw_only=True):
    """A picture ``cut_NAME_FIELD.png`` of the stresses on a plane through a 3D structure.

    Tension is positive. Rigid blocks are grey.

    Attributes
    ----------
    name : part of the pictures' names
    point : any point of the plane, in world coordinates of the undeformed structure
    normal : normal of the plane, pointing towards the viewer
    show : the fields, each of which gives a picture: von Mises stress, vertical stress (zz), greatest and
        least principal stress
    """

    name: Name
    point: Point
    normal: Axis
    show: tuple[CutField, ...] = ("von_mises",)


def _with_outputs(record: type[Output]) -> type[Output]:
    """The record with a key for each further file of ``masonry_fem.output.asked``."""
    keys = [key for key in asked.names() if key not in record.__struct_fields__]
    if not keys:
        return record
    told = "\n".join(f"{key} : {asked.meaning(key)}" for key in keys)
    text = {"__doc__": f"{record.__doc__}\nAttributes\n----------\n{told}"}
    fields = [(key, bool, False) for key in keys]
    wider = defstruct("Output", fields, bases=(record,), namespace=text, frozen=True, kw_only=True)
    return cast("type[Output]", wider)


@_with_outputs
class Output(Spec, frozen=True, kw_only=True):
    """What is written besides ``summary.json`` and ``history.csv``.

    Attributes
    ----------
    fields : write ``.vtu`` and ``.pvd`` files for ParaView
    pictures : write PNG pictures of the last state
    every : number of steps between field files; the first and the last are always written
    interfaces : write [``interfaces.csv``](results.md#interfacescsv): which forces each joint carries, where,
        and how far it opened and slid. With ``pictures``, thrust lines and maps of opening and sliding are
        drawn, too; with ``fields``, ``interfaces.pvd`` is written for ParaView
    cuts : pictures of [stresses on planes](results.md#cuts), in 3D
    determinacy : write ``determinacy.csv``: [which resultants are determined](determinacy.md), that is, equal
        in all solutions of the last step; its reactions are then those of least norm
    limit_analysis : put into the summary what [limit analysis](limit_analysis.md) says about rigid blocks
        with the same contact points
    contact_error : run the analysis a second time with [other contact points](errors.md#contact), and put
        into the summary what changes
    amplification : factor of displacements in pictures; chosen automatically by default
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
    """A whole problem: read it with ``masonry_fem.load``, write it with ``masonry_fem.scene.save``.

    Attributes
    ----------
    title : shown on pictures and in tables
    large : build the scene even if it exceeds the [size limits](limits.md#sizes); ``--yes`` sets it
    dimension : of space
    plane : whether a 2D scene is in plane strain or plane stress
    fidelity : what blocks are where nothing else says so: ``rigid``, ``elastic``, ``inelastic``, or ``auto``:
        elastic until their stress comes near to their strength (``promote_at`` of their material), and then
        inelastic
    mesh : elements of elastic blocks
    mass : mass matrix of elastic blocks
    materials : tables of material properties, by name
    structures : families of blocks
    overrides : exceptions for single blocks or groups
    joints : what joints do
    supports : blocks and faces that are held or moved, besides the supports that structures bring
    loads : forces and accelerations
    initial : velocities at the start
    analysis : statics, dynamics or a march to equilibrium
    solver : contact solver
    contact : which faces are in contact
    probes : points whose displacement is recorded
    output : what is written
    reading : limits on time and memory for reading files
    """

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

    @property
    def fidelities(self) -> set[str]:
        """Those that stones may have."""
        own = {one.fidelity or self.fidelity for one in self.structures}
        return own | {one.fidelity for one in self.overrides if one.fidelity is not None}
