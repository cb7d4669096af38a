"""Mohr–Coulomb: friction and cohesion of geomaterials by a pyramid, with a cut-off of tension.

MohrCoulomb(cohesion=2e6, friction_angle=35.0, dilatancy_angle=10.0, tensile_strength=0.4e6)

With principal stresses σ1 ≥ σ2 ≥ σ3 (tension positive), for each pair i < j and each i

    (1 + sin φ) σ_i − (1 − sin φ) σ_j ≤ 2 c cos φ,      σ_i ≤ f_t

The first flow by λ times 1 + sin ψ and −(1 − sin ψ) along their axes, the cut-off by λ along its own. All
are planes in principal stresses, and elasticity is linear: a step (backward Euler) ends on a plane, on the
line of two or in the point of three of them, exactly; which one is found by trying each of them for flow that
is nowhere negative and stress that is nowhere outside. f_t is at most c cot φ, so that the cut-off takes the
apex, too.

Strengths are linear in one more variable z, so that this remains so. Where the stone hardens, z is its slip
on planes of failure, ż = Σ 2 cos φ λ, the cohesion c + H z, and the cut-off stays. Where it softens, c and
f_t fall together to r c and r f_t at z = 1,

    c(z) = c (1 − (1 − r) z),     ż = (1 − r) h (c/(2 G_s) Σ 2 cos φ λ + f_t/(2 G_f) Σ λ_cut-off)

so that beyond what remains tension alone takes G_f per area of a crack, whatever the width h of its band of
elements, and associated slip alone takes G_s. Steps that come to z = 1 end with the strengths that remain.

References
----------
Clausen, Damkilde, Andersen, Efficient return algorithms for associated plasticity with multiple yield planes,
Int. J. Numer. Meth. Engng 66 (2006). The turn of principal axes: de Souza Neto, Perić, Owen, Computational
Methods for Plasticity (Wiley 2008), A.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import SHEARS, FloatArray, Isotropic, Response
from masonry_fem.fem.materials.parts.plastic import PLASTIC, Cohesion, FrictionAngle, Plastic
from masonry_fem.fem.materials.parts.principal import principal, sheared, tangents, tensors
from masonry_fem.fem.materials.parts.slip import sine_cosine, slip_planes

# of the strength and the trial stress: what is outside by less is inside
INSIDE = 1e-13
SLIP, CUT = slice(0, 3), slice(3, 6)  # the planes of friction, and those of the cut-off
# the planes that a stress may end on, few first: those of friction, and of the cut-off by axis
ENDS = (
    (0,), (3,), (0, 1), (0, 2), (0, 3), (3, 4),
    (0, 1, 3), (0, 1, 4), (0, 3, 4), (1, 3, 4), (0, 2, 3), (3, 4, 5),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class MohrCoulomb(Plastic):
    """Friction and cohesion by a pyramid with edges and apex, and a cut-off of tension.

    Perfectly plastic, or with a cohesion that grows with slip (`hardening`), or with cohesion and tensile
    strength that are lost together as the stone cracks and slips (`fracture_energy`,
    `shear_fracture_energy`). Strains then localise in one row of elements, and the law softens by its width,
    so that a crack takes the same energy on any mesh. All plastic work is dissipated.

    Attributes
    ----------
    cohesion : cohesion c
    friction_angle : friction angle φ
    dilatancy_angle : dilatancy angle ψ, the growth of volume with shear, at most φ; equal to φ if left out
        (associated flow)
    tensile_strength : greatest principal stress f_t; c cot φ, the apex, if left out or if that is less
    hardening : slope H of the cohesion over the plastic slip
    fracture_energy : energy G_f per area that cracks by tension take as strength is lost; if left out, they
        take none of it
    shear_fracture_energy : energy G_s per area that slip takes as cohesion is lost, friction apart; if left
        out, slip takes none of it
    residual : share r of cohesion and tensile strength that is never lost

    Examples
    --------
    law = "mohr_coulomb"
    cohesion = "2 MPa"
    friction_angle = 35
    dilatancy_angle = 10
    tensile_strength = "0.4 MPa"
    """

    cohesion: Cohesion
    friction_angle: FrictionAngle
    dilatancy_angle: FrictionAngle | None = None
    tensile_strength: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})] | None = None
    hardening: Annotated[float, Meta(ge=0, extra={"unit": "Pa"})] = 0.0
    fracture_energy: Annotated[float, Meta(gt=0, extra={"unit": "J/m^2"})] | None = None
    shear_fracture_energy: Annotated[float, Meta(gt=0, extra={"unit": "J/m^2"})] | None = None
    residual: Annotated[float, Meta(ge=0, lt=1)] = 0.0

    name: ClassVar[str] = "mohr_coulomb"
    variables: ClassVar[int] = 8  # those of Plastic, z

    def __post_init__(self) -> None:
        """Refuse parameters out of their range, a dilatancy above the friction, and what contradicts."""
        super(MohrCoulomb, self).__post_init__()  # with slots the class is another
        self.refuse_dilatancy(self.friction_angle, self.dilatancy_angle)
        if self.softens and self.hardening:
            raise LawError(
                f"law '{self.name}': hardening is {self.hardening:g} beside a fracture energy, expected one "
                "of both; leave one out"
            )
        if self.residual and not self.softens:
            raise LawError(
                f"law '{self.name}': residual is {self.residual:g}, but nothing is lost, expected a "
                "fracture_energy or shear_fracture_energy beside it; add one, or leave residual out"
            )
        if self.fracture_energy is not None and math.isinf(self.tension):
            raise LawError(
                f"law '{self.name}': fracture_energy is {self.fracture_energy:g}, but without friction "
                "nothing bounds tension, expected a tensile_strength beside it; add one"
            )

    @property
    @override
    def softens(self) -> bool:
        return self.fracture_energy is not None or self.shear_fracture_energy is not None

    @property
    def tension(self) -> float:
        """The cut-off f_t [Pa]; infinite where neither it nor friction bounds tension."""
        sine, cosine = sine_cosine(self.friction_angle)
        apex = self.cohesion * cosine / sine if sine > 0 else math.inf
        return apex if self.tensile_strength is None else min(self.tensile_strength, apex)

    @property
    def planes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Normals n, flows m and bounds of n · σ ≤ bound: shapes (6, 3), (6, 3), (6,) [Pa]."""
        cosine = sine_cosine(self.friction_angle)[1]
        normals, flows = np.eye(6, 3, -3), np.eye(6, 3, -3)
        normals[SLIP], flows[SLIP] = slip_planes(self.friction_angle, self.dilatancy_angle)
        bounds = np.array([2 * self.cohesion * cosine] * 3 + [self.tension] * 3)
        return normals, flows, bounds

    def _strengths(self, size: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of the bounds by z, shape (6,) [Pa], and of z by the planes' λ, shape (q, 6).

        Parameters
        ----------
        size : Of the elements at q points, shape (q,) [m].
        """
        bounds, slip = self.planes[2], 2 * sine_cosine(self.friction_angle)[1]
        change, growth = np.zeros(6), np.zeros((len(size), 6))
        if self.softens:
            lost = 1 - self.residual
            change = np.where(np.isinf(bounds), 0.0, -lost * bounds)
            if self.shear_fracture_energy is not None:
                growth[:, SLIP] = (lost * self.cohesion * slip / (2 * self.shear_fracture_energy) * size)[
                    :, None
                ]
            if self.fracture_energy is not None:
                growth[:, CUT] = lost * self.tension / (2 * self.fracture_energy) * size[:, None]
        elif self.hardening:
            change[SLIP], growth[:, SLIP] = self.hardening * slip, slip
        return change, growth

    @override
    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:
        """Elements so large that stress would fall faster than elasticity lets strains go on."""
        if not self.softens:
            return
        normals, flows, bounds = self.planes
        change, growth = self._strengths(np.ones(1))
        D = elastic.matrix[:3, :3]
        rates = [0.0]  # 1/h at which it is so, on each end, and for bars along each axis
        for planes in ENDS:
            chosen = list(planes)
            if np.isfinite(bounds[chosen]).all():
                stiff = normals[chosen] @ D @ flows[chosen].T
                rates.append(-float(growth[0, chosen] @ np.linalg.solve(stiff, change[chosen])))
        for plane in (0, 3):
            bar = elastic.young * normals[plane] * flows[plane]
            rates += [-float(growth[0, plane] * change[plane] / one) for one in bar[bar > 0]]
        widest = 1 / max(rates) if max(rates) > 0 else math.inf
        if size.max() >= widest:
            raise LawError(
                f"law '{self.name}': elements are up to {size.max():.3g} m wide, expected less than "
                f"{widest:.3g} m, as a crack in them would give back more energy than it takes; take smaller "
                "elements (mesh.size), or a larger fracture_energy or shear_fracture_energy"
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
        matrix = elastic.matrix
        stress = (strain - committed[:, PLASTIC]) @ matrix
        values, axes = principal(stress)
        normals, _, bounds = self.planes
        change, growth = self._strengths(np.broadcast_to(size, (len(strain),)))
        z = committed[:, 7].copy()
        scale = 2 * self.cohesion + np.abs(values).max(axis=1)
        outside = values @ normals.T - bounds - z[:, None] * change
        yields = (outside > INSIDE * scale[:, None]).any(axis=1)
        tangent = np.tile(matrix, (len(stress), 1, 1))
        grown, more = np.zeros_like(stress), np.zeros(len(stress))
        if yields.any():
            trial, own = values[yields], axes[yields]
            given = scale[yields], z[yields], growth[yields]
            ends, moduli, z[yields], more[yields] = self._returned(elastic, trial, *given)
            tangent[yields] = tangents(moduli, sheared(trial / (2 * elastic.shear), ends, moduli), own)
            flow = np.linalg.solve(matrix[:3, :3], (trial - ends).T).T
            stress[yields] = tensors(ends, own)
            grown[yields] = SHEARS * tensors(flow, own)
        strains = start, strain
        return self.response(elastic, strains, committed, grown, z[:, None], stress, tangent, yields, more)

    def _returned(
        self, elastic: Isotropic, trial: FloatArray, scale: FloatArray, before: FloatArray, growth: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """The ends of steps.

        These are principal stresses (q, 3), their derivatives by principal strains (q, 3, 3), z (q,), and
        what flow takes more than with the strengths of the end, (q,) [J/m³].

        Parameters
        ----------
        elastic : Of the intact material.
        trial : Principal trial stresses, some outside, shape (q, 3) [Pa].
        scale : Sizes of stress by which rounding is told, shape (q,) [Pa].
        before : z at the start, shape (q,). growth : Of z by λ of each plane, shape (q, 6).
        """
        D = elastic.matrix[:3, :3]
        normals, flows, bounds = self.planes
        change = self._strengths(np.ones(1))[0]
        ends, moduli, reached = trial.copy(), np.tile(D, (len(trial), 1, 1)), before.copy()
        more = np.zeros(len(trial))
        least = np.full(len(trial), np.inf)
        left = np.arange(len(trial))
        for spent, planes in product((False, True) if self.softens else (False,), ENDS):
            chosen = list(planes)
            if not np.isfinite(bounds[chosen]).all():
                continue
            n, m, z = normals[chosen], flows[chosen], before[left]
            falls = np.zeros(len(chosen)) if spent else change[chosen]
            own = np.ones(len(left)) if spent else z
            stiff = n @ D @ m.T + falls[:, None] * growth[left][:, None, chosen]
            inverse = np.linalg.inv(stiff)
            over = trial[left] @ n.T - bounds[chosen] - own[:, None] * change[chosen]
            rate = np.matmul(inverse, over[:, :, None])[:, :, 0]
            end = trial[left] - rate @ (m @ D)
            grown = z + (rate * growth[left][:, chosen]).sum(axis=1)
            z = np.ones(len(left)) if spent else grown
            # flow as the stress that it takes away, the stress outside, and z on the wrong side of 1
            outside = np.maximum(
                (end @ normals.T - bounds - z[:, None] * change).max(axis=1),
                (-rate).max(axis=1) * elastic.shear,
            )
            if self.softens:
                outside = np.maximum(outside, (1 - grown if spent else grown - 1) * self.cohesion)
            outside /= scale[left]
            better = outside < least[left]
            at = left[better]
            ends[at], least[at], reached[at] = end[better], outside[better], z[better]
            # strengths change along a straight line with the flow, and no more from z = 1 on
            gone, whole = z - before[left], grown - before[left]
            mean = 0.5 * gone**2 / np.where(whole > 0, whole, np.inf)
            more[at] = (-mean * (rate @ change[chosen]))[better]
            moduli[at] = D - (D @ m.T) @ inverse[better] @ (n @ D)
            left = left[least[left] > INSIDE * 10]
            if not left.size:
                break
        return ends, moduli, reached, more
