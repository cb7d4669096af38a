"""Mohr–Coulomb: friction and cohesion of geomaterials by a pyramid, with a cut-off of tension.

MohrCoulomb(cohesion=2e6, friction_angle=35.0, dilatancy_angle=10.0, tension_strength=0.4e6)

With principal stresses σ1 ≥ σ2 ≥ σ3 (tension positive), for each pair i < j and each i

    (1 + sin φ) σ_i − (1 − sin φ) σ_j ≤ 2 c cos φ,      σ_i ≤ f_t

The first flow by 1 + sin ψ and −(1 − sin ψ) along their axes, the cut-off along its own. All are planes in
principal stresses, and elasticity is linear: a step (backward Euler) ends on a plane, on the line of two or
in the point of three of them, exactly; which one is found by trying each of them for flow that is nowhere
negative and stress that is nowhere outside. f_t is at most c cot φ, so that the cut-off takes the apex, too.

References
----------
Clausen, Damkilde, Andersen, Efficient return algorithms for associated plasticity with multiple yield planes,
Int. J. Numer. Meth. Engng 66 (2006). The turn of principal axes: de Souza Neto, Perić, Owen, Computational
Methods for Plasticity (Wiley 2008), A.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.fem.material_law import SHEARS, BoolArray, FloatArray, Isotropic, Response
from masonry_fem.fem.materials.parts.plastic import PLASTIC, FrictionAngle, Plastic
from masonry_fem.fem.materials.parts.principal import principal, tangents, tensors

# of the strength and the trial stress: what is outside by less is inside
INSIDE = 1e-13
PAIRS = ((0, 2), (1, 2), (0, 1))  # of the planes of friction; after them those of the cut-off, by axis
# the planes that a stress may end on, few first; B and C bear on A at equal principal stresses
ENDS = (
    (0,), (3,), (0, 1), (0, 2), (0, 3), (3, 4),
    (0, 1, 3), (0, 1, 4), (0, 3, 4), (1, 3, 4), (0, 2, 3), (3, 4, 5),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class MohrCoulomb(Plastic):
    """Friction and cohesion by a pyramid with edges and apex, and a cut-off of tension; perfectly plastic.

    All plastic work is dissipated.

    Attributes
    ----------
    cohesion : cohesion c
    friction_angle : friction angle φ
    dilatancy_angle : dilatancy angle ψ, the growth of volume with shear, at most φ; equal to φ if left out
        (associated flow)
    tension_strength : greatest principal stress f_t; c cot φ, the apex, if left out or if that is less

    Examples
    --------
    law = "mohr_coulomb"
    cohesion = "2 MPa"
    friction_angle = 35
    dilatancy_angle = 10
    tension_strength = "0.4 MPa"
    """

    cohesion: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})]
    friction_angle: FrictionAngle
    dilatancy_angle: FrictionAngle | None = None
    tension_strength: Annotated[float, Meta(gt=0, extra={"unit": "Pa"})] | None = None

    name: ClassVar[str] = "mohr_coulomb"

    def __post_init__(self) -> None:
        """Refuse parameters out of their range, and a dilatancy above the friction."""
        super(MohrCoulomb, self).__post_init__()  # with slots the class is another
        self.refuse_dilatancy(self.friction_angle, self.dilatancy_angle)

    @property
    def tension(self) -> float:
        """The cut-off f_t [Pa]; infinite where neither it nor friction bounds tension."""
        sine, cosine = _sine_cosine(self.friction_angle)
        apex = self.cohesion * cosine / sine if sine > 0 else math.inf
        return apex if self.tension_strength is None else min(self.tension_strength, apex)

    @property
    def planes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Normals n, flows m and bounds of n · σ ≤ bound: shapes (6, 3), (6, 3), (6,) [Pa]."""
        sine, cosine = _sine_cosine(self.friction_angle)
        own = self.friction_angle if self.dilatancy_angle is None else self.dilatancy_angle
        flowing = _sine_cosine(own)[0]
        normals, flows = np.zeros((6, 3)), np.zeros((6, 3))
        for row, (i, j) in enumerate(PAIRS):
            normals[row, [i, j]] = 1 + sine, -(1 - sine)
            flows[row, [i, j]] = 1 + flowing, -(1 - flowing)
        normals[3:] = flows[3:] = np.eye(3)
        bounds = np.array([2 * self.cohesion * cosine] * 3 + [self.tension] * 3)
        return normals, flows, bounds

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
        scale = 2 * self.cohesion + np.abs(values).max(axis=1)
        yields = ((values @ normals.T - bounds) > INSIDE * scale[:, None]).any(axis=1)
        tangent = np.tile(matrix, (len(stress), 1, 1))
        grown = np.zeros_like(stress)
        if yields.any():
            ends, moduli = self._returned(elastic, values[yields], scale[yields])
            trial, own = values[yields], axes[yields]
            tangent[yields] = tangents(moduli, _shears(elastic, trial, ends, moduli), own)
            flow = np.linalg.solve(matrix[:3, :3], (trial - ends).T).T
            stress[yields] = tensors(ends, own)
            grown[yields] = SHEARS * tensors(flow, own)
        nothing = np.zeros((len(stress), 0))
        return self.response(elastic, (start, strain), committed, grown, nothing, stress, tangent, yields)

    def _returned(
        self, elastic: Isotropic, trial: FloatArray, scale: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Principal stresses (q, 3) at the end, and their derivatives by principal strains (q, 3, 3).

        Parameters
        ----------
        elastic : Of the intact material.
        trial : Principal trial stresses, some outside, shape (q, 3) [Pa].
        scale : Sizes of stress by which rounding is told, shape (q,) [Pa].
        """
        D = elastic.matrix[:3, :3]
        normals, flows, bounds = self.planes
        ends, moduli = trial.copy(), np.tile(D, (len(trial), 1, 1))
        least = np.full(len(trial), np.inf)
        left: BoolArray = np.ones(len(trial), dtype=bool)
        for planes in ENDS:
            chosen = list(planes)
            if not np.isfinite(bounds[chosen]).all():
                continue
            n, m = normals[chosen], flows[chosen]
            inverse = np.linalg.inv(n @ D @ m.T)
            rate = (trial[left] @ n.T - bounds[chosen]) @ inverse.T
            end = trial[left] - rate @ (m @ D)
            # flow as the stress that it takes away, and the stress outside
            outside = np.maximum((end @ normals.T - bounds).max(axis=1), (-rate).max(axis=1) * elastic.shear)
            outside /= scale[left]
            better = outside < least[left]
            at = np.flatnonzero(left)[better]
            ends[at], least[at] = end[better], outside[better]
            moduli[at] = D - (D @ m.T) @ inverse @ (n @ D)
            left = least > INSIDE * 10
            if not left.any():
                break
        return ends, moduli


def _sine_cosine(angle: float) -> tuple[float, float]:
    """Of an angle [degrees]."""
    return math.sin(math.radians(angle)), math.cos(math.radians(angle))


def _shears(elastic: Isotropic, trial: FloatArray, ends: FloatArray, moduli: FloatArray) -> FloatArray:
    """τ over γ in the planes of the axes, as these turn with the strain, shape (q, 3) [Pa].

    G (σ_i − σ_j)/(σ_i,trial − σ_j,trial), and where the trial stresses are equal the limit ½ (D_ii − D_ij).
    """
    pairs = ((0, 1), (1, 2), (0, 2))
    shears = np.empty_like(trial)
    for row, (i, j) in enumerate(pairs):
        apart = trial[:, i] - trial[:, j]
        equal = apart <= 1e-8 * (np.abs(trial).max(axis=1) + elastic.shear * 1e-12)
        ratio = (ends[:, i] - ends[:, j]) / np.where(equal, 1.0, apart)
        limit = 0.5 * (moduli[:, i, i] - moduli[:, i, j])
        shears[:, row] = np.where(equal, limit, elastic.shear * ratio)
    return shears
