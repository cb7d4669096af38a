"""Combinations: load combinations, each a run of its own, and the envelope of their results.

result = run_combinations(scene, out, base, run)
result.summary.combinations               # the rest of it is that of the last, or of the first that failed

Results of a combination stand in the folder of its name, ``combinations.csv`` above them. What the envelope
needs of each is kept in ``combination.json`` beside its results, once it has ended: a run that was killed
goes on with those that have not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from msgspec import structs

from masonry_fem.analyses.run.envelope_table import write_envelope
from masonry_fem.analyses.run.stages import GOOD
from masonry_fem.build import Built, build
from masonry_fem.build.strengths import strengths_of
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, read_checkpoint, write_checkpoint
from masonry_fem.output.folder import Folder, refuse_busy, telling_end
from masonry_fem.records.remark import gathered
from masonry_fem.records.told import write
from masonry_fem.results.combinations import (
    CombinationEnd,
    CombinationTold,
    Effects,
    EffectsTold,
    combinations_told,
    envelope,
)
from masonry_fem.scene import check, dumps, save, specs
from masonry_fem.scene.combinations import combination_scenes
from masonry_fem.scene.moved import moved

if TYPE_CHECKING:
    from masonry_fem.analyses.run.result import RunResult

TABLE = "combinations.csv"

ENDED = "combination.json"  # of each: how it has ended, and its effects

Run = Callable[[specs.Scene, Path, Built, "Checkpoint | None"], "RunResult"]


def run_combinations(
    scene: specs.Scene, out: Path, base: Path, run: Run, *, goes_on: bool = False
) -> RunResult:
    """Run all load combinations of a scene, whatever their ends, and write their envelope.

    Parameters
    ----------
    scene : With combinations. out : Results folder. base : Folder that the scene's paths are relative to.
    run : Runs the scene of a combination into a folder, with what it has of the model of another one, from a
        checkpoint on where there is one.
    goes_on : Go on with what is done in ``out``.

    Raises
    ------
    MasonryError : The scene cannot be built, or another process writes there.
    """
    scene = check(scene, base=base)
    refuse_busy(out)
    with gathered(
        aloud=False
    ):  # what a load cannot act on is refused before any run; each run tells the rest
        before = build(scene, base)
    told: list[CombinationTold] = []
    effects: list[Effects] = []
    files: list[Path] = []
    shown: RunResult | None = None  # the first that failed, else the last
    many, text = len(scene.combinations), dumps(moved(scene, base, out))
    keeps = [CHECKPOINT, *(f"{one.name}/" for one in scene.combinations)] if goes_on else []
    with (
        Folder(out, "run", title=scene.title, clears=("view", "report"), keeps=keeps),
        telling_end(out, scene.title, lambda: f"{len(told)} of {many} combinations are done"),
    ):
        write_checkpoint(out / CHECKPOINT, Checkpoint(text, "", None, {}, ()))
        save(moved(scene, base, out), out / "as_run.toml")
        for one, own in combination_scenes(scene):
            place = out / one.name
            ended = _ended(place) if goes_on else None
            failed = any(other.outcome not in GOOD for other in told)
            if ended is None or (not failed and (ended.outcome not in GOOD or len(told) == many - 1)):
                # what the summary is of is needed as a whole
                result = run(own, place, before, _kept(place) if goes_on and ended is None else None)
                before = result.built
                ended = _end(own, one.name, result)
                write(place / ENDED, ended)
                files += [*result.files, place / ENDED]
                shown = shown if failed else result
            told.append(
                CombinationTold(
                    name=one.name, factors=one.factors, outcome=ended.outcome, message=ended.message
                )
            )
            if ended.effects is not None:
                effects.append(ended.effects.of(one.name))
        assert shown is not None
        number = _shown(told)
        found = envelope(effects) if effects else None
        files += [out / "as_run.toml", write_envelope(out / TABLE, found, "combination")]
        summary = structs.replace(
            shown.summary, title=scene.title, combinations=combinations_told(told, found, told[number].name),
            message=f"Combination '{told[number].name}': {told[number].message}",
        )  # fmt: skip
        files.append(write(out / "summary.json", summary))
        if scene.output.report:
            from masonry_fem.output.report import write_report  # noqa: PLC0415 - only where asked for

            files.append(write_report(out))
        outcome = summary.outcome
        write_checkpoint(out / CHECKPOINT, Checkpoint(text, outcome, None, {}, ()))  # last: nothing is left
    return replace(shown, summary=summary, files=files)


def _shown(told: list[CombinationTold]) -> int:
    """Number of the combination that the summary is of: the first that failed, else the last."""
    return next((n for n, one in enumerate(told) if one.outcome not in GOOD), len(told) - 1)


def _kept(folder: Path) -> Checkpoint | None:
    """Where a combination can go on; None where it begins anew."""
    if not (folder / CHECKPOINT).exists():
        return None
    checkpoint = read_checkpoint(folder)
    return None if checkpoint.outcome else checkpoint


def _ended(folder: Path) -> CombinationEnd | None:
    """What is kept of a combination that has ended; None where it has not."""
    try:
        return msgspec.json.decode((folder / ENDED).read_bytes(), type=CombinationEnd)
    except (OSError, ValueError):
        return None


def _end(scene: specs.Scene, name: str, result: RunResult) -> CombinationEnd:
    """What is kept of a combination."""
    good = result.outcome in GOOD
    effects = EffectsTold.from_effects(_effects(scene, name, result)) if good else None
    return CombinationEnd(outcome=result.outcome, message=result.message, effects=effects)


def _effects(scene: specs.Scene, name: str, result: RunResult) -> Effects:
    """What a combination has done."""
    from masonry_fem.output.asked.stones import stone_columns  # noqa: PLC0415 - only combinations need it

    built, made = result.built, result.march
    columns = stone_columns(made.model, made.state, built.stones.material, strengths_of(scene, built.stones))
    local, mean, tension, compression = (
        np.array(columns[key], dtype=float)
        for key in ("utilisation [-]", "utilisation_of_mean [-]", "mean_sigma_1 [Pa]", "mean_sigma_3 [Pa]")
    )
    used = np.where(np.isnan(local), mean, local)
    supports = dict(made.report.support_resultants)
    return Effects(name, columns["block"], used, tension, compression, supports)
