"""Plastic: what laws of plastic strain have in common once stress and flow of a step are known.

Internal variables are the plastic strain (6), the accumulated plastic strain, and what else a law keeps.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import SHEARS, BoolArray, FloatArray, Isotropic, MaterialLaw, Response

PLASTIC, ACCUMULATED = slice(0, 6), 6
STRAIN = "plastic_strain"
FrictionAngle = Annotated[float, Meta(ge=0, lt=90, extra={"unit": "deg"})]
CURE = "take f_c (1 - sin φ)/(2 cos φ), that of stone of compressive strength f_c and friction_angle φ"
Cohesion = Annotated[float, Meta(gt=0, extra={"unit": "Pa", "cure": CURE})]


class Plastic(MaterialLaw):
    """A law with plastic strains; all plastic work is dissipated."""

    __slots__ = ()

    variables: ClassVar[int] = 7

    def refuse_dilatancy(self, friction_angle: float, dilatancy_angle: float | None) -> None:
        """Raise LawError where a dilatancy angle is above the friction angle [degrees]."""
        if dilatancy_angle is not None and dilatancy_angle > friction_angle:
            raise LawError(
                f"law '{self.name}': dilatancy_angle is {dilatancy_angle:g}, expected at most the "
                f"friction_angle {friction_angle:g}, as flow would create energy; lower it, or leave it out"
            )

    def response(
        self,
        elastic: Isotropic,
        strains: tuple[FloatArray, FloatArray],
        committed: FloatArray,
        grown: FloatArray,
        others: FloatArray,
        stress: FloatArray,
        tangent: FloatArray,
        changed: BoolArray,
        more: FloatArray | float = 0.0,
    ) -> Response:
        """The response of q points.

        Parameters
        ----------
        elastic : Of the intact material.
        strains : At the start and the end of the step, each of shape (q, 6).
        committed : Internal variables at the start, shape (q, k).
        grown : Plastic strain of the step, shears as angles, shape (q, 6).
        others : The law's further internal variables at the end, shape (q, k − 7).
        stress, tangent : At the end, shapes (q, 6) and (q, 6, 6) [Pa].
        changed : Points that yield, shape (q,).
        more : What flow takes beyond the work of the end's stress on it, as strength falls in the step,
            shape (q,) [J/m³].
        """
        start, end = strains
        length = np.sqrt(2 / 3 * (grown * grown / SHEARS).sum(axis=1))  # of angles half counts, and twice
        plastic = committed[:, PLASTIC] + grown
        internal = np.column_stack([plastic, committed[:, ACCUMULATED] + length, others])
        change = end - start - grown
        return Response(
            stress=stress,
            tangent=tangent,
            internal=internal,
            stored=0.5 * (stress * (end - plastic)).sum(axis=1),
            dissipation=(stress * grown).sum(axis=1) + more,
            excess=0.5 * ((change @ elastic.matrix) * change).sum(axis=1) - more,
            changed=changed,
        )

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        return {STRAIN: internal[:, ACCUMULATED]}
