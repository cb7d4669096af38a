"""Brittle damage: stone cracks in tension, and its cracks close again.

BrittleDamage(tension_strength=2e6, fracture_energy=100.0)

Only what is stretched is damaged: with the principal strains ε_i, their trace and Lamé's λ and μ

    ψ = g ψ⁺ + ψ⁻,     ψ± = ½ λ ⟨tr ε⟩±² + μ Σ ⟨ε_i⟩±²,     σ = ∂ψ/∂ε at fixed g,     g = 1 − d

so that what is squeezed bears as the intact stone does, and cracks close. The damage follows the greatest
principal stress r that the intact stone would have had so far (Rankine). Its function is such that a bar in
tension, whatever ν, has beyond f_t the stress

    s(e) = f_t exp(−2 H (E e/f_t − 1)),      1 + 1/H = 2 E G_f/(h f_t²)

and a crack takes the energy G_f per area whatever the width h of its band of elements. That width must be
less than 2 E G_f/f_t². Of the energy ψ⁺ Δd that damage takes, ψ⁺ is the mean of both ends of the step.

References
----------
Miehe, Welschinger, Hofacker, Int. J. Numer. Meth. Engng 83 (2010), for ψ±; Bažant, Oh, Crack band theory for
fracture of concrete, Matériaux et Constructions 16 (1983).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import SHEARS, BoolArray, FloatArray, Isotropic, MaterialLaw, Response
from masonry_fem.fem.materials.parts.principal import principal, sheared, tangents, tensors

ROUNDING = 1e-12  # of the strength: a trial stress above what it was by less is none
ROUNDS = 60  # of bisection and Newton's method for the bar's strain


@dataclass(frozen=True, slots=True)
class BrittleDamage(MaterialLaw):
    """Cracks by tension beyond a strength, with a fracture energy; cracks that close bear pressure again.

    Strains localise in one row of elements, and the law softens by its width, so that a crack takes the
    fracture energy on any mesh. Compression alone never damages. The damage is one number at each point:
    cracked stone whose sides are free bulges more under pressure, its modulus being between E and E/(1 + ν).

    Attributes
    ----------
    tension_strength : tensile strength f_t
    fracture_energy : energy G_f that a crack takes per area

    Examples
    --------
    law = "brittle_damage"
    tension_strength = "2 MPa"
    fracture_energy = 100
    """

    tension_strength: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
    fracture_energy: Annotated[float, Meta(gt=0, extra={"unit": "J/m^2"})]

    name: ClassVar[str] = "brittle_damage"
    variables: ClassVar[int] = 2  # greatest r so far (0: never above f_t) and d

    @property
    @override
    def softens(self) -> bool:
        return True

    @override
    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:
        if elastic.poisson < 0:
            raise LawError(
                f"law '{self.name}': poisson is {elastic.poisson:g}, expected at least 0, as energies of "
                "tension and pressure cannot be told apart below; correct it, or choose another law"
            )
        longest = 2 * elastic.young * self.fracture_energy / self.tension_strength**2
        if size.max() >= longest:
            raise LawError(
                f"law '{self.name}': elements are up to {size.max():.3g} m wide, expected less than "
                f"{longest:.3g} m, 2 E G_f/f_t²: a crack in them would give back more energy than it takes; "
                "take smaller elements (mesh.size), or a larger fracture_energy"
            )

    @override
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        lam, mu = elastic.bulk - 2 * elastic.shear / 3, elastic.shear
        values, axes = principal(strain / SHEARS)
        trace = values.sum(axis=1)
        before = np.maximum(committed[:, 0], self.tension_strength)
        greatest = lam * trace + 2 * mu * values[:, 0]
        grows = greatest > before * (1 + ROUNDING)
        reached = np.where(grows, greatest, before)
        damage, slope = committed[:, 1].copy(), np.zeros(len(strain))
        if grows.any():
            band = np.broadcast_to(size, (len(strain),))[grows]
            damage[grows], slope[grows] = self._damage(elastic, reached[grows], band)
        kept = 1.0 - damage
        pulled = lam * np.maximum(trace, 0.0)[:, None] + 2 * mu * np.maximum(values, 0.0)
        pressed = lam * np.minimum(trace, 0.0)[:, None] + 2 * mu * np.minimum(values, 0.0)
        own = kept[:, None] * pulled + pressed
        stretched, squeezed = _energies(lam, mu, values)
        at_start = _energies(lam, mu, principal(start / SHEARS)[0])
        stored = kept * stretched + squeezed
        lost = 0.5 * (stretched + at_start[0]) * (damage - committed[:, 1])
        stress = tensors(own, axes)
        changed: BoolArray = grows | (damage > 0)
        tangent = np.tile(elastic.matrix, (len(strain), 1, 1))
        if changed.any():
            part = values[changed], trace[changed], axes[changed]
            fall = slope[changed, None] * pulled[changed]
            tangent[changed] = _tangent(lam, mu, part, kept[changed], own[changed], fall)
        given = (1.0 - committed[:, 1]) * at_start[0] + at_start[1]
        return Response(
            stress=stress,
            tangent=tangent,
            internal=np.column_stack([np.where(grows, reached, committed[:, 0]), damage]),
            stored=stored,
            dissipation=lost,
            excess=(stress * (strain - start)).sum(axis=1) - (stored - given) - lost,
            changed=changed,
        )

    def _damage(
        self, elastic: Isotropic, reached: FloatArray, size: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Damage d of a greatest effective stress r, and its derivative by r [1/Pa], shapes (q,).

        A bar with the strain e has s(e) and effective stress r(e) = s/g; r grows with e, and is inverted.
        """
        young, strength = elastic.young, self.tension_strength
        length = 2 * young * self.fracture_energy / strength**2
        H = size / (length - size)
        # r/e is E of the intact bar, and λ + 2 μ of a crack, whose sides are at rest
        low, high = reached / (elastic.bulk + 4 * elastic.shear / 3), reached / young
        strain = high
        for _ in range(ROUNDS):
            value, rise, *_ = _bar(elastic, strength, H, strain)
            low, high = np.where(value <= reached, strain, low), np.where(value > reached, strain, high)
            moved = strain - (value - reached) / rise
            inside = (moved >= low) & (moved <= high)
            following = np.where(inside, moved, 0.5 * (low + high))
            if (np.abs(following - strain) <= 4e-16 * strain).all():
                break
            strain = following
        _, rise, kept, fall = _bar(elastic, strength, H, strain)
        return 1.0 - kept, -fall / rise

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        return {"damage": internal[:, 1]}


