"""PlaneStress: any material law between free faces, where σ_zz = 0.

    law = PlaneStress(DruckerPrager(cohesion=2e6, friction_angle=35.0))

The strain ε_zz follows from the law itself: at each point it is the root of σ_zz(ε_zz) = 0 in the step, by
Newton's method, which is kept between strains where σ_zz is below and above 0. It is remembered, as the last
of the internal variables. The tangent is condensed, D_ab − D_az D_zb/D_zz, and consistent with the step. As
laws are isotropic, σ_yz and σ_xz vanish with their strains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import override

import numpy as np

from masonry_fem.fem.material_law import FloatArray, Isotropic, MaterialLaw, Response

ROUNDING = 4e-16  # σ_zz that is none, of the greatest modulus times the greatest strain
FLAT = 1e-10  # of the elastic modulus: a slope below is no guide to the root
ROUNDS = 200
HALVED = 8  # each such round halves the bracket, whatever Newton's method says


@dataclass(frozen=True, slots=True)
class PlaneStress(MaterialLaw):
    """A law whose ε_zz is such that σ_zz = 0, whatever ε_zz it is given.

    Attributes
    ----------
    law : The law of three dimensions.
    """

    law: MaterialLaw

    def __post_init__(self) -> None:
        """The law has checked its own parameters."""

    @property
    def name(self) -> str:  # type: ignore[override]  # of the law
        """That of the law."""
        return self.law.name

    @property
    def variables(self) -> int:  # type: ignore[override]  # of the law, and ε_zz
        """Those of the law, and ε_zz."""
        return self.law.variables + 1

    @property
    @override
    def softens(self) -> bool:
        return self.law.softens

    @override
    def initial(self, count: int) -> FloatArray:
        return np.column_stack([self.law.initial(count), np.zeros(count)])

    @override
    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:
        self.law.refuse(elastic, size)

    @override
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        matrix, before = elastic.matrix, committed[:, :-1]
        start, strain = start.copy(), strain.copy()
        narrowing = -matrix[2, 0] / matrix[2, 2]
        # what has no memory yet was elastic until now, and may have been strained
        fresh = (committed == self.initial(len(start))).all(axis=1)
        start[:, 2] = np.where(fresh, narrowing * start[:, :2].sum(axis=1), committed[:, -1])
        # as if the step were elastic
        strain[:, 2] = start[:, 2] + narrowing * (strain - start)[:, :2].sum(axis=1)
        size = np.broadcast_to(size, (len(strain),))
        made = self.law.update(elastic, start, strain, before, size)
        small = ROUNDING * matrix.max() * np.maximum(np.abs(strain), np.abs(start)).max(axis=1)
        left = np.flatnonzero(np.abs(made.stress[:, 2]) > small)
        if left.size:
            part = start[left], strain[left], before[left], size[left]
            strain[left, 2] = self._free(elastic, part, (made.stress[left], made.tangent[left]), small[left])
            made = self.law.update(elastic, start, strain, before, size)
        elastic_one, changed = _condensed(matrix[None]), made.changed[:, None, None]
        tangent = np.where(changed, _condensed(made.tangent), elastic_one)
        held = None if made.held is None else np.where(changed, _condensed(made.held), elastic_one)
        stress = made.stress.copy()
        stress[:, 2] = 0.0
        return replace(
            made,
            stress=stress,
            tangent=tangent,
            internal=np.column_stack([made.internal, strain[:, 2]]),
            held=held,
        )

    def _free(
        self,
        elastic: Isotropic,
        step: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
        first: tuple[FloatArray, FloatArray],
        small: FloatArray,
    ) -> FloatArray:
        """ε_zz of a step that ends without σ_zz, shape (q,).

        Parameters
        ----------
        elastic : Of the intact material.
        step : Strains of start and end, internal variables of the law, sizes, each of q points.
        first : Stress and tangent at that end. small : σ_zz that is none, shape (q,) [Pa].
        """
        start, end, committed, size = step
        end, (stress, tangent) = end.copy(), first
        modulus, left = elastic.matrix[2, 2], np.arange(len(end))
        low, high = np.full(len(end), -np.inf), np.full(len(end), np.inf)
        for turn in range(1, ROUNDS):
            here, value, slope = end[left, 2], stress[:, 2], tangent[:, 2, 2]
            low[left] = np.where(value < 0, here, low[left])
            high[left] = np.where(value > 0, here, high[left])
            below, above = low[left], high[left]
            # where σ_zz hardly grows, strides grow until the root is between two strains
            moved = here - value / np.where(slope > FLAT * modulus, slope, modulus / 2.0 ** min(turn, 60))
            between = (moved > below) & (moved < above)
            if turn % HALVED == 0:
                between &= np.isinf(above - below)
            moved = np.where(between, moved, 0.5 * (below + above))
            end[left, 2] = moved
            made = self.law.update(elastic, start[left], end[left], committed[left], size[left])
            on = (np.abs(made.stress[:, 2]) > small[left]) & (moved != here)
            left, stress, tangent = left[on], made.stress[on], made.tangent[on]
            if not left.size:
                break
        return end[:, 2]

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        return self.law.measures(internal[:, :-1])


def _condensed(tangent: FloatArray) -> FloatArray:
    """Moduli (q, 6, 6) of points whose σ_zz stays 0; zero in the row and the column of zz."""
    own = tangent[:, 2, 2]
    steep = np.abs(own) > FLAT * np.abs(tangent).max(axis=(1, 2))
    taken = tangent[:, :, 2, None] * tangent[:, None, 2, :] / np.where(steep, own, np.inf)[:, None, None]
    made = tangent - taken
    made[:, 2], made[:, :, 2] = 0.0, 0.0
    return made
