"""Run: a scene from its description to results on disk.

from masonry_fem.scene import load
from masonry_fem.analyses.run import run
result = run(load("arch.toml"), Path("results"), base=Path("."))
result.outcome, result.summary["supports"], result.files
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_fem.analyses.discretisation import errors_of
from masonry_fem.analyses.start import Start, said, started
from masonry_fem.build import Built, build, solver_settings
from masonry_fem.errors import MasonryError, OutputError
from masonry_fem.march.clock import Clock
from masonry_fem.march.march import March, Observer, march
from masonry_fem.march.model import Model
from masonry_fem.march.step import Increment
from masonry_fem.nscd import save_problem
from masonry_fem.output.asked import recorders
from masonry_fem.output.folder import Folder, ended_by, refuse_busy
from masonry_fem.output.history import History
from masonry_fem.output.recorder import Recorders, Request
from masonry_fem.output.terminal import Progress
from masonry_fem.results.blocks import status_counts, write_summary
from masonry_fem.results.summary import summarise, wrench
from masonry_fem.scene import check, specs

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy

# What a scene did not ask for is not loaded: the outputs are imported where they are made.

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a run leaves.

    Attributes
    ----------
    outcome : ``equilibrium``, ``finished``, ``no_convergence`` or ``no_equilibrium``.
    message : The same as a sentence.
    summary : What ``summary.json`` holds.
    files : Files written.
    built, march : The model and the march, for further work in Python.
    determinacy : Which forces are facts, where the scene asks for it.
    """

    outcome: str
    message: str
    summary: dict[str, Any]
    files: list[Path]
    built: Built
    march: March
    determinacy: ForceDeterminacy | None = None


def solve_scene(scene: specs.Scene, base: Path = Path(), observers: Sequence[Observer] = ()) -> RunResult:
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
    scene = check(scene, base=base)
    built = build(scene, base)
    *_, result = _solved(scene, base, built, _limits(scene, built), observers)
    return result


def run(
    scene: specs.Scene,
    out: Path,
    *,
    base: Path = Path(),
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
    scene = check(scene, base=base)
    _check_step(save_contact, scene.analysis.steps)
    refuse_busy(out)  # before the work of building
    built = build(scene, base, before)
    recorders = _recorders(scene, built, out, quiet)
    kept: list[tuple[Model, Increment]] = []
    stages = _solved(scene, base, built, _limits(scene, built), (recorders,), save_contact, kept)
    with Folder(out, "run", title=scene.title, clears=("view",)):
        summary: dict[str, Any] = {"title": scene.title}
        try:
            recorders.start(built.model)
            for result in stages:
                summary = result.summary
            clock = Clock()
            if draws is not None and not draws(built, result.march):
                recorders.undrawn()
            recorders.end(result.march, result.determinacy)
            result.files.extend(recorders.close(summary))
            if kept:
                result.files.append(_save_problem(out, save_contact, *kept[0]))
            elif save_contact is not None:
                logger.warning("step %d was not reached: its contact problem is not saved", save_contact)
            clock.lap("output")
            summary["seconds"]["output"] += round(clock.phases["output"], 4)
            result.files.append(write_summary(out / "summary.json", summary))
        except BaseException as error:  # what was written so far is left readable, and says what it is
            ending = ended_by(error)
            so_far = "; history.csv and the field files hold the steps so far."
            summary |= ending | {"message": ending["message"].removesuffix(".") + so_far}
            with contextlib.suppress(OutputError):  # where even that has no place it goes on saying "running"
                write_summary(out / "summary.json", summary)
                recorders.close(summary)
            raise
    return result


def _solved(
    scene: specs.Scene,
    base: Path,
    built: Built,
    limits: dict[str, Any],
    observers: Sequence[Observer],
    keep: int | None = None,
    kept: list[tuple[Model, Increment]] | None = None,
) -> Iterator[RunResult]:
    """What is known of a scene: after its march, and with each further analysis that it asks for."""
    plan, settings = scene.analysis, solver_settings(scene.solver)
    made = march(built.model, plan, settings, bodies=built.bodies, observers=observers, keep=keep, kept=kept)
    start = started(made)
    made = said(made, start)
    summary = summarise(scene, built, made) | limits | _start(start)
    result = RunResult(made.outcome, made.message, summary, [], built, made)
    yield result
    summary |= {"errors": errors_of(scene, built, made, base)}
    _compare(summary)
    told = _determinacy(scene, built, made, summary)
    summary |= _joints(scene, made, told)
    yield replace(result, determinacy=told)


def _start(start: Start | None) -> dict[str, Any]:
    """How an equilibrium may come about."""
    return {} if start is None else {"start": start.told()}


def _joints(scene: specs.Scene, made: March, told: ForceDeterminacy | None) -> dict[str, Any]:
    """Joints by state, where the scene asks for them."""
    if not scene.output.interfaces or not made.model.interfaces:
        return {}
    from masonry_fem.output.asked.interfaces import joint_summary  # noqa: PLC0415

    return {"joints": joint_summary(made.model, made.state if told is None else told.state)}


def _limits(scene: specs.Scene, built: Built) -> dict[str, Any]:
    """What limit analysis says, where the scene asks for it; before the march, as it may refuse."""
    if not scene.output.limit_analysis:
        return {}
    from masonry_fem.analyses.limit import reported  # noqa: PLC0415 - only scenes that ask need its solvers

    return {"limit_analysis": reported(scene, built)}


def _compare(summary: dict[str, Any]) -> None:
    """Hold the supports' forces of an equilibrium against their intervals, where limit analysis was asked."""
    if "limit_analysis" in summary and summary["outcome"] == "equilibrium":
        from masonry_fem.limit.answers import outside  # noqa: PLC0415 - as above

        told = summary["limit_analysis"]
        told["outside"] = outside(told, summary["supports"], summary["applied"])
        if not told.get("admissible", True):
            told["notes"].append(
                "the run found an equilibrium all the same, of blocks where they came to rest: this is of "
                "rigid blocks where they stood at the start"
            )


def _determinacy(
    scene: specs.Scene, built: Built, made: March, summary: dict[str, Any]
) -> ForceDeterminacy | None:
    """What is determined, where the scene asks for it; it goes to the summary, with its reactions."""
    if not scene.output.determinacy:
        return None
    if not made.last.solution.solved:
        summary["determinacy"] = {
            "reactions": "as solved, which is not to the tolerance: nothing is determined"
        }
        return None
    from masonry_fem.march.determinacy import determine  # noqa: PLC0415
    from masonry_fem.output.asked.determinacy import determinacy_summary  # noqa: PLC0415

    told = determine(made.model, made.last)
    d = built.model.assembly.dimension
    summary["supports"] = {name: wrench(value, d) for name, value in told.supports.items()}
    summary["status"] = status_counts(told.state)
    summary["determinacy"] = determinacy_summary(made.model, told)
    return told


def _check_step(save_contact: int | None, steps: int) -> None:
    if save_contact is not None and not 1 <= save_contact <= steps:
        expected = "1, the only step" if steps == 1 else f"a step from 1 to {steps}"
        raise MasonryError(f"step to save is {save_contact}, expected {expected} of this analysis")


def _recorders(scene: specs.Scene, built: Built, out: Path, quiet: bool) -> Recorders:
    statics = not scene.analysis.inertia
    request = Request(out, scene.title, scene.output, statics, built.stones.material)
    return Recorders([_progress(scene, quiet), History(out), *recorders(request)], scene.output.every)


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