def _bar(
    elastic: Isotropic, strength: float, H: FloatArray, strain: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Effective stress r of a bar of strain e in tension, dr/de, g and dg/de, shapes (q,).

    Its sides are free: g μ (λ + 2 g λ + 2 μ)/(g λ + μ) = s/e gives g, and r = s/g.
    """
    young = elastic.young
    lam, mu = elastic.bulk - 2 * elastic.shear / 3, elastic.shear
    stress = strength * np.exp(-2 * H * (young * strain / strength - 1))
    secant = stress / strain
    falling = -secant * (2 * H * young / strength + 1 / strain)  # ds/de of s/e
    a, b = 2 * lam * mu, lam * mu + 2 * mu**2 - secant * lam
    # the positive root of a g² + b g − s/e μ = 0, without cancellation
    root = np.sqrt(b**2 + 4 * a * mu * secant)
    kept = 2 * mu * secant / (b + root)
    by_secant = (mu + lam * kept) / (2 * a * kept + b)
    fall = by_secant * falling
    inner = mu * (lam + 2 * kept * lam + 2 * mu) / (kept * lam + mu)  # r/e
    bent = -mu * lam**2 / (kept * lam + mu) ** 2  # its derivative by g
    return inner * strain, inner + strain * bent * fall, kept, fall


def _energies(lam: float, mu: float, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """ψ⁺ and ψ⁻ of principal strains (q, 3), shapes (q,)."""
    trace = values.sum(axis=1)
    plus = 0.5 * lam * np.maximum(trace, 0) ** 2 + mu * (np.maximum(values, 0) ** 2).sum(axis=1)
    minus = 0.5 * lam * np.minimum(trace, 0) ** 2 + mu * (np.minimum(values, 0) ** 2).sum(axis=1)
    return plus, minus


def _tangent(
    lam: float,
    mu: float,
    strains: tuple[FloatArray, FloatArray, FloatArray],
    kept: FloatArray,
    stress: FloatArray,
    fall: FloatArray,
) -> FloatArray:
    """Derivative of the stress by the strain, shape (q, 6, 6).

    ``strains`` are principal strains, their trace and axes; ``stress`` principal stresses; ``fall`` the
    principal stress that each unit of r takes away, shape (q, 3).
    """
    values, trace, axes = strains
    moduli = np.where(trace > 0, kept, 1.0)[:, None, None] * np.full((3, 3), lam)
    moduli[:, [0, 1, 2], [0, 1, 2]] += 2 * mu * np.where(values > 0, kept[:, None], 1.0)
    by_strain = np.broadcast_to([lam + 2 * mu, lam, lam], values.shape)
    taken = tensors(fall, axes)[:, :, None] * tensors(by_strain, axes)[:, None, :]
    tangent: FloatArray = tangents(moduli, sheared(values, stress, moduli), axes) - taken
    return tangent
