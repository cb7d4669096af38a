"""Collapse: the multiplier at which a structure falls, found by simulation, and how it falls.

    found = collapse(load("arch.toml"), Path("."), acceleration="x")
    found.summary.stands, found.summary.falls            # 0.2945, 0.2968: it falls between these
    found.mechanism.sentence()           # "10 blocks move in 3 parts; 4 hinges: ..."

What grows is the scene's loads but gravity and those named dead, or a horizontal acceleration, or the tilt
of the ground. Each trial goes on from the last state that stood, so that the loads grow as they would in a
test, and counts as standing, falling or undecided: what a solver did not solve is never a fall.
"""

from __future__ import annotations

import contextlib
import logging
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from masonry_fem.analyses.bracket import Bracket
from masonry_fem.analyses.cells.unwritten import unwritten
from masonry_fem.analyses.limit import growth_of, posed
from masonry_fem.analyses.pushing import Push
from masonry_fem.analyses.run.reopening import refuse_start
from masonry_fem.analyses.trials import Trials
from masonry_fem.build import Built, build
from masonry_fem.errors import MasonryError, ProblemError
from masonry_fem.limit import collapse_multiplier
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.records.record import check_share
from masonry_fem.records.remark import counted, gathered, repeated
from masonry_fem.results.search import CollapseTold, Fall, Trial, write_search
from masonry_fem.scene import check, specs

logger = logging.getLogger(__name__)

COLUMNS = ("multiplier", "verdict", "outcome", "steps", "seconds")  # of the trials
AT_LIMIT = "The loads are at the limit"  # how the message of such a march begins


@dataclass(frozen=True, slots=True)
class CollapseResult:
    """Results of a search for the collapse multiplier.

    Attributes
    ----------
    summary : What ``collapse.json`` holds, as attributes.
    mechanism : How the structure moves at the smallest multiplier at which it fell.
    model, state : Those at the start of the step in which it fell, for pictures.
    """

    summary: CollapseTold
    mechanism: Mechanism | None
    model: Model
    state: SystemState | None

    @property
    def multiplier(self) -> float | None:
        """Middle of the bracket; None where one end is not known."""
        ends = self.summary.stands, self.summary.falls
        return None if ends[0] is None or ends[1] is None else 0.5 * (ends[0] + ends[1])

    def __repr__(self) -> str:
        """A short table."""
        return repr(self.summary)

    def write(self, directory: str | Path, *, pictures: bool = True) -> list[Path]:
        """Write ``collapse.json``, ``trials.csv`` and ``mechanism.png`` to a folder."""
        fall = None
        if self.mechanism is not None and self.state is not None:
            fall = Fall(self.mechanism, self.model, self.state)
        return write_search(Path(directory), "collapse", self.summary, COLUMNS, fall, pictures=pictures)


def collapse(
    scene: specs.Scene,
    base: str | Path = Path(),
    *,
    tilt: str | None = None,
    acceleration: str | None = None,
    dead: Sequence[str] = (),
    tolerance: float = 1e-2,
    start: float = 0.0,
    guess: float | None = None,
    at_once: bool = False,
    limit: bool = True,
    tell: Callable[[Trial, float | None, float | None], None] | None = None,
) -> CollapseResult:
    """Find by simulation the multiplier of the loads at which a structure falls.

    The multiplier is bracketed by trials: the structure stands at the lower end of the bracket and falls at
    the upper one. Without ``tilt`` and ``acceleration`` it multiplies the scene's loads other than gravity.

    Parameters
    ----------
    scene : What to try.
    base : Folder that the paths in the scene are relative to.
    tilt : Axis (``"x"``, ``"-y"``) towards which the ground tilts; the multiplier is the angle's tangent.
    acceleration : Axis along which an acceleration grows beside gravity; the multiplier is its size over g,
        and the loads stay as they are.
    dead : Without the two: patterns of the loads that do not grow, such as ``"points.0"``.
    tolerance : Width of the bracket over its upper end at which the search ends.
    start : First multiplier; the structure must stand there.
    guess : Multiplier to try next; None: that of limit analysis, if there is one.
    at_once : Whether each trial puts its whole load on the first state, instead of on the last that stood.
    limit : Whether to run limit analysis too.
    tell : Called after each trial with the trial and the ends of the bracket so far.

    Raises
    ------
    MasonryError : The scene cannot be built, or has no load of such a name.
    """
    check_share("tolerance", tolerance)
    base = Path(base)
    scene = check(scene, base=base)
    refuse_start(scene, "a search for collapse")
    built = build(scene, base)
    push = Push.of(scene, built.model, growth_of, tilt=tilt, acceleration=acceleration, dead=dead)
    notes = [*unwritten(scene, "a search for collapse"), *scene.design.loads.notes, *push.notes]
    bound = _limit(scene, built, push, notes) if limit else None
    trials = Trials(scene, built, push, at_once=at_once, tell=tell, notes=notes)
    bracket = Bracket(trials.attempt, tolerance=tolerance, first=push.first)
    # what is known when it is interrupted is kept
    with gathered(aloud=False) as remarks, contextlib.suppress(KeyboardInterrupt):
        bracket.search(start, bound if guess is None else guess, sharp=guess is None)
    trials.notes.extend(repeated(remarks))
    return _result(scene, trials, bracket, bound, tolerance)


