"""Run: a scene from its description to results on disk.

from masonry_fem.scene import load
from masonry_fem.analyses.run import run
result = run(load("arch.toml"), Path("results"), base=Path("."))
result.outcome, result.summary.supports, result.files
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import structs

from masonry_fem.analyses.discretisation import errors_of
from masonry_fem.analyses.keeping import Keeper
from masonry_fem.analyses.reopening import Begun, begun
from masonry_fem.analyses.stages import run_stages
from masonry_fem.analyses.start import said, started
from masonry_fem.build import Built, build, solver_settings
from masonry_fem.build.going_on import gone_on
from masonry_fem.build.strengths import strengths_of
from masonry_fem.errors import MasonryError, OutputError, ProblemError
from masonry_fem.march.clock import Clock
from masonry_fem.march.march import March, Observer, march
from masonry_fem.march.model import Model
from masonry_fem.march.standing import Standing
from masonry_fem.march.step import Increment
from masonry_fem.nscd import save_problem
from masonry_fem.output.asked import recorders
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, CheckpointError
from masonry_fem.output.folder import Folder, ended_by, refuse_busy
from masonry_fem.output.history import History
from masonry_fem.output.recorder import Recorder, Recorders, Request
from masonry_fem.output.terminal import Progress
from masonry_fem.output.tie_table import TieTable
from masonry_fem.records.remark import gathered, remark
from masonry_fem.records.told import Ending, write
from masonry_fem.records.tree import same_bits
from masonry_fem.results.blocks import status_counts
from masonry_fem.results.determinacy import Determinacy
from masonry_fem.results.joints import Joints
from masonry_fem.results.limit_analysis import LimitAnalysis
from masonry_fem.results.summarise import summarise, wrenches
from masonry_fem.results.summary import Summary
from masonry_fem.results.utilisation import Utilisation
from masonry_fem.scene import check, save, specs
from masonry_fem.scene.moved import moved

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy

# what a run that goes on finds in its folder; it makes the rest anew
KEPT = (CHECKPOINT, "history.csv", "fields/")

# What a scene did not ask for is not loaded: the outputs are imported where they are made.


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a run leaves.

    Attributes
    ----------
    summary : What ``summary.json`` holds.
    files : Files written.
    built, march : The model and the march, for further work in Python.
    determinacy : Which forces are facts, where the scene asks for it.
    """

    summary: Summary
    files: list[Path]
    built: Built
    march: March
    determinacy: ForceDeterminacy | None = None

    @property
    def outcome(self) -> str:
        """``equilibrium``, ``finished``, ``no_convergence`` or ``no_equilibrium``."""
        return self.summary.outcome

    @property
    def message(self) -> str:
        """The same as a sentence."""
        return self.summary.message

    def __repr__(self) -> str:
        """A short table."""
        return repr(self.summary)


def solve_scene(
    scene: specs.Scene, base: str | Path = Path(), observers: Sequence[Observer] = ()
) -> RunResult:
    """Solve a scene without writing anything.

    Parameters
    ----------
    scene : What to solve.
    base : Folder that the paths in it are relative to.
    observers : Told of every step's state and report, as recorders are.

    Raises
    ------
    MasonryError : Where the scene cannot be built.
    """
    base = Path(base)
    if getattr(scene, "stages", ()):
        raise MasonryError("a scene with stages leaves where each of them ends; run it into a folder")
    with gathered() as remarks:
        scene = check(scene, base=base)
        built = build(scene, base)
        start = begun(scene, built, base)
        built = built if start is None else start.built
        *_, result = _solved(scene, base, built, _limits(scene, built), observers, start=start)
    return _ended(result, remarks=tuple(remarks))


def run(
    scene: specs.Scene,
    out: str | Path,
    *,
    base: str | Path = Path(),
    save_contact: int | None = None,
    quiet: bool = True,
    before: Built | None = None,
    draws: Callable[[Built, March], bool] | None = None,
) -> RunResult:
    """Solve a scene and write its results to the folder ``out``.

    Parameters
    ----------
    scene : What to solve. base : Folder that the paths in it are relative to.
    out : Folder for the results; made where it is missing.
    save_contact : Step whose contact problem is saved as ``contact_<step>.npz``.
    quiet : No progress bar.
    before : The same scene built with other meshes: what it has of these is not made again.
    draws : Asked after the march whether to draw the pictures that the scene asks for.

    Raises
    ------
    MasonryError : Where the scene cannot be built or has no such step; nothing is written then.
    """
    out, base = Path(out), Path(base)
    if getattr(scene, "stages", ()):  # what is no scene is refused below
        if save_contact is not None:
            raise MasonryError("a contact problem is saved of a single analysis, and the scene has stages")
        return run_stages(scene, out, base, partial(_stage, base=base, quiet=quiet))
    return _written(scene, out, base, save_contact, quiet, before, draws, None)


def _stage(
    scene: specs.Scene, out: Path, checkpoint: Checkpoint | None, *, base: Path, quiet: bool
) -> RunResult:
    """Run a stage, or go on with it; one that is done makes no steps."""
    return _written(scene, out, base, None, quiet, None, None, checkpoint)


