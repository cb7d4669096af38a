"""Determinism: two runs of a scene at an extreme give the same bits, whatever the number of threads."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import Scene, Solver
from tests.extremes.scenes import (
    LARGE_STEP,
    arch,
    bouncing,
    mass_ratio,
    pushed_wall,
    settling_column,
    stack,
    standing_wall,
)

SCENES: dict[str, Callable[[], Scene]] = {
    "rigid stack": lambda: stack(100),
    "elastic stack": lambda: stack(30, "elastic"),
    "mass ratio": lambda: mass_ratio(1e8, analysis=LARGE_STEP),
    "very rough wall": lambda: pushed_wall(1e6, fidelity="elastic", dimension=3),
    "wall that slips": lambda: pushed_wall(0.3, 0.2, "elastic", 3),
    "thin arch": lambda: arch(101, 0.11),
    "bounces": lambda: bouncing(1e-2),
    "long step": lambda: settling_column(1e3),
    "short step": lambda: standing_wall(1e-12),
}


def bits(result: RunResult) -> list[bytes]:
    state = result.march.state
    forces = [np.asarray(force) for force in result.march.report.support_resultants.values()]
    return [part.tobytes() for part in (state.reaction, state.velocity, state.gap, state.points, *forces)]


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_the_same_bits_twice(name: str) -> None:
    one, other = solve_scene(SCENES[name]()), solve_scene(SCENES[name]())
    assert one.outcome == other.outcome
    assert bits(one) == bits(other)


@pytest.mark.parametrize("name", ["very rough wall", "short step", "mass ratio"])
def test_the_same_bits_with_any_threads(name: str) -> None:
    """Sweeps in time: a statics scene marches for them."""
    scene = SCENES[name]()
    if name == "very rough wall":
        scene = pushed_wall(1e6, analysis=LARGE_STEP, dimension=3)
    found = []
    for threads in (1, 2, 4):
        solver = Solver(method="nsgs", threads=threads, tolerance=1e-6, max_iterations=2000)
        found.append(bits(solve_scene(msgspec.structs.replace(scene, solver=solver))))
    assert found[0] == found[1] == found[2]
