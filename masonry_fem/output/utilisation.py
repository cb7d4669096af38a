"""Utilisation: how much of its strength each stone uses, at its points, over a stated volume and in the mean.

    told = stone_utilisation(model, state, strengths)
    told.local[b], told.error[b], told.greatest[b]

Stress at corners and edges of contacts is singular: the ``greatest`` of a stone depends on its elements. The
``local`` utilisation is the mean over a stated share of the stone's volume, its most utilised points. No part
of the stone that is as large has a greater mean, and it converges as elements become smaller.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import StressError
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.mean_stress import mean_stress
from masonry_fem.output.strength import Strengths, principal, shares, utilisation

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]
PERCENTILE = 0.95  # 5 % of the volume have more
COMPONENTS = {2: 3, 3: 6}  # of a stress, among which an error of any direction is spread


@dataclass(frozen=True, slots=True)
class StoneUtilisation:
    """b blocks; NaN where nothing is known: supports, and all but means of rigid stones.

    Attributes
    ----------
    volume : Shape (b,) [m³; m² in 2D].
    stress : Mean stress, shape (b, 6), and its principal values, greatest first, (b, 3) [Pa].
    of_mean : Utilisation of the mean stress, shape (b,).
    local : Mean over the stated share of the volume, shape (b,). error : Estimated error of it, shape (b,).
    p95 : What 5 % of the volume exceed, shape (b,). greatest : At one point, shape (b,).
    at_greatest : Principal stresses there, greatest first, shape (b, 3) [Pa].
    parts : What tension and compression have of the greatest, of rigid stones of that of the mean, (b, 2).
    yielded : Stones whose material has reached its strength somewhere, shape (b,).
    """

    volume: FloatArray
    stress: FloatArray
    principal: FloatArray
    of_mean: FloatArray
    local: FloatArray
    error: FloatArray
    p95: FloatArray
    greatest: FloatArray
    at_greatest: FloatArray
    parts: FloatArray
    yielded: Mask

    @property
    def ranking(self) -> FloatArray:
        """The local utilisation, of rigid stones that of the mean stress, shape (b,)."""
        return np.where(np.isnan(self.local), self.of_mean, self.local)


def stone_utilisation(model: Model, state: SystemState, strengths: Strengths) -> StoneUtilisation:
    """Utilisation of all stones.

    Parameters
    ----------
    model : The structure of b blocks.
    state : A state of it.
    strengths : Of the blocks.
    """
    count = len(model.assembly.blocks)
    stress, volume = mean_stress(model, state)
    values = np.full((count, 3), np.nan)
    real = ~np.isnan(stress[:, 0])
    values[real] = principal(stress[real])[0]
    tension, compression = strengths.tension_design, strengths.compression_design
    local, error, p95, greatest = np.full((4, count), np.nan)
    at_greatest, parts = np.full((count, 3), np.nan), np.full((count, 2), np.nan)
    yielded = np.zeros(count, dtype=bool)
    for group, moved in zip(model.groups, state.bodies, strict=True):
        field = group.stress(moved)
        if field is None:
            continue
        blocks, b = group.blocks, len(group.blocks)
        gauss, weight = field.gauss.reshape(b, -1, 6), field.weight.ravel()
        points = principal(gauss)[0]
        used = utilisation(points, tension[blocks, None], compression[blocks, None])
        spent = _spent(group, moved, used.shape)
        yielded[blocks] = spent.any(axis=1)
        # a point that has yielded was at its strength, whatever stress is left there
        used = np.where(spent, np.fmax(used, strengths.material_factor), used)
        region = worst_region(used, weight, strengths.share)
        local[blocks] = (region * used).sum(axis=1) / region.sum(axis=1)
        p95[blocks] = _quantile(used, weight)
        top = np.where(np.isnan(used), -1.0, used).argmax(axis=1)
        rows = np.arange(b)
        greatest[blocks], at_greatest[blocks] = used[rows, top], points[rows, top]
        parts[blocks] = shares(points[rows, top], tension[blocks], compression[blocks])
        slope = _slope(points, tension[blocks, None], compression[blocks, None])
        told = group.stress_error(moved)
        assert told is not None  # what has stresses has it
        estimate = _error(told, gauss, weight, region, slope)
        error[blocks] = estimate / np.sqrt(COMPONENTS[model.assembly.dimension])
    means = shares(values, tension, compression)
    parts = np.where(np.isnan(parts), means, parts)  # rigid stones
    error[~strengths.known] = np.nan
    return StoneUtilisation(
        volume, stress, values, utilisation(values, tension, compression), local, error, p95, greatest,
        at_greatest, parts, yielded,
    )  # fmt: skip


def worst_region(used: FloatArray, weight: FloatArray, share: float) -> FloatArray:
    """The part of each point's volume that belongs to the most utilised share of its stone, shape (b, q).

    Parameters
    ----------
    used : Utilisation at q points of b stones, shape (b, q).
    weight : Volume of each point, shape (q,) [m³].
    share : Of the volume, above 0, at most 1.
    """
    order = np.argsort(-used, axis=1, kind="stable")
    sorted_weight = weight[order]
    before = np.cumsum(sorted_weight, axis=1) - sorted_weight
    taken = np.clip(share * weight.sum() - before, 0.0, sorted_weight)
    region = np.empty_like(taken)
    np.put_along_axis(region, order, taken, axis=1)
    return region


def _quantile(used: FloatArray, weight: FloatArray) -> FloatArray:
    """Least utilisation that all but 5 % of the volume do not exceed, shape (b,)."""
    order = np.argsort(used, axis=1, kind="stable")
    below = np.cumsum(weight[order], axis=1)
    at = (below < PERCENTILE * below[:, -1:]).sum(axis=1)
    quantile: FloatArray = np.take_along_axis(used, order, axis=1)[np.arange(len(used)), at]
    return quantile


def _spent(group: Any, moved: Any, shape: tuple[int, ...]) -> Mask:
    """Points at which the material law remembers that the strength was reached."""
    spent = np.zeros(shape, dtype=bool)
    for name, values in group.material_state(moved).items():
        if name != "inelastic":  # whether a stone of fidelity auto has its law by now
            spent |= values.reshape(shape) > 0
    return spent


def _slope(points: FloatArray, tension: FloatArray, compression: FloatArray) -> FloatArray:
    """How fast utilisation may grow with a stress of any direction, shape (b, q) [1/Pa]."""
    pulled = np.where(points.max(axis=-1) > 0, 1.0 / tension, 0.0)
    pressed = np.where(points.min(axis=-1) < 0, 1.0 / compression, 0.0)
    return np.hypot(np.nan_to_num(pulled), np.nan_to_num(pressed))


def _error(
    told: StressError, gauss: FloatArray, weight: FloatArray, region: FloatArray, slope: FloatArray
) -> FloatArray:
    """Estimated error of the mean utilisation over a region, shape (b,).

    The estimated error e² of the elements is parted as their volume lies in the region, the energy of the
    stress as its square does. Their ratio gives the size of the stress's error there, times the slope.
    """
    b, cells = told.squares.shape
    inside = region.reshape(b, cells, -1).sum(axis=2) / told.volume
    square = np.einsum("bc,bc->b", inside, told.squares)
    size = np.square(gauss[..., :3]).sum(axis=-1) + 2 * np.square(gauss[..., 3:]).sum(axis=-1)
    whole, here = size @ weight, (size * region).sum(axis=1)
    energy = told.norm * np.divide(here, whole, out=np.zeros_like(whole), where=whole > 0)
    relative = np.sqrt(np.divide(square, energy + square, out=np.zeros_like(square), where=square > 0))
    volume = region.sum(axis=1)
    missing: FloatArray = relative * np.sqrt(here / volume) * (slope * region).sum(axis=1) / volume
    return missing


def governed(told: StoneUtilisation) -> list[str]:
    """What uses most of each block's strength: tension, compression, yield; empty where nothing is known.

    Parameters
    ----------
    told : Of b blocks.
    """
    pulled = np.argmax(np.nan_to_num(told.parts), axis=1) == 0
    words = np.where(told.yielded, "yield", np.where(pulled, "tension", "compression"))
    found: list[str] = np.where(np.isnan(told.ranking), "", words).tolist()
    return found
