"""Sweep: a scene under all records at all scales, and the fragility that follows.

made = incremental("column.toml", ["a.AT2", "b.AT2"], scales="0.2:2:0.2")
made.told.fragilities[0].words
made.write()
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from masonry_fem.analyses.cells.crew import Crew
from masonry_fem.analyses.cells.kept import Kept, Tell, outlook
from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.cells.unwritten import unwritten
from masonry_fem.analyses.incremental.capacity import FALLS, capacities, fitted, fragility_told, notes
from masonry_fem.analyses.incremental.fragility import Fragility
from masonry_fem.analyses.incremental.outputs import write_incremental
from masonry_fem.analyses.incremental.shakes import Shaken
from masonry_fem.errors import MasonryError
from masonry_fem.output.folder import Folder
from masonry_fem.records.remark import gathered, repeated
from masonry_fem.results.incremental import IncrementalTold
from masonry_fem.scene.overrides import texts

logger = logging.getLogger(__name__)

DEMANDS = ("peak", "residual")  # of each probe


@dataclass(frozen=True, slots=True)
class Incremental:
    """Results of an incremental dynamic analysis.

    Attributes
    ----------
    told : What ``incremental.json`` holds, as attributes.
    fits : Fragility curve of each limit, in the order of ``told.fragilities``.
    demand : Name of what is drawn against intensity.
    folder : Folder in which the runs are kept.
    """

    told: IncrementalTold
    fits: tuple[Fragility, ...]
    demand: str
    folder: Path

    @property
    def interrupted(self) -> bool:
        """Whether it was ended before its end."""
        return self.told.outcome == "interrupted"

    @property
    def decided(self) -> bool:
        """Whether any run could be."""
        return any(one.verdict != "undecided" for one in self.told.runs)

    @property
    def outlook(self) -> str:
        """How many runs are made, and how to go on."""
        made = len(self.told.runs)
        return outlook(made, made + self.told.missing, "runs are made", self.folder)

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
    """Incremental dynamic analysis: run a scene under earthquake records, each scaled to several intensities.

    A run ends with its record, or when a stone has fallen.

    Parameters
    ----------
    scene : Path of the scene file, whose analysis is one in time; its ``loads.accelerograms``, one entry at
        most, says along which axes and how the records act.
    records : Files of accelerograms, or ``.txt`` files that list some.
    scales : Factors of each record: numbers, or a text such as ``"0.2:2:0.2"`` (first:last:step).
    levels : In place of ``scales``: intensities to which each record is scaled [m/s²].
    period : Period at which the pseudo-acceleration is the intensity [s]; None: the intensity is the peak
        ground acceleration.
    states : Limits besides falling: texts ``demand=value`` [rad, m].
    demand : What is drawn against intensity: ``lean``, ``probes.NAME.peak`` or ``probes.NAME.residual``.
    out : Folder of the runs, in which a later call finds them; None: ``results/SCENE-incremental``.
    overrides : Texts ``key=value`` for all runs.
    workers : Number of runs at the same time; None: as cores and memory allow.
    time_limit : CPU time that a run may take [s]; None: no limit.
    fresh : Whether to repeat runs whose results are kept.
    tell : Called with the number of finished runs, the number of all, and what was finished last.

    Raises
    ------
    MasonryError : The scene or a record cannot be read, or the analysis of the scene is none in time.
    """
    source = Source.of(scene, overrides, Path(scene).resolve().parent)
    shaken = Shaken(source, records, period)
    known = ("lean", *(f"probes.{probe.name}.{kind}" for probe in shaken.scene.probes for kind in DEMANDS))
    limits = {FALLS: math.nan} | _limits(states, known)
    _refuse_unknown(demand, known)
    with gathered(aloud=False) as remarks:
        shakes = shaken.shakes(scales, levels)
    folder = source.folder(out, "incremental")
    crew = Crew(workers, time_limit, task="shake")
    with Folder(folder, "incremental", title=shaken.scene.title):
        kept = Kept(folder, fresh=fresh)
        rows, interrupted = kept.computed([one.cell for one in shakes], crew, source.base, tell)
    runs = tuple(one.told(rows[one.cell.key]) for one in shakes if one.cell.key in rows)
    found = {_words(state, limit): capacities(runs, state, limit) for state, limit in limits.items()}
    fits = tuple(fitted(own) for own in found.values())
    words = shaken.intensity.words
    told = tuple(
        fragility_told(fit, own, state, words) for fit, (state, own) in zip(fits, found.items(), strict=True)
    )
    said = [
        *unwritten(shaken.scene, "an incremental dynamic analysis"),
        *repeated(remarks),
        *notes(runs, told),
    ]
    for note in said:
        logger.info("%s", note)
    summary = IncrementalTold(
        title=shaken.scene.title,
        outcome="interrupted" if interrupted else "finished",
        intensity=words,
        runs=runs,
        missing=len(shakes) - len(runs),
        fragilities=told,
        notes=tuple(said),
    )
    return Incremental(summary, fits, demand, folder)


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


def _words(state: str, limit: float) -> str:
    """A limit in words."""
    return state if state == FALLS else f"{state} > {limit:g}"
