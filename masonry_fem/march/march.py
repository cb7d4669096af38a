"""March: steps one after another until a strategy is satisfied or nothing more can be done.

made = march(model, Statics(), SolverSettings())
made.outcome, made.message, made.state, made.report

``marching`` makes the same march step by step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from masonry_fem.errors import MasonryError
from masonry_fem.march.acting import acted, extents
from masonry_fem.march.clock import Clock
from masonry_fem.march.coupling import Coupling, connect
from masonry_fem.march.deformation import beyond_small
from masonry_fem.march.equilibrium import Strategy
from masonry_fem.march.increments import Headway, increments, rested
from masonry_fem.march.ledger import Ledger
from masonry_fem.march.measure import measure
from masonry_fem.march.model import Model
from masonry_fem.march.overhang import tell_overhang
from masonry_fem.march.standing import Found, Keep, Standing
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment, initial_state
from masonry_fem.march.step_report import StepReport
from masonry_fem.march.troubles import Troubles, tell_flowed, tell_promoted
from masonry_fem.march.verdict import End, Verdict, could_rest, drift, sentence, within_tolerance
from masonry_fem.march.witness import Witness
from masonry_fem.nscd import Outcome, SolverSettings
from masonry_fem.records.remark import remark

DOUBTFUL = 1e-6  # of a block's load: what its equation of motion may miss without a word
TURNED = 1e-2  # of a block's load: what turning may leave of balance in what is written without a word
ROUNDING = 1e-9  # of a time
BEARABLE = 1e-3  # error up to which a transient march bears a step that missed its tolerance


class Observer(Protocol):
    """Who is told of each step (recorders, progress)."""

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """See the state that a step reached."""
        ...


type Seeing = Callable[[Model, SystemState, StepReport], object]
"""An observer as a function of model, state and report; what it returns is not looked at."""


@dataclass(frozen=True, slots=True)
class _Seer:
    """An observer made of a function."""

    see: Seeing

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        self.see(model, state, report)


def seen_by(observers: Sequence[Observer | Seeing]) -> tuple[Observer, ...]:
    """Observers, functions among them as such.

    Parameters
    ----------
    observers : Recorders, or functions of model, state and report.

    Raises
    ------
    MasonryError : One is neither.
    """
    made: list[Observer] = []
    for one in observers:
        if hasattr(one, "record"):
            made.append(one)
        elif callable(one):
            made.append(_Seer(one))
        else:
            raise MasonryError(
                f"observers has {one!r:.60}, expected a function of model, state and report, or an object "
                "with a method record(model, state, report)"
            )
    return tuple(made)


class StepMade(NamedTuple):
    """One step of an analysis; unpack it as ``model, state, report``.

    Attributes
    ----------
    model : The structure, with the contacts of this step.
    state : State at the end: motion of the blocks, forces, gaps and status of the contacts.
    report : Energies, probes, support forces and errors of the step.
    """

    model: Model
    state: SystemState
    report: StepReport


@dataclass(frozen=True, slots=True)
class March:
    """How a march ended.

    Attributes
    ----------
    outcome, message : Verdict and its sentence.
    state, report : The last state and what its step did.
    model : What the last step was made with. last : Everything of that step.
    ledger : Energies summed over the march.
    seconds : CPU time by phase [s]: factorise, solve, step, measure and output.
    moving : Blocks that move where there is no equilibrium: (name, speed [m/s], how).
    abrupt : Times of the steps in which some joint lost more than half of its adhesion at once.
    witness : What the written results leave open, worst over the steps.
    standing : What another march goes on from, with more steps; None where no more steps can be made of it.
    """

    outcome: Verdict
    message: str
    state: SystemState
    report: StepReport
    model: Model
    last: Increment
    ledger: Ledger
    seconds: dict[str, float]
    moving: tuple[tuple[str, float, str], ...]
    abrupt: tuple[float, ...] = ()
    witness: Witness | None = None
    standing: Standing | None = None


def marching(
    model: Model,
    strategy: Strategy,
    settings: SolverSettings,
    *,
    bodies: tuple[Any, ...] | None = None,
    start: SystemState | None = None,
    observers: Sequence[Observer] = (),
    keep: int | None = None,
    kept: list[tuple[Model, Increment]] | None = None,
    going_on: tuple[Model, Standing] | None = None,
    keeper: Keep | None = None,
) -> Generator[StepMade, None, March]:
    """Make the steps of a strategy until it is satisfied, its steps are used up, or nothing more can be done.

    Yields each step that is balanced, and returns how the march ended.

    Parameters
    ----------
    model : The structure.
    strategy : Which steps are made, and when they have arrived.
    settings : Of the contact solver.
    bodies : Body states to begin with, one a group; by default blocks are at rest in the reference.
    start : State where another march ended, to go on from; takes the place of ``bodies``.
    observers : Are told of each step.
    keep : Number of a step that is kept with its model, so that its contact problem can be solved again.
    kept : List that this step is appended to.
    going_on : What the same march knew between two steps, and the structure with the contacts that it had
        then; the steps before are not made again.
    keeper : Is given what the march knows between its steps. Each step then begins as one that goes on from
        there, so that both give the same bits.
    """
    first, headway = _controlled(model, strategy), Headway(seams=keeper is not None)
    if going_on is None:
        course = _Course.begun(first, bodies, start, headway)
    else:
        course = _Course.taken_up(first, _controlled(going_on[0], strategy), going_on[1], headway)
    size = extents(first.assembly)
    verdict: Verdict | None
    for coupling, step in increments(
        course.coupling, strategy, course.state, settings, course.clock, course.witness.lookout, headway
    ):
        course.coupling, acting = coupling, acted(coupling.model, step, size)
        report = measure(coupling.model, coupling, acting, headway.largest)
        made = course.made = _Made(coupling.model, acting, report)
        if keep == made.report.step and kept is not None:
            kept.append((made.model, made.step))
        if course.lost_balance(made):
            verdict = "no_convergence"
            break
        course.see(made, observers)
        yield StepMade(made.model, made.step.after, made.report)
        verdict = course.verdict(made, strategy)
        if verdict is not None:
            break
        if keeper is not None and headway.whole and headway.more:
            keeper.between(course.standing(made, strategy))
            course.clock.lap("output")
    else:
        verdict = _out_of_steps(made.model, strategy, course.start, made.step, made.report, settings)
    reached = course.reached(strategy)
    if keeper is not None:
        keeper.reached(reached)
    return course.ended(verdict, strategy, settings, reached)


def _to_its_end[**P](course: Callable[P, Generator[StepMade, None, March]]) -> Callable[P, March]:
    """All steps of a march at once."""

    def march(*given: P.args, **keys: P.kwargs) -> March:
        """Make all steps of ``marching``, with the same parameters, and say how they ended."""
        steps = course(*given, **keys)
        while True:
            try:
                next(steps)
            except StopIteration as end:
                made: March = end.value
                return made

    return march


march = _to_its_end(marching)


@dataclass(slots=True)
class _Course:
    """A march under way.

    Attributes
    ----------
    first : The structure at its start. coupling : With the contacts of its last step.
    start, state : Where it began, and where its next steps begin.
    made : Its last step. balanced : The last one whose balance is one; results are of that.
    """

    first: Model
    coupling: Coupling
    start: SystemState
    state: SystemState
    witness: Witness
    headway: Headway
    ledger: Ledger = field(default_factory=Ledger)
    troubles: Troubles = field(default_factory=Troubles)
    clock: Clock = field(default_factory=Clock)
    made: _Made | None = None
    balanced: _Made | None = None

    @classmethod
    def begun(
        cls, model: Model, bodies: tuple[Any, ...] | None, start: SystemState | None, headway: Headway
    ) -> _Course:
        """Before the first step."""
        clock, coupling = Clock(), connect(model)
        start = _begun(model, coupling, bodies) if start is None else start
        return cls(model, coupling, start, start, Witness(model, start.bodies), headway, clock=clock)

    @classmethod
    def taken_up(cls, first: Model, model: Model, at: Standing, headway: Headway) -> _Course:
        """Between two steps, with the contacts that it had then."""
        clock, coupling, witness = Clock(), connect(model), Witness(first, at.start.bodies)
        coupling.structure.factored = at.factored
        headway.done, headway.largest = at.done, at.largest
        course = cls(first, coupling, at.start, at.state, witness, headway, at.ledger, clock=clock)
        witness.go_on(at.seen)
        course.troubles.go_on(at.troubles)
        clock.phases.update(at.seconds)
        return course

    def lost_balance(self, made: _Made) -> bool:
        """Whether a step is not balanced while one before it was: results are of that one."""
        return bool(made.report.unsettled) and self.balanced is not None

    def see(self, made: _Made, observers: Sequence[Observer]) -> None:
        """Enter a step that is balanced, and show it."""
        self.balanced = made
        self.witness.see(made.model, made.step.after)
        self.clock.lap("measure")
        self.ledger = self.ledger.add(made.report)
        for observer in observers:
            observer.record(made.model, made.step.after, made.report)
        self.clock.lap("output")

    def verdict(self, made: _Made, strategy: Strategy) -> Verdict | None:
        """The verdict where the march ends with a step."""
        hopeless = _hopeless(made.report, made.static)
        if hopeless is not None:
            return hopeless
        self.troubles.see(made.step, made.report)
        return _arrived(made.model, strategy, made.report)

    def standing(self, made: _Made, strategy: Strategy) -> Standing:
        """All that is known after a step."""
        model, headway = made.model, self.headway
        built = model.contacts is self.first.contacts and not model.found
        found = None if built else Found(model.interfaces, model.contacts, model.joint_records)
        state = rested(model, made.step.after, strategy.kept)
        return Standing(
            headway.done, headway.largest, self.start, state, found,
            self.ledger, self.witness.seen, self.troubles.noted, dict(self.clock.phases),
            self.coupling.structure.factored,
            tuple(group.warmed(own) for group, own in zip(model.groups, state.bodies, strict=True)),
            model.ageing is not None,
        )  # fmt: skip

    def reached(self, strategy: Strategy) -> Standing | None:
        """Where more steps can be made from; None where none can."""
        assert self.made is not None
        assert self.balanced is not None
        hopeless = _hopeless(self.made.report, self.made.static) is not None
        return None if hopeless or not self.headway.whole else self.standing(self.balanced, strategy)

    def ended(
        self, verdict: Verdict, strategy: Strategy, settings: SolverSettings, reached: Standing | None
    ) -> March:
        """The results, with what is doubtful of them told."""
        assert self.made is not None
        assert self.balanced is not None
        last, witness, troubles = self.made, self.witness, self.troubles
        model, made, report = self.balanced.model, self.balanced.step, self.balanced.report
        if made.problem.structure is not None:
            made.problem.structure.empty()
        witness.end(model, made.after)
        troubles.tell_steps(report, strategy, settings)
        tell_promoted(model, made.after)
        flowed = tell_flowed(model, made.after)
        tell_overhang(model, made)
        verdict, objection = _witnessed(verdict, witness, model, made, report, settings, static=last.static)
        troubles.tell_overlaps(made, report, model.length, self.start.gap)
        if objection and flowed:
            objection = f"{flowed}. {objection}"
        drifts = strategy.balanced(last.report) and strategy.kept == 1
        end = End(last.model, last.step, last.report, settings, self.ledger, objection, drifts)
        return March(
            verdict, sentence(verdict, end), made.after, report, model, made, self.ledger, self.clock.phases,
            end.moving(verdict), tuple(troubles.abrupt), witness, reached,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Made:
    """A step, the model that it was made with, and what it did."""

    model: Model
    step: Increment
    report: StepReport

    @property
    def static(self) -> bool:
        """Whether it is one of statics."""
        return self.step.scheme.inertia == 0


def _controlled(model: Model, strategy: Strategy) -> Model:
    """The model with the displacement by which a strategy finds the load factor."""
    control = strategy.control(model.probes)
    return model if control is model.control else replace(model, control=control)


def _witnessed(
    verdict: Verdict,
    witness: Witness,
    model: Model,
    made: Increment,
    report: StepReport,
    settings: SolverSettings,
    *,
    static: bool,
) -> tuple[Verdict, str]:
    """The verdict, and what speaks against an equilibrium, "" if nothing does.

    Then there is none that was found. Doubts about a good end are told.
    """
    reached = _reached(report, settings)
    bound = max(DOUBTFUL, 1e3 * reached)
    still = within_tolerance(made, report, reached)
    buried = witness.objection(math.inf, still, static=static)  # blocks that are in each other
    objection = witness.objection(bound, still, static=static)
    pair = witness.overlap.blocks
    objection = _with_cure(objection, model, pair if objection == buried else (), static=static)
    if verdict == "finished" or (verdict == "equilibrium" and not objection):
        _doubt(model, made, report, bound)
        _tell_written(witness, _with_cure(buried, model, pair, static=static), made.scheme.step)
        _tell_drift(drift(model, made, report, reached), made.scheme.step)
    return ("no_convergence" if verdict == "equilibrium" and objection else verdict), objection


def _begun(model: Model, coupling: Coupling, bodies: tuple[Any, ...] | None) -> SystemState:
    """The state that a march begins with where none is given."""
    placed = tuple(group.rest() for group in model.groups) if bodies is None else bodies
    return initial_state(model, coupling, placed)


def _reached(report: StepReport, settings: SolverSettings) -> float:
    """The error that a step was solved to: the tolerance, or what came nearest to it."""
    inexact = report.outcome is Outcome.INEXACT
    return max(settings.tolerance, report.quality.error) if inexact else settings.tolerance


def _arrived(model: Model, strategy: Strategy, report: StepReport) -> Verdict | None:
    """The verdict where loads change no more and the strategy is satisfied, else None."""
    if report.time >= model.changing * (1 - ROUNDING) and strategy.settled(report):
        return "equilibrium" if report.joint_change == 0 else "no_convergence"
    return None


def _out_of_steps(
    model: Model,
    strategy: Strategy,
    start: SystemState,
    made: Increment,
    report: StepReport,
    settings: SolverSettings,
) -> Verdict:
    """The verdict where the steps were used up."""
    if not strategy.seeks_equilibrium:
        return "finished"
    # a step that was not solved says nothing of what exists, nor does a march that was too short
    may_rest = strategy.balanced(report) or could_rest(model, start, made, report, _reached(report, settings))
    if may_rest or not report.outcome.solved:
        return "no_convergence"
    return "no_equilibrium"


def _doubt(model: Model, made: Increment, report: StepReport, bound: float) -> None:
    """Say where a state that the solver and the steps are content with is not to be relied on."""
    beyond = beyond_small(model, made.after)
    if beyond is not None:
        remark(
            "large_strain",
            f"{beyond}: elastic blocks are computed for small strains (some per cent), and for small turns "
            "(some degrees) where they are clamped or contact.update = 'fixed'; do not rely on the result, "
            "look at materials.*.young and the loads, or make blocks rigid",
        )
    if max(report.block_balance, report.global_balance) > bound:
        remark(
            "imbalance",
            f"forces balance to {max(report.block_balance, report.global_balance):.0e} of a "
            "block's load only, which is rounding: blocks are too slender, or stiffnesses, sizes "
            "or masses lie too far apart; stresses there may be wrong by as much or more",
        )


def _with_cure(objection: str, model: Model, pair: tuple[str, ...], *, static: bool) -> str:
    """An objection to what is written, and what may help; ``pair``: blocks that are in each other, if any."""
    if not objection:
        return ""
    cure = "Take more load steps" if static else "Take shorter steps"
    if not pair:
        return f"{objection}. {cure}."
    if _impacts(model, pair):
        return (
            f"{objection}: contacts of form = 'velocity' act once faces have met, which may then be half of "
            f"speed times step in each other, or a little more. {cure}."
        )
    if model.meet is None:
        cure = "With contact.update = 'fixed' blocks go through each other: leave it out"
    elif model.update is None:
        cure += ", or contact.update = 'redetect' for rigid blocks that go far"
    else:
        cure += ", or move the blocks apart"
    return f"{objection}: contact between them came too late, or not at all. {cure}."


def _impacts(model: Model, pair: tuple[str, ...]) -> bool:
    """Whether contacts between two blocks are written in velocities."""
    names = np.array(model.assembly.blocks.names)
    between = np.isin(names[model.contacts.blocks], pair).all(axis=1)
    return bool((between & model.laws.in_velocities).any())


def _tell_written(witness: Witness, buried: str, step: float) -> None:
    """Say what the written results leave open, where a reader would not expect it."""
    if buried:
        remark("interpenetration", buried, *witness.overlap.blocks)
    left = witness.balance
    if left.value >= TURNED:
        remark(
            "written_balance",
            f"blocks move so far in a step of {step:g} s that the written forces leave "
            f"{left.value:.2g} of its load on '{left.blocks[0]}' (step {left.step}): take shorter "
            "steps",
            *left.blocks,
        )
    turned = witness.turning
    if turned.value >= TURNED:
        remark(
            "written_turning",
            f"where '{turned.blocks[0]}' is now forces leave {turned.value:.2g} of its load times "
            f"its size (step {turned.step}): elastic blocks that are clamped, and all where contact.update = "
            "'fixed', balance where they were at the start, and thrusts are off by about that share of the "
            "load; leave contact.update out, or hold the block by a support in contact instead of a clamp",
            *turned.blocks,
        )


def _tell_drift(far: float, step: float) -> None:
    """Say how far blocks were carried at speeds that the solver does not resolve [m], unless it is 0."""
    if far > 0:
        remark(
            "long_step",
            f"a step of {step:g} s is so long that speeds below the solver's tolerance "
            f"carry blocks {far:.1e} m away in it: forces may be right, places are not; take "
            "shorter steps, or kind = 'statics'",
        )


def _hopeless(report: StepReport, static: bool) -> Verdict | None:
    """Why the march cannot go on after a step, or None; statics bears no miss."""
    if report.unsettled:
        return "no_convergence"
    if report.outcome.moves:
        return "no_equilibrium"
    if report.outcome.solved:
        return None
    # by impulses alone a tall stack's error looks 1e-5 where two thirds of its weight are missing
    if static or not report.quality.error <= BEARABLE:
        return "no_convergence"
    return None
