"""Dilatancy at one point."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import LawError
from masonry_fem.joints import Bed, Dry, MohrCoulomb, Rough, fold, probe
from masonry_fem.scene import loads


def test_sliding_opens_up_to_the_bound_and_back():
    law = Rough(Dry(0.6), dilatancy=0.2, bound=1e-3)
    slides = np.array([1e-6, 1e-3, 1.0, 1e-3, 0.0])
    history = probe(law, np.stack([0 * slides, slides], axis=1), pressure=1e5)
    assert history.jump[:, 0] == pytest.approx(1e-3 * -np.expm1(-200 * slides), rel=1e-12, abs=1e-18)
    assert history.jump[0, 0] == pytest.approx(0.2e-6, rel=1e-3)
    assert np.abs(history.stress[:, 1]) == pytest.approx(0.6e5)
    assert history.settled.all()


def test_heat_is_what_pressure_does_not_take():
    law = Rough(Dry(0.6), dilatancy=0.2, bound=1e-3)
    history = probe(law, [[0, 1e-4], [0, 2e-4], [0, 0]], pressure=1e5)
    raised = 1e5 * history.jump[:, 0]
    assert history.rubbed == pytest.approx(np.array([6.0, 12.0, 24.0]) - raised)


def test_hindered_dilatancy_builds_up_pressure():
    """Between stiff blocks the opening that sliding wants compresses the bed."""
    law = Bed(Rough(Dry(0.6), dilatancy=0.2, bound=1e-3), 1e10, 1e12)
    history = probe(law, [[-1e-5, x] for x in np.linspace(0, 1e-4, 51)])
    assert history.settled.all()
    slid = history.state.jump[0, 1]
    raised = -1e-3 * np.expm1(-200 * slid)
    assert history.stress[-1, 0] == pytest.approx(-1e10 * (1e-5 + raised), rel=1e-9)
    assert history.stress[-1, 1] == pytest.approx(-0.6 * history.stress[-1, 0], rel=1e-9)


def test_bonded_joint_does_not_dilate():
    law = Rough(MohrCoulomb(cohesion=1e6, friction=0.6), dilatancy=0.2, bound=1e-3)
    history = probe(law, [[0, 0]], pressure=1e5)
    assert history.jump[0, 0] == 0.0


def test_dilatancy_above_friction_would_create_energy():
    with pytest.raises(LawError, match=r"dilatancy is 0\.7, expected at most the friction 0\.6"):
        Rough(Dry(0.6), dilatancy=0.7, bound=1e-3)


def test_what_is_still_to_be_raised_is_raised_in_a_step():
    law = Rough(Dry(0.6), dilatancy=0.2, bound=1e-3)
    state = replace(law.initial(1, 2), dilation=np.array([3e-4]), raised=np.array([1e-4]))
    area = np.ones(1)
    reduced, inner = (one.reduce(state, np.zeros((1, 2)), area, 0.5) for one in (law, law.law))
    assert reduced.shift[0, 0] - inner.shift[0, 0] == pytest.approx(-4e-4, rel=1e-12)


ELASTIC = """
dimension = 2

[materials.stone]
density = 2400
young = "10 GPa"
poisson = 0.2
thermal_expansion = 1e-5

[[structures]]
kind = "wall"
name = "s"
material = "stone"
brick = [0.4, 0.2]
columns = 3
courses = 3

[mesh]
element = "Q2"
divisions = [2, 1]

[[joints]]
friction = 0.6
form = "gap"
dilatancy = { tangent = 0.15, bound = 2e-4 }

[loads]
gravity = [0.0, -9.81]
points = [{ block = "s.c2.b1", point = [0.2, 0.3], vector = [2000.0, -5000.0] }]
temperatures = [{ on = "s.c2.b1", change = -20.0 }]

[analysis]
kind = "statics"
load_steps = 2
"""


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Solutions of the contact problems of joint laws, as they are made."""
    solve, made = fold.solve, []

    def counted(*given: Any) -> Any:
        made.append(solve(*given))
        return made[-1]

    monkeypatch.setattr(fold, "solve", counted)
    return made


def test_dilation_between_elastic_stones_is_found_in_few_turns(solved: list[Any]) -> None:
    """Each turn of its own leaves a third of the change: 63 contact problems, and not 36."""
    assert solve_scene(loads(ELASTIC)).outcome == "equilibrium"
    assert len(solved) < 45


def test_joints_that_do_not_settle_are_named_with_law_and_load(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fold, "SECANTS", (1,))
    made = solve_scene(loads(ELASTIC.replace('form = "gap"', "").replace("load_steps = 2", "load_steps = 1")))
    assert made.outcome == "no_convergence"
    assert "Step 1, at load factor 1: the joint laws did not settle" in made.message
    joint = re.search(r"most at that of '(.+)' and '(.+)' \('rough', 'dry'\)", made.message)
    assert joint is not None
    assert "s.c2.b1" in joint.groups()


def test_joints_that_come_to_no_state_end_the_step(
    monkeypatch: pytest.MonkeyPatch, solved: list[Any]
) -> None:
    """Each further round and part of a step would take as many secants, and not settle either."""
    monkeypatch.setattr(fold, "SECANTS", (4,))
    apart = ELASTIC.replace("columns = 3", "columns = 4").replace("[2000.0, -5000.0]", "[0.0, -1000.0]")
    result = solve_scene(loads(apart))
    assert result.outcome == "no_convergence"
    assert "'rough'" in result.message
    assert len(solved) < 30
