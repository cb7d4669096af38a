"""A9.7: whole scenes turned in space change nothing that is determined by more than 1e-8.

Displacements, strain energy, reactions that are unique, what all supports give together and what each gives
that is determined. Where three bricks meet in a point, forces can go round it and no block feels them: those
are not unique, elastic or not; nor is then what two supports beside each other give there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.march.determinacy import determine
from masonry_fem.scene.specs import Dynamics, Joint, Loads, MeshSettings, Scene, Solver, Statics
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.dome import DomeStructure
from tests.extremes.scenes import (
    STONE,
    arch,
    arrived,
    block_on_slope,
    down,
    leaning,
    pushed_wall,
    standing_wall,
)
from tests.extremes.turning import rotation_of, solve_turned

Dimension = Literal[2, 3]
BAR = 1e-8
SCENES: dict[str, Callable[..., Scene]] = {
    "arch": lambda fidelity, d: arch(7, 0.2, 0.6, fidelity, d),
    "thin arch": lambda fidelity, d: arch(7, 0.1, 0.6, fidelity, d),
    "wall": lambda fidelity, d: pushed_wall(0.6, 0.1, fidelity, d),
    "wall that slips": lambda fidelity, d: pushed_wall(0.3, 0.2, fidelity, d),
    "slide": lambda fidelity, d: block_on_slope(
        0.3, 20.0, fidelity, d, Dynamics(step=0.01, duration=0.1, theta=0.5)
    ),
    "wall in dynamics": lambda fidelity, d: msgspec.structs.replace(
        pushed_wall(0.6, 0.1, fidelity, d), analysis=standing_wall(0.01).analysis
    ),
}

QUICK = ("arch", "wall that slips")


def displacements(result: RunResult) -> np.ndarray:
    """Of all nodes of the blocks that are free [m]."""
    groups = zip(result.built.model.groups, result.march.state.bodies, strict=True)
    return np.concatenate([group.displacements(state) for group, state in groups if not group.prescribed])


def support_forces(result: RunResult) -> np.ndarray:
    """[N], shape (supports, d)."""
    return np.array([told.force for told in result.summary.supports.values()])


def determined(result: RunResult) -> tuple[np.ndarray, np.ndarray]:
    """What no self-stress can change [N]: normal reactions, and forces of supports, the last line their sum.

    What it can change is 0.
    """
    told = determine(result.march.model, result.march.last)
    force = support_forces(result)
    known = [told.supports_determined[name][: force.shape[1]].all() for name in result.summary.supports]
    forces = np.where(np.array(known)[:, None], force, 0.0)
    return (
        np.where(told.unique, result.march.state.reaction[:, 0], 0.0),
        np.vstack([forces, force.sum(axis=0)]),
    )


def difference(one: RunResult, other: RunResult, rotation: np.ndarray) -> dict[str, float]:
    """Of a scene and the same turned, relative; where rigid blocks stay at rest, to a centimetre."""
    moved, back = displacements(one), displacements(other) @ rotation
    far = max(np.abs(moved).max(), 1e-2 if one.march.last.problem.rigid else 0.0)
    (reaction, force), (turned_reaction, turned_force) = determined(one), determined(other)
    largest = np.abs(one.march.state.reaction).max()
    strain = one.summary.energy.strain, other.summary.energy.strain
    return {
        "displacement": float(np.abs(moved - back).max() / far),
        "support": float(np.abs(force - turned_force @ rotation).max() / np.abs(force).max()),
        "reaction": float(np.abs(reaction - turned_reaction).max() / largest),
        "energy": abs(strain[0] - strain[1]) / strain[0] if strain[0] else strain[1],
    }


CASES = [
    pytest.param(
        name, fidelity, dimension, angle,
        marks=[pytest.mark.slow] if angle != 30 or (dimension == 3 and name not in QUICK) else [],
    )
    for name in SCENES
    for fidelity in ("rigid", "elastic")
    for dimension in (2, 3)
    for angle in (30.0, 137.0)
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "fidelity", "dimension", "angle"), CASES)
def test_a9_7_turned_scenes_give_turned_results(name, fidelity, dimension: Dimension, angle: float) -> None:
    scene, rotation = SCENES[name](fidelity, dimension), rotation_of(dimension, angle)
    one, other = solve_scene(scene), solve_turned(scene, rotation)
    assert one.outcome == other.outcome == arrived(scene)
    found = difference(one, other, rotation)
    assert max(found.values()) < BAR, found


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a9_7_turned_dome(fidelity) -> None:
    scene = Scene(
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=(
            DomeStructure(name="dome", material="stone", radius=5.0, thickness=0.5, rings=3, slices=8),
        ),
        mesh=MeshSettings(divisions=(1, 1, 1)),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=down(3)),
        analysis=Statics(),
    )
    rotation = rotation_of(3, 77.0)
    one, other = solve_scene(scene), solve_turned(scene, rotation)
    assert one.outcome == other.outcome == "equilibrium"
    found = difference(one, other, rotation)
    assert max(found.values()) < BAR, found


@pytest.mark.parametrize("angle", [1e-6, 15.0, 90.0, 123.4])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a9_7_blocks_that_the_scene_turns(fidelity, dimension: Dimension, angle: float) -> None:
    """Two cubes by ``rotation`` and ``axis`` of the scene's own language: the ground carries them alike."""
    axis = None if dimension == 2 else (1.0, 2.0, 3.0)
    forces = []
    for turn in (0.0, angle):
        rotation = rotation_of(dimension, turn)
        up = rotation[:, -1]
        blocks = tuple(
            BlockStructure(
                name=name, material="stone", size=(1.0,) * dimension, rotation=turn, axis=axis,
                position=tuple(float(x) for x in level * up), support=level < 0,
            )
            for level, name in ((-1, "ground"), (0, "one"), (1, "two"))
        )  # fmt: skip
        scene = Scene(
            dimension=dimension,
            fidelity=fidelity,
            materials={"stone": STONE},
            structures=blocks,
            mesh=MeshSettings(divisions=(2,) * dimension),
            loads=Loads(gravity=tuple(float(x) for x in rotation @ np.array(leaning(15.0, dimension)))),
            solver=Solver(),
        )
        result = solve_scene(scene)
        assert result.outcome == "equilibrium"
        forces.append(np.concatenate([support_forces(result)[0] @ rotation, [result.summary.energy.strain]]))
    largest = np.abs(forces[0]).max()
    assert forces[1][:-1] == pytest.approx(forces[0][:-1], abs=BAR * largest)
    assert forces[1][-1] == pytest.approx(forces[0][-1], rel=BAR)
