"""Softening: cohesion with a stiffness, a strength and a fracture energy of its own in each mode.

    r_adh = β C u,    β = shape(λ, γ)

λ is the load over the threshold and γ how ductile the joint is, both from measured numbers:

    λ² = (c_N u_N/s_N)² + (c_T‖u_T‖/s_T)²,    Y = c_N u_N² + c_T‖u_T‖² = λ² Y_c
    γ = 2 G/Y_c,    (1/G)^a = ((1 − m)/G_N)^a + (m/G_T)^a,    m = c_T‖u_T‖²/Y

so that strength is elliptic and a proportional opening of any mode dissipates exactly G. A shape is
one law (``Bilinear``, ``Trapezoidal``, ``Exponential``, ``MonerieAcary``): all that differs.

With ``residual`` η > 0 a part η of the inelastic opening stays: unloading in tension goes to
u_p = η (1 − β) u_N instead of the origin, and the faces touch at u_p.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.joints.law import Place, spread
from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution
from masonry_fem.joints.parameters import Energy, FloatArray, Friction, Stiffness, Strength, check_ranges
from masonry_fem.joints.state import JointState
from masonry_fem.records.remark import remark

# of the least energy that a strength and a stiffness allow: where a draw leaves less
LEAST_DUCTILITY = 1.05


@dataclass(frozen=True, slots=True, eq=False)
class Softening(Adhesive):
    """Common part of the strength–energy laws.

    Attributes
    ----------
    normal_stiffness : c_N of the springs
    tangential_stiffness : c_T of the springs
    normal_strength : tensile strength s_N
    tangential_strength : shear strength s_T without pressure, as the cohesion c of Mohr-Coulomb
    normal_energy : fracture energy G_N in tension, more than what the springs store at the strength
    tangential_energy : the same in shear, G_T
    friction_mode : μ all along, or μ (1 − β) that comes with damage
    mixing : exponent a of (1/G)^a = ((1 − m)/G_N)^a + (m/G_T)^a, m the share of shear
    residual : share η of the inelastic opening that stays when the joint closes
    """

    softens: ClassVar[bool] = True

    normal_stiffness: Stiffness
    tangential_stiffness: Stiffness
    normal_strength: Strength
    tangential_strength: Strength
    normal_energy: Energy
    tangential_energy: Energy
    friction: Friction = 0.6
    friction_mode: Literal["constant", "damage"] = "constant"
    mixing: Annotated[float, Meta(ge=1)] = 1.0
    residual: Annotated[float, Meta(ge=0, lt=1)] = 0.0

    def __post_init__(self) -> None:
        check_ranges(self)
        for mode in ("normal", "tangential"):
            self._check_energy(mode)

    def _check_energy(self, mode: str) -> None:
        strength = np.asarray(getattr(self, f"{mode}_strength"), dtype=float)
        elastic = strength**2 / (2.0 * np.asarray(getattr(self, f"{mode}_stiffness")))
        energy = np.asarray(getattr(self, f"{mode}_energy"), dtype=float)
        short = np.broadcast_to(energy <= elastic, np.broadcast(energy, elastic).shape)
        if short.any():
            least = float(np.broadcast_to(elastic, short.shape)[short].flat[0])
            raise LawError(
                f"law '{self.name}': {mode}_energy is {np.min(energy):g} J/m², expected more than "
                f"the elastic s²/2c = {least:g} J/m²; "
                "raise the energy or the stiffness, or take 'elastic_brittle'"
            )

    @classmethod
    @override
    def made(cls, told: Mapping[str, Any], drawn: Mapping[str, Any], place: Place) -> Self:
        """Energies raised where a draw left less than springs of that strength store: s²/2c.

        Such a joint would snap back; what the scene itself gets wrong is left to be refused.
        """
        kept = dict(drawn)
        for mode in ("normal", "tangential"):
            names = [f"{mode}_{part}" for part in ("strength", "stiffness", "energy")]
            strength, stiffness, energy = (np.asarray(drawn[name], dtype=float) for name in names)
            floor = LEAST_DUCTILITY * strength**2 / (2.0 * stiffness)
            least = LEAST_DUCTILITY * told[names[0]] ** 2 / (2.0 * told[names[1]])
            short = np.atleast_1d(energy < floor)
            if told[names[2]] > least and short.any():
                remark(
                    "springs",
                    f"{place.key}.scatter: {int(short.sum())} of {len(short)} contact points drew a "
                    f"{names[2]} below what their springs store at the strength, s²/2c; it is raised to "
                    f"{LEAST_DUCTILITY:g} of that",
                )
                kept[names[2]] = np.maximum(energy, floor)
        return cls(**kept)

    @abstractmethod
    def shape(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        """β of a monotonic opening at λ ≥ 1, shape (c,)."""

    @abstractmethod
    def reached(self, adhesion: FloatArray, ductility: FloatArray) -> FloatArray:
        """λ at which a monotonic opening has come down to β, shape (c,)."""

    @abstractmethod
    def area(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        """Work up to λ ≥ 1 over Y_c; γ/2 at the end, shape (c,)."""

    @override
    def factors(self, state: JointState) -> FloatArray:
        remaining = np.repeat(state.adhesion[:, None], state.dimension, axis=1)
        # unloading in tension goes to the residual opening, along a steeper line
        remaining[:, 0] /= 1.0 - spread(self.residual, state.count) * (1.0 - state.adhesion)
        return remaining

    @override
    def evolve(self, state: JointState, jump: FloatArray, step: float) -> Evolution:
        c, before = state.count, state.adhesion
        opened = np.maximum(jump[:, 0], 0.0)
        stiffness = [spread(self.normal_stiffness, c), spread(self.tangential_stiffness, c)]
        normal = stiffness[0] * opened**2
        tangential = stiffness[1] * (jump[:, 1:] ** 2).sum(axis=1)
        total = normal + tangential
        share = np.divide(tangential, total, out=np.zeros(c), where=total > 0)  # m
        critical, ductility = self._mixed(share, stiffness)
        stretch = np.sqrt(total / critical)
        after = np.minimum(
            before, np.where(stretch > 1.0, self.shape(np.maximum(stretch, 1.0), ductility), 1.0)
        )
        residual = np.maximum(state.opening, spread(self.residual, c) * (1.0 - after) * opened)
        opening = np.where(after < before, residual, state.opening)
        loss = critical * (self._loss(after, share, ductility) - self._loss(before, share, ductility))
        rough = spread(self.residual, c) > 0
        if rough.any():
            loss = np.where(rough, self._loss_by_parts(state, jump, after, opening, stiffness), loss)
        reached = self.reached(np.maximum(before, np.finfo(float).tiny), ductility)
        return Evolution(
            adhesion=after,
            dissipated=np.where(after < before, np.maximum(loss, 0.0), 0.0),
            demand=np.where(before > 0, stretch / np.maximum(reached, 1.0), 0.0),
            opening=opening,
        )

    def _mixed(self, share: FloatArray, stiffness: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Y_c and γ of a mode."""
        c = len(share)
        normal = spread(self.normal_strength, c) ** 2 / stiffness[0]
        tangential = spread(self.tangential_strength, c) ** 2 / stiffness[1]
        critical = 1.0 / ((1.0 - share) / normal + share / tangential)
        parts = ((1.0 - share) / spread(self.normal_energy, c)) ** self.mixing
        parts += (share / spread(self.tangential_energy, c)) ** self.mixing
        return critical, 2.0 * parts ** (-1.0 / self.mixing) / critical

    def _loss(self, adhesion: FloatArray, share: FloatArray, ductility: FloatArray) -> FloatArray:
        """Energy lost by a proportional opening down to β without residual, over Y_c."""
        gone = adhesion <= 0.0
        stretch = self.reached(np.where(gone, 1.0, adhesion), ductility)
        lost = self.area(stretch, ductility) - 0.5 * adhesion * stretch**2
        return np.where(gone, 0.5 * ductility, lost)

    def _loss_by_parts(
        self,
        state: JointState,
        jump: FloatArray,
        after: FloatArray,
        opening: FloatArray,
        stiffness: list[FloatArray],
    ) -> FloatArray:
        """Energy lost to damage of both springs and to the residual opening [J/m²].

        By the trapezoidal rule over the step: with a residual opening it hangs on the path.
        """
        eta = spread(self.residual, state.count)
        left = [beta / (1.0 - eta * (1.0 - beta)) for beta in (state.adhesion, after)]
        stretched = [state.jump[:, 0] - state.opening, jump[:, 0] - opening]
        normal = 0.25 * (left[0] - left[1]) * stiffness[0] * (stretched[0] ** 2 + stretched[1] ** 2)
        slid = (state.jump[:, 1:] ** 2).sum(axis=1) + (jump[:, 1:] ** 2).sum(axis=1)
        tangential = 0.25 * (state.adhesion - after) * stiffness[1] * slid
        stress = 0.5 * stiffness[0] * (left[0] * stretched[0] + left[1] * stretched[1])
        lost: FloatArray = normal + tangential + np.maximum(stress, 0.0) * (opening - state.opening)
        return lost
