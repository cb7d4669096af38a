"""Threshold: the value of any key of a scene at which it stands no more, by simulation and limit analysis.

    found = threshold("arch.toml", "structures.arch.thickness", ("5 cm", "20 cm"))
    found.summary.simulation.stands, found.summary.simulation.falls       # 10.77, 10.7
    found.fall.mechanism.sentence()

A trial is the scene itself with one value of the key, from its start to its end; stages before the first one
that the value changes are run once for all trials. Either end of the values may be the one that stands. What
was tried is kept on disk as it becomes known: a second search, or one after a kill, goes on with it.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from masonry_fem.analyses.bracket import Bracket, Verdict
from masonry_fem.analyses.cells.cell import fingerprint
from masonry_fem.analyses.cells.history import FOLDER, last_stage
from masonry_fem.analyses.cells.kept import Kept
from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.cells.unwritten import unwritten
from masonry_fem.analyses.single_run import RunEnd, ask_limit_analysis, run_once
from masonry_fem.analyses.swept_key import SweptKey
from masonry_fem.errors import MasonryError, ProblemError
from masonry_fem.fidelities import deforms
from masonry_fem.march.clock import Clock
from masonry_fem.march.mechanism import Falling
from masonry_fem.output.folder import Folder
from masonry_fem.records.record import check_share
from masonry_fem.records.remark import counted, gathered, repeated
from masonry_fem.results.search import Fall, Outcome, Range, ThresholdTold, Tried, write_search
from masonry_fem.scene import check, specs
from masonry_fem.scene.combinations import combination_scenes

logger = logging.getLogger(__name__)

Tell = Callable[[float, str, float | None, float | None], None]

COLUMNS = ("value", "by", "verdict", "outcome", "steps", "seconds")  # of the trials
FINER = 0.1  # of the tolerance: that of limit analysis, which costs little
NEAR_ZERO = 1e-3  # of the ends' distance, times the tolerance: a bracket that is narrow even at 0


@dataclass(frozen=True, slots=True)
class Threshold:
    """Results of a search for a threshold.

    Attributes
    ----------
    summary : What ``threshold.json`` holds, as attributes.
    fall : How the structure falls there; None: not known.
    folder : Folder in which the trials are kept.
    """

    summary: ThresholdTold
    fall: Fall | None
    folder: Path

    @property
    def value(self) -> float | None:
        """Middle of the bracket of the simulation; None where one end is not known."""
        found = self.summary.simulation
        return None if found.stands is None or found.falls is None else 0.5 * (found.stands + found.falls)

    def __repr__(self) -> str:
        """A short table."""
        return repr(self.summary)

    def write(self, directory: str | Path | None = None, *, pictures: bool = True) -> list[Path]:
        """Write ``threshold.json``, ``trials.csv`` and ``mechanism.png``; returns their paths."""
        folder = self.folder if directory is None else Path(directory)
        return write_search(folder, "threshold", self.summary, COLUMNS, self.fall, pictures=pictures)


def threshold(
    scene: str | Path,
    key: str,
    between: tuple[str | float, str | float],
    *,
    along: Sequence[float] = (),
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    tolerance: float = 1e-2,
    limit: bool = True,
    fresh: bool = False,
    tell: Tell | None = None,
) -> Threshold:
    """Find the value of a key, such as a thickness or a friction, beyond which a scene no longer stands.

    Parameters
    ----------
    scene : Path of the scene file.
    key : Dotted key, as overrides take it.
    between : Two values: the scene stands at one of them and not at the other.
    along : Direction of a key that is a vector; values are its length along it.
    out : Folder of the trials, in which a later search finds them; None: ``results/SCENE-threshold``.
    overrides : Texts ``key=value`` for all trials.
    tolerance : Width of the bracket over the larger of its ends at which the search ends.
    limit : Whether to run limit analysis first, and to look near its answer.
    fresh : Whether to repeat trials whose results are kept.
    tell : Called after each trial with the value, its verdict, and the ends of the bracket so far.

    Raises
    ------
    MasonryError : The scene cannot be read with these values.
    """
    check_share("tolerance", tolerance)
    trials = _Trials(
        Source.of(scene, overrides, Path(scene).resolve().parent), SweptKey.of(key, *between, along)
    )
    folder = trials.source.folder(out, "threshold")
    title, keeps = trials.scenes[0].title, [] if fresh else [f"{FOLDER}/"]
    with Folder(folder, "threshold", title=title, keeps=keeps), gathered(aloud=False) as remarks:
        kept = Kept(folder, fresh=fresh)
        static = _limit(trials, kept, FINER * tolerance) if limit else None
        guess = None if static is None or static.bracket is None else static.middle
        runs = _Search(
            trials,
            kept,
            _in_all(lambda own, base: run_once(last_stage(own, base, folder), base)),
            "simulation",
            tell,
        )
        runs.search(tolerance, guess)
    notes = [
        *unwritten(trials.scenes[0], "a search for a threshold"),
        *trials.notes,
        *repeated(remarks),
        *_doubts(runs, static, tolerance),
    ]
    for note in notes:
        logger.info("%s", note)
    summary = ThresholdTold(
        title=trials.scenes[0].title,
        key=trials.key.key,
        unit=trials.key.unit,
        along=trials.key.along,
        outcome=runs.outcome,
        message=_sentence(trials.key, runs, static, combined=bool(trials.scenes[0].combinations)),
        simulation=runs.told(),
        limit_analysis=None if static is None else static.told(),
        trials=tuple(trial for one in (static, runs) if one is not None for trial in one.made),
        notes=tuple(notes),
    )
    return Threshold(summary, runs.fall, folder)


# --- trials -----------------------------------------------------------------------------------


class _Trials:
    """The scenes that values of a key make."""

    def __init__(self, source: Source, key: SweptKey) -> None:
        self.source, self.key = source, key.fitted(source.scene)
        self.scenes = [self.scene(value) for value in (self.key.low, self.key.high)]
        self.notes: list[str] = []

    def scene(self, value: float) -> specs.Scene:
        """The scene with a value of the key."""
        return check(self.source.scene(self.key.override(value)), base=self.source.base)


type _Ask = Callable[[specs.Scene, Path], RunEnd]


def _in_all(ask: _Ask) -> _Ask:
    """Asks of each load combination: the first one that falls decides, or one that is undecided."""

    def asked(scene: specs.Scene, base: Path) -> RunEnd:
        worst: RunEnd | None = None
        for combination, own in combination_scenes(scene):
            ended = ask(own, base)
            ended = replace(ended, message=f"Combination '{combination.name}': {ended.message}")
            if ended.verdict == "falls":
                return ended
            if worst is None or ended.verdict == "undecided":
                worst = ended
        return ask(scene, base) if worst is None else worst

    return asked


class _Search:
    """The threshold by one way of asking whether a scene stands."""

    def __init__(
        self,
        trials: _Trials,
        kept: Kept,
        ask: _Ask,
        by: Literal["simulation", "limit analysis"],
        tell: Tell | None,
    ) -> None:
        self._trials, self._kept, self._ask, self._by, self._tell = trials, kept, ask, by, tell
        self._base = trials.source.base
        self._ends: dict[float, RunEnd] = {}  # of those that were not known
        self._sign = 1.0  # of the direction in which values come nearer to a fall
        self.made: list[Tried] = []
        self.bracket: Bracket | None = None
        self.outcome: Outcome = "interrupted"
        self.mechanism: Falling | None = None
        self.fall: Fall | None = None

    def search(self, tolerance: float, guess: float | None) -> None:
        """Close in to a tolerance; what is known when it is interrupted is kept."""
        with contextlib.suppress(KeyboardInterrupt):
            self._search(tolerance, guess)
            fallen = self.ends[1]
            if fallen is not None:
                ended = self._ends.get(fallen) or self._ask(self._trials.scene(fallen), self._base)
                self.mechanism, self.fall = ended.mechanism, ended.fall

    def _search(self, tolerance: float, guess: float | None) -> None:
        key = self._trials.key
        first, last = self.attempt(key.low), self.attempt(key.high)
        if first == last:
            self.outcome = "undecided" if first == "undecided" else f"{first} at both ends"  # type: ignore
            return
        start, end = key.low, key.high
        if first == "falls" or last == "stands":
            start, end = end, start
        self._sign = sign = 1.0 if start < end else -1.0
        width = abs(end - start)
        self.bracket = Bracket(
            lambda multiplier: self.attempt(sign * multiplier), tolerance=tolerance, first=width,
            least=1.0 if key.whole else NEAR_ZERO * tolerance * width, whole=key.whole,
        )  # fmt: skip
        self.bracket.between(sign * start, sign * end, None if guess is None else sign * guess)
        self.outcome = "bracketed" if self.bracket.ending == "bracketed" else "undecided"

    def attempt(self, value: float) -> Verdict:
        """The verdict on a value, from disk where it is known."""
        value = float(value) + 0.0  # no -0
        for made in self.made:
            if made.value == value:
                return made.verdict
        scene, clock = self._trials.scene(value), Clock()
        key = f"{fingerprint(scene, self._base)}-{self._by.partition(' ')[0]}"
        trial = self._kept.row(key, Tried)
        if trial is None:
            self._ends[value] = ended = self._ask(scene, self._base)
            clock.lap("trial")
            trial = Tried(
                value=value, by=self._by, verdict=ended.verdict, outcome=ended.outcome,
                message=ended.message, steps=ended.steps, seconds=clock.phases["trial"],
            )  # fmt: skip
            self._kept.keep(key, trial)
        self.made.append(trial)
        if self._tell is not None:
            self._tell(value, trial.verdict, *self.ends)
        return trial.verdict

    @property
    def ends(self) -> tuple[float | None, float | None]:
        """Values nearest to each other at which it stands and falls."""
        if self.bracket is None:
            return None, None
        stands, falls = self.bracket.stands, self.bracket.falls
        return tuple(None if end is None else self._sign * end + 0.0 for end in (stands, falls))  # type: ignore

    @property
    def middle(self) -> float | None:
        """Middle of the bracket; None where one end is not known."""
        stands, falls = self.ends
        return None if stands is None or falls is None else 0.5 * (stands + falls)

    def told(self) -> Range:
        """What the summary says."""
        stands, falls = self.ends
        return Range(outcome=self.outcome, stands=stands, falls=falls, mechanism=self.mechanism)

    def words(self) -> str:
        """The range in words."""
        told = self._trials.key.told
        said = [
            f"{verdict} at {told(end)}"
            for verdict, end in zip(("stands", "falls"), self.ends, strict=True)
            if end is not None
        ]
        if not said:
            ends = f"{told(self._trials.key.low)} and {told(self._trials.key.high)}"
            return f"{self.outcome}, {ends}" if "both" in self.outcome else f"{self.outcome} at {ends}"
        return ", ".join(said) + ("" if self.outcome == "bracketed" else f" ({self.outcome})")


# --- limit analysis beside it -----------------------------------------------------------------


def _limit(trials: _Trials, kept: Kept, tolerance: float) -> _Search | None:
    """The threshold of limit analysis, where it has one."""
    scene = trials.scenes[0]
    why = (
        "the scene has stages" if scene.stages
        else "the scene starts where another ended" if scene.analysis.start is not None
        else "" if scene.analysis.seeks_equilibrium else "the analysis is in time"
    )  # fmt: skip
    if why:
        trials.notes.append(f"limit analysis is left out: {why}")
        return None
    found = _Search(trials, kept, _in_all(ask_limit_analysis), "limit analysis", None)
    try:
        found.search(tolerance, None)
    except (ProblemError, MasonryError) as error:
        trials.notes.append(f"limit analysis has no answer: {error}")
        return None
    if any(support.motion is not None for support in scene.supports):
        trials.notes.append("limit analysis leaves motions of supports out: blocks are where they start")
    if any(deforms(name) for name in scene.fidelities):
        trials.notes.append("limit analysis counts elastic blocks as rigid")
    return found


def _doubts(runs: _Search, static: _Search | None, tolerance: float) -> Iterator[str]:
    """What a user should know of the two ranges."""
    doubtful = [made for made in runs.made if made.verdict == "undecided"]
    if doubtful:
        yield (
            f"{counted(len(doubtful), 'trial')} undecided, the last at {doubtful[-1].value:.6g}: they count "
            f"neither as standing nor as falling; it said: {doubtful[-1].message}"
        )
    if static is None or static.middle is None or runs.middle is None:
        return
    apart = runs.middle - static.middle
    if abs(apart) > 2 * tolerance * abs(static.middle):
        yield (
            "the two differ: limit analysis takes rigid blocks where they start, whose joints open as they "
            "slide and keep their strength, and tells what can be carried at most"
        )


def _sentence(key: SweptKey, runs: _Search, static: _Search | None, *, combined: bool) -> str:
    words = [f"{key.key} {runs.words()}"]
    if "both" in runs.outcome:
        words.append("It changes nowhere between them: take ends further apart")
    fallen = next((made for made in runs.made if made.value == runs.ends[1]), None)
    if combined and fallen is not None:
        words.append(fallen.message.rstrip("."))  # names the one that decides
    if runs.mechanism is not None:
        words.append(f"There {runs.mechanism.sentence}")
    if static is not None:
        words.append(f"Limit analysis: {static.words()}")
    return ". ".join(words) + "."
