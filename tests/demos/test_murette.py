"""The slides' murette is demos/low_wall: what its ground carries, whatever the friction (A2.4)."""

from __future__ import annotations

import numpy as np
import pytest

from demos import low_wall
from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import load


@pytest.mark.parametrize("friction", [0.2, 0.6, 1.2])
def test_ground_carries_the_weight_and_nothing_across(friction):
    result = solve_scene(load(low_wall.SCENE, overrides=("mesh.size=0.25", f"joints.0.friction={friction}")))
    assert result.outcome == "equilibrium"
    ground = result.summary.supports["wall.ground"]
    weight = 2400 * 9.81 * 2.0 * 0.25 * 1.25
    assert ground.force == pytest.approx([0.0, 0.0, weight], rel=1e-9, abs=1e-9 * weight)
    # about the origin: through the middle of the wall, (1, 0.125)
    assert ground.moment == pytest.approx(np.cross([1.0, 0.125, 0.0], [0, 0, weight]), abs=1e-7 * weight)
