"""Run: a scene from its description to results on disk.

from masonry_fem.scene import load
from masonry_fem.analyses.run import run
result = run(load("arch.toml"), Path("results"), base=Path("."))
result.outcome, result.summary["supports"], result.files
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_fem.analyses.discretisation import errors_of
from masonry_fem.analyses.start import Start, said, started
from masonry_fem.build import Built, build, solver_settings, strategy
from masonry_fem.errors import MasonryError, OutputError
from masonry_fem.march.clock import Clock
from masonry_fem.march.march import March, Observer, march
from masonry_fem.march.model import Model
from masonry_fem.march.step import Increment
from masonry_fem.nscd import save_problem
from masonry_fem.output.folder import Folder, ended_by, refuse_busy
from masonry_fem.output.history import History
from masonry_fem.output.recorder import Recorder, Recorders
from masonry_fem.output.terminal import Progress
from masonry_fem.results.blocks import status_counts, write_summary
from masonry_fem.results.summary import seconds, summarise, wrench
from masonry_fem.scene import check, specs

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy
    from masonry_fem.output.interface_table import InterfaceTable

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
    """

    outcome: str
    message: str
    summary: dict[str, Any]
    files: list[Path]
    built: Built
    march: March


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
    clock = Clock()
    scene = check(scene, base=base)
    _check_step(save_contact, strategy(scene.analysis).steps)
    refuse_busy(out)  # before the work of building
    built = build(scene, base, before)
    clock.lap("build")
    limits = _limits(scene, built)
    with Folder(out, "run", title=scene.title, clears=("view",)):
        return _recorded(scene, built, limits, out, base, save_contact, quiet, draws, clock)


def _recorded(
    scene: specs.Scene,
    built: Built,
    limits: dict[str, Any],
    out: Path,
    base: Path,
    save_contact: int | None,
    quiet: bool,
    draws: Callable[[Built, March], bool] | None,
    clock: Clock,
) -> RunResult:
    """March, and write what is seen; ``summary.json`` says how it ended when all else is written."""
    table = _table(scene, out)
    recorders = _recorders(scene, built, out, quiet, table)
    kept: list[tuple[Model, Increment]] = []
    summary: dict[str, Any] = {"title": scene.title}
    try:
        recorders.start(built.model)
        made = march(
            built.model,
            strategy(scene.analysis),
            solver_settings(scene.solver),
            bodies=built.bodies,
            observers=(recorders,),
            keep=save_contact,
            kept=kept,
        )
        start = started(made)
        made = said(made, start)
        clock.lap("march")
        summary |= summarise(scene, built, made) | limits | _start(start)
        summary |= {"errors": errors_of(scene, built, made, base)}
        _compare(summary)
        told = _determinacy(scene, built, made, summary)
        if told is not None:
            recorders.amend(made.model, told.state, made.report)
            if table is not None:
                table.determine(told)
        summary |= _joints(scene, made, told)
        if draws is not None and not draws(built, made):
            recorders.undrawn()
        files = recorders.close(summary)
        if kept:
            files.append(_save_problem(out, save_contact, *kept[0]))
        elif save_contact is not None:
            logger.warning("step %d was not reached: its contact problem is not saved", save_contact)
        if made.outcome == "no_equilibrium" and scene.output.pictures:
            files += _picture(scene, made, out)
        if told is not None:
            from masonry_fem.output.determinacy_table import write_determinacy  # noqa: PLC0415

            files.append(write_determinacy(out / "determinacy.csv", made.model, told))
        clock.lap("output")
        summary["seconds"] = seconds(built, made, clock)
        files.append(write_summary(out / "summary.json", summary))
    except BaseException as error:  # what was written so far is left readable, and says what it is
        ending = ended_by(error)
        so_far = "; history.csv and the field files hold the steps so far."
        summary |= ending | {"message": ending["message"].removesuffix(".") + so_far}
        with contextlib.suppress(OutputError):  # where even that has no place it goes on saying "running"
            write_summary(out / "summary.json", summary)
            recorders.close(summary)
        raise
    return RunResult(made.outcome, made.message, summary, files, built, made)


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
    limits = _limits(scene, built)
    plan, settings = strategy(scene.analysis), solver_settings(scene.solver)
    made = march(built.model, plan, settings, bodies=built.bodies, observers=observers)
    start = started(made)
    made = said(made, start)
    summary = summarise(scene, built, made) | limits | _start(start)
    summary |= {"errors": errors_of(scene, built, made, base)}
    _compare(summary)
    told = _determinacy(scene, built, made, summary)
    summary |= _joints(scene, made, told)
    return RunResult(made.outcome, made.message, summary, [], built, made)


