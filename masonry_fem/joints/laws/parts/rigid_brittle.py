"""RigidBrittle: joints that neither open nor slide until a threshold breaks them.

While intact the cohesive reaction is a constant normal force, r_adh,N = apex · area: Coulomb's cone
moved along its axis, so that r̃ obeys the dry graphs. Rupture is an event, found by
``update`` from the reaction and the movement of the trial step and final in it: the step is then
solved again with the cohesion gone.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.law import ON_CONE, Law, rub, spread
from masonry_fem.joints.parameters import FloatArray, Parameter
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.nscd.graphs import lengths

# over this much of the tensile strength a joint is broken: above any solver's tolerance
OVERLOAD = 1e-9


class RigidBrittle(Law):
    """Common part of constant thresholds and of Mohr–Coulomb's.

    Attributes
    ----------
    critical_slip : slide at the strength that breaks the joint; 0: it breaks at once
    critical_opening : opening that breaks the joint; more than 0 where it yields before
    """

    __slots__ = ()
    softens: ClassVar[bool] = True

    critical_slip: Parameter
    critical_opening: Parameter

    @abstractmethod
    def apex(self, count: int) -> FloatArray:
        """Tensile stress at the tip of the intact cone [Pa], shape (c,)."""

    @abstractmethod
    def tension(self, count: int) -> FloatArray:
        """Tensile strength, at most the apex [Pa], shape (c,)."""

    @abstractmethod
    def frictions(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Coulomb's coefficients of the intact and of the broken joint, shape (c,)."""

    def _friction(self, state: JointState) -> FloatArray:
        intact, broken = self.frictions(state.count)
        return np.where(state.broken, broken, intact)

    def _threshold(self, state: JointState) -> FloatArray:
        return np.where(state.broken, 0.0, self.apex(state.count))

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        reduction = Reduction.dry(self._friction(state), state.dimension)
        offset = reduction.offset
        offset[:, 0] = area * self._threshold(state)
        return replace(reduction, offset=offset)

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        c = state.count
        apex, tension, friction = self.apex(c), self.tension(c), self.frictions(c)[0]
        stress = reaction / area[:, None]
        end = jump + step * velocity
        shear, strength = lengths(stress[:, 1:]), friction * (stress[:, 0] + apex)
        pulled = np.maximum(-stress[:, 0], 0.0)
        at_tip = (apex > 0) & (pulled >= apex * (1 - ON_CONE))
        yields = at_tip | (shear > 0) & (shear >= strength * (1 - ON_CONE))
        slip = state.slip + np.where(yields, step * lengths(velocity[:, 1:]), 0.0)
        torn = (pulled > tension * (1 + OVERLOAD)) & (tension < apex)
        opened = at_tip & (end[:, 0] > spread(self.critical_opening, c))
        slid = yields & (slip > spread(self.critical_slip, c))
        broken = trial.broken | torn | opened | slid
        sheared = np.divide(shear, strength, out=np.zeros(c), where=strength > 0)
        demand = np.maximum(sheared, np.divide(pulled, tension, out=np.zeros(c), where=tension > 0))
        lost = np.where(broken & ~state.broken, np.maximum(self.stored(state, area), 0.0), 0.0)
        after = replace(
            state,
            jump=end,
            broken=broken,
            adhesion=np.where(broken, 0.0, 1.0),
            demand=np.where(state.broken, 0.0, demand),
            dissipated=state.dissipated + lost,
        )
        return rub(self, state, after, self._friction(after), reaction, velocity, area, step)

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        force = np.zeros_like(state.jump)
        force[:, 0] = area * self._threshold(state)
        return force

    @override
    def spring_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return np.zeros_like(state.jump)

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        # an opening is below 0 where the solver's tolerance lets it be, and so is its energy
        return area * self._threshold(state) * state.jump[:, 0]
