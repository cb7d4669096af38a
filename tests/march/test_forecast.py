"""A step of statics may begin where the last one leads on to; what it ends at is the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.joints import fold as folding
from masonry_fem.march import turning
from masonry_fem.march.rounds import Rounds
from masonry_fem.scene import loads
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Override,
    Statics,
    Table,
    Traction,
    material_record,
)
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import STONE, G, solved

RAMP = ((0.0, 0.0), (1.0, 1.0))
SOFTENING = material_record("brittle_damage", tensile_strength=2e6, fracture_energy=50.0)
WEAK = material_record("drucker_prager", cohesion=1e5, friction_angle=30.0, dilatancy_angle=10.0)


def pressed(points: tuple[tuple[float, float], ...] = RAMP, law: Any = None, steps: int = 4) -> RunResult:
    """A wall under its weight and, as a table of the load factor says, 1 MPa on its top."""
    wall = WallStructure(name="w", material="stone", brick=(0.5, 0.25), columns=3, courses=3)
    weak = Material(density=STONE.density, young=STONE.young, poisson=STONE.poisson, inelastic=law)
    push = Traction(on="w.c3.*/top", vector=(0.0, -1e6), time=Table(points=points))
    yields = () if law is None else (Override(blocks="w.c2.*", fidelity="inelastic", material="weak"),)
    return solved(
        dimension=2,
        materials={"stone": STONE, "weak": weak},
        structures=(wall,),
        overrides=yields,
        mesh=MeshSettings(divisions=(4, 2)),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0.0, -G), tractions=(push,)),
        analysis=Statics(load_steps=steps),
    )


def seen(monkeypatch: pytest.MonkeyPatch) -> tuple[list[bool], list[int]]:
    """For each step from now on whether it was foreseen; for each round its linear solves."""
    told: list[bool] = []
    made: list[int] = []
    foresee, solve = turning.foreseen, folding.solve

    def foreseen(rounds: Rounds) -> Any:
        forecast = foresee(rounds)
        told.append(forecast is not None)
        return forecast

    def counted(*given: Any) -> Any:
        solution = solve(*given)
        made.append(solution.linear_solves)
        return solution

    monkeypatch.setattr(turning, "foreseen", foreseen)
    monkeypatch.setattr(folding, "solve", counted)
    return told, made


@pytest.mark.parametrize("law", [None, WEAK], ids=["elastic", "yields"])
def test_steps_alike_take_fewer_rounds_to_the_same_end(monkeypatch: pytest.MonkeyPatch, law: Any) -> None:
    told, made = seen(monkeypatch)
    found = pressed(law=law)
    assert told == [False, True, True, True]
    rounds = len(made)
    monkeypatch.setattr(turning, "foreseen", lambda rounds: None)
    made.clear()
    other = pressed(law=law)
    assert rounds < len(made)
    if law is not None:
        assert {stone.block for stone in found.summary.stress.yielded} == {f"w.c2.b{k}" for k in (1, 2, 3, 4)}
    # forces that go round within a joint and hardly strain it are determined less well
    one, two = (
        np.concatenate([body.displacement.ravel() for body in result.march.state.bodies[1:]])
        for result in (found, other)
    )
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-9 * np.abs(two).max())
    assert found.summary.certificate.block_balance < 1e-9


SETTLING = """
dimension = 2
fidelity = "elastic"
mesh = { divisions = [2, 2] }
materials.stone = { density = 2400.0, young = 1e9, poisson = 0.2 }
joints = [{ friction = 0.65 }]
loads.gravity = [0.0, -9.81]
loads.gravity_time = { kind = "table", points = [[0.0, 0.0], [0.2, 1.0], [1.0, 1.0]] }
analysis = { kind = "statics", load_steps = 5 }

[[structures]]
kind = "wall"
name = "w"
material = "stone"
brick = [0.6, 0.3]
columns = 4
courses = 2
ground = false

[[structures]]
kind = "block"
name = "firm"
material = "stone"
size = [1.2, 0.3]
position = [0.0, -0.3]

[[structures]]
kind = "block"
name = "soft"
material = "stone"
size = [1.2, 0.3]
position = [1.2, -0.3]

[[supports]]
on = "firm"

[[supports]]
on = "soft"

[supports.motion]
displacement = [0.0, -3e-3]
time = { kind = "table", points = [[0.0, 0.0], [0.2, 0.0], [0.8, 1.0], [1.0, 1.0]] }
"""


def test_a_support_that_goes_on_leads_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Loads stay from the second step on; it starts in that one, and stops before the last."""
    told, made = seen(monkeypatch)
    found = solve_scene(loads(SETTLING))
    assert told == [False, False, True, True, False]
    solves = sum(made)
    monkeypatch.setattr(turning, "foreseen", lambda rounds: None)
    made.clear()
    other = solve_scene(loads(SETTLING))
    assert solves < sum(made)
    one, two = (result.summary.supports["soft"].force for result in (found, other))
    np.testing.assert_allclose(one, two, rtol=0, atol=1e-8 * np.abs(two).max())


def test_a_load_that_turns_back_is_not_foreseen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Weight grows on, but the load on top, much the larger one, falls from the third step on."""
    told, _ = seen(monkeypatch)
    pressed(points=((0.0, 0.0), (0.5, 1.0), (1.0, 0.0)))
    assert told == [False, True, False, True]


def test_stones_that_soften_begin_where_the_last_step_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which of two balances they take depends on where rounds begin."""
    told, _ = seen(monkeypatch)
    pressed(law=SOFTENING)
    assert told == [False] * 4
