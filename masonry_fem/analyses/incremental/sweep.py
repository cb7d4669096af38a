"""Sweep: a scene under all records at all scales, and the fragility that follows.

made = incremental("column.toml", ["a.AT2", "b.AT2"], scales="0.2:2:0.2")
made.told.fragilities[0].words
made.write()
"""

from __future__ import annotations

import logging
import math
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.analyses.incremental.fragility import CONFIDENCE, Fragility, fragility
from masonry_fem.analyses.incremental.outputs import write_incremental
from masonry_fem.analyses.incremental.records import Intensity, Record, parsed_scales, read_records
from masonry_fem.analyses.study.cell import MOST, Cell, fingerprint
from masonry_fem.analyses.study.crew import Crew
from masonry_fem.analyses.study.sweep import Tell, computed
from masonry_fem.analyses.trials import counted, repeated
from masonry_fem.build.shaking import shaking
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.output.folder import Folder, make_folder
from masonry_fem.records.arguments import texts
from masonry_fem.records.listing import first_few
from masonry_fem.records.remark import gathered
from masonry_fem.results.incremental import Capacity, FragilityTold, IncrementalTold, ShakenTold
from masonry_fem.scene import check, dumps, loads, specs
from masonry_fem.scene.overrides import apply

logger = logging.getLogger(__name__)

FALLS = "falls"  # the limit that is always asked for
SWINGS = 0.1  # of the greatest way of a probe: where more is left at the end, nothing is said of what stays
FEW = 10  # records: of fewer the distribution's form is not seen
KEY = "loads.accelerograms.0"
DEMANDS = ("peak", "residual")  # of each probe


@dataclass(frozen=True, slots=True)
class Incremental:
    """What an incremental dynamic analysis found.

    Attributes
    ----------
    told : What ``incremental.json`` holds. fits : By limit, in the order of ``told.fragilities``.
    demand : What is drawn against intensity.
    folder : Where runs are kept.
    """

    told: IncrementalTold
    fits: tuple[Fragility, ...]
    demand: str
    folder: Path

    @property
    def outlook(self) -> str:
        """How many runs are made, and how to go on."""
        made = len(self.told.runs)
        return (
            f"{made} of {made + self.told.missing} runs are made and kept in {self.folder}; the same command "
            f"goes on with the {self.told.missing} left"
        )

    def __repr__(self) -> str:
        """The fragilities as sentences."""
        return repr(self.told)

    def write(self, directory: str | Path | None = None, *, pictures: bool = True) -> list[Path]:
        """Write tables and pictures; returns their paths.

        Parameters
        ----------
        directory : Where to; None: where the runs are kept.
        pictures : Whether any are drawn.
        """
        folder = self.folder if directory is None else Path(directory)
        return write_incremental(folder, self.told, self.fits, demand=self.demand, pictures=pictures)


