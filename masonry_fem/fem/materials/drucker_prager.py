"""Drucker–Prager: friction and cohesion of geomaterials by a smooth cone, with a dilatancy of its own.

DruckerPrager(cohesion=2e6, friction_angle=35.0, dilatancy_angle=10.0)

With J2 = ½ s : s of the deviator s and the mean stress p (tension positive)

    f = √J2 + η p − ξ c(κ) ≤ 0,      c(κ) = c + H κ,      Δε_p = Δγ (s/(2√J2) + η̄/3 I),      Δκ = ξ Δγ

Steps are implicit (backward Euler), so that the end's stress is on the cone, exactly, at its apex too: where
the cone's flow would overshoot the axis, the deviator is used up, Δγ = √J2_trial/G, and a second flow along
the axis brings p to the apex ξ c(κ)/η; it hardens by ξ/η times its volume. This holds for every dilatancy,
0 included.

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

from masonry_fem.fem.material_law import (
    DEVIATOR,
    SHEARS,
    UNIT,
    BoolArray,
    FloatArray,
    Isotropic,
    Response,
)
from masonry_fem.fem.materials.parts.plastic import PLASTIC, FrictionAngle, Plastic

# of ξ c + |trial stress|: a trial stress that is outside by less is on the cone
ON_CONE = 1e-14


@dataclass(frozen=True, slots=True)
class DruckerPrager(Plastic):
    """Friction and cohesion by a smooth cone, perfectly plastic or hardening, with separate dilatancy.

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
    fit : which strength the cone shares with that of Mohr and Coulomb

    Examples
    --------
    law = "drucker_prager"
    cohesion = "2 MPa"
    friction_angle = 35
    dilatancy_angle = 10
    """

    cohesion: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
    friction_angle: FrictionAngle
    dilatancy_angle: FrictionAngle | None = None
    hardening: Annotated[float, Meta(ge=0, extra={"unit": "Pa"})] = 0.0
    fit: Literal["compression", "tension", "plane_strain"] = "compression"

    name: ClassVar[str] = "drucker_prager"
    variables: ClassVar[int] = 8  # those of Plastic, κ

    def __post_init__(self) -> None:
        """Refuse parameters out of their range, and a dilatancy above the friction."""
        super(DruckerPrager, self).__post_init__()  # with slots the class is another
        self.refuse_dilatancy(self.friction_angle, self.dilatancy_angle)

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

    @override
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        K, G, H = elastic.bulk, elastic.shear, self.hardening
        eta, xi, eta_bar = self.cone
        matrix = elastic.matrix
        plastic, kappa = committed[:, PLASTIC], committed[:, 7]
        trial = (strain - plastic) @ matrix
        p = trial[:, :3].sum(axis=1) / 3
        s = trial - p[:, None] * UNIT
        root = np.sqrt(0.5 * (SHEARS * s * s).sum(axis=1))
        strength = xi * (self.cohesion + H * kappa)
        over = root + eta * p - strength
        yields = over > ON_CONE * (strength + root + np.abs(eta * p))
        A = G + K * eta * eta_bar + xi**2 * H
        flow = np.where(yields, over / A, 0.0)
        tip = yields & (root < G * flow)  # cone's flow would turn the deviator round
        flow[tip] = root[tip] / G
        direction = s / np.where(root > 0, root, 1.0)[:, None]  # N, with N : N = 2
        volume = eta_bar * flow  # plastic
        hardened = xi * flow
        if tip.any():
            left = p[tip] - K * volume[tip] - (strength[tip] + xi * H * hardened[tip]) / eta
            extra = left / (K + (xi / eta) ** 2 * H)
            volume[tip] += extra
            hardened[tip] += xi / eta * extra
        deviator = np.where(tip, 0.0, root - G * flow)[:, None] * direction
        stress = np.where(yields[:, None], deviator + (p - K * volume)[:, None] * UNIT, trial)
        # strains by angles
        grown = SHEARS * (0.5 * flow[:, None] * direction) + volume[:, None] / 3 * UNIT
        tangent = self._tangent(elastic, yields, tip, flow, root, direction)
        others = (kappa + hardened)[:, None]
        return self.response(elastic, (start, strain), committed, grown, others, stress, tangent, yields)

    def _tangent(
        self,
        elastic: Isotropic,
        yields: BoolArray,
        tip: BoolArray,
        flow: FloatArray,
        root: FloatArray,
        direction: FloatArray,
    ) -> FloatArray:
        """Derivative of the stress by the strain, shape (q, 6, 6)."""
        K, G, H = elastic.bulk, elastic.shear, self.hardening
        eta, xi, eta_bar = self.cone
        tangent = np.tile(elastic.matrix, (len(flow), 1, 1))
        cone = yields & ~tip
        if cone.any():
            N = direction[cone]
            A = G + K * eta * eta_bar + xi**2 * H
            shrink = G * flow[cone] / root[cone]
            taken = (G * N + K * eta_bar * UNIT)[:, :, None] * (G * N + K * eta * UNIT)[:, None, :] / A
            turned = N[:, :, None] * N[:, None, :]
            tangent[cone] += (
                -2 * G * shrink[:, None, None] * DEVIATOR + G * shrink[:, None, None] * turned - taken
            )
        if tip.any():
            N, whole = direction[tip], K + (xi / eta) ** 2 * H
            kept = K * (xi / eta) ** 2 * H / whole
            sheared = K * (K * eta_bar + xi**2 / eta * H) / whole - K * eta_bar
            tangent[tip] = UNIT[:, None] * (kept * UNIT + sheared * N)[:, None, :]
        return tangent
