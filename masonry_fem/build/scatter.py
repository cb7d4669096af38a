"""Scatter: by how much the properties of each interface differ from what the scene says.

scatter = scatter_factors(scene, interfaces, chosen)
cohesion = 0.35e6 * scatter["cohesion"][contacts.interface]
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.scene import specs

FloatArray = NDArray[np.float64]


def scatter_factors(scene: specs.Scene, interfaces: Interfaces, chosen: list[int]) -> dict[str, FloatArray]:
    """Factors on the scene's values by parameter, shape (i,); 1 where nothing scatters.

    The field of a joint record does not depend on which interfaces have the record: records with one seed
    share a field.

    Parameters
    ----------
    scene : Has the joint records.
    interfaces : Where blocks touch, i in number.
    chosen : Number of the joint record of each interface.
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
        middles = np.add.reduceat(interfaces.corners, interfaces.first[:-1]) / interfaces.size[:, None]
        field = gaussian_field(middles, scatter.seed, scatter.correlation_length)
        for name, variation in scatter.variation.items():
            values = found.setdefault(name, np.ones(len(interfaces)))
            values[own] = factors(field[own], variation, scatter.distribution)
    return found


def scattered(values: Mapping[str, Any], factor: Mapping[str, FloatArray]) -> dict[str, Any]:
    """The values that scatter as arrays, the others as they are.

    Parameters
    ----------
    values : Of the keys of a joint record.
    factor : By the key that scatters: factors, shape (c,).
    """
    return {
        name: value * factor[name] if name in factor and isinstance(value, float) else value
        for name, value in values.items()
    }
