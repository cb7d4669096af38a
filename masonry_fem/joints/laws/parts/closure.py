"""Closure: a dry joint whose asperities give way under pressure, in series with any joint law.

    w = σ w_max/(k_0 w_max + σ),    k(σ) = dσ/dw = k_0 (1 + σ/(k_0 w_max))²

The closing w follows this hyperbola under pressures σ that the joint has never borne (Goodman; Bandis et al.
1983). Below the greatest pressure so far, P, it goes along the hyperbola's tangent at P, with the stiffness
k(P): unloaded, the joint stays closed by w_max P²/(k_0 w_max + P)². Shear is elastic, too, with the share
``shear_ratio`` of k(P), until it slides; as P grows, what the shear has moved stays.

The tangent at P *is* the line of unloading from P: the contact solver sees one line, of the greatest pressure
including that of the turn before, and the turns are Newton's method on the hyperbola.

    Closure(Dry(0.6), normal_stiffness=18e9, greatest=0.1e-3)
    fit_closure([0.5e6, 0.875e6, 1.25e6], [3.3e9, 4.1e9, 4.7e9], 20.2e9, 0.15)     # k_0, w_max

References
----------
Bandis, Lumsden, Barton, Fundamentals of rock joint deformation, Int. J. Rock Mech. Min. Sci. 20 (1983).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta
from numpy.typing import ArrayLike

from masonry_fem.errors import LawError
from masonry_fem.joints.law import Layer, spread
from masonry_fem.joints.laws.parts.bed import bearing
from masonry_fem.joints.parameters import FloatArray, Length, Parameter, Stiffness
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class Closure(Layer):
    """Asperities that close.

    Attributes
    ----------
    normal_stiffness : k_0 of the joint that no pressure has closed [N/m³].
    greatest : w_max, the closing that no pressure reaches [m].
    shear_ratio : Stiffness in shear over that under pressure.
    """

    normal_stiffness: Stiffness
    greatest: Length
    shear_ratio: Annotated[Parameter, Meta(gt=0)] = 0.4

    name: ClassVar[str] = "closure"

    def _stiffness(self, state: JointState, area: FloatArray) -> FloatArray:
        """K · area of the line at the greatest pressure [N/m], shape (c, d)."""
        yielded = 1.0 + state.compacted / (self.normal_stiffness * np.asarray(self.greatest))
        stiffness = np.empty_like(state.closing)
        stiffness[:, 0] = area * self.normal_stiffness * yielded**2
        stiffness[:, 1:] = (spread(self.shear_ratio, state.count) * stiffness[:, 0])[:, None]
        return stiffness

    def _set(self, pressure: FloatArray) -> FloatArray:
        """What a greatest pressure leaves of the closing when it is gone, ≥ 0, shape (c,) [m]."""
        reached = pressure / (self.normal_stiffness * np.asarray(self.greatest) + pressure)
        left: FloatArray = self.greatest * reached**2
        return left

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        area = bearing(area)
        inner = self.law.reduce(state, jump - state.closed, area, step)
        return replace(
            inner,
            compliance=inner.compliance + 1.0 / (step**2 * self._stiffness(state, area)),
            shift=inner.shift + (state.closed - state.settled) / step,
            closure=inner.closure + state.closed[:, 0],
        )

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        area = bearing(area)
        before = self._stiffness(state, area) * (state.settled - state.closing)  # reaction at the start
        # as the contact was solved, which may not yet be on the hyperbola
        moved = trial.settled - reaction / self._stiffness(trial, area) - state.closing
        after = self.law.update(
            state, trial, jump - state.closing, reaction, velocity - moved / step, area, step
        )
        here = replace(after, compacted=np.maximum(state.compacted, reaction[:, 0] / area))
        stiffness = self._stiffness(here, area)
        settled = state.closing + before / stiffness
        # what it is set by already stays, also where its law has become another
        settled[:, 0] = state.settled[:, 0] + self._set(state.compacted) - self._set(here.compacted)
        closing = settled - reaction / stiffness
        # the mean of what it bears at the two ends of the step, as the energy ledger takes it
        work = -(0.5 * (before + reaction) * (closing - state.closing)).sum(axis=1)
        here = replace(here, settled=settled, closing=closing, closed=state.closing)
        lost = work - self._springs(here, area) + self._springs(state, area)
        return replace(here, dissipated=after.dissipated + np.maximum(lost, 0.0))

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.adhesive_reaction(state, bearing(area))

    @override
    def spring_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.spring_reaction(state, bearing(area))

    @override
    def work_at_start(self, before: JointState, after: JointState, area: FloatArray) -> FloatArray:
        borne = self._stiffness(before, bearing(area)) * (before.settled - before.closing)
        work: FloatArray = (borne * (after.closing - before.closing)).sum(axis=1)
        return work

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        area = bearing(area)
        energy: FloatArray = self.law.stored(state, area) + self._springs(state, area)
        return energy

    def _springs(self, state: JointState, area: FloatArray) -> FloatArray:
        """What the asperities give back when unloaded, shape (c,) [J]."""
        energy: FloatArray = 0.5 * (self._stiffness(state, area) * (state.closing - state.settled) ** 2).sum(
            axis=1
        )
        return energy


def fit_closure(pressures: ArrayLike, moduli: ArrayLike, stone: float, spacing: float) -> tuple[float, float]:
    """What ``[joints.closure]`` needs so that a wall has measured tangent moduli.

    Stones and joints are in series, 1/E = 1/E_stone + 1/(k spacing), with k = k_0 (1 + σ/(k_0 w_max))², so
    that √k is linear in σ: a straight line of least squares through the measured ones.

    Parameters
    ----------
    pressures : At which the wall was measured, two at least, shape (n,) [Pa].
    moduli : Tangent modulus E of the wall at each pressure, shape (n,) [Pa].
    stone : E of the stone alone [Pa].
    spacing : Distance between joints [m].

    Returns
    -------
    k_0 [N/m³] and w_max [m].

    Raises
    ------
    LawError
        Fewer than two pressures, a wall as stiff as its stone, or one that does not stiffen as it is pressed.

    References
    ----------
    Bandis, Lumsden, Barton, Fundamentals of rock joint deformation, Int. J. Rock Mech. Min. Sci. 20 (1983).
    """
    at, measured = np.asarray(pressures, dtype=float), np.asarray(moduli, dtype=float)
    if at.ndim != 1 or at.shape != measured.shape or len(np.unique(at)) < 2:
        raise LawError(
            f"closure: {at.size} pressures and {measured.size} moduli, expected one modulus for each of two "
            "or more different pressures; measure at another one, or set [joints.closure] yourself"
        )
    if not ((measured > 0) & (measured < stone)).all():
        raise LawError(
            f"closure: a wall's modulus is {measured.max():g} Pa, expected more than 0 and less than the "
            f"{stone:g} Pa of its stone, as joints only add to what gives way; check the units of both"
        )
    stiffness = 1.0 / (spacing * (1.0 / measured - 1.0 / stone))
    slope, root = np.polyfit(at, np.sqrt(stiffness), 1)
    if slope <= 0 or root <= 0:
        raise LawError(
            f"closure: √k of the joints is {root:.4g} + {slope:.4g} σ, expected both > 0, as of joints "
            "that are soft at first and stiffen when pressed; take [joints.mortar], which does not stiffen"
        )
    return float(root**2), float(1.0 / (slope * root))
