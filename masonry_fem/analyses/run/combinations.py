"""Combinations: load combinations, each a run of its own, and the envelope of their results.

result = run_combinations(scene, out, base, run)
result.summary.combinations               # the rest of it is that of the last, or of the first that failed

Results of a combination stand in the folder of its name, ``combinations.csv`` above them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from masonry_fem.analyses.run.envelope_table import write_envelope
from masonry_fem.analyses.run.stages import GOOD
from masonry_fem.build import Built, build
from masonry_fem.build.strengths import strengths_of
from masonry_fem.output.folder import Folder, refuse_busy, telling_end
from masonry_fem.records.remark import gathered
from masonry_fem.records.told import write
from masonry_fem.results.combinations import (
    CombinationTold,
    Effects,
    combinations_told,
    envelope,
)
from masonry_fem.scene import check, save, specs
from masonry_fem.scene.combinations import combination_scenes
from masonry_fem.scene.moved import moved

if TYPE_CHECKING:
    from masonry_fem.analyses.run.result import RunResult

TABLE = "combinations.csv"

Run = Callable[[specs.Scene, Path, Built], "RunResult"]


def run_combinations(scene: specs.Scene, out: Path, base: Path, run: Run) -> RunResult:
    """Run all load combinations of a scene, whatever their ends, and write their envelope.

    Parameters
    ----------
    scene : With combinations. out : Results folder. base : Folder that the scene's paths are relative to.
    run : Runs the scene of a combination into a folder, with what it has of the model of another one.

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
    worst: RunResult | None = None
    many = len(scene.combinations)
    with (
        Folder(out, "run", title=scene.title, clears=("view", "report")),
        telling_end(out, scene.title, lambda: f"{len(told)} of {many} combinations are done"),
    ):
        save(moved(scene, base, out), out / "as_run.toml")
        for one, own in combination_scenes(scene):
            result = run(own, out / one.name, before)
            before = result.built
            told.append(
                CombinationTold(
                    name=one.name, factors=one.factors, outcome=result.outcome, message=result.message
                )
            )
            files += result.files
            if result.outcome in GOOD:
                effects.append(_effects(own, one.name, result))
            elif worst is None:
                worst = result
        shown, number = result if worst is None else worst, _shown(told)
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
    return replace(shown, summary=summary, files=files)


def _shown(told: list[CombinationTold]) -> int:
    """Number of the combination that the summary is of: the first that failed, else the last."""
    return next((n for n, one in enumerate(told) if one.outcome not in GOOD), len(told) - 1)


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
