"""A façade of blocks that bars hold: stones are rigid, and the bars alone give way."""

from __future__ import annotations

import pytest

from demos import shaken_facade
from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import loads

SCENE = """
dimension = 3
fidelity = "rigid"
materials.stone.density = 2200.0
joints = [{ friction = 0.6 }]
loads.gravity = [0.0, 0.0, -9.81]
analysis = { kind = "dynamics", step = 0.01, duration = 0.25, theta = 0.5 }
output = { pictures = false }

[[structures]]
kind = "wall"
name = "front"
material = "stone"
brick = [1.2, 0.5, 0.55]
columns = 5
courses = 10
openings = [{ position = [2.4, 0.0], size = [1.2, 2.2] }]

[[structures]]
kind = "block"
name = "left"
material = "stone"
size = [0.6, 3.0, 5.5]
position = [0.0, 0.5, 0.0]
support = true

[[structures]]
kind = "block"
name = "right"
material = "stone"
size = [0.6, 3.0, 5.5]
position = [5.4, 0.5, 0.0]
support = true

[[ties]]
name = "left"
points = [{ block = "front.c10.b1", point = [0.3, 0.0, 5.225] }, { block = "left", point = [0.3, 2.5, 5.1] }]
diameter = "24 mm"
young = "200 GPa"

[[ties]]
name = "right"
points = [{ block = "front.c10.b6", point = [5.7, 0.0, 5.225] }, { block = "right", point = [5.7, 2.5, 5.1] }]
diameter = "24 mm"
young = "200 GPa"
"""


RECORD = f"loads.accelerograms=[{{y='{shaken_facade.SCENE.with_suffix('.csv')}'}}]"


def test_the_interior_point_begins_at_what_stones_press_each_other_with():
    """Two stiff bars among 572 rigid contacts say nothing of their impulses and speeds."""
    alone = "solver={method='interior_point', tolerance=1e-5}"
    assert solve_scene(loads(SCENE, [RECORD, alone, "analysis.duration=0.02"])).outcome == "finished"


@pytest.mark.slow
def test_a_step_begins_anew_where_the_last_one_leads_astray():
    """As the record first pulls the façade from its side walls, no method ends from the step before."""
    made = solve_scene(loads(SCENE, [RECORD]))
    assert made.outcome == "finished"
    assert made.summary.certificate.natural_map < 1e-9
