"""Small structures for limit analysis: rigid blocks, and their limit problems."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.build import build
from masonry_fem.limit import LimitProblem, group_forces, limit_problem
from masonry_fem.march.model import Model
from masonry_fem.scene import check
from masonry_fem.scene.specs import Joint, Loads, Material, Scene
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.stack import StackStructure

G = 9.81
STONE = Material(density=2400.0)
GAMMA = 2400.0 * G
Live = Callable[[Model], list[np.ndarray]]


def scene(*structures: Any, dimension: int = 2, **keys: Any) -> Scene:
    """Rigid blocks under gravity."""
    given = {
        "dimension": dimension,
        "fidelity": "rigid",
        "materials": {"stone": STONE},
        "structures": structures,
        "loads": Loads(gravity=(0.0,) * (dimension - 1) + (-G,)),
    } | keys
    return check(Scene(**given))


def problem(made: Scene, live: Live | None = None) -> LimitProblem:
    """Gravity as dead load, and a live load made for the model."""
    model = build(made, Path()).model
    forces = None if live is None else live(model)
    return limit_problem(model, group_forces(model, {"gravity": 1.0}), forces)


def accelerated(*direction: float) -> Live:
    """Live load: an acceleration of g along a direction."""
    return lambda model: [group.acceleration_force(G * np.array(direction)) for group in model.groups]


def pushed(block: str, force: Sequence[float], point: Sequence[float] | None = None) -> Live:
    """Live load: a force on a block, at its centroid where no point is given."""

    def live(model: Model) -> list[np.ndarray]:
        made = group_forces(model, {})
        at = None if point is None else np.array(point, dtype=float)
        for index, group in enumerate(model.groups):
            for body, number in enumerate(group.blocks.tolist()):
                if model.assembly.blocks[number].name == block:
                    made[index] = made[index] + group.point_force(body, at, np.array(force, dtype=float))
        return made

    return live


def weight(problem: LimitProblem) -> float:
    """Weight of all free blocks [N]."""
    return sum(float(group.mass.sum()) for group in problem.model.groups) * G


def number(problem: LimitProblem, name: str) -> int:
    """Number of a block."""
    return [block.name for block in problem.model.assembly.blocks].index(name)


def arch(thickness: float, voussoirs: int, friction: float, dimension: int = 2, **keys: Any) -> Scene:
    """Semicircular arch of mean radius 1."""
    inset = keys.pop("inset", 1.0)
    stones = ArchStructure(
        name="arch", material="stone", radius=1.0, thickness=thickness, voussoirs=voussoirs, **keys
    )
    return scene(stones, dimension=dimension, joints=(Joint(friction=friction, inset=inset),))


def column(count: int, size: tuple[float, ...], friction: float = 0.65, **keys: Any) -> Scene:
    """Blocks one on another on the ground."""
    stones = StackStructure(name="column", material="stone", size=size, count=count, **keys)
    return scene(stones, dimension=len(size), joints=(Joint(friction=friction),))
