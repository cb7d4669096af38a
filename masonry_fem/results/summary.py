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
from masonry_fem.output.response import ResponseTold, SpectraTold
from masonry_fem.records.remark import Remark
from masonry_fem.records.told import Told, versioned
from masonry_fem.results.blocks import Stress
from masonry_fem.results.combinations import Combinations, Places
from masonry_fem.results.damping import DampingTold
from masonry_fem.results.determinacy import Determinacy
from masonry_fem.results.discretisation import Errors, RefinementTold
from masonry_fem.results.joints import Joints, TieTold
from masonry_fem.results.limit_analysis import LimitAnalysis
from masonry_fem.results.utilisation import Utilisation

FloatArray = NDArray[np.float64]

AXES = {2: "xy", 3: "xyz"}

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


class Rounding(Told, frozen=True, kw_only=True):
    """What rounding of the arithmetic alone may make of measures.

    All from one formula: ``nscd.rounding`` derives it for those of the last contact problem,
    ``march.rounding`` for the balances of the structure.

    Attributes
    ----------
    natural_map : Relative, as the measure. max_penetration : By one step [m].
    min_normal_reaction : At most 0 [N]. cone_violation : Relative to the largest reaction.
    block_balance : Relative to the largest impulse on a block.
    global_balance, energy_balance : Relative, as the measures.
    """

    natural_map: float
    max_penetration: float
    min_normal_reaction: float
    cone_violation: float
    block_balance: float
    global_balance: float
    energy_balance: float


class Certificate(Told, frozen=True, kw_only=True):
    """How exact the last state is, by measures that no solver has a say in.

    With cohesion normal reaction and cone are those of contact, what the joint pulls taken off.

    Attributes
    ----------
    natural_map : The worse of the contact problem's natural maps, in impulses and in velocities; relative.
    rounding : What rounding of the arithmetic alone may make of these.
    max_penetration : Deepest that contacts go into each other [m].
    min_normal_reaction : Least normal reaction, at most 0 [N].
    cone_violation : Worst excess over friction, relative to the largest reaction.
    block_balance, global_balance : What forces and moments miss, of the worst block and of all; relative.
    energy_balance : What the energy ledger misses, relative.
    written : The same of what is written; None where it was not asked for.
    """

    natural_map: float
    rounding: Rounding
    max_penetration: float
    min_normal_reaction: float
    cone_violation: float
    block_balance: float
    global_balance: float
    energy_balance: float
    written: Written | None = None


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
    rounds : Iterations of Newton's method on stones that yield; None where all are linear.
    """

    method: str
    iterations: int
    linear_solves: int
    rounds: int | None = None


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


class WorkTold(Told, frozen=True, kw_only=True):
    """What ranks have spent on one kind of work, each a number for every rank, the one that leads first.

    Attributes
    ----------
    seconds : CPU time, in which MPI waits for other ranks, too [s].
    wall : Wall-clock time [s].
    received : What came from other ranks [MB].
    times : How often some came.
    """

    seconds: tuple[float, ...]
    wall: tuple[float, ...]
    received: tuple[float, ...]
    times: tuple[int, ...]


class RanksTold(Told, frozen=True, kw_only=True):
    """Several ranks.

    Attributes
    ----------
    count : How many there were. peak_memory_mb : Greatest resident memory of each [MB].
    work : What each has spent, by kind of work; None: nothing of this scene is split.
    """

    count: int
    peak_memory_mb: tuple[float, ...]
    work: dict[str, WorkTold] | None = None


class StageTold(Told, frozen=True, kw_only=True):
    """A stage of a history.

    Attributes
    ----------
    name : Of the stage, and of the folder with its results.
    after : Name of the stage where it began; None: in the reference, or where the scene says.
    outcome, message : Verdict, and the same as a sentence.
    time : End of its last step [s]; load factor in statics. steps : Steps made.
    supports : What each support gives to the blocks at its end, by name.
    """

    name: str
    after: str | None = None
    outcome: str
    message: str
    time: float
    steps: int
    supports: dict[str, Wrench]


class Summary(Told, frozen=True, kw_only=True, tag_field="schema", tag=versioned("run")):
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
    load_factors : Partial factors by which loads were multiplied, by kind; None: all are 1.
    damping : What damps a march in time; None in statics.
    certificate : How well the equations hold.
    stress : None without elastic blocks. utilisation : None where no stone has a strength.
    ties : What each straight part of a tie bears, by name; None where there are none.
    probes : Displacement of the named points, shape (d,) [m].
    response : Of the probes in dynamics, by name; None in statics, without probes or a results folder.
    spectra : Response spectra of probes and accelerograms; None where there are none of the latter.
    status : Numbers of contacts that are ``open``, ``stick``, ``slip`` and ``bonded``.
    mechanism : How the structure falls. moving : Blocks that move. Both only with ``no_equilibrium``.
    energy : Where the energy went since the start [J].
    solver : How the last step was solved.
    seconds : CPU time by phase [s]. peak_memory_mb : Greatest resident memory [MB].
    ranks : What several ranks have spent; None: there was one process.
    versions : Of this program and its libraries.
    limit_analysis, determinacy, joints : With the keys of ``[output]`` that ask for them.
    start : Whether an equilibrium is reached from a start without stress.
    stages : Of a history, whose last one is told by all else; None: there are none.
    combinations : Of loads, with their envelope; all else is of the last one, or the first that failed.
    places : Of a load that moves, with their envelope; all else is of the last one; None: none moves.
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
    load_factors: dict[str, float] | None = None
    damping: DampingTold | None = None
    certificate: Certificate
    stress: Stress | None = None
    utilisation: Utilisation | None = None
    ties: dict[str, TieTold] | None = None
    probes: dict[str, FloatArray]
    response: dict[str, ResponseTold] | None = None
    spectra: SpectraTold | None = None
    status: dict[str, int]
    mechanism: Falling | None = None
    moving: tuple[Mover, ...]
    energy: Ledger
    solver: SolverTold
    seconds: dict[str, float]
    peak_memory_mb: float
    ranks: RanksTold | None = None
    versions: dict[str, str]
    limit_analysis: LimitAnalysis | None = None
    start: StartTold | None = None
    stages: tuple[StageTold, ...] | None = None
    combinations: Combinations | None = None
    places: Places | None = None
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
        from masonry_fem.output.components import in_words  # noqa: PLC0415 - only what is shown needs it

        yield "outcome", self.outcome.replace("_", " ")
        yield "message", self.message
        yield "size", f"{self.blocks} blocks, {self.contacts} contacts, {self.unknowns} unknowns"
        yield "end", f"t = {self.time:.6g} after {self.steps} step{'' if self.steps == 1 else 's'}"
        if self.utilisation is not None and self.utilisation.worst:
            worst = self.utilisation.worst[0]
            used = worst.of_mean if worst.local is None else worst.local
            error = "" if worst.error is None else f" ± {worst.error:.1g}"
            yield "utilisation", f"at most {used:.2g}{error}, {worst.governs} in {worst.block} (1 is all)"
        certificate, written = self.certificate, self.certificate.written
        yield "balance", f"blocks {certificate.block_balance:.1e}, whole {certificate.global_balance:.1e}"
        overlap = certificate.max_penetration if written is None else written.overlap.value
        yield "overlap", f"{overlap:.2g} m"
        unit = "N/m" if len(self.applied) == 2 else "N"
        for name, wrench in self.supports.items():
            yield f"support {name}", in_words(wrench.force, unit, AXES[len(wrench.force)], 5)
        yield "CPU", f"{sum(self.seconds.values()):.2f} s, {self.peak_memory_mb:.0f} MB"
