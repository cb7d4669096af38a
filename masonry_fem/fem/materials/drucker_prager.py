"""Drucker–Prager: friction and cohesion of geomaterials by a smooth cone, with a dilatancy of its own.

DruckerPrager(cohesion=2e6, friction_angle=35.0, dilatancy_angle=10.0)

With J2 = ½ s : s of the deviator s and the mean stress p (tension positive)

    f = √J2 + η p − ξ c(κ) ≤ 0,      c(κ) = c + H κ,      Δε_p = Δγ (s/(2√J2) + η̄/3 I),      Δκ = ξ Δγ

and, by flow of volume alone, p ≤ p_t and −p ≤ p_c + H_c ζ, where ζ is the volume that is crushed. Without
cut-off p_t is the apex ξ c(κ)/η; flow there hardens by ξ/η times its volume.

Steps are implicit (backward Euler). Limits are lines in the plane of p and √J2, in which elasticity is linear
and has no coupling: a step ends on a line or in the corner of two, exactly, the apex being that of cone and
cut-off; which one is found by trying each for flow that is nowhere negative and stress that is nowhere
outside. This holds for every dilatancy, 0 included.

References
----------
de Souza Neto, Perić, Owen, Computational Methods for Plasticity (Wiley 2008), 6.4, 8.3. Their return to the
apex divides by η̄ and fails without dilatancy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import (
    DEVIATOR,
    SHEARS,
    UNIT,
    FloatArray,
    Isotropic,
    Response,
)
from masonry_fem.fem.materials.parts.plastic import PLASTIC, Cohesion, FrictionAngle, Plastic

# of ξ c + |trial stress|: a trial stress that is outside by less is on the line
ON_LINE = 1e-14
CONE, CUT, CAP = range(3)
# the apex before the cut-off alone, whose stress is the same without shear
ENDS = ((CONE,), (CONE, CUT), (CUT,), (CAP,), (CONE, CAP))


@dataclass(frozen=True, slots=True)
class DruckerPrager(Plastic):
    """Friction and cohesion by a smooth cone, perfectly plastic or hardening, with separate dilatancy.

    Mean stress may be cut off in tension, and capped in pressure, at which pores are crushed.
    The cone is fitted to that of Mohr and Coulomb with the same cohesion and friction angle: with
    `compression` both have the same uniaxial compressive strength 2 c cos φ/(1 − sin φ), with `tension` the
    same uniaxial tensile strength 2 c cos φ/(1 + sin φ), with `plane_strain` the same limit loads of plane
    associated flow. All plastic work is dissipated.

    Attributes
    ----------
    cohesion : cohesion c
    friction_angle : friction angle φ, the pressure dependence of the strength
    dilatancy_angle : dilatancy angle ψ, the growth of volume with shear, at most φ; equal to φ if left out
        (associated flow)
    hardening : slope H of the cohesion over the accumulated plastic strain
    tension_cutoff : greatest mean stress p_t; c cot φ, the apex, if left out or if that is less
    crushing_pressure : greatest mean pressure p_c; there is none if left out
    crushing_hardening : slope H_c of that pressure over the volume that is crushed
    fit : which strength the cone shares with that of Mohr and Coulomb

    Examples
    --------
    law = "drucker_prager"
    cohesion = "2 MPa"
    friction_angle = 35
    dilatancy_angle = 10
    """

    cohesion: Cohesion
    friction_angle: FrictionAngle
    dilatancy_angle: FrictionAngle | None = None
    hardening: Annotated[float, Meta(ge=0, extra={"unit": "Pa"})] = 0.0
    tension_cutoff: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})] | None = None
    crushing_pressure: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})] | None = None
    crushing_hardening: Annotated[float, Meta(ge=0, extra={"unit": "Pa"})] = 0.0
    fit: Literal["compression", "tension", "plane_strain"] = "compression"

    name: ClassVar[str] = "drucker_prager"
    variables: ClassVar[int] = 9  # those of Plastic, κ, ζ

    def __post_init__(self) -> None:
        """Refuse parameters out of their range, and a dilatancy above the friction."""
        super(DruckerPrager, self).__post_init__()  # with slots the class is another
        self.refuse_dilatancy(self.friction_angle, self.dilatancy_angle)
        if self.crushing_hardening and self.crushing_pressure is None:
            raise LawError(
                f"law '{self.name}': crushing_hardening is {self.crushing_hardening:g}, but nothing is "
                "crushed, expected a crushing_pressure beside it; add one, or leave crushing_hardening out"
            )

    @property
    def cone(self) -> tuple[float, float, float]:
        """η, ξ and η̄."""
        dilatancy = self.friction_angle if self.dilatancy_angle is None else self.dilatancy_angle
        eta, xi = self._fitted(self.friction_angle)
        return eta, xi, self._fitted(dilatancy)[0]

    def _fitted(self, angle: float) -> tuple[float, float]:
        """η and ξ of an angle [degrees]."""
        sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
        if self.fit == "plane_strain":
            tangent = sine / cosine
            root = math.sqrt(9 + 12 * tangent**2)
            return 3 * tangent / root, 3 / root
        root = math.sqrt(3) * (3 - sine if self.fit == "compression" else 3 + sine)
        return 6 * sine / root, 6 * cosine / root

    @property
    def _lines(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Limits n · (√J2, p) ≤ bound + slopes · (κ, ζ), by cone, cut-off and cap.

        These are n and the directions of flow, shapes (3, 2), the bounds (3,) [Pa], and what κ and ζ grow by
        each flow, shape (3, 2), by which the bounds grow, too, times H and H_c.
        """
        eta, xi, eta_bar = self.cone
        normals = np.array([[1.0, eta], [0.0, 1.0], [0.0, -1.0]])
        flows = np.array([[1.0, eta_bar], [0.0, 1.0], [0.0, -1.0]])
        growth = np.array([[xi, 0.0], [0.0, 0.0], [0.0, 1.0]])
        apex = xi / eta if eta > 0 else math.inf
        cut = self.cohesion * apex
        if self.tension_cutoff is not None and self.tension_cutoff < cut:
            cut = self.tension_cutoff
        elif eta > 0:
            growth[CUT, 0] = apex
        cap = math.inf if self.crushing_pressure is None else self.crushing_pressure
        return normals, flows, np.array([xi * self.cohesion, cut, cap]), growth

    @override
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        normals, _, bounds, growth = self._lines
        plastic, hardened = committed[:, PLASTIC], committed[:, 7:]
        trial = (strain - plastic) @ elastic.matrix
        p = trial[:, :3].sum(axis=1) / 3
        s = trial - p[:, None] * UNIT
        root = np.sqrt(0.5 * (SHEARS * s * s).sum(axis=1))
        point = np.column_stack([root, p])
        strength = bounds + hardened * [self.hardening, self.crushing_hardening] @ growth.T
        scale = strength[:, CONE] + root + np.abs(p)
        yields = (point @ normals.T - strength > ON_LINE * scale[:, None]).any(axis=1)
        ends = point.copy()
        moduli = np.tile(np.diag([elastic.shear, elastic.bulk]), (len(strain), 1, 1))
        hardened = hardened.copy()
        if yields.any():
            ends[yields], moduli[yields], more = self._returned(
                elastic, point[yields], strength[yields], scale[yields]
            )
            hardened[yields] += more
        lost = point - ends
        direction = s / np.where(root > 0, root, 1.0)[:, None]  # N, with N : N = 2
        stress = np.where(yields[:, None], ends[:, :1] * direction + ends[:, 1:] * UNIT, trial)
        # strains by angles
        shear, volume = lost[:, 0] / elastic.shear, lost[:, 1] / elastic.bulk
        grown = SHEARS * (0.5 * shear[:, None] * direction) + volume[:, None] / 3 * UNIT
        tangent = np.tile(elastic.matrix, (len(strain), 1, 1))
        if yields.any():
            # without √J2, all of it is kept if the cone is not reached, and nothing at the apex
            kept = np.where(
                root > 0, ends[:, 0] / np.where(root > 0, root, 1.0), moduli[:, 0, 0] / elastic.shear
            )
            tangent[yields] = _tangent(elastic, direction[yields], kept[yields], moduli[yields])
        return self.response(elastic, (start, strain), committed, grown, hardened, stress, tangent, yields)

    def _returned(
        self, elastic: Isotropic, trial: FloatArray, strength: FloatArray, scale: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """√J2 and p at the end (q, 2), their derivatives (q, 2, 2) [Pa], and the growth of κ and ζ (q, 2).

        The derivatives are by N : ε, where N is s/√J2, and by the volume.

        Parameters
        ----------
        elastic : Of the intact material.
        trial : √J2 and p of trial stresses, some outside, shape (q, 2) [Pa].
        strength : The bounds at the start, shape (q, 3) [Pa].
        scale : Sizes of stress by which rounding is told, shape (q,) [Pa].
        """
        normals, flows, _, growth = self._lines
        E = np.diag([elastic.shear, elastic.bulk])
        slopes = growth * [self.hardening, self.crushing_hardening]
        ends, moduli, more = trial.copy(), np.tile(E, (len(trial), 1, 1)), np.zeros((len(trial), 2))
        least, left = np.full(len(trial), np.inf), np.arange(len(trial))
        for lines in ENDS:
            chosen = list(lines)
            if not np.isfinite(strength[0, chosen]).all():
                continue
            n, m = normals[chosen], flows[chosen]
            inverse = np.linalg.inv(n @ E @ m.T + slopes[chosen] @ growth[chosen].T)
            rate = (trial[left] @ n.T - strength[left][:, chosen]) @ inverse.T
            end, grown = trial[left] - rate @ (m @ E), rate @ growth[chosen]
            over = end @ normals.T - strength[left] - grown @ slopes.T
            outside = np.maximum(over.max(axis=1), (-rate).max(axis=1) * elastic.shear) / scale[left]
            better = outside < least[left]
            at = left[better]
            ends[at], least[at], more[at] = end[better], outside[better], grown[better]
            moduli[at] = E - E @ m.T @ inverse @ n @ E
            left = left[least[left] > 10 * ON_LINE]
            if not left.size:
                break
        ends[:, 0] = np.maximum(ends[:, 0], 0.0)  # but for rounding, at the apex
        return ends, moduli, more


def _tangent(elastic: Isotropic, direction: FloatArray, kept: FloatArray, moduli: FloatArray) -> FloatArray:
    """Derivative of the stress by the strain, shape (q, 6, 6).

    Parameters
    ----------
    elastic : Of the intact material.
    direction : N = s/√J2 of the trial stress, shape (q, 6).
    kept : What is left of √J2, of the trial stress's, shape (q,).
    moduli : Derivatives of √J2 and p by N : ε and the volume, shape (q, 2, 2) [Pa].
    """
    axes = np.stack([direction, np.broadcast_to(UNIT, direction.shape)], axis=1)
    turned = 2 * DEVIATOR - direction[:, :, None] * direction[:, None, :]
    tangent: FloatArray = axes.transpose(0, 2, 1) @ moduli @ axes
    return tangent + elastic.shear * kept[:, None, None] * turned
