"""Steering: the load factor that takes a displacement to where a step is to end.

rounds = SteeredRounds(model, coupling, state, scheme, settings, share, clock, begun(coupling, state.bodies))
made = rounds.solved(rounds.start, None)           # a round whose load factor is an unknown
made.loading.end

A structure that softens bears no more than its peak, and one that snaps back has states beyond it that
neither a growing load nor a growing displacement of the load leads to. What goes on growing there is the
opening of the crack. Each round is linear in displacements and load factor but for contacts that open or
slide: two load factors tell the one that gives the opening, as the two right-hand sides of a bordered system
do, and where contacts change a few more.

References
----------
de Borst, Computation of post-bifurcation and post-failure behavior of strain-softening solids, Computers &
Structures 25 (1987): control by a displacement that grows.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, override

import numpy as np

from masonry_fem.march.model import Control, Model, Probe
from masonry_fem.march.place import Place
from masonry_fem.march.rounds import Round, Rounds

MISSED = 1e-8  # of a step's part of the distance
ROUNDING = 1e-12  # of the distance: a way that no load has made
MOST = 12  # load factors that a round tries


class SteeredRounds(Rounds):
    """Rounds that end where ``model.control`` has gone the share ``until`` of its distance."""

    __slots__ = ()

    @override
    def _solved(self, place: Place, last: Round | None, ends: tuple[Any, ...]) -> Round:
        """The round with the load factor that takes the control there."""
        state, scheme = self.state, self.scheme
        factor, slope = state.time, 0.0
        if last is not None:
            factor, slope = last.loading.end, last.slope
        asked = MISSED * scheme.step * self._control.distance
        made = self._under(self.loaded(factor), place, last, ends)
        missed = self._missed(made)
        for _ in range(MOST):
            if abs(missed) <= asked or not made.solution.solved:
                break
            change = -missed / slope if slope else scheme.step
            following = self._under(self.loaded(factor + change), place, last, ends)
            gone = self._missed(following)
            moved = abs(gone - missed) > ROUNDING * self._control.distance
            slope, missed = (gone - missed) / change if moved else 0.0, gone
            made, factor = following, factor + change
            if not moved:
                break
        return replace(made, slope=slope, missed=abs(missed) / asked)

    @override
    def worst(self, made: Round) -> int:
        """The same, or the block of the control where that alone is not where it is to be."""
        if made.residuals and made.residuals[-1] > self.balanced:
            return super().worst(made)
        probe = self._control.probe
        return int(self.model.groups[probe.group].blocks[probe.body])

    @property
    def _control(self) -> Control:
        assert self.model.control is not None  # these rounds are made for it
        return self.model.control

    def _missed(self, made: Round) -> float:
        """How much further than the step's end the control has gone [m]."""
        return gone(self.model, self._control, made.bodies) - self.until * self._control.distance


def gone(model: Model, control: Control, bodies: tuple[Any, ...]) -> float:
    """How far a control has gone [m].

    Parameters
    ----------
    model : Its structure. control : The displacement. bodies : States, one a group.
    """

    def moved(probe: Probe) -> np.ndarray:
        return model.groups[probe.group].displacement(bodies[probe.group], probe.body, probe.point)

    way = moved(control.probe)
    if control.against is not None:
        way = way - moved(control.against)
    return float(way @ control.direction)
