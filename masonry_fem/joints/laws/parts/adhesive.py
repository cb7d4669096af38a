"""Adhesive: joints whose cohesion is springs side by side with the contact, weakened by damage.

    r_adh = area · factors(state) · C (u − u_p n),    C = diag(c_N, c_T, c_T)

``factors`` is 1 for sound springs, β² for Frémond–Cangémi, β for strength–energy laws; u_p is a
residual opening. In compression the contact itself is rigid: u_N ≥ u_p where faces touched at the start.
Where they were apart, springs are pressed until they touch.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import override

import numpy as np

from masonry_fem.joints.law import Law, rub, spread
from masonry_fem.joints.parameters import FloatArray, Parameter
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState, Mask


@dataclass(frozen=True, slots=True)
class Evolution:
    """What a step does to the springs.

    Attributes
    ----------
    adhesion : β at the end of the step, shape (c,).
    dissipated : Energy lost on the way [J/m²], shape (c,).
    demand : Load over the threshold of further damage, shape (c,).
    opening : Residual opening [m], shape (c,); None: as before.
    delayed : Part of ``dissipated`` that a delay burned [J/m²], shape (c,); None: nothing.
    """

    adhesion: FloatArray
    dissipated: FloatArray
    demand: FloatArray
    opening: FloatArray | None = None
    delayed: FloatArray | None = None


class Adhesive(Law):
    """Common part of the laws with springs in parallel to the contact.

    Parameters
    ----------
    normal_stiffness, tangential_stiffness : c_N and c_T of the sound joint [N/m³].
    friction : Coulomb's coefficient μ.
    """

    __slots__ = ()

    normal_stiffness: Parameter
    tangential_stiffness: Parameter
    friction: Parameter

    @abstractmethod
    def evolve(self, state: JointState, jump: FloatArray, step: float) -> Evolution:
        """From the committed state to a jump at the end of a step of length ``step``."""

    def factors(self, state: JointState) -> FloatArray:
        """What is left of each spring, shape (c, d)."""
        return np.ones_like(state.jump)

    def friction_at(self, state: JointState) -> FloatArray:
        """Coulomb's coefficient of the trial state, shape (c,): μ all along, or as it comes with damage."""
        friction = spread(self.friction, state.count)
        comes = getattr(self, "friction_mode", "constant") == "damage"
        return friction * (1.0 - state.adhesion) if comes else friction

    def is_broken(self, state: JointState) -> Mask:
        """Where nothing is left of the cohesion, shape (c,)."""
        return state.adhesion <= 0.0

    def springs(self, state: JointState) -> FloatArray:
        """C per contact point [N/m³], shape (c, d)."""
        stiffness = np.empty_like(state.jump)
        stiffness[:, 0] = self.normal_stiffness
        stiffness[:, 1:] = spread(self.tangential_stiffness, state.count)[:, None]
        return stiffness

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        stiffness = area[:, None] * self.factors(state) * self.springs(state)
        reduction = Reduction.dry(self.friction_at(state), state.dimension)
        axis = np.arange(state.dimension)
        reduction.stiffness[:, axis, axis] = step * stiffness
        return replace(
            reduction,
            offset=stiffness * _stretch(state, held(state, jump)),
            closure=state.opening,
        )

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        end = held(state, jump) + step * velocity
        evolution = self.evolve(state, end, step)
        after = replace(
            state,
            jump=end,
            adhesion=evolution.adhesion,
            opening=state.opening if evolution.opening is None else evolution.opening,
            demand=evolution.demand,
            dissipated=state.dissipated + area * evolution.dissipated,
            delayed=state.delayed + area * (0.0 if evolution.delayed is None else evolution.delayed),
        )
        after = replace(after, broken=self.is_broken(after))
        return rub(self, state, after, self.friction_at(after), reaction, velocity, area, step)

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return area[:, None] * self.factors(state) * self.springs(state) * _stretch(state, state.jump)

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        energy: FloatArray = 0.5 * (self.adhesive_reaction(state, area) * _stretch(state, state.jump)).sum(
            axis=1
        )
        return energy


def held(state: JointState, jump: FloatArray) -> FloatArray:
    """The jump with penetrations taken as touching: what overlaps is held, not expelled.

    Parameters
    ----------
    state : Of the joints. jump : Displacement jump u, local frame, shape (c, d) [m].
    """
    start = jump.copy()
    start[:, 0] = np.maximum(jump[:, 0], 0.0 - state.apart)
    return start


def load(springs: FloatArray, jump: FloatArray) -> FloatArray:
    """Y = c_N u_N² + c_T ‖u_T‖², where penetration counts as none, shape (c,) [J/m²].

    Parameters
    ----------
    springs : Stiffnesses of each point, shape (c, d) [N/m³].
    jump : Displacement jump u, local frame, shape (c, d) [m].
    """
    normal = springs[:, 0] * np.maximum(jump[:, 0], 0.0) ** 2
    tangential: FloatArray = (springs[:, 1:] * jump[:, 1:] ** 2).sum(axis=1)
    total: FloatArray = normal + tangential
    return total


def _stretch(state: JointState, jump: FloatArray) -> FloatArray:
    stretched = jump.copy()
    stretched[:, 0] -= state.opening
    return stretched
