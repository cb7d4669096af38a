"""Recognition of mechanisms in motions made to order: parts, poles, hinges, sliding joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.build import build
from masonry_fem.march.coupling import connect
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.motion import BlockMotion, PointMotion
from masonry_fem.march.recognition import recognise
from masonry_fem.scene import check
from masonry_fem.scene.specs import Loads, Material, Scene
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.survey import SurveyStructure
from masonry_fem.structures.wall import WallStructure


def model_of(structure, dimension: int = 2) -> Model:
    scene = Scene(
        dimension=dimension,
        fidelity="rigid",
        materials={"stone": Material(density=2400.0)},
        structures=(structure,),
        loads=Loads(gravity=(0.0,) * (dimension - 1) + (-9.81,)),
    )
    return build(check(scene), Path()).model


def stack(count: int = 3) -> Model:
    return model_of(StackStructure(name="s", material="stone", size=(1.0, 0.5), count=count))


def seen(model: Model, velocity: dict[str, tuple], spin: dict[str, float], **keys) -> Mechanism:
    """The mechanism of blocks that move as told, (velocity of the middle, spin), the others at rest."""
    names = [block.name for block in model.assembly.blocks]
    d = model.assembly.dimension
    corners = tuple(model.assembly.solid(block).vertices for block in range(len(names)))
    spins = np.zeros((len(names), 1 if d == 2 else 3))
    moves = np.zeros((len(names), d))
    for name, value in velocity.items():
        moves[names.index(name)] = value
    for name, value in spin.items():
        spins[names.index(name)] = value
    motion = BlockMotion(
        centre=np.stack([points.mean(axis=0) for points in corners]),
        velocity=moves,
        spin=spins,
        held=np.array(["ground" in name for name in names]),
        corners=corners,
    )
    here = connect(model).placement(tuple(group.rest() for group in model.groups))
    points = PointMotion(here.points, here.frame, here.gap < 1e-3)
    return recognise(model, motion, points, rest=1e-3, **keys)


@given(speed=st.floats(1e-6, 1e3), share=st.sampled_from([0.0, 0.05]))
def test_a_block_that_turns_about_its_edge(speed: float, share: float) -> None:
    """The upper two of three blocks turn clockwise about (1, 0.5), at any speed."""
    middle = {"s.b2": np.array([0.5, 0.75]), "s.b3": np.array([0.5, 1.25])}
    velocity = {name: -speed * np.array([-(at[1] - 0.5), at[0] - 1.0]) for name, at in middle.items()}
    found = seen(stack(), velocity, {"s.b2": -speed, "s.b3": -speed}, share=share)
    (joint,), (part,) = found.joints, found.parts
    assert (joint.how, set(joint.between)) == ("hinge", {"s.b1", "s.b2"})
    np.testing.assert_allclose(joint.at, [1.0, 0.5], atol=1e-9)
    np.testing.assert_allclose(part.pole, [1.0, 0.5], atol=1e-9)
    assert part.blocks == ("s.b2", "s.b3")
    assert found.speed == pytest.approx(speed * np.hypot(1.0, 1.0))
    assert found.sentence() == "2 blocks move as one; 1 hinge: s.b2 / s.b1"
    assert found.words()[0] == "s.b2, s.b3 turn clockwise about (1, 0.5) m"
    assert "hinge bed s.b2 / s.b1 at (1, 0.5) m" in found.words()[1]


def test_parts_that_slide_on_each_other() -> None:
    found = seen(stack(), {"s.b2": (1.0, 0.0), "s.b3": (0.5, 0.0)}, {})
    assert [joint.how for joint in found.joints] == ["slides", "slides"]
    assert found.groups == (("s.b2",), ("s.b3",))
    slip = {frozenset(joint.between): joint.slip[0] for joint in found.joints}
    assert abs(slip[frozenset(("s.b1", "s.b2"))]) == pytest.approx(1.0)
    assert abs(slip[frozenset(("s.b2", "s.b3"))]) == pytest.approx(0.5)
    assert "s.b3 moves along (1, 0)" in found.words()


def test_a_block_that_lifts_off_opens_its_joint() -> None:
    found = seen(stack(), {"s.b3": (0.0, 1.0)}, {})
    assert [(joint.how, set(joint.between)) for joint in found.joints] == [("opens", {"s.b2", "s.b3"})]
    assert found.sentence() == "s.b3 moves; 1 opening joint: s.b3 / s.b2"


def test_what_slides_as_it_dilates_slides_where_joints_are_associated() -> None:
    motion = {"s.b3": (1.0, 0.4)}
    assert seen(stack(), motion, {}, friction=0.4).joints[0].how == "slides"
    assert seen(stack(), motion, {}).joints[0].how == "opens"


def test_nothing_moves() -> None:
    found = seen(stack(), {}, {})
    assert (found.joints, found.parts, found.moving) == ((), (), 0)
    assert found.sentence() == "nothing moves"


def test_what_is_one_with_a_support_at_rest_rests() -> None:
    """A creep from joint to joint, each below what counts, adds up to no motion of a part."""
    creep = {f"s.b{number}": (4e-4 * number, 0.0) for number in range(1, 6)}
    found = seen(stack(6), creep | {"s.b6": (1.0, 0.0)}, {})
    assert found.groups == (("s.b6",),)


def test_many_joints_between_two_parts_are_told_together() -> None:
    wall = model_of(WallStructure(name="w", material="stone", brick=(0.4, 0.2), columns=4, courses=3))
    upper = [block.name for block in wall.assembly.blocks if ".c3." in block.name]
    found = seen(wall, dict.fromkeys(upper, (1.0, 0.0)), {})
    assert len(found.parts) == 1
    assert len(found.of("slides")) > 3
    told = [line for line in found.words() if "joints from" in line]
    assert len(told) == 1
    assert "slide along" in told[0]


FACETS, FIRST, LAST = 6, 240.0, 300.0  # of an arc of radius 1 m, and where it begins and ends [degrees]


@pytest.fixture
def cradle(tmp_path: Path) -> Model:
    """A drum in a cradle: their joint is an arc of six facets about the origin."""
    angles = np.radians(np.linspace(FIRST, LAST, FACETS + 1))
    arc = np.column_stack([np.cos(angles), np.sin(angles)])
    outside = [(1.5, arc[-1, 1]), (1.5, -1.5), (-1.5, -1.5), (-1.5, arc[0, 1])]
    stones = {"drum": arc, "cradle": np.array([*arc, *outside])}
    rows = [f"{name},{k},{x},{y},0" for name, at in stones.items() for k, (x, y) in enumerate(at.tolist())]
    (tmp_path / "stones.csv").write_text("\n".join(["stone,vertex,x,y,z", *rows]) + "\n")
    survey = SurveyStructure(
        name="s", material="stone", path=str(tmp_path / "stones.csv"), depth=1.0, ground=False,
        supports=("cradle",),
    )  # fmt: skip
    return model_of(survey)


def drum(model: Model) -> np.ndarray:
    """Middle of its corners."""
    names = [block.name for block in model.assembly.blocks]
    middle: np.ndarray = model.assembly.solid(names.index("s.drum")).vertices.mean(axis=0)
    return middle


def test_a_round_joint_slides_as_one(cradle: Model) -> None:
    """The drum turns about the middle of its arc; told where a facet moves fastest, by the arc's speed."""
    assert len(cradle.interfaces) == FACETS
    x, y = drum(cradle)
    found = seen(cradle, {"s.drum": (-y, x)}, {"s.drum": 1.0})
    (joint,) = found.joints
    assert (joint.how, joint.facets) == ("slides", tuple(range(FACETS)))
    assert found.sentence() == f"s.drum moves; 1 sliding joint: {' / '.join(joint.between)}"
    assert np.linalg.norm(joint.at) == pytest.approx(np.cos(np.radians(5.0)))
    assert np.linalg.norm(joint.slip) == pytest.approx(np.cos(np.radians(5.0)))
    assert sum("slides" in line for line in found.words()) == 1


