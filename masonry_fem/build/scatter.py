"""Scatter: by how much the properties of each interface differ from what the scene says.

scatter = scatter_factors(scene, interfaces, chosen)
cohesion = 0.35e6 * scatter["cohesion"][contacts.interface]
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.contacts import Interface
from masonry_fem.scene import specs
from masonry_fem.scene.laws import Softening

logger = logging.getLogger(__name__)

FloatArray = NDArray[np.float64]

# of the least energy that a strength and a stiffness allow: where a draw leaves less
LEAST_DUCTILITY = 1.05


def scatter_factors(
    scene: specs.Scene, interfaces: tuple[Interface, ...], chosen: list[int]
) -> dict[str, FloatArray]:
    """Factors on the scene's values by parameter, shape (i,); 1 where nothing scatters.

    ``chosen`` is the number of the joint record of each of the i interfaces. A record's field does not
    hang on which interfaces have it: records with one seed share a field.
    """
    if all(joint.scatter is None for joint in scene.joints):
        return {}
    from masonry_fem.build.random_field import factors, gaussian_field  # noqa: PLC0415 - brings scipy.optimize

    found: dict[str, FloatArray] = {}
    record = np.array(chosen, dtype=int)
    for index, joint in enumerate(scene.joints):
        scatter, own = joint.scatter, record == index
        if scatter is None or not own.any():
            continue
        middles = np.array([interface.polygon.mean(axis=0) for interface in interfaces])
        field = gaussian_field(middles, scatter.seed, scatter.correlation_length)
        for name, variation in scatter.variation.items():
            values = found.setdefault(name, np.ones(len(interfaces)))
            values[own] = factors(field[own], variation, scatter.distribution)
    return found


def scattered(values: Mapping[str, Any], factor: Mapping[str, FloatArray]) -> dict[str, Any]:
    """The values that scatter as arrays, the others as they are."""
    return {
        name: value * factor[name] if name in factor and isinstance(value, float) else value
        for name, value in values.items()
    }


def with_ductility(law: Softening, values: dict[str, Any], key: str) -> dict[str, Any]:
    """Energies raised where a draw left less than springs of that strength store: s²/2c.

    Such a joint would snap back; what the scene itself gets wrong is left to the law to refuse.
    """
    kept = dict(values)
    for mode in ("normal", "tangential"):
        names = [f"{mode}_{part}" for part in ("strength", "stiffness", "energy")]
        least = LEAST_DUCTILITY * _elastic(*(getattr(law, name) for name in names[:2]))
        drawn = [np.asarray(values[name], dtype=float) for name in names]
        if getattr(law, names[2]) <= least or all(one.ndim == 0 for one in drawn):
            continue
        energy, floor = np.broadcast_arrays(drawn[2], LEAST_DUCTILITY * _elastic(drawn[0], drawn[1]))
        short = energy < floor
        if short.any():
            logger.warning(
                "%s.scatter: %d of %d contact points drew a %s below what their springs store at the "
                "strength, s²/2c; it is raised to %g of that",
                key, int(short.sum()), len(short), names[2], LEAST_DUCTILITY,
            )  # fmt: skip
        kept[names[2]] = np.maximum(energy, floor)
    return kept


def _elastic(strength: FloatArray, stiffness: FloatArray) -> FloatArray:
    return strength**2 / (2.0 * stiffness)
