"""Strengths: those of each block's material, with the partial factor of the scene."""

from __future__ import annotations

import numpy as np

from masonry_fem.build.stones import Stones
from masonry_fem.output.strength import Strengths
from masonry_fem.scene import specs


def strengths_of(scene: specs.Scene, stones: Stones) -> Strengths | None:
    """Strengths of the blocks; None where no stone has one.

    Parameters
    ----------
    scene : The scene, with its materials and ``design``.
    stones : Its blocks.
    """
    names = ("tensile_strength", "compressive_strength")
    if all(stone.strength(name) is None for stone in scene.materials.values() for name in names):
        return None

    used, material = np.unique(np.array(stones.material), return_inverse=True)

    def of(name: str) -> np.ndarray:
        known = np.array([scene.materials[one].strength(name) for one in used.tolist()], dtype=float)
        found: np.ndarray = known[material]
        found[stones.of(None)] = np.nan
        return found

    design = scene.design
    found = Strengths(
        of("tensile_strength"), of("compressive_strength"), design.material_factor, design.share
    )
    return found if found.known.any() else None