def go_on(scene: specs.Scene, out: Path, checkpoint: Checkpoint, *, quiet: bool = True) -> RunResult:
    """Make the steps of a run that its checkpoint lacks, and write its results as if it had gone on.

    Parameters
    ----------
    scene : Of the checkpoint; its analysis may have more steps. out : Results folder.
    checkpoint : Where to go on. quiet : No progress bar.

    Raises
    ------
    MasonryError : The checkpoint does not fit the scene.
    """
    if scene.stages:
        return run_stages(scene, out, out, partial(_stage, base=out, quiet=quiet), goes_on=True)
    return _written(scene, out, out, None, quiet, None, None, checkpoint)


def _written(
    scene: specs.Scene,
    out: Path,
    base: Path,
    save_contact: int | None,
    quiet: bool,
    before: Built | None,
    draws: Callable[[Built, March], bool] | None,
    checkpoint: Checkpoint | None,
) -> RunResult:
    """Solve a scene and write its results, from a checkpoint on where there is one."""
    with gathered() as remarks:
        given, scene = scene, _told(check(scene, base=base))
        _check_step(save_contact, scene.analysis.steps)
        refuse_busy(out)  # before the work of building
        built = build(scene, base, before)
        start = begun(scene, built, base)
        built = built if start is None else start.built
        recorders = _recorders(scene, built, out, quiet)
        kept: list[tuple[Model, Increment]] = []
        limits = _limits(scene, built)
        standing = None if checkpoint is None else checkpoint.standing
        going_on = None if standing is None else (gone_on(scene, built, base, standing), standing)
        if start is not None and standing is not None and not same_bits(start.state, standing.start):
            raise CheckpointError(
                f"the state in {scene.analysis.start}, where the run started, has changed since; restore it, "
                "or run the scene again"
            )
        if checkpoint is not None and going_on is not None:  # has what building it remarked on already
            remarks[:] = checkpoint.remarks
        keeper = Keeper.of(given, base, out, recorders, remarks)
        stages = _solved(
            scene,
            base,
            built,
            limits,
            (recorders,),
            save_contact,
            kept,
            start=start,
            going_on=going_on,
            keeper=keeper,
        )
        keeps = () if checkpoint is None else KEPT
        with Folder(out, "run", title=scene.title, clears=("view", "report"), keeps=keeps):
            figures: Summary | None = None
            try:
                save(moved(scene, base, out), out / "as_run.toml")
                if checkpoint is None or going_on is None:
                    recorders.start(built.model)
                    if keeper is not None:
                        keeper.begin()
                else:
                    recorders.go_on(built.model, checkpoint.outputs)
                for result in stages:
                    figures = result.summary
                clock = Clock()
                if draws is not None and not draws(built, result.march):
                    recorders.undrawn()
                recorders.end(result.march, result.determinacy)
                files = recorders.close(result.summary)
                if kept:
                    files.append(_save_problem(out, save_contact, *kept[0]))
                elif save_contact is not None:
                    unsaved = "was not reached: its contact problem is not saved"
                    remark("unsaved", f"step {save_contact} {unsaved}")
                clock.lap("output")
                seconds = dict(result.summary.seconds)
                seconds["output"] = round(seconds["output"] + clock.phases["output"], 4)
                result = _ended(result, seconds=seconds, remarks=tuple(remarks))
                files += [out / "as_run.toml", write(out / "summary.json", result.summary)]
                files += recorders.finish()
                if keeper is not None:
                    files.append(keeper.end(result.outcome))
            except BaseException as error:  # what was written so far is left readable, and says what it is
                with contextlib.suppress(OutputError):  # where there is no place it goes on saying "running"
                    hold = "history.csv and the field files hold the steps so far"
                    if keeper is not None:
                        hold += f"; 'masonry-fem resume {out}' goes on"
                    ending: Summary | Ending = ended_by(error, "run", scene.title, hold)
                    if figures is not None:
                        ending = structs.replace(
                            figures, outcome=ending.outcome, message=ending.message, remarks=tuple(remarks)
                        )
                    write(out / "summary.json", ending)
                    recorders.close(ending)
                raise
    return replace(result, files=files)


def _ended(result: RunResult, **keys: Any) -> RunResult:
    """The same with other values in its summary."""
    return replace(result, summary=structs.replace(result.summary, **keys))


def _solved(
    scene: specs.Scene,
    base: Path,
    built: Built,
    limits: LimitAnalysis | None,
    observers: Sequence[Observer],
    keep: int | None = None,
    kept: list[tuple[Model, Increment]] | None = None,
    *,
    start: Begun | None = None,
    going_on: tuple[Model, Standing] | None = None,
    keeper: Keeper | None = None,
) -> Iterator[RunResult]:
    """What is known of a scene: after its march, and with all that is asked of its end."""
    plan, settings = scene.analysis, solver_settings(scene.solver)
    made = march(
        built.model, plan, settings, bodies=built.bodies, start=None if start is None else start.state,
        observers=observers, keep=keep, kept=kept, going_on=going_on, keeper=keeper,
    )  # fmt: skip
    source = started(made)
    made = said(made, source)
    summary = summarise(
        scene, built, made, limit_analysis=limits, start=None if source is None else source.told()
    )
    result = RunResult(summary, [], built, made)
    yield result
    told, keys = _determinacy(scene, made)
    yield replace(
        _ended(
            result,
            errors=errors_of(scene, built, made, base),
            limit_analysis=_compared(summary),
            joints=_joints(scene, made, told),
            utilisation=_utilisation(scene, built, made, told),
            **keys,
        ),
        determinacy=told,
    )