def incremental(
    scene: str | Path,
    records: Sequence[str | Path],
    *,
    scales: str | Sequence[float] = (),
    levels: str | Sequence[float] = (),
    period: float | None = None,
    states: Sequence[str] | Mapping[str, float] = (),
    demand: str = "lean",
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    workers: int | None = None,
    time_limit: float | None = None,
    fresh: bool = False,
    tell: Tell | None = None,
) -> Incremental:
    """Run a scene under records at scales, each run until its end or until a stone has fallen.

    Parameters
    ----------
    scene : Path of its file, an analysis in time; its ``loads.accelerograms``, one at most, say along which
        axes and how records act.
    records : Files of accelerograms, or ``.txt`` files that list some.
    scales : What each record is multiplied by: numbers, or a text as ``"0.2:2:0.2"``.
    levels : In place of ``scales`` the intensities that each record is scaled to [m/s²].
    period : Intensity is the pseudo-acceleration of this period [s]; None: the greatest acceleration.
    states : Limits besides falling: texts ``demand=value`` [rad, m].
    demand : What is drawn against intensity: ``lean``, ``probes.NAME.peak`` or ``probes.NAME.residual``.
    out : Folder of the runs, where a second call finds them; None: ``results/SCENE-incremental``.
    overrides : Texts ``key=value`` for all runs.
    workers : Runs at the same time; None: as cores and memory allow.
    time_limit : CPU time that a run may take [s].
    fresh : Run again what is already known.
    tell : Called with the number of finished runs, the number of all, and what was finished last.

    Raises
    ------
    MasonryError : The scene or a record cannot be read, or the scene cannot be shaken so.
    """
    path = Path(scene)
    source = _Source(path, texts(overrides), records, period)
    known = ("lean", *(f"probes.{probe.name}.{kind}" for probe in source.scene.probes for kind in DEMANDS))
    limits = {FALLS: math.nan} | _limits(states, known)
    _refuse_unknown(demand, known)
    with gathered(aloud=False) as remarks:
        shakes = source.shakes(scales, levels)
    folder = Path("results") / f"{path.stem}-incremental" if out is None else Path(out)
    crew = Crew(workers, time_limit, task="shake")
    cells = [one.cell for one in shakes]
    with Folder(folder, "incremental", title=source.scene.title):
        make_folder(folder / "cells")
        rows, interrupted = computed(cells, crew, source.base, folder / "cells", fresh, tell)
    runs = tuple(one.told(rows[one.cell.key]) for one in shakes if one.cell.key in rows)
    capacities = {state: _capacities(runs, state, limit) for state, limit in limits.items()}
    fits = tuple(_fitted(found) for found in capacities.values())
    words = source.intensity.words
    told = tuple(
        _told(fit, found, _state(state, limits[state]), words)
        for fit, (state, found) in zip(fits, capacities.items(), strict=True)
    )
    notes = [*repeated(remarks), *_notes(runs, told)]
    for note in notes:
        logger.info("%s", note)
    summary = IncrementalTold(
        title=source.scene.title,
        outcome="interrupted" if interrupted else "finished",
        intensity=words,
        runs=runs,
        missing=len(shakes) - len(runs),
        fragilities=told,
        notes=tuple(notes),
    )
    return Incremental(summary, fits, demand, folder)


# --- what is run ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Shake:
    """One record at one scale, and the scene that they make."""

    record: str
    scale: float
    intensity: float
    pga: float
    cell: Cell

    def told(self, row: Mapping[str, Any]) -> ShakenTold:
        """With what a worker left."""
        return ShakenTold(
            record=self.record, scale=self.scale, intensity=self.intensity, pga=self.pga,
            verdict=row.get("verdict", "undecided"), outcome=row["outcome"], message=row["message"],
            leans=row.get("leans", ""), demands=row.get("demands", {}), swing=row.get("swing", 0.0),
            steps=row.get("steps", 0), cpu=row.get("cpu", 0.0),
        )  # fmt: skip


