"""W_el of a model by what its stones share: the same march as with the assembled matrix."""

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.march import coupling
from masonry_fem.nscd.compliance import Shared
from masonry_fem.scene import loads

WALL = """
dimension = 3
fidelity = "elastic"
materials.stone = {{ density = 2200, young = 1e9, poisson = 0.2 }}
loads.gravity = [0.0, 0.0, -9.81]
mesh.divisions = [2, 1, 1]
[[loads.accelerations]]
vector = [1.5, 0.0, 0.0]
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.5, 0.25, 0.25]
columns = 2
courses = 3
{more}
"""
JOINTS = {
    "dry": "[[joints]]\nfriction = 0.4\n",
    "closing": "[[joints]]\nfriction = 0.4\nclosure = { normal_stiffness = 1e10, greatest = 1e-4 }\n",
    "some rigid": "[[joints]]\nfriction = 0.4\n[[overrides]]\nblocks = 'wall.c1.*'\nfidelity = 'rigid'\n",
    "moving": "[[joints]]\nfriction = 0.4\n[analysis]\nkind = 'dynamics'\nstep = 1e-3\nduration = 3e-3\n",
}


@pytest.mark.parametrize("more", JOINTS.values(), ids=JOINTS)
def test_a_march_is_the_same_by_what_stones_share(more, monkeypatch):
    scene = loads(WALL.format(more=more))
    expected = solve_scene(scene)
    monkeypatch.setattr(coupling, "MANY", 0)
    made, compliance = [], coupling.Coupling.compliance
    monkeypatch.setattr(
        coupling.Coupling, "compliance", lambda *given: made.append(compliance(*given)) or made[-1]
    )
    found = solve_scene(scene)
    assert made
    assert all(isinstance(one, Shared) for one in made)
    assert found.outcome == expected.outcome
    last, other = found.march.last.after, expected.march.last.after
    np.testing.assert_allclose(last.velocity, other.velocity, atol=1e-7 * np.abs(other.velocity).max())
    np.testing.assert_allclose(last.gap, other.gap, atol=1e-7 * np.abs(other.gap).max())
