"""Frémond–Cangémi (Raous–Cangémi–Cocu): adhesion that decays, in pair with friction.

    r_adh = β² C u
    b β̇ = −[(w h'(β) − β (c_N u_N² + c_T ‖u_T‖²) + k Δβ)⁻]^(1/p),    β̇ ≤ 0 ≤ β ≤ 1

β follows implicitly from the jump at the end of the step; for b = 0 the branch is independent of the
rate and closed: β = w/Y with h(β) = β, sudden rupture at Y = 2w with h(β) = β², Y = c_N u_N² + c_T‖u_T‖².

    FremondCangemi(normal_stiffness=1e10, tangential_stiffness=1e10, energy=50.0, friction=0.6)

The slides print −k ∇β and the literature −k Δβ. From the free energy ½ β² u·C u − w h(β) + ½ k ‖∇β‖²
the term is +k Δβ: the sign that spreads damage and is well posed. It is the one taken here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.joints.law import Place, spread
from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution, load
from masonry_fem.joints.parameters import Energy, FloatArray, Friction, Stiffness, Viscosity, check_ranges
from masonry_fem.joints.state import JointState

BISECTIONS = 60  # from the width of [0, 1] to rounding


@dataclass(frozen=True, slots=True, eq=False)
class FremondCangemi(Adhesive):
    """Adhesion β that decays with the energy of the springs, with friction (Raous, Cangémi, Cocu).

    Attributes
    ----------
    normal_stiffness : c_N of the springs
    tangential_stiffness : c_T of the springs
    energy : energy of decohesion w
    viscosity : b, which delays damage; with 0 the rate of loading has no influence
    exponent : exponent p of the delayed evolution
    degree : degree of h: 1 for h(β) = β, 2 for β²
    friction_mode : μ all along, or μ (1 − β) that comes with damage
    gradient : k, which spreads damage along a joint over √(k/Y); needs degree and exponent 1

    Examples
    --------
    kind = "fremond_cangemi"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    energy = 20.0
    """

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    energy: Energy
    viscosity: Viscosity = 0.0
    exponent: Annotated[float, Meta(gt=0)] = 1.0
    degree: Literal[1, 2] = 1
    friction: Friction = 0.6
    friction_mode: Literal["constant", "damage"] = "constant"
    gradient: Annotated[float, Meta(ge=0, extra={"unit": "J"})] = 0.0
    # for −Δ among the law's contact points, sparse, an M-matrix, shape (c, c) [1/m²]; needed where k > 0
    laplacian: Any = None

    name: ClassVar[str] = "fremond_cangemi"
    softens: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.gradient > 0 and (self.laplacian is None or self.degree != 1 or self.exponent != 1.0):
            raise LawError(
                f"law '{self.name}': gradient is {self.gradient:g}, expected with a laplacian, degree 1 and "
                "exponent 1; give the Laplacian of the interface's points or leave the gradient out"
            )

    @classmethod
    @override
    def made(cls, told: Mapping[str, Any], drawn: Mapping[str, Any], place: Place) -> Self:
        return cls(**drawn, laplacian=place.laplacian() if told["gradient"] > 0 else None)

    @override
    def factors(self, state: JointState) -> FloatArray:
        return np.repeat(state.adhesion[:, None] ** 2, state.dimension, axis=1)

    @override
    def evolve(self, state: JointState, jump: FloatArray, step: float) -> Evolution:
        Y, w = load(self.springs(state), jump), spread(self.energy, state.count)
        before = state.adhesion
        if self.gradient > 0:
            return self._evolve_together(before, Y, w, step)
        free = self._limit(Y, w)
        after = np.minimum(before, free)  # b = 0
        viscous = (spread(self.viscosity, state.count) > 0) & (free < before)
        if viscous.any():
            after[viscous] = self._delayed(before[viscous], free[viscous], Y[viscous], w[viscous],
                                           spread(self.viscosity, state.count)[viscous], step)  # fmt: skip
        # the surface energy given up, and what the delay burns on top of it
        surface = w * (before**self.degree - after**self.degree)
        excess = np.maximum(after * Y - w * self._slope(after), 0.0) * (before - after)
        threshold = w * self._slope(before)
        demand = np.divide(before * Y, threshold, out=np.zeros_like(Y), where=threshold > 0)
        delayed = np.where(spread(self.viscosity, state.count) > 0, excess, 0.0)
        return Evolution(after, surface + excess, np.sqrt(demand), delayed=delayed)

    def _evolve_together(self, before: FloatArray, Y: FloatArray, w: FloatArray, step: float) -> Evolution:
        """The same with neighbours coupled by k."""
        delay = spread(self.viscosity, len(Y)) / step
        coupling = self.gradient * self.laplacian
        from masonry_fem.joints.spreading import spread_damage  # noqa: PLC0415 - SciPy is slow to import

        after = spread_damage(Y + delay, coupling, w + delay * before, before)
        lost = after * Y * (before - after)
        if not delay.any():
            return Evolution(after, lost, np.sqrt(before * Y / w))
        burned = delay * (before - after) ** 2
        return Evolution(after, lost, np.sqrt(before * Y / w), delayed=burned)

    def _slope(self, adhesion: FloatArray) -> FloatArray:
        """h'(β)."""
        return np.ones_like(adhesion) if self.degree == 1 else 2.0 * adhesion

    def _limit(self, Y: FloatArray, w: FloatArray) -> FloatArray:
        """β without delay, where it may go at once."""
        if self.degree == 2:
            return np.where(2.0 * w < Y, 0.0, 1.0)
        return np.divide(w, Y, out=np.ones_like(Y), where=w < Y)

    def _delayed(
        self, before: FloatArray, free: FloatArray, Y: FloatArray, w: FloatArray, b: FloatArray, step: float
    ) -> FloatArray:
        """Implicit Euler of the viscous evolution, between ``free`` and ``before``."""
        if self.exponent == 1.0:
            if self.degree == 1:
                return (b * before + step * w) / (b + step * Y)
            return b * before / (b + step * (Y - 2.0 * w))
        low, high = free.copy(), before.copy()
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            excess = np.maximum(middle * Y - w * self._slope(middle), 0.0)
            # (b (β_i − β)/h)^p against the driving force: one falls with β, the other rises
            falls = (b * (before - middle) / step) ** self.exponent < excess
            high = np.where(falls, middle, high)
            low = np.where(falls, low, middle)
        return 0.5 * (low + high)
