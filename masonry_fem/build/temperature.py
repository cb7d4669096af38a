"""Temperature: by how much which blocks expand, from the scene's changes of temperature.

warming = expansions(scene, stones, base)           # strains with their factors in time, by block
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from masonry_fem.build.selection import select_blocks
from masonry_fem.build.stones import Stones
from masonry_fem.build.supports import ramp, time_factor
from masonry_fem.errors import SceneError
from masonry_fem.fidelities import deforms
from masonry_fem.scene import specs

# by block: strains, each with its factor in time
type Expansions = dict[int, list[tuple[float, Callable[[float], float]]]]


def expansions(scene: specs.Scene, stones: Stones, base: Path) -> Expansions:
    """Strains by temperature of the blocks that have any, each with its factor in time.

    Parameters
    ----------
    scene : The scene. stones : Its blocks. base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : A selector selects nothing or supports only; a block cannot expand.
    """
    made: Expansions = {}
    for index, one in enumerate(scene.loads.temperatures):
        key = f"loads.temperatures.{index}.on"
        free = [
            block
            for block in select_blocks(one.on, stones.assembly.blocks, key)
            if stones.fidelity[block] is not None
        ]
        if one.material is not None:
            free = [block for block in free if stones.material[block] == one.material]
            if not free:
                raise SceneError(
                    f"loads.temperatures.{index}.material = '{one.material}' is that of no free block among "
                    f"'{one.on}'; name a material that they have, or select others"
                )
        if not free:
            raise SceneError(
                f"{key} = '{one.on}' selects supports only, which do not expand; choose a free block"
            )
        factor = ramp(scene) if one.time is None else time_factor(scene, one.time, base)
        for block in free:
            strain = one.change * _expansion(scene, stones, block, key)
            made.setdefault(block, []).append((strain, factor))
    return made


def _expansion(scene: specs.Scene, stones: Stones, block: int, key: str) -> float:
    """Strain of a block by each kelvin [1/K]."""
    name, material = stones.assembly.blocks.names[block], stones.material[block]
    if not deforms(stones.fidelity[block]):
        raise SceneError(
            f"{key}: block '{name}' is {stones.fidelity[block]} and cannot expand, expected blocks that "
            "deform; set their fidelity = 'elastic', or select others"
        )
    expansion = scene.materials[material].thermal_expansion
    if expansion is None:
        raise SceneError(
            f"materials.{material}.thermal_expansion is missing: the temperature of block '{name}' changes, "
            "expected its strain by each kelvin in 1/K, some 8e-6 for stone; give it"
        )
    return expansion