def _joints(scene: specs.Scene, made: March, told: ForceDeterminacy | None) -> Joints | None:
    """Joints by state, where the scene asks for them."""
    if not scene.output.interfaces or all(one.tie for one in made.model.interfaces):
        return None
    from masonry_fem.results.joints import joint_summary  # noqa: PLC0415

    return joint_summary(made.model, made.state if told is None else told.state)


def _utilisation(
    scene: specs.Scene, built: Built, made: March, told: ForceDeterminacy | None
) -> Utilisation | None:
    """How much of their strength stones use, where some have one."""
    strengths = strengths_of(scene, built.stones)
    if strengths is None:
        return None
    from masonry_fem.results.utilisation import utilisation_summary  # noqa: PLC0415

    return utilisation_summary(made.model, made.state if told is None else told.state, strengths)


def _limits(scene: specs.Scene, built: Built) -> LimitAnalysis | None:
    """What limit analysis says, where the scene asks for it; before the march, as it may refuse."""
    if not scene.output.limit_analysis:
        return None
    from masonry_fem.analyses.limit import cross_check  # noqa: PLC0415 - only who asks needs its solvers

    try:
        return cross_check(scene, built)
    except ProblemError as error:
        remark("limit_analysis", f"limit analysis has no answer: {error}")
        return None


def _compared(summary: Summary) -> LimitAnalysis | None:
    """Limit analysis, where it was asked, with forces of an equilibrium that lie outside its intervals."""
    told = summary.limit_analysis
    if told is None or summary.outcome != "equilibrium":
        return told
    from masonry_fem.results.limit import outside  # noqa: PLC0415 - as above

    note = (
        "the run found an equilibrium all the same: that is for blocks where they came to rest, limit "
        "analysis for rigid blocks where they stood at the start"
    )
    return structs.replace(
        told,
        outside=outside(told, summary.supports, summary.applied),
        notes=told.notes if told.admissible else (*told.notes, note),
    )


def _determinacy(scene: specs.Scene, made: March) -> tuple[ForceDeterminacy | None, dict[str, Any]]:
    """What is determined, where the scene asks for it, and what the summary says then."""
    if not scene.output.determinacy:
        return None, {}
    if not made.last.solution.solved:
        unsolved = "as solved, which is not to the tolerance: nothing is determined"
        return None, {"determinacy": Determinacy(reactions=unsolved)}
    from masonry_fem.march.determinacy import determine  # noqa: PLC0415
    from masonry_fem.results.determinacy import determinacy_summary  # noqa: PLC0415

    told = determine(made.model, made.last)
    return told, {
        "supports": wrenches(told.supports, made.model.assembly.dimension),
        "status": status_counts(told.state),
        "determinacy": determinacy_summary(made.model, told),
    }


def _told(scene: specs.Scene) -> specs.Scene:
    """The scene with what a report of it tells."""
    if not scene.output.report or scene.output.interfaces:
        return scene
    return structs.replace(scene, output=structs.replace(scene.output, interfaces=True))


def _check_step(save_contact: int | None, steps: int) -> None:
    if save_contact is not None and save_contact not in range(1, steps + 1):
        expected = "1, the only step" if steps == 1 else f"a step from 1 to {steps}"
        raise MasonryError(f"step to save is {save_contact!r}, expected {expected} of this analysis")


def _recorders(scene: specs.Scene, built: Built, out: Path, quiet: bool) -> Recorders:
    statics = not scene.analysis.inertia
    strengths, asked = strengths_of(scene, built.stones), scene.output
    if asked.stones is None:
        asked = structs.replace(asked, stones=strengths is not None or asked.report)
    request = Request(out, scene.title, asked, statics, built.stones.material, strengths)
    always: list[Recorder] = [_progress(scene, quiet), History(out)]
    if scene.ties:
        always.append(TieTable(out))
    return Recorders([*always, *recorders(request)], asked.every)


def _progress(scene: specs.Scene, quiet: bool) -> Progress:
    plan = scene.analysis
    if plan.parts > 1:  # how many steps there will be is not known
        return Progress(end=1.0, quiet=quiet)
    return Progress(plan.steps, quiet=quiet)


def _save_problem(out: Path, step: int | None, model: Model, made: Increment) -> Path:
    from masonry_fem.output.contact_file import found_arrays  # noqa: PLC0415

    path = out / f"contact_{step}.npz"
    save_problem(made.problem, path, found_arrays(made, model))
    return path
