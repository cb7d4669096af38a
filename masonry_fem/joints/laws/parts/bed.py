"""Bed: a layer of elastic mortar in series with any joint law.

    u = u_c + u_e,    u_e = −r/(k · area)

The law acts on what the layer leaves, u_c. Pressure closes the gap by r_N/k_N, shear is elastic
before it slides. The contact solver sees a compliance 1/(h² k · area) on the diagonal of W and a
closure u_e,N of the gap: cone and graphs stay exact, nothing is penalised. A bed in pair with a rigid
law that breaks is the usual joint of limit k_N, k_T, tension, cohesion, friction.

With a ``crushing`` strength the layer yields under pressure and keeps what it was crushed; the
pressure may still rise by ``hardening`` per length of crushing. Shear τ helps to crush where it has a
weight C: the pressure σ yields at σ² + C τ² = f_c² (the cap of Lourenço and Rots, 1997).

    Bed.of_mortar(MohrCoulomb(cohesion=0.35e6, friction=0.75), thickness=0.01, young=1.2e9)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.law import Law, Layer, spread
from masonry_fem.joints.parameters import Factor, FloatArray, Parameter, Stiffness, Strength
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.nscd.graphs import lengths

ROUNDING = 1e-12  # of a strength
STEEPEST = 1e3  # shear over pressure that counts for the cap: no layer is crushed by a pressure of rounding
SAME = 1e-6  # of the pressure: a change of it that tells nothing
LEAST_SHARE = 1e-6  # of the largest tributary area: what a point without an area bears


@dataclass(frozen=True, slots=True, eq=False)
class Bed(Layer):
    """An elastic layer in series.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness : k_N, k_T of the layer [N/m³].
    crushing : Compressive strength f_c of the mortar [Pa]; None: none.
    hardening : Slope of the pressure over the crushing [N/m³], > 0; None: a thousandth of k_N.
    shear_weight : C of the shear stress in the cap.
    """

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    crushing: Strength | None = None
    hardening: Stiffness | None = None
    shear_weight: Factor = 0.0

    name: ClassVar[str] = "bed"

    @classmethod
    def of_mortar(
        cls,
        law: Law,
        thickness: float,
        young: float,
        poisson: float = 0.2,
        crushing: Parameter | None = None,
        hardening: Parameter | None = None,
        shear_weight: Parameter = 0.0,
    ) -> Bed:
        """The bed of a mortar layer: E'/t across, G/t along; its stretch in the plane is hindered.

        Parameters
        ----------
        thickness : t [m]. young : E [Pa]. poisson : ν. crushing : f_c [Pa]. hardening : [N/m³].
        shear_weight : C.
        """
        confined = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
        shear = young / (2.0 * (1.0 + poisson))
        return cls(law, confined / thickness, shear / thickness, crushing, hardening, shear_weight)

    def _stiffness(self, state: JointState, area: FloatArray) -> FloatArray:
        """K · area [N/m], shape (c, d)."""
        stiffness = np.empty_like(state.jump)
        stiffness[:, 0] = area * self.normal_stiffness
        stiffness[:, 1:] = (area * spread(self.tangential_stiffness, state.count))[:, None]
        return stiffness

    def _cap(self, state: JointState) -> tuple[FloatArray, FloatArray]:
        """The cap as a line about the state's pressure and shear: crushed = start − slope · pressure.

        ``start`` [m], ``slope`` [m/Pa], shape (c,).
        """
        ratio, aside = state.obliquity, self._aside(state.obliquity)
        slope = (1.0 + self.shear_weight * ratio * state.following) / aside
        start = self._strength() + state.pressed * (slope - aside)
        hardening = self._hardening()
        return start / hardening, slope / hardening

    def _aside(self, ratio: FloatArray) -> FloatArray:
        """√(σ² + C τ²)/σ of a shear over pressure, shape (c,)."""
        aside: FloatArray = np.sqrt(1.0 + self.shear_weight * ratio**2)
        return aside

    def _strength(self) -> Parameter:
        """f_c [Pa], infinite where nothing crushes."""
        return np.inf if self.crushing is None else self.crushing

    def _hardening(self) -> FloatArray:
        """Slope of the pressure over the crushing [N/m³]."""
        slope = 1e-3 * np.asarray(self.normal_stiffness) if self.hardening is None else self.hardening
        return np.asarray(slope, dtype=float)

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        area = bearing(area)
        # the trial state has moved on: ``bedded`` is the deformation at the start of the step
        inner = self.law.reduce(state, jump - state.bedded, area, step)
        compliance = 1.0 / (step**2 * self._stiffness(state, area))
        kept = np.zeros_like(state.bedded)  # deformation at the end without reaction
        kept[:, 0] = state.crushed
        flows = state.crushing
        if flows.any():
            start, slope = self._cap(state)
            compliance[flows, 0] += slope[flows] / (step**2 * area[flows])
            kept[flows, 0] = start[flows]
        return replace(
            inner,
            compliance=inner.compliance + compliance,
            shift=inner.shift + (state.bedded - kept) / step,
            closure=inner.closure + state.bedded[:, 0],
        )

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        area = bearing(area)
        elastic = -reaction / self._stiffness(state, area)
        pressure = reaction[:, 0] / area
        obliquity = self._obliquity(reaction)
        following = self._following(state, trial, obliquity, pressure)
        here = replace(trial, obliquity=obliquity, pressed=pressure, following=following)
        # where it crushes already, the line that the contact was solved with
        start, slope = (
            np.where(trial.crushing, old, new)
            for old, new in zip(self._cap(trial), self._cap(here), strict=True)
        )
        flown = start - slope * pressure
        # at the limit to rounding it does not begin, or the turns would alternate
        crushing = flown < state.crushed - np.where(trial.crushing, 0.0, ROUNDING * slope * np.abs(pressure))
        crushed = np.where(crushing, flown, state.crushed)
        moved = elastic - state.elastic
        # as the contact was solved: what crushes from the next turn on is no opening that breaks the faces
        moved[:, 0] += np.where(trial.crushing, flown, state.crushed) - state.crushed
        own = velocity - moved / step
        after = self.law.update(state, trial, jump - state.bed, reaction, own, area, step)
        # mean over the step, on a path of one ratio of shear to pressure
        rise = 0.5 * self._hardening() * (crushed - state.crushed) / self._aside(obliquity)
        yielding = pressure + rise
        ground = area * np.where(crushing, yielding * (state.crushed - crushed), 0.0)
        after = replace(
            after, elastic=elastic, crushed=crushed, crushing=crushing, bedded=state.bed,
            obliquity=np.where(crushing, obliquity, 0.0),
            pressed=np.where(crushing, pressure, 0.0),
            following=np.where(crushing, following, 0.0),
            dissipated=after.dissipated + ground,
        )  # fmt: skip
        # what a sudden rupture sets free: the work put in less what is stored or lost elsewhere
        given = -0.5 * (reaction - self._stiffness(state, area) * state.elastic) * velocity
        spent = self.stored(after, area) - self.stored(state, area)
        spent += after.dissipated - state.dissipated + after.rubbed - state.rubbed
        freed = np.maximum(step * given.sum(axis=1) - spent, 0.0)
        damaged = after.adhesion < state.adhesion
        return replace(after, dissipated=after.dissipated + np.where(damaged, freed, 0.0))

    def _obliquity(self, reaction: FloatArray) -> FloatArray:
        """τ/σ where shear helps to crush, shape (c,)."""
        shear = lengths(reaction[:, 1:]) * (np.asarray(self.shear_weight) > 0)
        ratio = np.divide(shear, reaction[:, 0], out=np.zeros(len(shear)), where=reaction[:, 0] > 0)
        return np.minimum(ratio, STEEPEST)

    def _following(
        self, state: JointState, trial: JointState, ratio: FloatArray, pressure: FloatArray
    ) -> FloatArray:
        """dτ/dσ from the last turn to this one, between 0 and τ/σ, shape (c,).

        Shear that sticks stays where pressure changes, shear that slides goes along; in between are springs.
        Lines of a wrong slope would be crossed to and fro, hence the mean of the last turns. None lets the
        pressure fall below half by the next turn: where shear alone is more than the cap, it has to slide,
        and the faces do not part.
        """
        rise, shear = pressure - trial.pressed, ratio * pressure - trial.obliquity * trial.pressed
        told = trial.crushing & (np.abs(rise) > SAME * np.abs(pressure)) & (shear * rise >= 0)
        slope = np.where(trial.crushing, trial.following, ratio)
        seen = np.divide(shear, rise, out=slope.copy(), where=told)
        slope = 0.5 * (slope + np.clip(seen, 0.0, ratio))

        aside, steepness = self._aside(ratio), self.shear_weight * ratio
        limit = self._strength() - self._hardening() * state.crushed
        beyond = aside - np.divide(limit, pressure, out=np.full_like(aside, np.inf), where=pressure > 0)
        least = np.divide(
            2.0 * aside * beyond - 1.0, steepness, out=np.zeros_like(ratio), where=steepness > 0
        )
        return np.clip(slope, np.clip(least, 0.0, ratio), ratio)

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.adhesive_reaction(state, bearing(area))

    @override
    def spring_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return self.law.spring_reaction(state, bearing(area))

    @override
    def work_at_start(self, before: JointState, after: JointState, area: FloatArray) -> FloatArray:
        borne = -self._stiffness(before, bearing(area)) * before.elastic
        work: FloatArray = (borne * (after.bed - before.bed)).sum(axis=1)
        return work

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        area = bearing(area)
        stretched = (self._stiffness(state, area) * state.elastic**2).sum(axis=1)
        energy: FloatArray = self.law.stored(state, area) + 0.5 * stretched
        return energy


def bearing(area: FloatArray) -> FloatArray:
    """Areas that are all positive.

    Nothing of a face belongs to the corner nodes of quadratic triangles: they lie on no mortar and bear
    next to nothing, but have to give way.
    """
    least: FloatArray = np.maximum(area, LEAST_SHARE * area.max(initial=0.0))
    return least
