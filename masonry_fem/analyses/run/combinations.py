"""Combinations: load combinations, each a run of its own, and the envelope of their results.

result = run_combinations(scene, out, base, run)
result.summary.combinations               # the rest of it is that of the last, or of the first that failed

Results of a combination stand in the folder of its name, ``combinations.csv`` above them. What the envelope
needs of each is kept in ``combination.json`` beside its results, once it has ended: a run that was killed
goes on with those that have not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_fem.analyses.run.stages import GOOD, kept_part, told_above
from masonry_fem.build import Built, build
from masonry_fem.build.strengths import strengths_of
from masonry_fem.host.atomic import write_table
from masonry_fem.host.phases import counted
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, write_checkpoint
from masonry_fem.output.folder import Folder, refuse_busy, telling_end
from masonry_fem.records.remark import gathered
from masonry_fem.records.told import known, write
from masonry_fem.results.combinations import (
    CombinationEnd,
    CombinationTold,
    Effects,
    EffectsTold,
    Envelope,
    Extremes,
    combinations_told,
    envelope,
)
from masonry_fem.scene import check, dumps, save, specs
from masonry_fem.scene.combinations import combination_scenes
from masonry_fem.scene.writing import moved

if TYPE_CHECKING:
    from masonry_fem.analyses.run.result import RunResult


TABLE = "combinations.csv"

ENDED = "combination.json"  # of each: how it has ended, and its effects

Run = Callable[[specs.Scene, Path, Built, "Checkpoint | None"], "RunResult"]


def write_envelope(path: Path, found: Envelope | None, by: str) -> Path:
    """Write the envelope, one line for each extreme.

    Parameters
    ----------
    path : Of the file. found : The extremes; None: there are none.
    by : Title of the column of what governs.
    """
    lines = () if found is None else _lines(found)
    return write_table(path, ("of", "name", "quantity", "value", by), lines)


def _lines(found: Envelope) -> Iterator[tuple[Any, ...]]:
    def of_stones(quantity: str, extremes: Extremes) -> Iterator[tuple[Any, ...]]:
        for name, value, by in zip(
            extremes.names, extremes.value.tolist(), extremes.combination, strict=True
        ):
            if not math.isnan(value):
                yield "stone", name, quantity, value, by

    yield from of_stones("utilisation [-]", found.utilisation)
    yield from of_stones("mean_sigma_3 [Pa]", found.compression)
    yield from of_stones("mean_sigma_1 [Pa]", found.tension)
    for support, pair in found.supports.items():
        for end, extremes in zip(("least", "greatest"), pair, strict=True):
            for axis, value, by in zip(
                extremes.names, extremes.value.tolist(), extremes.combination, strict=True
            ):
                yield "support", support, f"{end}_{axis}", value, by


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
    done = _Done(out, run, before, goes_on)
    many, text = len(scene.combinations), dumps(moved(scene, base, out))
    keeps = [CHECKPOINT, *(f"{one.name}/" for one in scene.combinations)] if goes_on else []
    with (
        Folder(out, "run", title=scene.title, clears=("view", "report"), keeps=keeps),
        telling_end(out, scene.title, lambda: f"{len(done.told)} of {many} combinations are done"),
    ):
        write_checkpoint(out / CHECKPOINT, Checkpoint(text, "", None, {}, ()))
        save(moved(scene, base, out), out / "as_run.toml")
        each = counted("combinations", combination_scenes(scene), many)
        for number, (one, own) in enumerate(each, start=1):
            done.take(one, own, last=number == many)
        result = done.result(scene)
        ended = Checkpoint(text, result.outcome, None, {}, ())
        write_checkpoint(out / CHECKPOINT, ended)  # last: nothing is left
    return result


@dataclass
class _Done:
    """The combinations that are done.

    Attributes
    ----------
    out : Results folder. run : Runs one. before : What there is of a model.
    goes_on : Take those that are kept.
    told, effects, files : How each has ended, what those that stand have done, and what was written.
    shown : Run that the summary is of: the first that failed, else the last.
    """

    out: Path
    run: Run
    before: Built
    goes_on: bool
    told: list[CombinationTold] = field(default_factory=list)
    effects: list[Effects] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)
    shown: RunResult | None = None

    @property
    def failed(self) -> int | None:
        """Number of the first that failed; None: none did."""
        return next((n for n, one in enumerate(self.told) if one.outcome not in GOOD), None)

    def take(self, one: specs.Combination, scene: specs.Scene, *, last: bool) -> None:
        """Run a combination, unless it is known; what the summary is of is needed as a whole."""
        ended = known(self.out / one.name / ENDED, CombinationEnd) if self.goes_on else None
        if ended is None or (self.failed is None and (last or ended.outcome not in GOOD)):
            ended = self._run(one.name, scene, begun=self.goes_on and ended is None)
        self.told.append(
            CombinationTold(name=one.name, factors=one.factors, outcome=ended.outcome, message=ended.message)
        )
        if ended.effects is not None:
            self.effects.append(ended.effects.of(one.name))

    def _run(self, name: str, scene: specs.Scene, *, begun: bool) -> CombinationEnd:
        """Run one, from its checkpoint if it may have ``begun``."""
        place = self.out / name
        result = self.run(scene, place, self.before, kept_part(place)[0] if begun else None)
        self.before = result.built
        if self.failed is None:
            self.shown = result
        ended = _end(scene, name, result)
        self.files += [*result.files, write(place / ENDED, ended)]
        return ended

    def result(self, scene: specs.Scene) -> RunResult:
        """What there is of all of them, with the envelope, and its files."""
        assert self.shown is not None
        shown = self.told[-1 if self.failed is None else self.failed]
        found = envelope(self.effects) if self.effects else None
        table = write_envelope(self.out / TABLE, found, "combination")
        return told_above(
            self.shown, scene, self.out, [*self.files, self.out / "as_run.toml", table],
            combinations=combinations_told(self.told, found, shown.name),
            message=f"Combination '{shown.name}': {shown.message}",
        )  # fmt: skip


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