def _start(start: Start | None) -> dict[str, Any]:
    """How an equilibrium may come about."""
    return {} if start is None else {"start": start.told()}


def _joints(scene: specs.Scene, made: March, told: ForceDeterminacy | None) -> dict[str, Any]:
    """Joints by state, where the scene asks for them."""
    if not scene.output.interfaces or not made.model.interfaces:
        return {}
    from masonry_fem.output.interface_table import joint_summary  # noqa: PLC0415

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
    from masonry_fem.output.determinacy_table import determinacy_summary  # noqa: PLC0415

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


def _table(scene: specs.Scene, out: Path) -> InterfaceTable | None:
    """Recorder of what the joints carry, where the scene asks for it."""
    if not scene.output.interfaces:
        return None
    from masonry_fem.output.interface_table import InterfaceTable  # noqa: PLC0415

    return InterfaceTable(out, fields=scene.output.fields)


def _recorders(
    scene: specs.Scene, built: Built, out: Path, quiet: bool, table: InterfaceTable | None
) -> Recorders:
    members: list[Recorder] = [_progress(scene, quiet), History(out)]
    if scene.output.fields:
        from masonry_fem.output.vtu import FieldFiles  # noqa: PLC0415

        statics = isinstance(scene.analysis, specs.Statics)
        members.append(FieldFiles(out, materials=built.stones.material, statics=statics))
    if table is not None:
        members.append(table)
    if scene.output.pictures:
        from masonry_fem.output.cut import Plane  # noqa: PLC0415
        from masonry_fem.output.picture import Pictures  # noqa: PLC0415

        output = scene.output
        planes = [Plane(one.name, one.point, one.normal, one.show) for one in output.cuts]
        members.append(
            Pictures(out, scene.title, output.amplification, joints=output.interfaces, cuts=planes)
        )
    return Recorders(members, scene.output.every)


def _progress(scene: specs.Scene, quiet: bool) -> Progress:
    plan = strategy(scene.analysis)
    if plan.parts > 1:  # how many steps there will be is not known
        return Progress(end=1.0, quiet=quiet)
    return Progress(plan.steps, quiet=quiet)


def _save_problem(out: Path, step: int | None, model: Model, made: Increment) -> Path:
    from masonry_fem.output.contact_file import found_arrays  # noqa: PLC0415

    path = out / f"contact_{step}.npz"
    save_problem(made.problem, path, found_arrays(made, model))
    return path


def _picture(scene: specs.Scene, made: March, out: Path) -> list[Path]:
    """The mechanism, on the structure as it was when the last step began, where this machine can draw."""
    from masonry_fem.march.mechanism import mechanism_of_step  # noqa: PLC0415
    from masonry_fem.output.mechanism_picture import draw_mechanism  # noqa: PLC0415
    from masonry_fem.output.render import can_render  # noqa: PLC0415
    from masonry_fem.output.scenery import Scenery  # noqa: PLC0415

    found = mechanism_of_step(made.last, made.model)
    if not found.parts or not can_render():
        return []
    scenery = Scenery.of(made.model, made.last.before, title=scene.title)
    return [draw_mechanism(scenery, found, out / "mechanism.png")]
