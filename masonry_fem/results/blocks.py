"""Summary: the parts of ``summary.json`` that come from the fields, and the file itself."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.stress import principal, von_mises
from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.model import Model
from masonry_fem.march.state import STATUS_NAMES, SystemState
from masonry_fem.output.stress_error import block_errors, told

FloatArray = NDArray[np.float64]
TOP = 5


def stress_summary(model: Model, state: SystemState) -> dict[str, Any]:
    """Greatest stresses [Pa] and where; {} where no block has stresses.

    Keys: ``max_von_mises`` (over the Gauss points), ``max_von_mises_nodal`` (of the stress smoothed
    to the nodes, which pictures show), ``p95_von_mises`` (5 % of the volume has more),
    ``max_principal`` and ``min_principal`` (over the Gauss points, tension positive), each extreme as
    ``value`` and ``block``; ``blocks``: the ``TOP`` blocks of greatest mean von Mises stress, with
    their mean stress tensor and its principal values; ``error``: how exact all this is, estimated.
    """
    gathered = [_group_values(group, moved) for group, moved in zip(model.groups, state.bodies, strict=True)]
    values = [value for value in gathered if value is not None]
    if not values:
        return {}
    sigma, weight, block = (np.concatenate(part) for part in zip(*values, strict=True))
    names = [stone.name for stone in model.assembly.blocks]
    mises, (extreme, _) = von_mises(sigma), principal(sigma)

    def at(number: int, value: float) -> dict[str, Any]:
        return {"value": float(value), "block": names[block[number]]}

    low, high, most = (
        int(extreme.min(axis=1).argmin()),
        int(extreme.max(axis=1).argmax()),
        int(mises.argmax()),
    )
    return {
        "max_von_mises": at(most, mises[most]),
        "max_von_mises_nodal": _greatest_nodal(model, state),
        "p95_von_mises": weighted_quantile(mises, weight, 0.95),
        "max_principal": at(high, extreme[high].max()),
        "min_principal": at(low, extreme[low].min()),
        "blocks": _block_means(sigma, weight, block, names),
        **_error(model, state),
    }


def _error(model: Model, state: SystemState) -> dict[str, Any]:
    """How exact these stresses are, estimated; nothing where no group can say."""
    errors = block_errors(model, state)
    return {} if errors is None else {"error": told(errors, model)}


def status_counts(state: SystemState) -> dict[str, int]:
    """How many contacts are open, stick, slip and are bonded."""
    counts = np.bincount(state.status.astype(np.int64), minlength=len(STATUS_NAMES))
    return dict(zip(STATUS_NAMES, counts.tolist(), strict=True))


def weighted_quantile(values: FloatArray, weight: FloatArray, fraction: float) -> float:
    """Smallest value that ``fraction`` of the weight does not exceed."""
    order = np.argsort(values)
    share = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(share, fraction * share[-1])])


def write_summary(path: Path, summary: Mapping[str, Any]) -> Path:
    """Write a summary as JSON; arrays become lists, infinities and NaN null. The file is replaced whole."""
    text = json.dumps(plain(summary), indent=2, allow_nan=False, ensure_ascii=False)
    write_atomic(path, (text + "\n").encode())
    return path


def plain(value: Any) -> Any:
    """A value with JSON's types only."""
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(part) for part in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, (int, str, type(None))) else str(value)


def _group_values(group: Any, moved: Any) -> tuple[FloatArray, FloatArray, NDArray[np.int64]] | None:
    """Stress, volume and block number at all Gauss points of a group."""
    field = group.stress(moved)
    if field is None:
        return None
    bodies, cells, points, _ = field.gauss.shape
    weight = np.broadcast_to(field.weight, (bodies, cells, points)).ravel()
    return field.gauss.reshape(-1, 6), weight, np.repeat(group.blocks, cells * points)


def _greatest_nodal(model: Model, state: SystemState) -> dict[str, Any]:
    """Greatest von Mises stress at nodes [Pa] and its block; some group has stresses."""
    found: list[tuple[float, str]] = []
    for group, moved in zip(model.groups, state.bodies, strict=True):
        field = group.stress(moved)
        if field is not None:
            mises = von_mises(field.nodal).max(axis=1)
            body = int(mises.argmax())
            found.append((float(mises[body]), model.assembly.blocks[int(group.blocks[body])].name))
    value, block = max(found)
    return {"value": value, "block": block}


def _block_means(
    sigma: FloatArray, weight: FloatArray, block: NDArray[np.int64], names: Sequence[str]
) -> list[dict[str, Any]]:
    numbers, where = np.unique(block, return_inverse=True)
    volume = np.bincount(where, weight)
    mean = np.stack([np.bincount(where, weight * part) for part in sigma.T], axis=1) / volume[:, None]
    mises, (values, _) = von_mises(mean), principal(mean)
    return [
        {"block": names[numbers[i]], "von_mises": mises[i], "principal": values[i], "stress": mean[i]}
        for i in np.argsort(-mises)[:TOP]
    ]
