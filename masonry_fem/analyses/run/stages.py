"""Stages: a history, stage after stage, each a run of its own that begins where another has ended.

result = run_stages(scene, out, base)
result.summary.stages                     # how each ended; the rest of it is that of the last one

Results of a stage stand in the folder of its name. The history and the series of all stand above these.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import structs

from masonry_fem.analyses.run.reopening import of_the_reference
from masonry_fem.build import build
from masonry_fem.errors import MasonryError
from masonry_fem.host.atomic import write_records
from masonry_fem.host.phases import counted
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, read_checkpoint, write_checkpoint
from masonry_fem.output.folder import Folder, refuse_busy, telling_end
from masonry_fem.records.remark import gathered, muted, remark
from masonry_fem.records.told import write
from masonry_fem.results.summary import StageTold, Wrench
from masonry_fem.scene import check, dumps, specs
from masonry_fem.scene.misfit import listed
from masonry_fem.scene.stages import predecessor, stage_scenes
from masonry_fem.scene.writing import moved

if TYPE_CHECKING:
    from masonry_fem.analyses.run.result import RunResult

GOOD = ("equilibrium", "finished")

Run = Callable[[specs.Scene, Path, "Checkpoint | None"], "RunResult"]


def run_stages(scene: specs.Scene, out: Path, base: Path, run: Run, *, goes_on: bool = False) -> RunResult:
    """Run the stages of a scene one after another, and stop after one that does not come to a good end.

    Parameters
    ----------
    scene : With stages. out : Results folder. base : Folder that the scene's paths are relative to.
    run : Runs the scene of a stage into a folder, from a checkpoint on where there is one.
    goes_on : Go on with what is done in ``out``.

    Raises
    ------
    MasonryError : A stage cannot be built, or another process writes there.
    """
    for stage, own in zip(scene.stages, check_stages(scene, base), strict=True):
        # what a stage's selectors and files lack is told before the first one takes its time
        with gathered(aloud=False), of_stage(stage.name):
            build(own, base, solved=False)
    refuse_busy(out)
    with gathered() as said:
        _tell_left_out(scene)
        for stage, whole in stage_scenes(scene):
            _tell_repeated(stage, whole, predecessor(scene, stage))
    names = [stage.name for stage in scene.stages]
    keeps = [CHECKPOINT, *(f"{name}/" for name in names)] if goes_on else []
    told: list[StageTold] = []
    with Folder(out, "run", title=scene.title, clears=("view",), keeps=keeps):
        write_checkpoint(out / CHECKPOINT, Checkpoint(dumps(moved(scene, base, out)), "", None, {}, ()))
        with telling_end(out, scene.title, lambda: f"{len(told)} of {len(names)} stages are done"):
            for stage, whole in counted("stages", stage_scenes(scene), len(names)):
                after = predecessor(scene, stage)
                kept, done = kept_part(out / stage.name) if goes_on else (None, False)
                if done and stage is not scene.stages[-1]:  # the last one is run once more
                    told.append(_done(out / stage.name, stage.name, after))
                    continue
                own = starting(whole, None if after is None else out / after, base)
                with muted(*_unsaid(stage, after)), of_stage(stage.name):
                    result = run(own, out / stage.name, kept)
                end = result.summary
                told.append(
                    StageTold(
                        name=stage.name, after=after, outcome=end.outcome, message=end.message, time=end.time,
                        steps=end.steps, supports=end.supports,
                    )
                )  # fmt: skip
                if result.outcome not in GOOD:
                    break
            files = [*result.files, *_joined(out, told)]
            message = f"Stage '{told[-1].name}': {told[-1].message}"
            said += result.summary.remarks
            return told_above(
                result, scene, out, files, message=message, stages=tuple(told), remarks=tuple(said)
            )


def check_stages(scene: specs.Scene, base: Path) -> list[specs.Scene]:
    """The checked scenes of all stages.

    Parameters
    ----------
    scene : With stages. base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : A stage describes something impossible.
    """
    checked = check(scene, base=base)
    with gathered(aloud=False):  # what is seldom meant is told when a stage runs
        return [check(own, base=base, source=f"stage '{stage.name}'") for stage, own in stage_scenes(checked)]


@contextmanager
def of_stage(name: str) -> Iterator[None]:
    """Name the stage in the errors that its scene makes meanwhile.

    Parameters
    ----------
    name : Of the stage.
    """
    try:
        yield
    except MasonryError as error:
        error.args = (f"stage '{name}': {error}",)
        raise


def _unsaid(stage: specs.Stage, after: str | None) -> tuple[str, ...]:
    """Codes of remarks that a stage need not repeat.

    Rules of joints that an earlier stage had may have lost theirs with blocks that are gone.
    """
    return () if after is None or stage.joints is not None else ("idle_joint",)


def _tell_repeated(stage: specs.Stage, scene: specs.Scene, after: str | None) -> None:
    """Say which supports move in a stage only because the one before moved them."""
    moved = [one.on for one in scene.supports if one.motion is not None]
    if moved and after is not None and stage.supports is None:
        remark(
            "repeated_motion",
            f"stage '{stage.name}' says nothing of supports, so that it makes the motion of "
            f"{listed(moved)} once more; name in [[stages.supports]] what is to stay, without a motion",
        )


def _tell_left_out(scene: specs.Scene) -> None:
    """Say what is not written of stages that begin where another has ended."""
    keys = [f"output.{key}" for key in of_the_reference(scene)]
    later = [stage.name for stage in scene.stages if predecessor(scene, stage) is not None]
    if keys and later:
        remark(
            "of_the_reference",
            f"{listed(keys)}: of stones in the reference, so not of stages that begin where another has "
            f"ended: {listed(later)}",
        )


def starting(scene: specs.Scene, after: Path | None, base: Path) -> specs.Scene:
    """A stage's scene, which begins where another stage has ended, and leaves where it ends itself.

    Parameters
    ----------
    scene : Of the stage. after : Results folder of the other one; None: it begins as the scene says.
    base : Folder that paths in the scene are relative to.
    """
    analysis, output = scene.analysis, scene.output
    if after is not None:
        start = Path(os.path.relpath(after.resolve(), base.resolve())).as_posix()
        analysis = structs.replace(analysis, start=start)
        output = structs.replace(output, **dict.fromkeys(of_the_reference(scene), False))
    if output.checkpoint_steps is None and output.checkpoint_time is None:
        output = structs.replace(output, checkpoint_steps=analysis.steps)
    return structs.replace(scene, analysis=analysis, output=output)


def _done(folder: Path, name: str, after: str | None) -> StageTold:
    """What was told of a stage that is done."""
    told = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    keys = {key: told[key] for key in ("outcome", "message", "time", "steps")}
    supports = {
        support: Wrench(force=np.array(wrench["force"]), moment=np.array(wrench["moment"]))
        for support, wrench in told["supports"].items()
    }
    return StageTold(name=name, after=after, supports=supports, **keys)


def told_above(
    shown: RunResult, scene: specs.Scene, out: Path, files: Sequence[Path], **changes: Any
) -> RunResult:
    """Write what is told of several runs, each in a folder of its own: the summary, and the report if asked.

    Parameters
    ----------
    shown : Run that the summary is of. scene : Of all runs. out : Folder of all.
    files : Written before. changes : What the summary says otherwise.
    """
    summary = structs.replace(shown.summary, title=scene.title, **changes)
    written = [*files, write(out / "summary.json", summary)]
    if scene.output.report:
        from masonry_fem.output.report import write_report  # noqa: PLC0415 - only where asked for

        written.append(write_report(out))
    return replace(shown, summary=summary, files=written)


def kept_part(folder: Path) -> tuple[Checkpoint | None, bool]:
    """Where one of several runs can go on, None where it has not begun or is done; and whether it is done."""
    if not (folder / CHECKPOINT).exists():
        return None, False
    checkpoint = read_checkpoint(folder)
    done = bool(checkpoint.outcome)
    return (None if done else checkpoint), done


def _joined(out: Path, told: list[StageTold]) -> list[Path]:
    """The histories of all stages as one table, and their field files as one series, times added up."""
    from masonry_fem.output.vtu import Series  # noqa: PLC0415 - only histories need it

    rows: list[dict[str, str]] = []
    series = {name: Series(out, name) for name in ("blocks", "contacts", "interfaces")}
    since = 0.0
    for stage in told:
        with (out / stage.name / "history.csv").open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                rows.append({"stage": stage.name} | row)
        for name, whole in series.items():
            whole.take_over(out / stage.name / f"{name}.pvd", since)
        since += stage.time
    history = write_records(out / "history.csv", rows, first=("stage",), end="\r\n")
    return [history, *(whole.path for whole in series.values() if whole.write())]
