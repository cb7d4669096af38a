"""Start: what stands without ever having been pressed together, and what needs a thrust that is not there."""

import json

import pytest

from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.records.told import plain
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Output,
    Override,
    Scene,
    Statics,
    Support,
    law_record,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.file import FileStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

STONE = {"stone": Material(density=2000.0, young=1e10)}
FRICTION = 0.8
WEIGHT = 2000.0 * 10.0  # of a cubic metre [N], of a square metre of a plane structure [N/m]


def block(name, size, position):
    return BlockStructure(name=name, material="stone", size=size, position=position)


def scene(structures, supports=(), **keys):
    given = {
        "dimension": 2,
        "fidelity": "rigid",
        "materials": STONE,
        "structures": structures,
        "supports": tuple(Support(on=name) for name in supports),
        "joints": (Joint(friction=FRICTION),),
        "loads": Loads(gravity=(0.0, -10.0)),
        "analysis": Statics(),
        "output": Output(pictures=False),
    } | keys
    return Scene(**given)


def beam(count=1, **keys):
    """Stones in a row between two vertical faces that nothing has pushed together."""
    stones = [block(f"stone{k}", (0.5, 1.0), (0.5 * k, 0.0)) for k in range(count)]
    ends = [block("left", (0.5, 3.0), (-0.5, -1.0)), block("right", (0.5, 3.0), (0.5 * count, -1.0))]
    return scene((*stones, *ends), ("left", "right"), **keys)


@pytest.mark.parametrize("count", [1, 4])
def test_stones_between_vertical_faces_stand_only_if_pre_stressed(count):
    # each end carries half the weight by friction under one thrust
    found = solve_scene(beam(count))
    told = found.summary.start
    assert found.outcome == "equilibrium"
    assert told.reached is False
    assert told.least_thrust == pytest.approx(0.5 * count * WEIGHT / (2 * FRICTION), rel=1e-6)
    assert "stands only if it is pre-stressed by at least" in found.message
    assert told.mechanism.groups == (tuple(f"stone{k}" for k in range(count)),)


def test_elastic_stones_between_vertical_faces_fall():
    found = solve_scene(beam(fidelity="elastic", mesh=MeshSettings(size=0.25)))
    assert found.outcome == "no_equilibrium"
    assert found.message.startswith("No equilibrium from a start without stress")
    assert found.summary.mechanism.groups == (("stone0",),)
    assert found.summary.moving[0].how == "falls"
    assert found.summary.start.least_thrust == pytest.approx(0.5 * WEIGHT / (2 * FRICTION), rel=1e-6)


@pytest.mark.parametrize(("where", "reached"), [("on the ground", True), ("between faces", None)])
def test_rigid_stones_beside_elastic_ones_are_asked_as_rigid(where, reached):
    pile = StackStructure(name="pile", material="stone", size=(1.0, 0.5), count=3, position=(5.0, 0.0))
    soft = (Override(blocks="pile.b1", fidelity="elastic"),)
    stones = (pile,) if reached else (pile, *beam().structures)
    held = () if reached else ("left", "right")
    found = solve_scene(scene(stones, held, overrides=soft, mesh=MeshSettings(size=0.25)))
    assert found.outcome == "equilibrium"
    assert found.summary.start.reached is reached


def test_elastic_stones_with_a_law_take_their_stress_from_what_moves():
    law = Joint(friction=FRICTION, law=law_record("mohr_coulomb", cohesion=1e5, tensile_strength=1e4))
    found = solve_scene(beam(joints=(law,), fidelity="elastic", mesh=MeshSettings(divisions=(2, 2))))
    assert plain(found.summary.start) == {"reached": True}
    assert found.summary.message == "Equilibrium after 1 step."


def test_joints_with_a_law_are_not_asked():
    law = Joint(friction=FRICTION, law=law_record("mohr_coulomb", cohesion=1e5, tensile_strength=1e4))
    told = solve_scene(beam(joints=(law,))).summary.start
    assert told.reached is None
    assert "law of their own" in told.note


def test_an_elastic_beam_that_is_slender_braces_itself():
    # as it sags its lower edges push the faces apart; four times as long as deep it still falls
    for length, outcome in ((2.0, "no_equilibrium"), (3.0, "equilibrium")):
        stone = block("stone", (length, 0.5), (0.0, 0.0))
        ends = [block("left", (0.5, 1.5), (-0.5, -0.5)), block("right", (0.5, 1.5), (length, -0.5))]
        mesh = MeshSettings(size=0.125)
        found = solve_scene(scene((stone, *ends), ("left", "right"), fidelity="elastic", mesh=mesh))
        assert found.outcome == outcome
    assert plain(found.summary.start) == {"reached": True}


@pytest.mark.parametrize(
    ("name", "gravity", "thrust"),
    [
        ("H", (0.0, 0.0, -9.81), 16817.0),
        ("A", (0.0, 0.0, -9.81), 63740.0),
        ("type-a", (0.0, 0.0, -9.81), None),
        ("type-b", (0.0, 0.0, -9.81), None),
        ("type-a", (0.0, 0.0, 9.81), 30036.0),
        ("type-b", (9.81, 0.0, 0.0), None),
        ("type-b", (0.0, 9.81, 0.0), 48915.2),
    ],
)
def test_cases_of_coupled_rigid_block_analysis(shared_data, name, gravity, thrust):
    """Wedges between two held stones; the least thrusts of H and A follow from the angle of their faces."""
    path = str(shared_data / f"compas/cra_{name}.json")
    stones = FileStructure(name="s", material="stone", path=path, scale=1.0, supports=("b0", "b1"))
    found = solve_scene(
        scene((stones,), dimension=3, joints=(Joint(friction=0.84),), loads=Loads(gravity=gravity))
    )
    assert found.outcome == "equilibrium"
    assert found.summary.start.reached is (thrust is None)
    assert found.summary.start.least_thrust == (thrust and pytest.approx(thrust, rel=1e-4))


@pytest.mark.parametrize("name", ["H", "A"])
def test_elastic_cases_of_coupled_rigid_block_analysis_fall(shared_data, name):
    path = str(shared_data / f"compas/cra_{name}.json")
    stones = FileStructure(name="s", material="stone", path=path, scale=1.0, supports=("b0", "b1"))
    found = solve_scene(
        scene(
            (stones,), dimension=3, fidelity="elastic", mesh=MeshSettings(size=0.4),
            joints=(Joint(friction=0.84),), loads=Loads(gravity=(0.0, 0.0, -9.81)),
        )
    )  # fmt: skip
    assert found.outcome == "no_equilibrium"
    assert found.summary.mechanism.groups == (("s.b2",),)
    assert found.summary.start.least_thrust > 0


def test_the_verdict_is_written(tmp_path):
    run(beam(), tmp_path)
    kept = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert kept["start"]["reached"] is False
    assert sorted(map(sorted, kept["start"]["joints"])) == [["left", "stone0"], ["right", "stone0"]]


@pytest.mark.parametrize(
    "structure",
    [
        ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.2, voussoirs=11),
        WallStructure(name="wall", material="stone", brick=(0.4, 0.2), columns=5, courses=6),
    ],
    ids=["arch", "wall"],
)
def test_arches_and_walls_are_reached(structure):
    found = solve_scene(scene((structure,)))
    assert plain(found.summary.start) == {"reached": True}
    assert "pre-stressed" not in found.message
