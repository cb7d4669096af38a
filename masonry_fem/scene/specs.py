"""What a user describes, one frozen record a noun, the same in TOML and in Python.

A field's unit and range stand in its annotation and are checked on reading. Selectors are
shell-style patterns matched against block and group names (``wall.*``); a face selector is
``block-selector/face`` (``wall.c5.*/top``). Structures stand in their files in ``masonry_fem.structures``,
laws in ``masonry_fem.joints.laws``, and each is loaded by the scenes that name it; the other nouns stand in
files of this folder, and can be imported from here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from msgspec import Meta, StructMeta

from masonry_fem.march.equilibrium import Strategy
from masonry_fem.march.equilibrium.dynamics import Dynamics
from masonry_fem.march.equilibrium.equilibrium import Equilibrium
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.records.opening import Opening
from masonry_fem.records.record import (
    AngularVelocity,
    BlockSelector,
    Count,
    Element,
    Fidelity,
    Length,
    Name,
    Spec,
    SpinVector,
    VelocityVector,
    turn_faults,
)
from masonry_fem.records.structure import MeshSettings, Reading, Structure
from masonry_fem.scene.actions import (
    Acceleration,
    Accelerogram,
    Combination,
    LineForce,
    Loads,
    MovingLoad,
    PointForce,
    PressureLoad,
    Temperature,
    Traction,
)
from masonry_fem.scene.combinations import Design, LoadFactors
from masonry_fem.scene.joint import Joint
from masonry_fem.scene.laws import (
    AnyLaw,
    Closure,
    Dilatancy,
    Mortar,
    PythonLaw,
    PythonMaterial,
    Scatter,
    law_record,
    material_record,
)
from masonry_fem.scene.material import Damping, Material, Orthotropy
from masonry_fem.scene.motion import Motion, Pulse, Record, Sine, Support, Table, TimeFunction
from masonry_fem.scene.output import Cut, Output, Probe
from masonry_fem.scene.solver import Solver
from masonry_fem.scene.tie import Tie, TiePoint

__all__ = [
    "Acceleration",
    "Accelerogram",
    "Analysis",
    "AnyLaw",
    "AnyStructure",
    "Closure",
    "Combination",
    "Contact",
    "Cut",
    "Damping",
    "Design",
    "Dilatancy",
    "Dynamics",
    "Element",
    "Equilibrium",
    "Fidelity",
    "Initial",
    "Joint",
    "LineForce",
    "LoadFactors",
    "Loads",
    "Material",
    "MeshSettings",
    "Mortar",
    "Motion",
    "MovingLoad",
    "Opening",
    "Orthotropy",
    "Output",
    "Override",
    "PointForce",
    "PressureLoad",
    "Probe",
    "Pulse",
    "PythonLaw",
    "PythonMaterial",
    "Reading",
    "Record",
    "Scatter",
    "Scene",
    "Sine",
    "Solver",
    "Spec",
    "Stage",
    "Statics",
    "Structure",
    "Support",
    "Table",
    "Temperature",
    "Tie",
    "TiePoint",
    "TimeFunction",
    "Traction",
    "law_record",
    "material_record",
]

# what ``structures`` and ``analysis`` of a scene may be
AnyStructure = Annotated[Structure, Meta(extra={"kinds in": "masonry_fem.structures"})]
Analysis = Annotated[Strategy, Meta(extra={"kinds in": "masonry_fem.march.equilibrium"})]


class Override(Spec, frozen=True, kw_only=True):
    """Fidelity, material or elements of selected blocks, in place of what their structure says.

    Attributes
    ----------
    blocks : selector of blocks
    fidelity : rigid, reduced, elastic, inelastic or auto
    material : name of a table in ``materials``
    mesh : elements, with the keys of the scene's ``mesh``; ``run --refine-to`` writes such entries
    """

    blocks: BlockSelector
    fidelity: Fidelity | None = None
    material: str | None = None
    mesh: MeshSettings | None = None


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

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A spin of the other dimension."""
        return turn_faults("spin", self.spin, dimension, "rad/s")


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


