"""Push: what grows until a structure falls, as the loads of a model at a multiplier.

push = Push.of(scene, model, growth_of, acceleration="x")
push.onward(strategy, since, 0.1, 0.2)      # loads of a trial that goes from 0.1 g to 0.2 g
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from masonry_fem.analyses.limit import Growth
from masonry_fem.errors import MasonryError
from masonry_fem.march.equilibrium import Strategy
from masonry_fem.march.model import Load, Model
from masonry_fem.scene import specs
from masonry_fem.scene.time_function import endless

Share = Callable[[float], float]  # multiplier -> factor of a pattern of forces


@dataclass(frozen=True, slots=True)
class Push:
    """What grows, and what stays.

    Attributes
    ----------
    action : In words. unit : Of the multiplier. first : A multiplier to begin with.
    growth : Which loads of the model stay and which grow.
    model : Whose loads these are.
    axis : Of an acceleration or a tilt; None: the scene's loads grow. tilts : Whether gravity turns.
    dead : Patterns of loads that do not grow. foreign : A tilt leaves other loads than gravity as they are.
    notes : Remarks for the user.
    """

    action: str
    unit: str
    first: float
    growth: Growth
    model: Model
    axis: str | None
    tilts: bool
    dead: tuple[str, ...]
    foreign: bool
    notes: tuple[str, ...]

    @classmethod
    def of(
        cls,
        scene: specs.Scene,
        model: Model,
        choose: Callable[..., Growth],
        *,
        tilt: str | None,
        acceleration: str | None,
        dead: Sequence[str],
    ) -> Push:
        """What a user asks for.

        Raises
        ------
        MasonryError : Two actions at once, nothing that grows, or no gravity to turn.
        """
        if tilt is not None and acceleration is not None:
            raise MasonryError("both a tilt and an acceleration are given, expected one of them")
        axis = acceleration if tilt is None else tilt
        growth = choose(scene, model, dead=dead, tilt=axis)
        if axis is None and not growth.growing:
            raise MasonryError(
                "the scene has no load that may grow: gravity stays; give it loads, or ask for an "
                "acceleration or a tilt along x"
            )
        if tilt is not None and "gravity" not in growth.dead:
            raise MasonryError("a tilt turns gravity, and the scene has none; expected loads.gravity")
        if axis is None:
            action, unit, first = f"loads that grow: {', '.join(growth.growing)}", "times", 1.0
        elif tilt is None:
            action, unit, first = f"acceleration along {axis}, gravity stays", "g", 0.1
        else:
            action, unit, first = f"ground tilted, gravity turns towards {axis}", "tan", 0.1
        return cls(
            action=action,
            unit=unit,
            first=first,
            growth=growth,
            model=model,
            axis=axis,
            tilts=tilt is not None,
            dead=tuple(dead),
            foreign=tilt is not None and growth.dead != ("gravity",),
            notes=("loads and motions with a sine go on while loads grow",) if _goes_on(scene) else (),
        )

    def told(self, multiplier: float) -> str:
        """A multiplier with its unit, as 0.2956 g."""
        if self.tilts:
            return f"{math.degrees(math.atan(multiplier)):.5g} degrees (tan {multiplier:.6g})"
        return f"{multiplier:.6g} {'g' if self.unit == 'g' else 'times the loads'}"

    def at_first(self, strategy: Strategy, multiplier: float) -> tuple[Load, ...]:
        """Loads of the first trial: by their own functions of time, what grows times a multiplier."""
        turned = self._turned(multiplier)
        loads = []
        for load in self.model.loads:
            share = turned if load.name == "gravity" else 1.0
            if load.name not in self.growth.staying:
                share = multiplier
            loads.append(Load(load.name, load.forces, partial(_times, load.factor, share)))
        if self.axis is not None and multiplier:
            ramp = partial(_ramp, 0.0, 0.0 if strategy.inertia else self.growth.end, 0.0)
            loads.append(Load("push", self._live(), partial(_times, ramp, self._ahead(multiplier))))
        return tuple(loads)

    def onward(self, strategy: Strategy, since: float, reached: float, multiplier: float) -> tuple[Load, ...]:
        """Loads of a trial that goes on from a multiplier that was reached at the time ``since``.

        In statics they grow evenly over the load steps; a march in time is struck by the difference.
        """
        span = 0.0 if strategy.inertia else 1.0

        def grown(share: Share) -> Callable[[float], float]:
            return partial(_between, since, span, share(reached), share(multiplier))

        loads = []
        for load in self.model.loads:
            if load.name in self.growth.staying:
                factor = self.growth.staying[load.name]
                turned = load.name == "gravity" and self.tilts
                share = partial(_product, factor, self._turned) if turned else partial(_always, factor)
                loads.append(Load(load.name, load.forces, grown(share)))
        loads.append(Load("push", self._live(), grown(self._ahead)))
        return tuple(loads)

    def _live(self) -> tuple[Any, ...]:
        pairs = zip(self.model.groups, self.growth.live, strict=True)
        return tuple(None if group.prescribed else force for group, force in pairs)

    def _turned(self, multiplier: float) -> float:
        """Cosine of the tilt."""
        return 1 / math.hypot(1.0, multiplier) if self.tilts else 1.0

    def _ahead(self, multiplier: float) -> float:
        """Factor of what grows: the multiplier, or the sine of the tilt."""
        return multiplier / math.hypot(1.0, multiplier) if self.tilts else multiplier


def _goes_on(scene: specs.Scene) -> bool:
    """Whether something swings for ever in a scene that seeks equilibrium in time."""
    if not (scene.analysis.inertia and scene.analysis.seeks_equilibrium):
        return False
    times = [scene.loads.gravity_time]
    times += [support.motion.time for support in scene.supports if support.motion is not None]
    return any(endless(time) for time in times)


def _times(function: Callable[[float], float], share: float, time: float) -> float:
    return share * function(time)


def _ramp(since: float, span: float, low: float, time: float) -> float:
    return _between(since, span, low, 1.0, time)


def _between(since: float, span: float, low: float, high: float, time: float) -> float:
    """From ``low`` to ``high`` over ``span`` after ``since``; ``high`` at once without a span."""
    share = 1.0 if span == 0 else min(max((time - since) / span, 0.0), 1.0)
    return low + share * (high - low)


def _product(factor: float, share: Share, multiplier: float) -> float:
    return factor * share(multiplier)


def _always(value: float, multiplier: float) -> float:
    return value
