"""Blocks: the stresses in a summary, and where they are greatest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.model import Model
from masonry_fem.march.state import STATUS_NAMES, SystemState
from masonry_fem.output.strength import principal, von_mises
from masonry_fem.output.stress_error import StressError, block_errors, told
from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]
TOP = 5  # blocks that a summary names
ROUNDING = 1e-12  # of the largest stress


class Extreme(Told, frozen=True, kw_only=True):
    """A greatest value and where it is.

    Attributes
    ----------
    value : The stress [Pa].
    block : Name of its block.
    """

    value: float
    block: str


class BlockStress(Told, frozen=True, kw_only=True):
    """Mean stress of a block.

    Attributes
    ----------
    block : Its name.
    von_mises : Von Mises' stress [Pa].
    principal : Principal values, shape (3,) [Pa].
    stress : Components xx, yy, zz, xy, yz, xz [Pa].
    """

    block: str
    von_mises: float
    principal: FloatArray
    stress: FloatArray


class BlockYield(Told, frozen=True, kw_only=True):
    """What the material of a block that yielded remembers, such as its plastic strain.

    Attributes
    ----------
    block : Its name.
    measure : What is measured, as fields call it: ``plastic_strain``.
    greatest : Over its Gauss points.
    mean : Over its volume.
    """

    block: str
    measure: str
    greatest: float
    mean: float


class Stress(Told, frozen=True, kw_only=True):
    """Greatest stresses, tension positive, and where they are.

    Attributes
    ----------
    max_von_mises, max_principal, min_principal : Over the Gauss points [Pa].
    max_von_mises_nodal : Of the stress smoothed to the nodes, which pictures show [Pa].
    p95_von_mises : 5 % of the volume have more [Pa].
    blocks : Those of greatest mean von Mises stress.
    error : How wrong all this may be, estimated.
    yielded : Inelastic blocks that have yielded, those that did most first; None where no block is inelastic.
    """

    max_von_mises: Extreme
    max_von_mises_nodal: Extreme
    p95_von_mises: float
    max_principal: Extreme
    min_principal: Extreme
    blocks: tuple[BlockStress, ...]
    error: StressError | None = None
    yielded: tuple[BlockYield, ...] | None = None


def stress_summary(model: Model, state: SystemState) -> Stress | None:
    """Greatest stresses and where; None where no block has stresses.

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    """
    gathered = [_group_values(group, moved) for group, moved in zip(model.groups, state.bodies, strict=True)]
    values = [value for value in gathered if value is not None]
    if not values:
        return None
    sigma, weight, block = (np.concatenate(part) for part in zip(*values, strict=True))
    names = model.assembly.blocks.names
    mises = von_mises(sigma)

    def at(number: int, value: float) -> Extreme:
        return Extreme(value=float(value), block=names[block[number]])

    most = int(mises.argmax())
    errors = block_errors(model, state)
    return Stress(
        max_von_mises=at(most, mises[most]),
        max_von_mises_nodal=_greatest_nodal(model, state),
        p95_von_mises=weighted_quantile(mises, weight, 0.95),
        max_principal=at(*_greatest_principal(sigma, mises)),
        min_principal=at(*_greatest_principal(sigma, mises, sign=-1)),
        blocks=_block_means(sigma, weight, block, names),
        error=None if errors is None else told(errors, model),
        yielded=_yielded(model, state),
    )


def _greatest_principal(sigma: FloatArray, mises: FloatArray, sign: int = 1) -> tuple[int, float]:
    """Which of all stresses (k, 6) has the greatest principal one, or the least one (sign −1), and that.

    It lies above the mean normal stress by a third to two thirds of von Mises' (k,): few are looked at.
    """
    mean = sign * sigma[:, :3].mean(axis=1)
    known = (mean + mises / 3).max() - ROUNDING * (np.abs(mean) + mises).max()
    some = np.flatnonzero(mean + mises * 2 / 3 >= known)
    values = sign * principal(sigma[some])[0]
    number, column = np.unravel_index(int(values.argmax()), values.shape)
    return int(some[number]), sign * float(values[number, column])


def _yielded(model: Model, state: SystemState) -> tuple[BlockYield, ...] | None:
    """Blocks whose material remembers that it yielded; None where none could."""
    found, known = [], False
    for group, moved in zip(model.groups, state.bodies, strict=True):
        kept = group.material_state(moved)
        known = known or bool(kept)
        if not kept:
            continue
        field = group.stress(moved)
        assert field is not None  # what yields has stresses
        for measure, values in kept.items():
            most = values.max(axis=(1, 2))
            mean = (values * field.weight).sum(axis=(1, 2)) / field.weight.sum()
            for row in np.flatnonzero(most > 0):
                name = model.assembly.blocks.names[int(group.blocks[row])]
                found.append(
                    BlockYield(block=name, measure=measure, greatest=float(most[row]), mean=float(mean[row]))
                )
    return tuple(sorted(found, key=lambda one: -one.greatest)) if known else None


def status_counts(state: SystemState) -> dict[str, int]:
    """How many contacts are open, stick, slip and are bonded."""
    counts = np.bincount(state.status.astype(np.int64), minlength=len(STATUS_NAMES))
    return dict(zip(STATUS_NAMES, counts.tolist(), strict=True))


def weighted_quantile(values: FloatArray, weight: FloatArray, fraction: float) -> float:
    """Smallest value that ``fraction`` of the weight does not exceed."""
    order = np.argsort(values)
    share = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(share, fraction * share[-1])])


def _group_values(group: Any, moved: Any) -> tuple[FloatArray, FloatArray, NDArray[np.int64]] | None:
    """Stress, volume and block number at all Gauss points of a group."""
    field = group.stress(moved)
    if field is None:
        return None
    bodies, cells, points, _ = field.gauss.shape
    weight = np.broadcast_to(field.weight, (bodies, cells, points)).ravel()
    return field.gauss.reshape(-1, 6), weight, np.repeat(group.blocks, cells * points)


def _greatest_nodal(model: Model, state: SystemState) -> Extreme:
    """Greatest von Mises stress at nodes [Pa] and its block; some group has stresses."""
    found: list[tuple[float, str]] = []
    for group, moved in zip(model.groups, state.bodies, strict=True):
        field = group.stress(moved)
        if field is not None:
            mises = von_mises(field.nodal).max(axis=1)
            body = int(mises.argmax())
            found.append((float(mises[body]), model.assembly.blocks.names[int(group.blocks[body])]))
    value, block = max(found)
    return Extreme(value=value, block=block)


def _block_means(
    sigma: FloatArray, weight: FloatArray, block: NDArray[np.int64], names: Sequence[str]
) -> tuple[BlockStress, ...]:
    numbers, where = np.unique(block, return_inverse=True)
    volume = np.bincount(where, weight)
    mean = np.stack([np.bincount(where, weight * part) for part in sigma.T], axis=1) / volume[:, None]
    mises, (values, _) = von_mises(mean), principal(mean)
    return tuple(
        BlockStress(block=names[numbers[i]], von_mises=float(mises[i]), principal=values[i], stress=mean[i])
        for i in np.argsort(-mises)[:TOP]
    )
