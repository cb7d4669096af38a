"""Summary: what ``summary.json`` holds of a run, key by key; ``docs/results.md`` tells units and meanings.

    result.summary.certificate.natural_map
    print(result.summary)            # a short table

Keys that a run has nothing to say of are left out of the file, and None here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.ledger import Ledger
from masonry_fem.march.mechanism import Falling
from masonry_fem.march.witness import Written
from masonry_fem.output.stress_error import StressError
from masonry_fem.records.remark import Remark
from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]

Outcome = Literal["equilibrium", "finished", "no_convergence", "no_equilibrium", "interrupted", "failed"]


class Wrench(Told, frozen=True, kw_only=True):
    """Force and moment.

    Attributes
    ----------
    force : Shape (d,) [N].
    moment : About the origin, shape (1 or 3,) [N m].
    """

    force: FloatArray
    moment: FloatArray


class Certificate(Told, frozen=True, kw_only=True):
    """How exact the last state is, by measures that no solver has a say in.

    With cohesion normal reaction and cone are those of contact, what the joint pulls taken off.

    Attributes
    ----------
    natural_map : The worse of the contact problem's natural maps, in impulses and in velocities; relative.
    rounding : What rounding of the arithmetic alone may make of the natural map.
    max_penetration : Deepest that contacts go into each other [m].
    min_normal_reaction : Least normal reaction, at most 0 [N].
    cone_violation : Worst excess over friction, relative to the largest reaction.
    block_balance, global_balance : What forces and moments miss, of the worst block and of all; relative.
    energy_balance : What the energy ledger misses, relative.
    written : The same of what is written; None where it was not asked for.
    """

    natural_map: float
    rounding: float
    max_penetration: float
    min_normal_reaction: float
    cone_violation: float
    block_balance: float
    global_balance: float
    energy_balance: float
    written: Written | None = None


class Extreme(Told, frozen=True, kw_only=True):
    """A greatest value and where it is.

    Attributes
    ----------
    value : The stress [Pa].
    block : Name of its block.
    """

    value: float
    block: str


class BlockStress(Told, frozen=True, kw_only=True):
    """Mean stress of a block.

    Attributes
    ----------
    block : Its name.
    von_mises : Von Mises' stress [Pa].
    principal : Principal values, shape (3,) [Pa].
    stress : Components xx, yy, zz, xy, yz, xz [Pa].
    """

    block: str
    von_mises: float
    principal: FloatArray
    stress: FloatArray


class BlockYield(Told, frozen=True, kw_only=True):
    """What the material of a block that yielded remembers, such as its plastic strain.

    Attributes
    ----------
    block : Its name.
    measure : What is measured, as fields call it: ``plastic_strain``.
    greatest : Over its Gauss points.
    mean : Over its volume.
    """

    block: str
    measure: str
    greatest: float
    mean: float


class Stress(Told, frozen=True, kw_only=True):
    """Greatest stresses, tension positive, and where they are.

    Attributes
    ----------
    max_von_mises, max_principal, min_principal : Over the Gauss points [Pa].
    max_von_mises_nodal : Of the stress smoothed to the nodes, which pictures show [Pa].
    p95_von_mises : 5 % of the volume have more [Pa].
    blocks : Those of greatest mean von Mises stress.
    error : How wrong all this may be, estimated.
    yielded : Inelastic blocks that have yielded, those that did most first; None where no block is inelastic.
    """

    max_von_mises: Extreme
    max_von_mises_nodal: Extreme
    p95_von_mises: float
    max_principal: Extreme
    min_principal: Extreme
    blocks: tuple[BlockStress, ...]
    error: StressError | None = None
    yielded: tuple[BlockYield, ...] | None = None


class Mover(Told, frozen=True, kw_only=True):
    """A block that moves.

    Attributes
    ----------
    block : Its name.
    speed : Of its fastest corner [m/s].
    how : ``slides``, ``tips``, ``falls`` or ``rises``.
    """

    block: str
    speed: float
    how: str


class Abrupt(Told, frozen=True, kw_only=True):
    """Steps in which some joint lost more than half of its adhesion at once.

    Attributes
    ----------
    steps : How many.
    first, last : Times at their ends [s]; load factors in statics.
    """

    steps: int
    first: float
    last: float


class ScatterTold(Told, frozen=True, kw_only=True):
    """Random fields of the joints' properties.

    Attributes
    ----------
    seeds : Of the joint records that scatter.
    factors : Least and greatest factor on the scene's values, by parameter.
    """

    seeds: tuple[int, ...]
    factors: dict[str, tuple[float, float]]


class SolverTold(Told, frozen=True, kw_only=True):
    """How the contact problem of the last step was solved.

    Attributes
    ----------
    method : Contact solver that ran.
    iterations, linear_solves : How many it took.
    """

    method: str
    iterations: int
    linear_solves: int


class TimeError(Told, frozen=True, kw_only=True):
    """What time steps of a finite length did to the energy, relative to the largest energy of the march.

    Attributes
    ----------
    dissipated : Lost to the time integration.
    imbalance : Appeared or lost without a name.
    note : What these two do not show.
    """

    dissipated: float
    imbalance: float
    note: str | None = None


class ContactError(Told, frozen=True, kw_only=True):
    """Relative changes where the analysis is made again with other contact points.

    Attributes
    ----------
    points, points_again : Numbers of contact points, and of those of the second analysis.
    outcome_again : Its outcome, where this is another.
    note : Why there is nothing to compare.
    supports, probes : Greatest change of a support's force, of a probe's displacement.
    stress, block_stress : Change of the stress in the mean over the volume, of the blocks' mean stresses.
    seconds : CPU time of the second analysis [s].
    """

    points: int | None = None
    points_again: int | None = None
    outcome_again: str | None = None
    note: str | None = None
    supports: float | None = None
    probes: float | None = None
    stress: float | None = None
    block_stress: float | None = None
    seconds: float | None = None


class Errors(Told, frozen=True, kw_only=True):
    """What elements, contact points and steps leave open; what does not apply is None.

    Attributes
    ----------
    stress : Of the elements: estimated, relative, in the energy norm.
    contact : Of the contact points.
    time : Of the time steps.
    """

    stress: float | None = None
    contact: ContactError | None = None
    time: TimeError | None = None


class StartTold(Told, frozen=True, kw_only=True):
    """How an equilibrium may come about.

    Attributes
    ----------
    reached : From a start without stress; False: it stands only if it is pre-stressed; None: not known.
    note : Why it is not known.
    message : In a sentence what it needs, where it is not reached.
    least_thrust : Least pre-stress of a joint with which the loads are carried [N].
    joints : Names of the two blocks between which it is needed.
    mechanism : How the blocks move without it.
    """

    reached: bool | None
    note: str | None = None
    message: str | None = None
    least_thrust: float | None = None
    joints: tuple[tuple[str, str], ...] | None = None
    mechanism: Falling | None = None


class LeftOpen(Told, frozen=True, kw_only=True):
    """An interface whose resultant is not determined as a whole.

    Attributes
    ----------
    interface : Names of its blocks.
    components : Components that are not determined.
    """

    interface: str
    components: tuple[str, ...]


class Determinacy(Told, frozen=True, kw_only=True):
    """Which forces are determined, and the names of those interfaces and supports of which something is not.

    Attributes
    ----------
    reactions : ``least norm`` or ``as solved``; where the last step was not solved it says so, and all else
        is None.
    error : Error of the least-norm reactions, as the contact solver measures it.
    interfaces_determined, interfaces_not_determined : How many.
    not_determined : Interfaces with the components that are not determined, the first 50.
    supports_not_determined : Components that are not determined, by support.
    contacts_unique, contacts_not_unique : How many contacts have the same reaction in every solution.
    """

    reactions: str
    error: float | None = None
    interfaces_determined: int | None = None
    interfaces_not_determined: int | None = None
    not_determined: tuple[LeftOpen, ...] | None = None
    supports_not_determined: dict[str, tuple[str, ...]] | None = None
    contacts_unique: int | None = None
    contacts_not_unique: int | None = None


class Furthest(Told, frozen=True, kw_only=True):
    """The greatest value of all interfaces.

    Attributes
    ----------
    value : Opening or sliding [m].
    interface : Names of the interface's blocks.
    """

    value: float
    interface: str


class Joints(Told, frozen=True, kw_only=True):
    """How many joints are in which state.

    Attributes
    ----------
    open, closed, middle_third, cracked, hinge, held : Numbers of joints, each in one of these states.
    slide : Number of joints that slide, in whichever state.
    greatest_opening, greatest_sliding : How far, and which joint.
    """

    open: int
    closed: int
    middle_third: int
    cracked: int
    hinge: int
    held: int
    slide: int
    greatest_opening: Furthest
    greatest_sliding: Furthest


class LimitAnalysis(Told, frozen=True, kw_only=True, tag_field="schema", tag="limit/1"):
    """What limit analysis says of the blocks where they stand at the start.

    Attributes
    ----------
    title : Of the scene. message : All of this in sentences.
    dead, growing : Names of the loads that stay and of those that grow.
    blocks, contacts : How many there are.
    admissible : Whether the loads of the scene can be carried. share : Part of them that can.
    multiplier : Greatest factor on the growing loads with which they can be carried; None: none grow, none
        can be carried, or they are ``unlimited``.
    least_multiplier : Least such factor, above 0 where the dead loads need the growing ones; None: there is
        none.
    unlimited : Whether the loads may grow without bound.
    mechanism : How the blocks move at collapse, or under loads that cannot be carried.
    supports : Least and greatest force [N] by support and axis; None: no bound.
    inexact : By how much an end of these is less exact than the rest [N]; None: it was not found.
    certificate : Relative errors of the programs that were solved.
    notes : What was taken otherwise than the scene says.
    outside : Forces of a simulation's supports outside these intervals.
    """

    title: str | None = None
    message: str
    dead: tuple[str, ...]
    growing: tuple[str, ...]
    blocks: int
    contacts: int
    admissible: bool
    share: float
    multiplier: float | None
    least_multiplier: float | None
    unlimited: bool
    mechanism: Falling | None
    supports: dict[str, dict[str, tuple[float | None, float | None]]]
    inexact: dict[str, dict[str, float | None]]
    certificate: dict[str, float | None]
    notes: tuple[str, ...]
    outside: tuple[Outside, ...] | None = None


class Outside(Told, frozen=True, kw_only=True):
    """Force of a simulation's support that lies outside its interval.

    Attributes
    ----------
    support : Its name. axis : Component.
    force : The force [N].
    """

    support: str
    axis: str
    force: float


class Round(Told, frozen=True, kw_only=True):
    """One solution of a refinement.

    Attributes
    ----------
    round : From 1. unknowns : Of displacement and contact. meshes : Distinct ones, ``made`` of them new.
    error : Estimated, relative, in the energy norm. refined : Blocks that get finer elements next.
    seconds : CPU time [s].
    """

    round: int
    unknowns: int
    meshes: int
    made: int
    error: float
    refined: int
    seconds: float


class RefinementTold(Told, frozen=True, kw_only=True):
    """How the error of the stress was brought down.

    Attributes
    ----------
    target : Relative error asked for.
    reached : Whether it was reached. message : The same in a sentence.
    rounds : Each solution on the way.
    """

    target: float
    reached: bool
    message: str
    rounds: tuple[Round, ...]


class Summary(Told, frozen=True, kw_only=True, tag_field="schema", tag="run/1"):
    """The end of a run.

    Attributes
    ----------
    title : Of the scene.
    outcome, message : Verdict, and the same as a sentence.
    time : End of the last step [s]; load factor in statics. steps : Steps made.
    blocks, shapes, meshes, interfaces, contacts : How many there are at the end.
    unknowns : Of displacement and contact.
    factorisations : Matrices of elastic shapes that were factorised.
    scatter : Random fields of the joints' properties; None: nothing scatters.
    abrupt : Steps in which joints gave way; None: there were none.
    supports : What each support gives to the blocks, by name.
    applied : Resultant of all loads on the free blocks, shape (d,) [N].
    certificate : How well the equations hold.
    stress : None without elastic blocks.
    probes : Displacement of the named points, shape (d,) [m].
    status : Numbers of contacts that are ``open``, ``stick``, ``slip`` and ``bonded``.
    mechanism : How the structure falls. moving : Blocks that move. Both only with ``no_equilibrium``.
    energy : Where the energy went since the start [J].
    solver : How the last step was solved.
    seconds : CPU time by phase [s]. peak_memory_mb : Greatest resident memory [MB].
    versions : Of this program and its libraries.
    limit_analysis, determinacy, joints : With the keys of ``[output]`` that ask for them.
    start : Whether an equilibrium is reached from a start without stress.
    errors : What elements, contact points and steps leave open.
    refinement : With ``--refine-to``: how the error was brought down.
    remarks : What was logged as a warning.
    """

    title: str
    outcome: Outcome
    message: str
    time: float
    steps: int
    blocks: int
    shapes: int
    meshes: int
    interfaces: int
    contacts: int
    unknowns: int
    factorisations: int
    scatter: ScatterTold | None = None
    abrupt: Abrupt | None = None
    supports: dict[str, Wrench]
    applied: FloatArray
    certificate: Certificate
    stress: Stress | None = None
    probes: dict[str, FloatArray]
    status: dict[str, int]
    mechanism: Falling | None = None
    moving: tuple[Mover, ...]
    energy: Ledger
    solver: SolverTold
    seconds: dict[str, float]
    peak_memory_mb: float
    versions: dict[str, str]
    limit_analysis: LimitAnalysis | None = None
    start: StartTold | None = None
    errors: Errors
    determinacy: Determinacy | None = None
    joints: Joints | None = None
    refinement: RefinementTold | None = None
    remarks: tuple[Remark, ...] = ()

    def __repr__(self) -> str:
        """A short table."""
        rows = dict(self._rows())
        width = max(map(len, rows))
        return "\n".join(f"{name:<{width}}  {value}" for name, value in rows.items())

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "outcome", self.outcome
        yield "message", self.message
        yield "size", f"{self.blocks} blocks, {self.contacts} contacts, {self.unknowns} unknowns"
        yield "end", f"t = {self.time:.6g} after {self.steps} steps"
        certificate, written = self.certificate, self.certificate.written
        yield "balance", f"blocks {certificate.block_balance:.1e}, whole {certificate.global_balance:.1e}"
        overlap = certificate.max_penetration if written is None else written.overlap.value
        yield "overlap", f"{overlap:.2g} m"
        for name, wrench in self.supports.items():
            yield f"support {name}", f"({', '.join(f'{part:.5g}' for part in wrench.force)}) N"
        yield "CPU", f"{sum(self.seconds.values()):.2f} s, {self.peak_memory_mb:.0f} MB"
