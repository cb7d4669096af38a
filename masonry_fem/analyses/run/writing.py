"""Writing: a scene is run into a folder, or a run goes on there.

result = run(load("arch.toml"), Path("results"), base=Path("."))
result.files
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from msgspec import structs

from masonry_fem.analyses.run.asked import answered, limits_of
from masonry_fem.analyses.run.combinations import run_combinations
from masonry_fem.analyses.run.keeping import Keeper
from masonry_fem.analyses.run.places import PlacesTable
from masonry_fem.analyses.run.reopening import begun
from masonry_fem.analyses.run.response import responded
from masonry_fem.analyses.run.result import RunResult
from masonry_fem.analyses.run.solving import told
from masonry_fem.analyses.run.stages import run_stages
from masonry_fem.build import Built, build
from masonry_fem.build.going_on import gone_on
from masonry_fem.build.strengths import strengths_of
from masonry_fem.errors import MasonryError, OutputError
from masonry_fem.host.phases import phase
from masonry_fem.march.clock import Clock
from masonry_fem.march.march import March, Observer, Seeing, march, seen_by
from masonry_fem.march.model import Model
from masonry_fem.march.standing import Standing
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.nscd import save_problem
from masonry_fem.output.asked import recorders
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, CheckpointError
from masonry_fem.output.display import shown
from masonry_fem.output.folder import Folder, ended_by, refuse_busy
from masonry_fem.output.history import History
from masonry_fem.output.recorder import Recorder, Recorders, Request
from masonry_fem.output.terminal import Progress
from masonry_fem.output.tie_table import TieTable
from masonry_fem.records.remark import Remark, gathered, remark
from masonry_fem.records.told import Ending, write
from masonry_fem.records.tree import same_bits
from masonry_fem.results.limit_analysis import LimitAnalysis
from masonry_fem.results.summary import Summary
from masonry_fem.scene import check, of_records, save, specs
from masonry_fem.scene.writing import moved

# what a run that goes on finds in its folder; it makes the rest anew
KEPT = (CHECKPOINT, "history.csv", "fields/")


def run(
    scene: specs.Scene,
    out: str | Path,
    *,
    base: str | Path = Path(),
    save_contact: int | None = None,
    quiet: bool = True,
    before: Built | None = None,
    draws: Callable[[Built, March], bool] | None = None,
    observers: Sequence[Observer | Seeing] = (),
) -> RunResult:
    """Solve a scene and write its results to the folder ``out``.

    Parameters
    ----------
    scene : What to solve.
    out : Folder for the results; created if it is missing.
    base : Folder that the paths in the scene are relative to.
    save_contact : Step whose contact problem is saved as ``contact_<step>.npz``.
    quiet : Whether to show no progress on a terminal.
    before : ``built`` of an earlier result of the same scene with other meshes; parts that are the same are
        used again.
    draws : Called after the last step; whether to draw the pictures that the scene asks for.
    observers : Called after every step: functions of model, state and report (see ``steps``), or recorders.

    Raises
    ------
    MasonryError : The scene cannot be built or has no such step; nothing is written then.
    """
    out, base, told_too = Path(out), Path(base), seen_by(observers)
    scene = of_records(scene, base=base)
    if scene.stages:
        if save_contact is not None:
            raise MasonryError("a contact problem is saved of a single analysis, and the scene has stages")
        with shown(not quiet):
            return run_stages(scene, out, base, partial(_stage, base=base, observers=told_too))
    if scene.combinations:
        if save_contact is not None:
            raise MasonryError("a contact problem is saved of a single run, and the scene has combinations")
        with shown(not quiet):
            return run_combinations(scene, out, base, partial(_combination, base=base, observers=told_too))
    with shown(not quiet):
        order = _Order(
            scene, out, base, save_contact=save_contact, before=before, draws=draws, observers=told_too
        )
        return _written(order)


def go_on(scene: specs.Scene, out: Path, checkpoint: Checkpoint, *, quiet: bool = True) -> RunResult:
    """Make the steps of a run that its checkpoint lacks, and write its results as if it had gone on.

    Parameters
    ----------
    scene : Of the checkpoint; its analysis may have more steps. out : Results folder.
    checkpoint : Where to go on. quiet : Do not show on a terminal what is being done.

    Raises
    ------
    MasonryError : The checkpoint does not fit the scene.
    """
    with shown(not quiet):
        if scene.stages:
            return run_stages(scene, out, out, partial(_stage, base=out), goes_on=True)
        if scene.combinations:
            own = partial(_combination, base=out, observers=())
            return run_combinations(scene, out, out, own, goes_on=True)
        return _written(_Order(scene, out, out, checkpoint))


def _stage(
    scene: specs.Scene,
    out: Path,
    checkpoint: Checkpoint | None,
    *,
    base: Path,
    observers: tuple[Observer, ...] = (),
) -> RunResult:
    """Run a stage, or go on with it; one that is done makes no steps."""
    return _written(_Order(scene, out, base, checkpoint, observers=observers))


def _combination(
    scene: specs.Scene, out: Path, before: Built, checkpoint: Checkpoint | None, *, base: Path,
    observers: tuple[Observer, ...],
) -> RunResult:  # fmt: skip
    """Run a load combination, or go on with it, with the meshes, matrices and factors of the one before."""
    return _written(_Order(scene, out, base, checkpoint, before=before, observers=observers))


@dataclass(frozen=True, slots=True)
class _Order:
    """What is to be run, as for ``run``, and where it goes on; None: from its start."""

    scene: specs.Scene
    out: Path
    base: Path
    checkpoint: Checkpoint | None = None
    save_contact: int | None = None
    before: Built | None = None
    draws: Callable[[Built, March], bool] | None = None
    observers: tuple[Observer, ...] = ()


def _written(order: _Order) -> RunResult:
    """Solve a scene and write its results."""
    with gathered() as remarks:
        job = _prepared(order, remarks)
        keeps = () if order.checkpoint is None else KEPT
        with Folder(order.out, "run", title=job.scene.title, clears=("view", "report"), keeps=keeps):
            try:
                return job.done()
            except BaseException as error:  # what was written so far is left readable, and says what it is
                job.give_up(error)
                raise


def _prepared(order: _Order, remarks: list[Remark]) -> _Job:
    """All that is done before a file is written, and may be refused."""
    scene, out, base, checkpoint = order.scene, order.out, order.base, order.checkpoint
    scene = _reported(check(scene, base=base))
    _check_step(order.save_contact, scene.analysis.steps)
    refuse_busy(out)  # before the work of building
    built, start = begun(scene, build(scene, base, order.before), base)
    places = PlacesTable(scene, built, out) if scene.loads.moving else None
    made = _recorders(scene, built, out, places)
    limits = limits_of(scene, built)
    going_on = None
    if checkpoint is not None and checkpoint.standing is not None:
        going_on = (gone_on(scene, built, base, checkpoint.standing), checkpoint.standing)
        if start is not None and not same_bits(start, checkpoint.standing.start):
            raise CheckpointError(
                f"the state in {scene.analysis.start}, where the run started, has changed since; restore it, "
                "or run the scene again"
            )
        remarks[:] = checkpoint.remarks  # has what building it remarked on already
    keeper = Keeper.of(order.scene, base, out, made, remarks)
    return _Job(order, scene, built, start, limits, going_on, made, keeper, remarks, places)


@dataclass(slots=True)
class _Job:
    """A run under way in its folder.

    Attributes
    ----------
    order : What is to be run. scene : The same, checked. built : Made of it.
    start : State that it starts from; None: at rest in the reference.
    limits : What limit analysis says of it. going_on : Where the march goes on.
    recorders, keeper : Write results, and checkpoints. remarks : Made so far; grows.
    places : Tables of a load that moves; None: none does.
    figures : The summary as far as it is known.
    """

    order: _Order
    scene: specs.Scene
    built: Built
    start: SystemState | None
    limits: LimitAnalysis | None
    going_on: tuple[Model, Standing] | None
    recorders: Recorders
    keeper: Keeper | None
    remarks: list[Remark]
    places: PlacesTable | None
    figures: Summary | None = field(default=None, init=False)

    def done(self) -> RunResult:
        """March to the end and write all of it."""
        out = self.order.out
        save(moved(self.scene, self.order.base, out), out / "as_run.toml")
        self._open()
        result, kept = self._solved()
        with phase("results"):
            return self._told(result, kept)

    def _told(self, result: RunResult, kept: list[tuple[Model, Increment]]) -> RunResult:
        """The result with its files written."""
        out, recorders, clock = self.order.out, self.recorders, Clock()
        draws = self.order.draws is None or self.order.draws(self.built, result.march)
        if not draws:
            recorders.undrawn()
        recorders.end(result.march, result.determinacy)
        files = recorders.close(result.summary) + self._saved_problem(kept)
        result, more = responded(self.scene, out, result, draws=draws)
        files += more
        if self.places is not None:
            result, more = self.places.told(result, draws=draws)
            files += more
        clock.lap("output")
        seconds = dict(result.summary.seconds)
        seconds["output"] = round(seconds["output"] + clock.phases["output"], 4)
        result = result.telling(seconds=seconds, remarks=tuple(self.remarks))
        files += [out / "as_run.toml", write(out / "summary.json", result.summary)]
        files += recorders.finish()
        if self.keeper is not None:
            files.append(self.keeper.end(result.outcome))
        return replace(result, files=files)

    def give_up(self, error: BaseException) -> None:
        """Leave what there is, and say what ended it; without a place for that the summary says "running"."""
        out = self.order.out
        hold = "history.csv and the field files hold the steps so far"
        if self.keeper is not None:
            hold += f"; 'masonry-fem resume {out}' goes on"
        with contextlib.suppress(OutputError):
            ending: Summary | Ending = ended_by(error, "run", self.scene.title, hold)
            if self.figures is not None:
                known = {"outcome": ending.outcome, "message": ending.message, "remarks": tuple(self.remarks)}
                ending = structs.replace(self.figures, **known)
            write(out / "summary.json", ending)
            self.recorders.close(ending)

    def _open(self) -> None:
        """Begin the files, or go on with them."""
        if self.going_on is not None:
            assert self.order.checkpoint is not None  # it goes on from there
            self.recorders.go_on(self.built.model, self.order.checkpoint.outputs)
            return
        self.recorders.start(self.built.model)
        if self.keeper is not None:
            self.keeper.begin()

    def _solved(self) -> tuple[RunResult, list[tuple[Model, Increment]]]:
        """The march with all that is asked of its end, and the step whose contact problem is saved."""
        scene, built = self.scene, self.built
        kept: list[tuple[Model, Increment]] = []
        made = march(
            built.model, scene.analysis, scene.solver.settings, bodies=built.bodies, start=self.start,
            observers=(self.recorders, *self.order.observers), keep=self.order.save_contact, kept=kept,
            going_on=self.going_on,
            keeper=self.keeper,
        )  # fmt: skip
        with phase("measures"):
            result = told(scene, built, made, self.limits)
            self.figures = result.summary
            result = answered(scene, self.order.base, result)
            self.figures = result.summary
        return result, kept

    def _saved_problem(self, kept: list[tuple[Model, Increment]]) -> list[Path]:
        """The file of the contact problem that is asked for."""
        step = self.order.save_contact
        if step is None:
            return []
        if not kept:
            remark("unsaved", f"step {step} was not reached: its contact problem is not saved")
            return []
        from masonry_fem.output.contact_file import found_arrays  # noqa: PLC0415 - only who asks needs it

        path = self.order.out / f"contact_{step}.npz"
        model, made = kept[0]
        save_problem(made.problem, path, found_arrays(made, model))
        return [path]


def _reported(scene: specs.Scene) -> specs.Scene:
    """The scene with what a report of it tells."""
    if not scene.output.report or scene.output.interfaces:
        return scene
    return structs.replace(scene, output=structs.replace(scene.output, interfaces=True))


def _check_step(save_contact: int | None, steps: int) -> None:
    if save_contact is not None and save_contact not in range(1, steps + 1):
        expected = "1, the only step" if steps == 1 else f"a step from 1 to {steps}"
        raise MasonryError(f"step to save is {save_contact!r}, expected {expected} of this analysis")


def _recorders(scene: specs.Scene, built: Built, out: Path, places: PlacesTable | None) -> Recorders:
    statics = not scene.analysis.inertia
    strengths, asked = strengths_of(scene, built.stones), scene.output
    if asked.stones is None:
        asked = structs.replace(asked, stones=strengths is not None or asked.report)
    request = Request(out, scene.title, asked, statics, built.stones.material, strengths)
    always: list[Recorder] = [_progress(scene), History(out)]
    if places is not None:
        always.append(places)
    if scene.ties:
        always.append(TieTable(out))
    return Recorders([*always, *recorders(request)], asked.every)


def _progress(scene: specs.Scene) -> Progress:
    plan = scene.analysis
    if plan.parts > 1:  # how many steps there will be is not known
        return Progress(end=1.0)
    return Progress(plan.steps)
