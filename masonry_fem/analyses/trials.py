"""Trials: a structure under one multiplier after another, each from the last state that stood.

trials = Trials(scene, built, push, at_once=False, tell=None, notes=[])
trials.attempt(0.1)                  # "stands"
trials.made, trials.fallen
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from masonry_fem.analyses.bracket import Verdict
from masonry_fem.analyses.pushing import Push
from masonry_fem.build import Built
from masonry_fem.march.clock import Clock
from masonry_fem.march.equilibrium import Strategy
from masonry_fem.march.equilibrium.equilibrium import Equilibrium
from masonry_fem.march.equilibrium.parts.onward import Onward
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.march.march import March, march
from masonry_fem.march.model import Model
from masonry_fem.march.motion import greatest_shift
from masonry_fem.march.recognition import OPEN
from masonry_fem.march.state import SystemState
from masonry_fem.results.search import Trial
from masonry_fem.scene import specs

VERDICTS: dict[str, Verdict] = {"equilibrium": "stands", "no_equilibrium": "falls"}
# where statics of rigid blocks does not decide, steps in time from rest may
STRIKE = Equilibrium(strategy="brutal_damping", step=0.01, max_steps=3)


class Trials:
    """Trials one after another, and the states that they go on from.

    Parameters
    ----------
    scene : What is pushed. built : The model made of it.
    push : Which loads a multiplier stands for.
    at_once : Put the whole load on the state at the start in each trial, not on the last that stood.
    tell : Is told of each trial, with the greatest multiplier that stood and the least that fell.
    notes : List that doubts are appended to.
    """

    def __init__(
        self,
        scene: specs.Scene,
        built: Built,
        push: Push,
        *,
        at_once: bool,
        tell: Callable[[Trial, float | None, float | None], None] | None,
        notes: list[str],
    ) -> None:
        self.built, self.push, self.at_once, self.tell, self.notes = built, push, at_once, tell, notes
        # an error of 1e-6 is more than what lies between standing and falling near the limit
        self.settings = replace(scene.solver.settings, acceptable=0.0)
        self.strategy: Strategy = scene.analysis.loading
        if not self.strategy.seeks_equilibrium:
            self.strategy = Statics()
            notes.append("dynamics does not end by standing or falling: statics was taken for the trials")
        self.made: list[Trial] = []
        self.struck = 0  # trials that a step in time decided
        self.reached: float | None = None
        self.standing: tuple[March, float] | None = None
        self.first: tuple[March, float] | None = None
        self.fallen: tuple[March, float] | None = None

    def attempt(self, multiplier: float) -> Verdict:
        """Try a multiplier."""
        clock = Clock()
        ended = self._march(multiplier)
        clock.lap("trial")
        verdict: Verdict = VERDICTS.get(ended.outcome, "undecided")
        if verdict == "stands" and (self.reached is None or multiplier > self.reached):
            self.reached = multiplier
            if self._rests(ended):
                self.standing = (ended, multiplier)
                self.first = self.first or self.standing
        if verdict == "falls" and (self.fallen is None or multiplier < self.fallen[1]):
            self.fallen = (ended, multiplier)
        trial = Trial(
            multiplier=multiplier,
            verdict=verdict,
            outcome=ended.outcome,
            message=ended.message,
            steps=ended.state.index,
            seconds=clock.phases["trial"],
        )
        self.made.append(trial)
        if self.tell is not None:
            self.tell(trial, self.reached, None if self.fallen is None else self.fallen[1])
        return verdict

    def _rests(self, ended: March) -> bool:
        """Whether a trial that stands is a state to go on from.

        At the very limit statics may end anywhere along the mechanism: rigid blocks whose dry joints carry
        more loads do not move.
        """
        if self.standing is None or not ended.model.laws.all_plain:
            return True
        model, origin = ended.model, self.standing[0].state.bodies
        return greatest_shift(model, origin, ended.state.bodies) <= OPEN * model.length

    def _march(self, multiplier: float) -> March:
        origin = self.first if self.at_once else self.standing
        if origin is None:
            model = replace(self.built.model, loads=self.push.at_first(self.strategy, multiplier))
            return march(model, self.strategy, self.settings, bodies=self.built.bodies)
        ended = self._onward(self.strategy, *origin, multiplier)
        rigid = not any(group.deforms for group in ended.model.groups)
        if ended.outcome != "no_convergence" or self.strategy.inertia or not rigid:
            return ended
        again = self._onward(STRIKE, *origin, multiplier)
        if again.outcome not in VERDICTS:
            return ended
        self.struck += 1
        return again

    def _onward(self, plan: Strategy, made: March, reached: float, multiplier: float) -> March:
        """Go on from where a march ended, from one multiplier to another."""
        since = made.state.time
        model = replace(made.model, loads=self.push.onward(plan, since, reached, multiplier))
        return march(
            model, Onward(strategy=plan, since=since), self.settings, start=_rested(model, made.state)
        )


def _rested(model: Model, state: SystemState) -> SystemState:
    """Where a march ended, at rest, to go on from with other loads."""
    bodies = tuple(
        group.scale_velocity(own, 0.0) for group, own in zip(model.groups, state.bodies, strict=True)
    )
    return replace(state, index=0, bodies=bodies, velocity=0 * state.velocity, rigid_velocity=None)