class _Source:
    """The scene's text, and the scenes that records make of it."""

    def __init__(
        self, path: Path, overrides: tuple[str, ...], given: Sequence[str | Path], period: float | None
    ) -> None:
        try:
            self._text = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            raise SceneError(f"{path}: cannot be read ({error}); expected a TOML file") from error
        self._path, self.base, self._overrides = str(path), path.resolve().parent, overrides
        self._records = read_records(given, self._axes())
        # with a record, as files that the scene names need not be there
        self.scene, _ = self._scaled(self._records[0], 1.0)
        self._refuse(path)
        self.intensity = Intensity(period, self.scene.output.spectrum_damping)

    def _axes(self) -> list[str]:
        """Along which the scene is shaken; what is no scene is refused as it is read."""
        try:
            tree = tomllib.loads(self._text)
        except (ValueError, RecursionError):
            return ["x"]
        apply(tree, self._overrides)
        match tree:
            case {"loads": {"accelerograms": [dict(held), *_]}}:
                return [axis for axis in "xyz" if axis in held] or ["x"]
        return ["x"]

    def _refuse(self, path: Path) -> None:
        scene = self.scene
        for several in ("stages", "combinations"):
            if getattr(scene, several):
                raise MasonryError(f"{path} has {several}, and a record shakes one run; leave them out")
        if scene.analysis.seeks_equilibrium:
            raise MasonryError(f"{path} is no analysis in time; give [analysis] kind = 'dynamics'")
        if len(scene.loads.accelerograms) > 1:
            raise MasonryError(
                f"{path} has {len(scene.loads.accelerograms)} loads.accelerograms, expected one, whose files "
                "the records take the place of"
            )

    def shakes(self, scales: str | Sequence[float], levels: str | Sequence[float]) -> list[_Shake]:
        """All runs, record by record."""
        wanted = parsed_scales(scales, "scales") or parsed_scales(levels, "levels")
        if bool(len(scales)) == bool(len(levels)):
            raise MasonryError("give either scales, as 0.2:2:0.2, or levels of intensity [m/s²]")
        count = len(self._records) * len(wanted)
        if count > MOST:
            raise MasonryError(
                f"{len(self._records)} records at {len(wanted)} scales are {count} runs, expected at most "
                f"{MOST}"
            )
        found = []
        for record in self._records:
            scene, _ = self._scaled(record, 1.0)
            ground = shaking(check(scene, base=self.base), self.base)
            assert ground is not None
            unit = self.intensity.of(ground, self._level)
            pga = Intensity(None, 0.0).of(ground, self._level)
            if not unit > 0:
                raise MasonryError(f"record '{record.name}' does not move the ground; leave it out")
            for one in wanted:
                scale = one / unit if len(levels) else one
                intensity = one if len(levels) else one * unit
                scene, settings = self._scaled(record, scale)
                key = f"{fingerprint(scene, self.base)}-shaken"
                cell = Cell((), settings, dumps(scene), key)
                found.append(_Shake(record.name, scale, intensity, scale * pga, cell))
        return found

    @property
    def _level(self) -> list[int]:
        """Axes across gravity."""
        pull = self.scene.loads.gravity
        down = self.scene.dimension - 1 if pull is None else int(np.abs(np.array(pull)).argmax())
        return [axis for axis in range(self.scene.dimension) if axis != down]

    def _scaled(self, record: Record, scale: float) -> tuple[specs.Scene, dict[str, str]]:
        # by the same name from wherever the command is called
        files = {axis: os.path.relpath(path.resolve(), self.base) for axis, path in record.files.items()}
        own = [f'{KEY}.{axis}="{name}"' for axis, name in files.items()]
        own.append(f"{KEY}.scale={scale!r}")
        if all(path.suffix.lower() == ".at2" for path in record.files.values()):
            own.append(f'{KEY}.unit="g"')
        scene = loads(self._text, [*self._overrides, *own], base=self.base, source=self._path)
        return scene, {"record": record.name, "scale": f"{scale:.6g}"}


def _limits(states: Sequence[str] | Mapping[str, float], known: Sequence[str]) -> dict[str, float]:
    """Greatest demands by name."""
    named = (
        states.items() if isinstance(states, Mapping) else [one.partition("=")[::2] for one in texts(states)]
    )
    found: dict[str, float] = {}
    for name, value in named:
        _refuse_unknown(name, known)
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = math.nan
        if not 0 < found[name] < math.inf:
            raise MasonryError(f"limit of {name} is '{value}', expected a positive number in rad or m")
    return found


def _refuse_unknown(demand: str, known: Sequence[str]) -> None:
    if demand not in known:
        raise MasonryError(f"demand '{demand}', expected one of {', '.join(known)}")


# --- what came out ----------------------------------------------------------------------------