def test_a_round_joint_that_turns_about_its_end_is_one_hinge(cradle: Model) -> None:
    end = np.array([np.cos(np.radians(LAST)), np.sin(np.radians(LAST))])
    x, y = drum(cradle) - end
    found = seen(cradle, {"s.drum": (y, -x)}, {"s.drum": -1.0})
    (joint,) = found.joints
    assert joint.how == "hinge"
    np.testing.assert_allclose(joint.at, end, atol=1e-9)


def test_a_round_joint_that_rests_keeps_its_blocks_together(cradle: Model) -> None:
    found = seen(cradle, {"s.drum": (1.0, 0.0), "s.cradle": (1.0, 0.0)}, {})
    assert found.joints == ()
    assert len(found.parts) == 1


def test_a_block_in_space_tells_its_axis() -> None:
    model = model_of(StackStructure(name="s", material="stone", size=(1.0, 0.6, 0.5), count=1), 3)
    name = next(block.name for block in model.assembly.blocks if "ground" not in block.name)
    middle = model.assembly.solid([b.name for b in model.assembly.blocks].index(name)).vertices.mean(axis=0)
    edge = np.array([0.0, 0.6, 0.0])
    spin = np.array([-1.0, 0.0, 0.0])
    found = seen(model, {name: np.cross(spin, middle - edge)}, {name: spin})
    (joint,) = found.joints
    assert joint.how == "hinge"
    np.testing.assert_allclose(joint.at, [0.5, 0.6, 0.0], atol=1e-9)
    assert "about the axis (-1, 0, 0)" in found.words()[0]


def test_many_parts_are_told_as_macro_blocks() -> None:
    """The left half of a wall slides, its right half turns, and every brick wobbles a little."""
    model = model_of(WallStructure(name="w", material="stone", brick=(0.4, 0.2), columns=8, courses=8))
    random = np.random.default_rng(1)
    velocity, spin = {}, {}
    for block in model.assembly.blocks:
        if "ground" in block.name:
            continue
        middle = model.assembly.solid(model.assembly.blocks.index(block)).vertices.mean(axis=0)
        right = middle[0] > 1.6
        turned = -0.4 * np.array([-middle[1], middle[0] - 3.2])
        moved = turned if right else np.array([0.5, 0.0])
        velocity[block.name] = tuple(moved + 0.01 * random.uniform(-1, 1, 2))
        spin[block.name] = (-0.4 if right else 0.0) + 0.01 * random.uniform(-1, 1)
    found = seen(model, velocity, spin)
    assert len(found.parts) > 50
    right = {name for name in velocity if velocity[name][1] > 0.02}
    halves = {frozenset(right), frozenset(velocity.keys() - right)}
    assert {frozenset(part.blocks) for part in found.macroblocks} == halves
    turning = max(found.macroblocks, key=lambda part: abs(part.spin[0]))
    assert turning.spin[0] * found.speed == pytest.approx(-0.4, rel=0.05)
    assert turning.pole == pytest.approx([3.2, 0.0], abs=0.1)
    assert "nearly so in 2: " in found.sentence()
    assert len(found.words()) < 30
    assert len(found.told().parts) == len(found.parts)
