"""Collapse: the multiplier at which a structure falls, found by simulation, and how it falls.

    found = collapse(load("arch.toml"), Path("."), acceleration="x")
    found.stands, found.falls            # 0.2945, 0.2968: it falls between these
    found.mechanism.sentence()           # "10 blocks move in 3 parts; 4 hinges: ..."

What grows is the scene's loads but gravity and those named dead, or a horizontal acceleration, or the tilt
of the ground. Each trial goes on from the last state that stood, so that the loads grow as they would in a
test, and counts as standing, falling or undecided: what a solver did not solve is never a fall.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

from masonry_fem.build import Built, build, solver_settings, strategy
from masonry_fem.dynamics.clock import Clock
from masonry_fem.dynamics.equilibrium import Onward, Statics, Strategy
from masonry_fem.dynamics.march import March, march
from masonry_fem.dynamics.mechanism import Mechanism, mechanism_of_step
from masonry_fem.dynamics.model import Model
from masonry_fem.dynamics.state import SystemState
from masonry_fem.errors import MasonryError, ProblemError
from masonry_fem.limit import collapse_multiplier
from masonry_fem.limit_analysis import growth_of, posed
from masonry_fem.post.collapse_files import write_collapse
from masonry_fem.pushing import Push
from masonry_fem.scene import check, specs

logger = logging.getLogger(__name__)

Verdict = Literal["stands", "falls", "undecided"]
VERDICTS: dict[str, Verdict] = {"equilibrium": "stands", "no_equilibrium": "falls"}
Ending = Literal["bracketed", "undecided", "unlimited", "falls at the start", "interrupted"]

GREATEST = 1e4  # times the first guess: loads that may grow so far have no limit
MOST = 60  # trials
NEAR = 0.4  # of the tolerance: how near to the limit multiplier the first trials are


@dataclass(frozen=True, slots=True)
class Trial:
    """One attempt.

    Attributes
    ----------
    multiplier : Of what grows. verdict : ``stands``, ``falls`` or ``undecided``.
    outcome, message : How its march ended, and the sentence for it.
    steps : Made. seconds : CPU time [s].
    """

    multiplier: float
    verdict: Verdict
    outcome: str
    message: str
    steps: int
    seconds: float


@dataclass(frozen=True, slots=True)
class CollapseResult:
    """What is known of the collapse.

    Attributes
    ----------
    title : Of the scene. action : What grows, in words. unit : Of the multiplier ("g", "times", "tan").
    outcome : ``bracketed`` to the tolerance, ``undecided`` where trials were not, ``unlimited``, ``falls at
        the start``, ``interrupted``. message : The same as a sentence.
    trials : In their order.
    stands, falls : Greatest multiplier that stood, least that fell; None: none did.
    mechanism : How the structure moves at the least fall.
    limit : Collapse multiplier of limit analysis, an upper bound; None: not known.
    notes : What was taken otherwise than the scene says, and doubts.
    model, state : At the start of the step that fell, for pictures.
    """

    title: str
    action: str
    unit: str
    outcome: Ending
    message: str
    trials: tuple[Trial, ...]
    stands: float | None
    falls: float | None
    mechanism: Mechanism | None
    limit: float | None
    notes: tuple[str, ...]
    model: Model
    state: SystemState | None

    @property
    def multiplier(self) -> float | None:
        """Middle of the bracket; None where one end is not known."""
        if self.stands is None or self.falls is None:
            return None
        return 0.5 * (self.stands + self.falls)

    def told(self) -> dict[str, Any]:
        """What ``collapse.json`` holds."""
        return {
            "title": self.title,
            "action": self.action,
            "unit": self.unit,
            "outcome": self.outcome,
            "message": self.message,
            "stands": self.stands,
            "falls": self.falls,
            "limit_multiplier": self.limit,
            "mechanism": None if self.mechanism is None else self.mechanism.told(),
            "trials": [asdict(trial) for trial in self.trials],
            "notes": list(self.notes),
        }

    def write(self, directory: Path, *, pictures: bool = True) -> list[Path]:
        """Write ``collapse.json``, ``trials.csv`` and ``mechanism.png`` to a folder."""
        return write_collapse(
            directory, self.told(), self.model, self.state, self.mechanism, pictures=pictures
        )


def collapse(
    scene: specs.Scene,
    base: Path = Path(),
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
    """Find by simulation the multiplier at which a structure falls.

    Parameters
    ----------
    scene : What to try. base : Folder that the paths in it are relative to.
    tilt : Axis to which the ground is tilted, gravity turned; the multiplier is the angle's tangent.
    acceleration : Axis along which an acceleration of g grows beside gravity; all loads stay.
    dead : Patterns of loads that do not grow, where neither is given; gravity never does.
    tolerance : Width of the bracket over its upper end.
    start : First multiplier; the structure must stand there.
    guess : Where to look first; None: at the multiplier of limit analysis, if there is one.
    at_once : Put the whole load on the state at the start in each trial, not on the last that stood.
    limit : Ask limit analysis too. tell : Is told each trial and the bracket so far.

    Raises
    ------
    MasonryError : The scene cannot be built, or nothing in it is so named.
    """
    if not 0 < tolerance < 1:
        raise MasonryError(f"tolerance is {tolerance:g}, expected one between 0 and 1, as 0.01")
    scene = check(scene, base=base)
    built = build(scene, base)
    push = Push.of(scene, built.model, growth_of, tilt=tilt, acceleration=acceleration, dead=dead)
    notes = list(push.notes)
    bound = _limit(scene, built, push, notes) if limit else None
    search = _Search(scene, built, push, tolerance, at_once, tell, notes)
    try:
        ending = search.run(start, bound if guess is None else guess, guess is None)
    except KeyboardInterrupt:
        ending = "interrupted"
    return search.result(ending, bound)


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
    if "elastic" in built.stones.role:
        notes.append("limit analysis counts elastic blocks as rigid")
    return found if math.isfinite(found) and found > 0 else None


class _Search:
    """Trials, and what is known from them."""

    def __init__(
        self,
        scene: specs.Scene,
        built: Built,
        push: Push,
        tolerance: float,
        at_once: bool,
        tell: Callable[[Trial, float | None, float | None], None] | None,
        notes: list[str],
    ) -> None:
        self.title, self.built, self.push = scene.title, built, push
        self.tolerance, self.at_once, self.tell, self.notes = tolerance, at_once, tell, notes
        self.settings = solver_settings(scene.solver)
        self.strategy: Strategy = strategy(scene.analysis)
        if not self.strategy.seeks_equilibrium:
            self.strategy = Statics()
            notes.append("dynamics does not end by standing or falling: statics was taken for the trials")
        self.trials: list[Trial] = []
        self.low: float | None = None
        self.high: float | None = None
        self.standing: tuple[March, float] | None = None
        self.first: tuple[March, float] | None = None
        self.fallen: March | None = None

    # --- one trial --------------------------------------------------------------------------------

    def attempt(self, multiplier: float) -> Verdict:
        """Try a multiplier and learn from it."""
        clock = Clock()
        made = self._march(multiplier)
        clock.lap("trial")
        verdict: Verdict = VERDICTS.get(made.outcome, "undecided")
        trial = Trial(
            multiplier, verdict, made.outcome, made.message, made.state.index, clock.phases["trial"]
        )
        self.trials.append(trial)
        if verdict == "stands" and (self.low is None or multiplier > self.low):
            self.low, self.standing = multiplier, (made, multiplier)
            self.first = self.first or self.standing
        if verdict == "falls" and (self.high is None or multiplier < self.high):
            self.high, self.fallen = multiplier, made
        if self.tell is not None:
            self.tell(trial, self.low, self.high)
        return verdict

    def _march(self, multiplier: float) -> March:
        origin = self.first if self.at_once else self.standing
        if origin is None:
            model = replace(self.built.model, loads=self.push.at_first(self.strategy, multiplier))
            return march(model, self.strategy, self.settings, bodies=self.built.bodies)
        made, reached = origin
        since = made.state.time
        loads = self.push.onward(self.strategy, since, reached, multiplier)
        model = replace(made.model, loads=loads)
        return march(model, Onward(self.strategy, since), self.settings, start=_rested(model, made.state))

    # --- the search -------------------------------------------------------------------------------

    def run(self, start: float, guess: float | None, sharp: bool) -> Ending:
        """Try the start, find a multiplier that falls, close in."""
        first = self.attempt(start)
        if first != "stands":
            return "falls at the start" if first == "falls" else "undecided"
        self._expand(start, guess, sharp)
        if self.high is None and not self._doubtful():
            return "unlimited"
        self._close_in()
        return "bracketed" if self._known() else "undecided"

    def _expand(self, start: float, guess: float | None, sharp: bool) -> None:
        """Multipliers that grow until one falls."""
        if guess is not None and guess > start:
            margin = 1 + NEAR * self.tolerance
            here = margin * guess if sharp else guess
            if self.attempt(here) == "falls":
                if sharp and guess / margin > start:
                    self.attempt(guess / margin)
                return
            stride = 4 * self.tolerance * guess
        else:
            here, stride = start, self.push.first
        end = GREATEST * max(stride, self.push.first)
        while self.high is None and here < end and len(self.trials) < MOST:
            here, stride = here + stride, 2 * stride
            self.attempt(here)

    def _close_in(self) -> None:
        """Halve the widest gap between what stands, what is undecided, and what falls."""
        while len(self.trials) < MOST:
            gaps = self._gaps()
            if not gaps:
                return
            below, above = max(gaps, key=lambda gap: gap[1] - gap[0])
            self.attempt(0.5 * (below + above))

    def _gaps(self) -> list[tuple[float, float]]:
        """Ranges of multipliers wider than the tolerance that nothing is known of."""
        low = 0.0 if self.low is None else self.low
        doubtful = self._doubtful()
        if doubtful:
            found = [(low, doubtful[0])]
            if self.high is not None:
                found.append((doubtful[-1], self.high))
        else:
            found = [] if self.high is None else [(low, self.high)]
        scale = self.high if self.high is not None else (doubtful[-1] if doubtful else 0.0)
        least = max(self.tolerance * scale, 1e-9 * self.push.first)
        return [gap for gap in found if gap[1] - gap[0] > least]

    def _doubtful(self) -> list[float]:
        """Multipliers of undecided trials between what stands and what falls."""
        low, high = self.low or 0.0, math.inf if self.high is None else self.high
        return sorted(
            trial.multiplier
            for trial in self.trials
            if trial.verdict == "undecided" and low < trial.multiplier < high
        )

    def _known(self) -> bool:
        low = self.low if self.low is not None else -math.inf
        return self.high is not None and self.high - low <= 1.001 * self.tolerance * self.high

    # --- the answer -------------------------------------------------------------------------------

    def result(self, ending: Ending, bound: float | None) -> CollapseResult:
        """What is known now."""
        mechanism = state = None
        model = self.built.model
        if self.fallen is not None:
            model, state = self.fallen.model, self.fallen.last.before
            mechanism = mechanism_of_step(self.fallen.last, model)
        doubtful = self._doubtful()
        if doubtful:
            self.notes.append(
                f"{len(doubtful)} trials from {doubtful[0]:.6g} to {doubtful[-1]:.6g} were not decided "
                f"({self._doubt()}); they count neither as standing nor as falling"
            )
        if bound is not None and self.high is not None and self.high < bound * (1 - 2 * self.tolerance):
            self.notes.append(
                f"it falls below the {bound:.6g} of limit analysis, whose joints open as they slide; real "
                "joints do not, and between the two both rest and motion may be possible"
            )
        for note in self.notes:
            logger.info("%s", note)
        return CollapseResult(
            title=self.title,
            action=self.push.action,
            unit=self.push.unit,
            outcome=ending,
            message=self._sentence(ending, mechanism, bound),
            trials=tuple(self.trials),
            stands=self.low,
            falls=self.high,
            mechanism=mechanism,
            limit=bound,
            notes=tuple(self.notes),
            model=model,
            state=state,
        )

    def _doubt(self) -> str:
        """Message of the last undecided trial, without its end."""
        said = [trial.message for trial in self.trials if trial.verdict == "undecided"][-1]
        return said.split(". ")[0].rstrip(".")

    def _sentence(self, ending: Ending, mechanism: Mechanism | None, bound: float | None) -> str:
        words = []
        if self.trials and ending == "unlimited":
            words.append(f"No fall up to {self.push.told(self.trials[-1].multiplier)}")
        elif ending == "falls at the start":
            words.append(f"Falls at the start, {self.push.told(self.trials[0].multiplier)}")
        elif not self.trials or (self.low is None and self.high is None):
            words.append("Nothing is known of its collapse")
        else:
            ends = [f"stands at {self.push.told(self.low)}"] if self.low is not None else []
            ends += [f"falls at {self.push.told(self.high)}"] if self.high is not None else []
            words.append(", ".join(ends).capitalize())
        if ending in ("undecided", "interrupted"):
            words[0] += f" ({ending})"
        if mechanism is not None:
            words.append(f"At collapse {mechanism.sentence()}")
        if bound is not None:
            words.append(f"Limit analysis: at most {self.push.told(bound)}")
        return ". ".join(words) + "."


def _rested(model: Model, state: SystemState) -> SystemState:
    """Where a march ended, at rest, to go on from with other loads."""
    bodies = tuple(
        group.scale_velocity(own, 0.0) for group, own in zip(model.groups, state.bodies, strict=True)
    )
    return replace(state, index=0, bodies=bodies, velocity=0 * state.velocity, rigid_velocity=None)