def _capacities(runs: Sequence[ShakenTold], state: str, limit: float) -> list[Capacity]:
    """Between which intensities each record begins to pass a limit; what is undecided tells nothing."""
    found = []
    for name in dict.fromkeys(one.record for one in runs):
        own = sorted(
            (one.intensity, one.verdict == "falls" or (state != FALLS and one.demands[state] > limit))
            for one in runs
            if one.record == name and one.verdict != "undecided"
        )
        first = min((at for at, passed in own if passed), default=math.inf)
        stands = max((at for at, passed in own if not passed and at < first), default=0.0)
        again = sum(not passed for at, passed in own if at > first)
        if own:
            passes = None if math.isinf(first) else first
            found.append(Capacity(record=name, stands=stands, passes=passes, again=again))
    return found


def _fitted(found: Sequence[Capacity]) -> Fragility:
    passes = [math.inf if one.passes is None else one.passes for one in found]
    return fragility(np.array([one.stands for one in found]), np.array(passes))


def _state(state: str, limit: float) -> str:
    return state if state == FALLS else f"{state} > {limit:g}"


def _told(fit: Fragility, found: Sequence[Capacity], state: str, intensity: str) -> FragilityTold:
    sample = f"{counted(fit.records, 'record')}, of which {fit.passed} pass it"
    said = f"{state}: not determined by {sample}"
    if fit.outcome == "never passed":
        said = f"{state}: never, under {counted(fit.records, 'record')}"
    elif fit.outcome == "step" and fit.median_range is not None:
        low, high = fit.median_range
        said = f"{state}: at {intensity} between {low:.4g} and {high:.4g} m/s² for all of {sample}"
    elif fit.median_range is not None and fit.dispersion_range is not None:
        said = (
            f"{state}: median {intensity} {fit.median:.4g} m/s² ({_between(fit.median_range)}), dispersion "
            f"{fit.dispersion:.3g} ({_between(fit.dispersion_range)}), {100 * CONFIDENCE:g} % ranges, of "
            f"{sample}"
        )
    return FragilityTold(
        state=state,
        outcome=fit.outcome,
        records=fit.records,
        passed=fit.passed,
        median=fit.median,
        dispersion=fit.dispersion,
        median_range=fit.median_range,
        dispersion_range=fit.dispersion_range,
        confidence=CONFIDENCE,
        capacities=tuple(found),
        words=f"{said}.",
    )


def _between(ends: tuple[float, float]) -> str:
    return f"{ends[0]:.3g} to " + ("any" if math.isinf(ends[1]) else f"{ends[1]:.3g}")


def _notes(runs: Sequence[ShakenTold], told: Sequence[FragilityTold]) -> list[str]:
    """What a reader should know."""
    notes = []
    doubtful = [one for one in runs if one.verdict == "undecided"]
    if doubtful:
        named = first_few([f"{one.record} at {one.scale:.4g}" for one in doubtful], 3)
        notes.append(
            f"{counted(len(doubtful), 'run')} ended undecided and were left out ({named}); the last said: "
            f"{doubtful[-1].message}"
        )
    for one in told:
        back = [own for own in one.capacities if own.again]
        if back:
            named = first_few([own.record for own in back], 3)
            notes.append(
                f"{one.state}: {counted(sum(own.again for own in back), 'run')} of {named} stay below it at "
                "a greater intensity than the first that passes it; the first counts"
            )
    if any(one.outcome == "fitted" and one.records < FEW for one in told):
        notes.append(
            f"ranges are those of large samples; of fewer than {FEW} records they are somewhat too narrow, "
            "and whether the distribution is lognormal cannot be seen"
        )
    moving = [one for one in runs if one.verdict == "stands" and one.swing > SWINGS]
    if moving:
        notes.append(
            f"in {counted(len(moving), 'run')} probes still move at the end by more than {100 * SWINGS:g} % "
            "of their peak: residuals are not final, and what moves may still fall; expected a longer "
            "analysis.duration"
        )
    return notes
