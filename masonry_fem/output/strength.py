"""Strength: what share of its strength a stress takes, and invariants of stresses (xx, yy, zz, xy, yz, xz).

    strengths = Strengths(tension, compression, 2.2, 0.05)      # of each block, characteristic
    utilisation(principal, strengths.tension_design, strengths.compression_design)

With principal stresses σ1 ≥ σ2 ≥ σ3, tension positive, and design strengths f_t and f_c the utilisation is

    u = ⟨σ1⟩/f_t + ⟨−σ3⟩/f_c,        ⟨x⟩ = max(x, 0).

Under pressure all round that is the greatest pressure over f_c: what lateral pressure adds to strength is
left aside. Between tension and compression it is the straight line from f_t to f_c, that of Mohr and Coulomb.
It grows in proportion to the stress, so that 1/u is the factor by which all stresses may grow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Strengths:
    """Strengths of b blocks, as the scene has them.

    Attributes
    ----------
    tension, compression : f_t and f_c, NaN where they are not known, shape (b,) [Pa].
    material_factor : What both are divided by.
    share : Of a stone's volume, over which its local utilisation is the mean.
    """

    tension: FloatArray
    compression: FloatArray
    material_factor: float = 1.0
    share: float = 0.05

    @property
    def tension_design(self) -> FloatArray:
        """f_t over the material factor, shape (b,) [Pa]."""
        return self.tension / self.material_factor

    @property
    def compression_design(self) -> FloatArray:
        """f_c over the material factor, shape (b,) [Pa]."""
        return self.compression / self.material_factor

    @property
    def known(self) -> Mask:
        """Blocks with a strength, shape (b,)."""
        known: Mask = ~(np.isnan(self.tension) & np.isnan(self.compression))
        return known


def utilisation(principal: FloatArray, tension: FloatArray, compression: FloatArray) -> FloatArray:
    """Utilisation of principal stresses; NaN where neither strength is known or there is no stress.

    Where one strength is not known, stresses of its sign do not count.

    Parameters
    ----------
    principal : Shape (..., 3), in any order [Pa].
    tension, compression : Design strengths, shape (...) [Pa].
    """
    parts = shares(principal, tension, compression)
    known = ~(np.isnan(tension) & np.isnan(compression)) & ~np.isnan(principal[..., 0])
    return np.where(known, parts.sum(axis=-1), np.nan)


def shares(principal: FloatArray, tension: FloatArray, compression: FloatArray) -> FloatArray:
    """What tension and compression add to the utilisation, shape (..., 2); 0 where a strength is not known.

    Parameters
    ----------
    principal : Shape (..., 3), in any order [Pa].
    tension, compression : Design strengths, shape (...) [Pa].
    """
    pulled = np.maximum(principal.max(axis=-1), 0.0) / tension
    pressed = np.maximum(-principal.min(axis=-1), 0.0) / compression
    return np.nan_to_num(np.stack([pulled, pressed], axis=-1))


def tensor(stress: FloatArray) -> FloatArray:
    """The symmetric matrices of components (..., 6), shape (..., 3, 3)."""
    components: FloatArray = stress[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]]
    matrices: FloatArray = components.reshape(*stress.shape[:-1], 3, 3)
    return matrices


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises equivalent of stresses (..., 6), same unit, shape (...)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    normal = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
    squared: FloatArray = normal + 3.0 * (xy**2 + yz**2 + xz**2)
    return np.sqrt(squared)


def principal(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal stresses, largest (most tensile) first, (..., 3), and unit directions, rows, (..., 3, 3)."""
    values, vectors = np.linalg.eigh(tensor(stress))
    return values[..., ::-1], np.swapaxes(vectors, -1, -2)[..., ::-1, :]
