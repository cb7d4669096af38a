"""Brittle damage: stone cracks in tension, and its cracks close again.

BrittleDamage(tensile_strength=2e6, fracture_energy=100.0)

Strains are those of the intact stone and of cracks across the principal axes of tension:

    ε = C⁻¹ σ + ω/E ⟨σ⟩₊,     ψ = ½ σ : ε

The damage ω ≥ 0 is of the compliance, and pressure does not see it: cracks close, stone between open ones is
pressed as if there were none, and pressure along a crack neither opens it nor takes part in what it costs.
With κ, the greatest that a bar of the stress σ1 would be strained so far, the strength is

    σ1 ≤ s(κ) = f_t exp(−2 H (E κ/f_t − 1)),     1 + ω = E κ/s(κ),     1 + 1/H = 2 E G_f/(h f_t²)

so that a crack takes the energy G_f per area whatever the width h of its band of elements, and whatever
strains its sides. That width must be less than 2 E G_f/f_t². Where more axes are in tension each has a crack.

Steps are implicit. At a given ω stresses are linear in strains as long as the same axes are in tension: which
are is found by trying. The κ at which σ1 = s is the root of one equation.

References
----------
M. Ortiz, A constitutive theory for the inelastic behavior of concrete, Mechanics of Materials 4 (1985), for
the added compliance; Bažant, Oh, Crack band theory for fracture of concrete, Matériaux et Constructions 16
(1983).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import SHEARS, BoolArray, FloatArray, Isotropic, MaterialLaw, Response
from masonry_fem.fem.materials.parts.cracked import cracked, crossing, softening
from masonry_fem.fem.materials.parts.principal import principal, sheared, tangents, tensors

ROUNDING = 1e-12  # of the strength: a stress above it by less is none
ROUNDS = 80  # of Newton's method and bisection for κ
NEAR = 1e-14  # of κ: what rounding leaves of its equation is less
BROKEN = 16.0  # −ln(s/f_t) beyond which the strength falls no further: e⁻¹⁶ of it is none


@dataclass(frozen=True, slots=True)
class BrittleDamage(MaterialLaw):
    """Cracks by tension beyond a strength, with a fracture energy; cracks that close bear pressure again.

    Strains localise in one row of elements, and the law softens by its width, so that a crack takes the
    fracture energy on any mesh, under any pressure along it. Compression alone never damages. The damage is
    one number at each point: a crack weakens the stone for tension along every axis.

    Attributes
    ----------
    tensile_strength : tensile strength f_t
    fracture_energy : energy G_f that a crack takes per area

    Examples
    --------
    law = "brittle_damage"
    tensile_strength = "2 MPa"
    fracture_energy = 100
    """

    tensile_strength: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
    fracture_energy: Annotated[float, Meta(gt=0, extra={"unit": "J/m^2"})]

    name: ClassVar[str] = "brittle_damage"
    variables: ClassVar[int] = 2  # κ (0: never in tension beyond f_t), and d = 1 − 1/(1 + ω)

    @property
    @override
    def softens(self) -> bool:
        return True

    @override
    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:
        longest = 2 * elastic.young * self.fracture_energy / self.tensile_strength**2
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
        q, before = len(strain), committed[:, 0]
        values, axes = principal(strain / SHEARS)
        stress, tangent = strain @ elastic.matrix, np.tile(elastic.matrix, (q, 1, 1))
        held = tangent.copy()
        internal, lost, changed = committed.copy(), np.zeros(q), np.zeros(q, dtype=bool)
        greatest = (values @ elastic.matrix[:3, :3])[:, 0]
        left = np.flatnonzero((before > 0) | (greatest > self.tensile_strength * (1 + ROUNDING)))
        if left.size:
            bar = self._bar(elastic, np.broadcast_to(size, (q,))[left])
            made, moduli, stiff, reached, grows = self._end(bar, values[left], before[left])
            own, turn = made[:, 0] > 0, axes[left]  # which cracks are open
            changed[left[own]] = True
            stress[left] = tensors(made, turn)
            for whole, parts in ((tangent, moduli), (held, stiff)):
                whole[left[own]] = tangents(parts, sheared(values[left], made, parts), turn)[own]
            internal[left[grows]] = np.column_stack([reached, bar.damage(reached)])[grows]
            if grows.any():
                more, some = left[grows], bar.of(grows)
                begun = _held(elastic, principal(start[more] / SHEARS)[0], some.opened(before[more]))[0]
                taken = some.taken(reached[grows]) - some.taken(before[more])
                lost[more] = crossing(begun, made[grows]) * taken
        stored = 0.5 * (stress * strain).sum(axis=1)
        given = self._stored(elastic, start, before, size)
        return Response(
            stress=stress,
            tangent=tangent,
            internal=internal,
            stored=stored,
            dissipation=lost,
            excess=(stress * (strain - start)).sum(axis=1) - (stored - given) - lost,
            changed=changed,
            held=held,
        )

    def _bar(self, elastic: Isotropic, size: FloatArray) -> _Bar:
        """How bars soften at points whose bands have widths (q,)."""
        length = 2 * elastic.young * self.fracture_energy / self.tensile_strength**2
        return _Bar(elastic, self.tensile_strength, size / (length - size))

    def _end(
        self, bar: _Bar, strains: FloatArray, before: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
        """Ends of steps, by principal strains (q, 3) and κ at the start (q,).

        Principal stresses (q, 3), their derivatives (q, 3, 3), those where ω stays, κ, where it grows (q,).
        """
        reached = np.maximum(before, bar.first)
        stress, stiff = _held(bar.elastic, strains, bar.opened(reached))
        moduli = stiff.copy()
        grows: BoolArray = stress[:, 0] > bar.strength(reached) * (1 + ROUNDING)
        reached = np.where(before > 0, reached, 0.0)
        if grows.any():
            some = bar.of(grows)
            reached[grows] = there = _grown(some, strains[grows], np.maximum(before[grows], bar.first))
            stress[grows], stiff[grows] = _held(bar.elastic, strains[grows], some.opened(there))
            moduli[grows] = softening(bar.elastic, stiff[grows], stress[grows], some.growth(there))
        return stress, moduli, stiff, reached, grows

    def _stored(
        self, elastic: Isotropic, strain: FloatArray, before: FloatArray, size: FloatArray
    ) -> FloatArray:
        """Energy of strains (q, 6) where nothing grows, shape (q,) [J/m³]."""
        energy = 0.5 * ((strain @ elastic.matrix) * strain).sum(axis=1)
        own = np.flatnonzero(before > 0)
        if own.size:
            values = principal(strain[own] / SHEARS)[0]
            bar = self._bar(elastic, np.broadcast_to(size, (len(strain),))[own])
            energy[own] = 0.5 * (_held(elastic, values, bar.opened(before[own]))[0] * values).sum(axis=1)
        return energy

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        return {"damage": internal[:, 1]}


@dataclass(frozen=True, slots=True)
class _Bar:
    """How a bar softens beyond f_t at q points, as functions of the greatest strain κ, shape (q,).

    Attributes
    ----------
    elastic : Of the intact material. tension : f_t [Pa]. H : Of the softening, shape (q,).
    """

    elastic: Isotropic
    tension: float
    H: FloatArray

    @property
    def first(self) -> float:
        """κ at which it begins."""
        return self.tension / self.elastic.young

    def of(self, points: BoolArray) -> _Bar:
        """That of some points."""
        return _Bar(self.elastic, self.tension, self.H[points])

    def _fallen(self, reached: FloatArray) -> FloatArray:
        """−ln(s/f_t)."""
        fallen: FloatArray = 2 * self.H * (np.maximum(reached, self.first) / self.first - 1)
        return fallen

    def strength(self, reached: FloatArray) -> FloatArray:
        """S [Pa]."""
        strength: FloatArray = self.tension * np.exp(-np.minimum(self._fallen(reached), BROKEN))
        return strength

    def opened(self, reached: FloatArray) -> FloatArray:
        """ω."""
        return self.elastic.young * np.maximum(reached, self.first) / self.strength(reached) - 1

    def damage(self, reached: FloatArray) -> FloatArray:
        """Damage d."""
        opened = self.opened(reached)
        return opened / (1 + opened)

    def slope(self, reached: FloatArray) -> FloatArray:
        """dω/dκ."""
        return self.elastic.young / self.strength(reached) * (1 + 2 * self.H * reached / self.first)

    def growth(self, reached: FloatArray) -> FloatArray:
        """dω/ds [1/Pa], by which stresses of tension strain more as s falls."""
        return -self.slope(reached) * self.first / (2 * self.H * self.strength(reached))

    def taken(self, reached: FloatArray) -> FloatArray:
        """Energy that can not be given back, ∫ s dκ − ½ s κ [J/m³]."""
        fallen, at = self._fallen(reached), np.maximum(reached, self.first)
        most, strength = np.minimum(fallen, BROKEN), self.strength(reached)
        whole = self.tension * (0.5 - np.expm1(-most) / (2 * self.H)) + strength * (fallen - most) / (
            2 * self.H
        )
        return whole * self.first - 0.5 * strength * at


def _grown(bar: _Bar, strains: FloatArray, before: FloatArray) -> FloatArray:
    """κ = (1 + ω) σ1/E where that of the start bears too much, by principal strains (q, 3), shape (q,).

    That is ε1 + ν (σ2 + σ3)/E, and no stress is above √(2 E ψ) of the intact stone.
    """
    elastic = bar.elastic
    young, poisson = elastic.young, elastic.poisson
    most = np.sqrt(np.maximum(((strains @ elastic.matrix[:3, :3]) * strains).sum(axis=1) / young, 0.0))
    low, high = before, strains[:, 0] + 2 * abs(poisson) * most
    reached = before
    for _ in range(ROUNDS):
        opened = bar.opened(reached)
        stress, stiff = _held(elastic, strains, opened)
        over = strains[:, 0] + poisson * stress[:, 1:].sum(axis=1) / young - reached
        low, high = np.where(over > 0, reached, low), np.where(over > 0, high, reached)
        falls = np.matmul(stiff, np.maximum(stress, 0.0)[:, :, None])[:, 1:, 0].sum(axis=1) / young
        moved = reached + over / (1 + poisson / young * falls * bar.slope(reached))
        between = (moved > low) & (moved < high)
        near = (np.abs(moved - reached) <= NEAR * reached) | (high - low <= NEAR * reached)
        reached = np.where(between | near, moved, 0.5 * (low + high))
        if near.all():
            break
    return reached


def _held(elastic: Isotropic, strains: FloatArray, opened: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal stresses (q, 3) of principal strains (q, 3) at a damage ω (q,), and their derivatives."""
    stiff = np.stack([cracked(elastic, opened, pulled) for pulled in range(4)])
    stress = np.matmul(stiff, strains[:, :, None])[..., 0]
    tension = np.arange(3) < np.arange(4)[:, None]  # of the first axes; by what their cracks have opened
    outside = np.where(tension[:, None], -(1 + opened[:, None]) * stress, stress).max(axis=2)
    best, every = outside.argmin(axis=0), np.arange(len(strains))
    return stress[best, every], stiff[best, every]