def _limit(scene: specs.Scene, built: Built, push: Push, notes: list[str]) -> float | None:
    """Collapse multiplier of limit analysis, where it has one for this action."""
    if push.foreign:
        notes.append("limit analysis is left out: the tilt turns gravity, but not the other loads")
        return None
    try:
        problem, _ = posed(scene, built, dead=push.dead, tilt=push.axis)
        found = collapse_multiplier(problem).multiplier
    except (ProblemError, MasonryError) as error:
        notes.append(f"limit analysis has no answer: {error}")
        return None
    if built.stones.deforming:
        notes.append("limit analysis counts elastic blocks as rigid")
    return found if math.isfinite(found) and found > 0 else None


# --- the answer -------------------------------------------------------------------------------


def _result(
    scene: specs.Scene, trials: Trials, bracket: Bracket, bound: float | None, tolerance: float
) -> CollapseResult:
    """What is known now."""
    fall = None if trials.fallen is None else Fall.of(trials.fallen[0])
    mechanism = None if fall is None else fall.mechanism
    notes = [*trials.notes, *_doubts(trials, bracket, bound, tolerance)]
    for note in notes:
        logger.info("%s", note)
    summary = CollapseTold(
        title=scene.title,
        action=trials.push.action,
        unit=trials.push.unit,
        outcome=bracket.ending,
        message=_sentence(trials, bracket, mechanism, bound),
        stands=bracket.stands,
        falls=bracket.falls,
        limit_multiplier=bound,
        mechanism=None if mechanism is None else mechanism.told(),
        trials=tuple(trials.made),
        notes=tuple(notes),
    )
    if fall is None:
        return CollapseResult(summary, None, trials.built.model, None)
    return CollapseResult(summary, fall.mechanism, fall.model, fall.state)


def _doubts(trials: Trials, bracket: Bracket, bound: float | None, tolerance: float) -> Iterator[str]:
    """What a user should know of the bracket."""
    doubtful = bracket.doubtful
    if doubtful:
        said = [trial.message for trial in trials.made if trial.verdict == "undecided"][-1]
        yield (
            f"{counted(len(doubtful), 'trial')} from {doubtful[0]:.6g} to {doubtful[-1]:.6g} undecided: they "
            f"count neither as standing nor as falling; the last: {said}"
        )
    if trials.struck:
        yield (f"{counted(trials.struck, 'trial')} that statics could not decide: dynamics from rest decided")
    if any(trial.message.startswith(AT_LIMIT) for trial in trials.made if trial.verdict == "falls"):
        yield "a trial at the limit, without equilibrium if friction is 0.1 % less, counts as falling"
    if bound is not None:
        yield from _beside_limit(bracket, bound, tolerance)


def _beside_limit(bracket: Bracket, bound: float, tolerance: float) -> Iterator[str]:
    """How the bracket may lie apart from the ``bound`` of limit analysis."""
    if bracket.falls is not None and bracket.falls < bound * (1 - 2 * tolerance):
        yield (
            f"it falls below the {bound:.6g} of limit analysis, whose joints open as they slide and keep "
            "their strength; real joints do not, and between the two both rest and motion may be possible"
        )
    if bracket.stands is not None and bracket.stands > bound * (1 + 2 * tolerance):
        yield f"it stands above the {bound:.6g} of limit analysis, as structures may that have moved far"


def _sentence(trials: Trials, bracket: Bracket, mechanism: Mechanism | None, bound: float | None) -> str:
    told = trials.push.told
    ends = [f"stands at {told(bracket.stands)}"] if bracket.stands is not None else []
    ends += [f"falls at {told(bracket.falls)}"] if bracket.falls is not None else []
    first = ", ".join(ends) or "nothing is known of its collapse"
    if bracket.ending == "unlimited":
        first = f"no fall up to {told(trials.made[-1].multiplier)}"
    elif bracket.ending == "falls at the start":
        first = f"falls at the start, {told(trials.made[0].multiplier)}"
    words = [first[0].upper() + first[1:]]
    if bracket.ending in ("undecided", "interrupted"):
        words[0] += f" ({bracket.ending})"
    if mechanism is not None:
        words.append(f"At collapse {mechanism.sentence()}")
    if bound is not None:
        words.append(f"Limit analysis: at most {told(bound)}")
    return ". ".join(words) + "."