class Stage(Spec, frozen=True, kw_only=True):
    """A part of a [history](histories.md): it begins where the stage before has ended.

    A key that is left out is as in that stage, in the first one as in the scene.

    Attributes
    ----------
    name : name of the folder with its results
    after : the earlier stage where it begins; by default the one before, and the first where the scene begins
    analysis : what is done
    loads : in place of those of the stage before; in statics the change goes evenly over the steps
    supports : in place of those of the stage before
    joints : in place of those of the stage before; joints whose kind of law changes begin anew
    ties : in place of those of the stage before. Ties of the same names continue; new ones have their
        pretension with their points in their present places
    materials : tables in place of those of the same names; the numbers of stones that deform change evenly
    without : blocks that are absent, in place of those of the stage before. In statics the forces that they
        exerted are removed evenly over the steps; stones that appear have no stress, and begin where
        ``analysis.new_stones`` says
    """

    name: Name
    after: Name | None = None
    analysis: Analysis | None = None
    loads: Loads | None = None
    supports: tuple[Support, ...] | None = None
    joints: tuple[Joint, ...] | None = None
    ties: tuple[Tie, ...] | None = None
    materials: dict[Name, Material] | None = None
    without: tuple[BlockSelector, ...] | None = None


class _Checked(StructMeta):
    """Of ``Scene``: what its keys cannot be is told in Python as it is of files."""

    def __call__(self, *values: Any, **keys: Any) -> Any:
        try:
            return super().__call__(*values, **keys)
        except TypeError:
            if values:
                raise
            from masonry_fem.scene.reading import of_keys  # noqa: PLC0415 - it needs this file

            return of_keys(keys)


class Scene(Spec, frozen=True, kw_only=True, metaclass=_Checked):
    """A whole problem: read it with ``masonry_fem.load``, write it with ``masonry_fem.save``.

    Attributes
    ----------
    title : title of pictures and tables
    large : build the scene even if it exceeds the [size limits](limits.md#sizes); ``--yes`` sets it
    dimension : number of dimensions of space
    plane : whether a 2D scene is in plane strain or plane stress
    fidelity : how blocks are modelled unless a structure or an override says otherwise: ``rigid``,
        ``reduced``: elastic by few modes (``degree`` of their material), ``elastic``, ``inelastic``, or
        ``auto``: elastic until their stress comes near to their strength (``promote_at`` of their material),
        and then inelastic
    mesh : elements of elastic blocks
    mass : mass matrix of elastic blocks
    materials : tables of material properties, by name
    structures : families of blocks
    overrides : exceptions for single blocks or groups
    joints : properties of joints: friction, law, contact points
    ties : bars, cables and chains between points of blocks
    supports : blocks and faces that are held or moved, besides the supports that structures bring
    without : blocks that are left out; what else the scene says of them is left out, too
    loads : forces and accelerations
    design : partial factors, for the [strength check](strength.md)
    initial : velocities at the start
    analysis : statics, dynamics or a march to equilibrium
    stages : parts of a [history](histories.md), one after another
    combinations : [combinations](combinations.md) of load cases, each a run of its own
    solver : how contact problems are solved
    contact : which faces are in contact
    probes : points whose displacement is recorded
    output : which files are written
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
    ties: tuple[Tie, ...] = ()
    supports: tuple[Support, ...] = ()
    without: tuple[BlockSelector, ...] = ()
    loads: Loads = Loads()
    design: Design = Design()
    initial: tuple[Initial, ...] = ()
    analysis: Analysis = Statics()
    stages: tuple[Stage, ...] = ()
    combinations: tuple[Combination, ...] = ()
    solver: Solver = Solver()
    contact: Contact = Contact()
    probes: tuple[Probe, ...] = ()
    output: Output = Output()
    reading: Reading = Reading()

    def _repr_html_(self) -> str:
        """The scene as a file would have it, for notebooks."""
        from html import escape  # noqa: PLC0415 - only notebooks need it

        from masonry_fem.scene.writing import dumps  # noqa: PLC0415 - it needs this file

        return f"<b>{escape(self.title)}</b><pre>{escape(dumps(self))}</pre>"

    @property
    def fidelities(self) -> set[str]:
        """Those that stones may have."""
        own = {one.fidelity or self.fidelity for one in self.structures}
        return own | {one.fidelity for one in self.overrides if one.fidelity is not None}
