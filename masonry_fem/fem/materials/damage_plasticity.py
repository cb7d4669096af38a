"""Damage with plasticity: stone that cracks in tension and is crushed under pressure.

DamagePlasticity(tensile_strength=2e6, fracture_energy=100.0, compressive_strength=30e6, friction_angle=35.0)

With principal stresses σ1 ≥ σ2 ≥ σ3 (tension positive) strains are the sum of those of the intact stone, of
cracks across the axes of tension, and of crushing:

    ε = C⁻¹ σ + ω/E ⟨σ⟩₊ + ε_p

Cracks are a damage ω ≥ 0 of the compliance, which stresses of pressure do not see: they close, and none is
left of their strain. The greatest crack strain so far, λ, leaves the stone the tensile strength

    σ1 ≤ s(λ) = f_t exp(−λ h f_t/G_f),     ω = E λ/s(λ)

so that a crack takes the energy G_f per area whatever the width h of its band of elements, if that is less
than E G_f/f_t². Crushing is the slip of Mohr and Coulomb, for each pair i < j of axes

    (1 + sin φ) σ_i − (1 − sin φ) σ_j ≤ (1 − sin φ) f_c

with the dilatancy ψ. It is of the stress itself, not of that of an intact stone: between open cracks stone
bears f_c, and where strain goes on in tension nothing flows. Strains are the derivative of the complementary
energy ½ σ : C⁻¹ : σ + ω/(2E) Σ⟨σ_i⟩², by which all energy is accounted for.

Steps are implicit. At a given ω stresses are linear in strains as long as the same axes are in tension and
the same planes slip: which do is found by trying. The λ at which σ1 = s is the root of one equation. Where
stone cracks and slips at once that root is the only one if h is below some third of the widest band; in wider
ones the stress may jump there, as in any snap-back, and rounds of a step are slow.

References
----------
M. Ortiz, A constitutive theory for the inelastic behavior of concrete, Mechanics of Materials 4 (1985), for
the added compliance; Bažant, Oh, Crack band theory for fracture of concrete, Matériaux et Constructions 16
(1983).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import SHEARS, BoolArray, FloatArray, Isotropic, Response
from masonry_fem.fem.materials.parts.cracked import Held, IntArray, cracked, crossing, sliding, softening
from masonry_fem.fem.materials.parts.plastic import PLASTIC, FrictionAngle, Plastic
from masonry_fem.fem.materials.parts.principal import principal, sheared, tangents, tensors
from masonry_fem.fem.materials.parts.slip import sine_cosine, slip_planes

ROUNDING = 1e-12  # of stress: what is outside by less is inside
ROUNDS = 80  # of Newton's method and bisection for λ
BROKEN = 16.0  # λ h f_t/G_f beyond which the strength falls no further: e⁻¹⁶ of it is none
SURE = 1e-7  # as far outside no end was found
NEAR = 1e-13  # of λ: what rounding leaves of its equation is less
CRACK, DAMAGE = 7, 8  # λ, and 1 − 1/(1 + ω), after the variables of Plastic
# how many axes are in tension, and which planes slip; σ1 = σ2 where the first two do, σ2 = σ3 where the first
# and third do; with three axes in tension the strength f_t comes first. In the order in which they are tried:
# most points of a crushed stone are only pressed
ENDS = (
    (0, ()), (0, (0,)), (0, (0, 1)), (0, (0, 2)), (1, ()), (2, ()), (3, ()), (1, (0,)), (2, (0,)),
    (2, (0, 1)), (1, (0, 2)),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class DamagePlasticity(Plastic):
    """Cracks by tension, with a fracture energy, and crushing by pressure, with friction, of one stone.

    Cracks close and bear pressure as the intact stone does; what was crushed stays short. Crushed stone flows
    at its strength, that in tension softens: strains localise in one row of elements there, and the law
    softens by its width, so that a crack takes the fracture energy on any mesh.

    Attributes
    ----------
    tensile_strength : tensile strength f_t, at most f_c (1 − sin φ)/(1 + sin φ)
    fracture_energy : energy G_f that a crack takes per area
    compressive_strength : uniaxial compressive strength f_c
    friction_angle : friction angle φ: strength grows by (1 + sin φ)/(1 − sin φ) times lateral pressure
    dilatancy_angle : dilatancy angle ψ, the growth of volume as stone is crushed, at most φ; equal to φ if
        left out (associated flow)

    Examples
    --------
    law = "damage_plasticity"
    tensile_strength = "1 MPa"
    fracture_energy = 100
    compressive_strength = "8 MPa"
    friction_angle = 35
    dilatancy_angle = 10
    """

    tensile_strength: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
    fracture_energy: Annotated[float, Meta(gt=0, extra={"unit": "J/m^2"})]
    compressive_strength: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
    friction_angle: FrictionAngle
    dilatancy_angle: FrictionAngle | None = None

    name: ClassVar[str] = "damage_plasticity"
    variables: ClassVar[int] = 9  # those of Plastic, λ, damage

    @property
    @override
    def softens(self) -> bool:
        return True

    def __post_init__(self) -> None:
        """Refuse parameters out of their range, a dilatancy above the friction, and too much tension."""
        super(DamagePlasticity, self).__post_init__()  # with slots the class is another
        self.refuse_dilatancy(self.friction_angle, self.dilatancy_angle)
        sine = sine_cosine(self.friction_angle)[0]
        most = self.compressive_strength * (1 - sine) / (1 + sine)
        if self.tensile_strength > most:
            raise LawError(
                f"law '{self.name}': tensile_strength is {self.tensile_strength:g} Pa, expected at most "
                f"{most:.4g} Pa, compressive_strength (1 − sin φ)/(1 + sin φ), at which stone in tension "
                "slips; lower it, or the friction_angle"
            )

    @override
    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:
        longest = elastic.young * self.fracture_energy / self.tensile_strength**2
        if size.max() >= longest:
            raise LawError(
                f"law '{self.name}': elements are up to {size.max():.3g} m wide, expected less than "
                f"{longest:.3g} m, E G_f/f_t²: a crack in them would give back more energy than it takes; "
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
        q, plastic, before = len(strain), committed[:, PLASTIC], committed[:, CRACK]
        rate = self.tensile_strength / self.fracture_energy * np.broadcast_to(size, (q,))
        values, axes = principal((strain - plastic) / SHEARS)
        stress, tangent = (strain - plastic) @ elastic.matrix, np.tile(elastic.matrix, (q, 1, 1))
        held = tangent.copy()
        crack, grown, lost = before.copy(), np.zeros((q, 6)), np.zeros(q)
        changed = np.zeros(q, dtype=bool)
        left = np.flatnonzero(self._beyond(elastic, values, before))
        if left.size:
            end = self._end(elastic, values[left], before[left], rate[left])
            own, turn = end.changed, axes[left]
            stress[left], grown[left] = tensors(end.stress, turn), SHEARS * tensors(end.flow, turn)
            for whole, parts in ((tangent, end.moduli), (held, end.stiff)):
                moduli = tangents(parts, sheared(values[left], end.stress, parts), turn)
                whole[left] = np.where(own[:, None, None], moduli, elastic.matrix)
            changed[left], crack[left] = own, end.crack
            grows = left[end.crack > before[left]]
            if grows.size:
                opened = elastic.young * before[grows] / self._strength(before[grows], rate[grows])
                begun = principal((start[grows] - plastic[grows]) / SHEARS)[0]
                taken = self._taken(crack[grows], rate[grows]) - self._taken(before[grows], rate[grows])
                ends = end.stress[end.crack > before[left]]
                lost[grows] = crossing(self._held(elastic, begun, opened).stress, ends) * taken
        damage = crack / (crack + self._strength(crack, rate) / elastic.young)
        others, strains = np.column_stack([crack, damage]), (start, strain)
        made = self.response(elastic, strains, committed, grown, others, stress, tangent, changed, lost)
        given = made.stored - self._stored(elastic, start - plastic, before, rate)
        work = (stress * (strain - start)).sum(axis=1)
        return replace(made, excess=work - given - made.dissipation, held=held)

    def _beyond(self, elastic: Isotropic, strains: FloatArray, crack: FloatArray) -> BoolArray:
        """Where principal strains are not those of intact elastic stone, shape (q,)."""
        normals, _, bound = self._planes
        trial = strains @ elastic.matrix[:3, :3]
        slips = trial @ normals[0] - bound > ROUNDING * (bound + np.abs(trial).max(axis=1))
        beyond: BoolArray = (crack > 0) | slips | (trial[:, 0] > self.tensile_strength * (1 + ROUNDING))
        return beyond

    @property
    def _planes(self) -> tuple[FloatArray, FloatArray, float]:
        """Normals and flows of slip, each of shape (3, 3), and its bound [Pa]."""
        planes = slip_planes(self.friction_angle, self.dilatancy_angle)
        return *planes, (1 - sine_cosine(self.friction_angle)[0]) * self.compressive_strength

    def _strength(self, crack: FloatArray, rate: FloatArray) -> FloatArray:
        """The strength s that λ leaves, shape (q,) [Pa]; ``rate`` is h f_t/G_f, shape (q,)."""
        return self.tensile_strength * np.exp(-np.minimum(rate * crack, BROKEN))

    def _taken(self, crack: FloatArray, rate: FloatArray) -> FloatArray:
        """What a crack has taken that can not be given back, ∫ s dλ − ½ s λ, shape (q,) [J/m³]."""
        whole = -self.tensile_strength / rate * np.expm1(-rate * crack)
        return whole - 0.5 * self._strength(crack, rate) * crack

    def _stored(
        self, elastic: Isotropic, strain: FloatArray, crack: FloatArray, rate: FloatArray
    ) -> FloatArray:
        """Energy of strains (q, 6) without plastic ones where nothing grows, shape (q,) [J/m³]."""
        energy = 0.5 * ((strain @ elastic.matrix) * strain).sum(axis=1)
        own = np.flatnonzero(crack > 0)
        if own.size:
            values = principal(strain[own] / SHEARS)[0]
            opened = elastic.young * crack[own] / self._strength(crack[own], rate[own])
            energy[own] = 0.5 * (self._held(elastic, values, opened).stress * values).sum(axis=1)
        return energy

    def _end(self, elastic: Isotropic, strains: FloatArray, before: FloatArray, rate: FloatArray) -> _End:
        """The ends of steps, by principal strains (q, 3) without plastic ones and λ at the start (q,)."""
        young, crack, strength = elastic.young, before.copy(), self._strength(before, rate)
        held = self._held(elastic, strains, young * before / strength)
        moduli = held.moduli.copy()
        grows = (held.stress[:, 0] > strength * (1 + ROUNDING)) | (held.outside > SURE)
        if grows.any():
            own, speed = strains[grows], rate[grows]
            crack[grows] = reached = self._grown(elastic, own, before[grows], speed)
            strength = self._strength(reached, speed)
            there = self._held(elastic, own, young * reached / strength)
            # dω/ds, by which stresses of tension strain more as s falls
            growth = -young * (1 + speed * reached) / (speed * strength**2)
            held = held.replaced(grows, there)
            moduli[grows] = self._softening(elastic, there, young * reached / strength, growth)
        changed: BoolArray = held.flow.any(axis=1) | ((crack > 0) & (held.stress[:, 0] > 0))
        return _End(held.stress, held.flow, moduli, held.moduli, crack, changed)

    def _grown(
        self, elastic: Isotropic, strains: FloatArray, before: FloatArray, rate: FloatArray
    ) -> FloatArray:
        """The λ that is the crack strain ω σ1/E itself, where the λ of the start bears too much, shape (q,).

        It is at most the greatest strain. From there on Newton's method comes down to it.
        """
        low, high = before.copy(), np.maximum(strains[:, 0], before)
        crack, left, ends = high.copy(), np.arange(len(strains)), None
        for _ in range(ROUNDS):
            here, speed, young = crack[left], rate[left], elastic.young
            strength = self._strength(here, speed)
            opened = young * here / strength
            held = self._held(elastic, strains[left], opened, ends)
            over = opened * held.stress[:, 0] / young - here
            more = (over > 0) | (held.outside > SURE)
            low[left], high[left] = np.where(more, here, low[left]), np.where(more, high[left], here)
            pulled = np.maximum(held.stress, 0.0)
            change = held.stress[:, 0] - opened * np.einsum("qj,qj->q", held.moduli[:, 0], pulled) / young
            slope = (1 + speed * here) / strength * change - 1
            moved = np.where(slope < 0, here - over / np.where(slope < 0, slope, 1.0), -1.0)
            near = np.abs(moved - here) <= NEAR * here
            between = near | ((moved > low[left]) & (moved < high[left]))
            # rounding may close the bracket before two of Newton's steps agree
            there = near | (high[left] - low[left] <= NEAR * here)
            crack[left] = np.where(between, moved, 0.5 * (low[left] + high[left]))
            left, ends = left[~there], held.end[~there]
            if not left.size:
                break
        return crack

    def _held(
        self, elastic: Isotropic, strains: FloatArray, opened: FloatArray, known: IntArray | None = None
    ) -> Held:
        """Stresses of principal strains (q, 3) without plastic ones at a damage ω (q,) that stays.

        ``known`` are ends to try first, shape (q,).
        """
        normals, flows, bound = self._planes
        trial = strains @ elastic.matrix[:3, :3]
        scale = bound + np.abs(trial).max(axis=1)
        made = Held.none(len(strains))
        left = np.arange(len(strains))
        likely = [] if known is None else [(end, known == end) for end in np.unique(known)]
        for number, own in [*likely, *((end, None) for end in range(len(ENDS)))]:
            pulled, planes = ENDS[number]
            left = left if own is None else np.flatnonzero(own)
            n, m = normals[list(planes)], flows[list(planes)]
            stiff = cracked(elastic, opened[left], pulled)
            stress = np.matmul(stiff, strains[left][:, :, None])[:, :, 0]
            rate = np.zeros((len(left), len(planes)))
            if planes:
                over = (stress @ n.T - bound)[:, :, None]
                rate = np.matmul(np.linalg.inv(n @ stiff @ m.T), over)[:, :, 0]
            flow = rate @ m
            stress = stress - np.matmul(stiff, flow[:, :, None])[:, :, 0]
            # cracks by what they have opened: the stress that is left of them may be less than rounding
            opening = (1 + opened[left, None]) * stress[:, :pulled]
            outside = np.maximum.reduce([
                (-opening).max(axis=1, initial=0),
                stress[:, pulled:].max(axis=1, initial=0),
                (stress @ normals.T - bound).max(axis=1),
                (-rate).max(axis=1, initial=0) * elastic.shear,
            ]) / scale[left]  # fmt: skip
            better = outside < made.outside[left]
            new = Held(stress, flow, sliding(stiff, n, m), outside, np.full(len(left), number))
            made = made.replaced(left[better], new.of(better))
            left = np.flatnonzero(made.outside > ROUNDING)
            if not left.size:
                break
        return made

    def _softening(
        self, elastic: Isotropic, held: Held, opened: FloatArray, growth: FloatArray
    ) -> FloatArray:
        """Derivatives of stresses by strains as ω grows, shape (q, 3, 3) [Pa].

        Parameters
        ----------
        elastic : Of the intact material. held : Stresses with that ω.
        opened : ω, shape (q,). growth : dω/dσ1, shape (q,) [1/Pa].
        """
        normals, flows, _ = self._planes
        moduli = held.moduli.copy()
        for number in np.unique(held.end):
            pulled, planes = ENDS[number]
            own = np.flatnonzero(held.end == number)
            n, m = normals[list(planes)], flows[list(planes)]
            stiff = cracked(elastic, opened[own], pulled)
            moduli[own] = sliding(softening(elastic, stiff, held.stress[own], growth[own]), n, m)
        return moduli

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        return {"damage": internal[:, DAMAGE], **super(DamagePlasticity, self).measures(internal)}


@dataclass(frozen=True, slots=True)
class _End:
    """Ends of steps, q points: principal stresses and plastic strains of the step, derivatives of the first.

    Attributes
    ----------
    stress, flow : Shapes (q, 3) [Pa]. moduli, stiff : Those where ω stays, shapes (q, 3, 3) [Pa].
    crack : λ, shape (q,).
    changed : Points whose tangent is not the elastic one, shape (q,).
    """

    stress: FloatArray
    flow: FloatArray
    moduli: FloatArray
    stiff: FloatArray
    crack: FloatArray
    changed: BoolArray
