"""Flying buttresses: straight and arched, square and upright ends, and what they hold up."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec import structs

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    AnyStructure,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Scene,
    Solver,
    Statics,
)
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import assemble, build_structure
from masonry_fem.structures.flying_buttress import FlyingButtressStructure
from masonry_fem.structures.portal import PortalStructure
from masonry_fem.structures.stack import StackStructure
from tests.meshing.test_meshing import volumes

G, DENSITY = 9.81, 2000.0


def spec(**keys) -> FlyingButtressStructure:
    given = {"span": 2.6, "inclination": 30.0, "thickness": 0.4, "voussoirs": 8}
    return FlyingButtressStructure(**({"name": "flyer", "material": "stone"} | given | keys))


def flyer(dimension: int = 2, **keys) -> Assembly:
    return build_structure(spec(**keys), dimension, Path(), MeshSettings())


@pytest.mark.parametrize("camber", [0.0, 0.4])
@pytest.mark.parametrize("ends", ["square", "vertical"])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_stones_touch_from_foot_to_head(dimension: int, side: str, ends: str, camber: float) -> None:
    made = flyer(dimension, side=side, ends=ends, camber=camber, depth=0.5)
    interfaces = detect(made)
    assert Counter(one.label for one in interfaces) == {"radial": 7, "head": 2}
    assert max(np.abs(one.gap).max() for one in interfaces) < 1e-12
    assert overlapping(made) == []
    names = [block.name for block in made.blocks]
    foot, head = (made.solid(names.index(f"flyer.{n}")).mass_properties().centroid for n in ("v01", "v08"))
    sign = 1 if side == "right" else -1
    assert sign * foot[0] > sign * head[0] > 0
    assert foot[-1] < head[-1] < 0.05  # the head is at the origin


@pytest.mark.parametrize("camber", [0.0, 0.4])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_vertical_ends_have_vertical_joints(dimension: int, side: str, camber: float) -> None:
    made = flyer(dimension, side=side, ends="vertical", camber=camber, depth=0.5)
    ends = [one.normal[-1] for one in detect(made) if one.label == "head"]
    assert ends == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("ends", ["square", "vertical"])
def test_volume_of_a_straight_flyer(side: str, ends: str) -> None:
    """A parallelogram with either kind of ends: length of the axis by thickness."""
    made = flyer(side=side, ends=ends)
    area = sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)
    assert area == pytest.approx(2.6 / np.cos(np.pi / 6) * 0.4, rel=1e-12)


def test_volume_of_an_arched_flyer() -> None:
    """Thickness by length of the arc, whose radius is c² / 8f + f / 2."""
    made = flyer(camber=0.4)
    chord = 2.6 / np.cos(np.pi / 6)
    radius = chord**2 / (8 * 0.4) + 0.2
    area = sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)
    assert area == pytest.approx(0.4 * 2 * radius * np.arcsin(chord / 2 / radius), rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(
    inclination=st.floats(0.0, 75.0),
    camber=st.floats(0.0, 0.45),
    thickness=st.floats(0.02, 0.5),
    voussoirs=st.integers(1, 12),
    ends=st.sampled_from(["square", "vertical", "vertical_head"]),
    side=st.sampled_from(["left", "right"]),
)
def test_flyers_of_any_proportions(inclination, camber, thickness, voussoirs, ends, side) -> None:
    """What is not refused has a joint between all neighbours, no overlap, and its head at the wall."""
    one = spec(
        inclination=inclination, thickness=thickness, voussoirs=voussoirs, ends=ends, side=side, span=1.0
    )
    one = structs.replace(one, camber=camber * one.chord if camber > 0.01 else 0.0)
    assume(not list(one.faults(2)))
    try:
        made = build_structure(one, 2, Path(), MeshSettings())
    except GeometryError:
        assume(ends == "square")  # never refused
        raise
    interfaces = detect(made)
    assert len(interfaces) == voussoirs + 1
    assert overlapping(made) == []
    head = next(i for i, block in enumerate(made.blocks) if block.name == "flyer.head")
    wall = next(interface for interface in interfaces if head in interface.blocks)
    if ends == "square":
        assert wall.polygon.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
    else:
        assert np.abs(wall.polygon[:, 0]).max() < 1e-12


def test_congruent_stones_share_a_shape() -> None:
    assert (
        len({b.shape for b in flyer(camber=0.4).blocks if not b.support}) == 3
    )  # labels of both ends differ
    assert len({b.shape for b in flyer(ends="vertical").blocks if not b.support}) == 3


def test_both_sides_mirror_each_other() -> None:
    left, right = (flyer(side=side, camber=0.3, ends="vertical") for side in ("left", "right"))
    for one, two in zip(left.blocks, right.blocks, strict=True):
        assert one.name == two.name
    for i, block in enumerate(left.blocks):
        if not block.support:
            middles = [made.solid(i).mass_properties().centroid for made in (left, right)]
            assert middles[0] == pytest.approx(middles[1] * [-1, 1], abs=1e-12)


@pytest.mark.parametrize("camber", [0.0, 0.4])
def test_elastic_flyers_carry_their_weight(camber: float) -> None:
    mesh = MeshSettings(divisions=(2, 1, 3))
    scene = Scene(
        fidelity="elastic",
        materials={"stone": Material(density=DENSITY, young=10e9)},
        structures=(spec(camber=camber, depth=0.3, mesh=mesh),),
        joints=(Joint(friction=0.7),),
        loads=Loads(gravity=(0.0, 0.0, -G)),
        analysis=Statics(),
    )
    result = solve_scene(scene)
    assert result.outcome == "equilibrium"
    made = result.built.model.assembly
    weight = G * sum(
        DENSITY * volumes(made.shapes[block.shape].mesh).sum() for block in made.blocks if not block.support
    )
    foot, head = (np.array(result.summary.supports[f"flyer.{n}"].force) for n in ("foot", "head"))
    assert foot + head == pytest.approx([0.0, 0.0, weight], rel=1e-8, abs=1e-6 * weight)
    assert foot[0] < 0 < head[0]  # the foot lies on the right of the wall


# --- leaning on a portal -------------------------------------------------------------------------------


def leaning(kind: str, depth: float | None = None) -> tuple[AnyStructure, ...]:
    """A portal too high to stand alone, flyers on both sides of it, and their own piers.

    Straight flyers have vertical ends on both walls; arched ones are quarters of a circle, from a level joint
    on top of their pier to a vertical one at the wall.
    """
    level, deep = ((0.0,), (depth,)) if depth else ((), ())
    span, height, outer, reach = 2.0, 1.45, 0.925 + 0.3, 0.9
    deeper = {"depth": depth} if depth else {}
    made: list[AnyStructure] = [
        PortalStructure(
            name="portal", material="stone", span=span, thickness=0.15, voussoirs=20, pier_width=0.3,
            pier_height=height, courses=4, **deeper,
        )
    ]  # fmt: skip
    arched = kind == "arched"
    form = (
        {"inclination": 45.0, "camber": reach * (1 - np.sqrt(0.5)), "thickness": 0.15}
        if arched
        else {"inclination": 10.0, "ends": "vertical", "thickness": 0.12}
    )
    for side, sign in (("left", -1), ("right", 1)):
        flyer = FlyingButtressStructure(
            name=f"flyer_{side}", material="stone", span=reach, voussoirs=5, side=side, head=False,
            foot=False, position=(sign * outer, *level, height - 0.1), **form, **deeper,
        )  # fmt: skip
        near = outer + reach - (0.075 if arched else 0.0)
        width, top = (0.6, height - 0.1 - reach) if arched else (0.6, 1.4)
        low = near if sign > 0 else -near - width
        pier = StackStructure(
            name=f"pier_{side}", material="stone", size=(width, *deep, top / 2), count=2,
            position=(low, *level, 0.0),
        )  # fmt: skip
        made += [flyer, pier]
    return tuple(made)


def solve(structures: tuple[AnyStructure, ...]) -> RunResult:
    scene = Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": Material(density=DENSITY)},
        structures=structures,
        joints=(Joint(friction=0.7),),
        loads=Loads(gravity=(0.0, -G)),
        analysis=Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6),
        solver=Solver(tolerance=1e-10),
    )
    return solve_scene(scene)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", ["straight", "arched"])
def test_flyers_touch_portal_and_piers_exactly(kind: str, dimension: int) -> None:
    parts = leaning(kind, 0.4 if dimension == 3 else None)
    made = assemble([build_structure(part, dimension, Path(), MeshSettings()) for part in parts])
    interfaces = detect(made)
    assert overlapping(made) == []
    ends = [one for one in interfaces if sum("flyer" in made.blocks[block].name for block in one.blocks) == 1]
    pairs = {tuple(sorted(made.blocks[b].name for b in one.blocks)) for one in ends}
    assert {name for pair in pairs for name in pair if "flyer" in name} == {
        f"flyer_{side}.v0{k}" for side in ("left", "right") for k in (1, 5)
    }
    assert max(np.abs(one.gap).max() for one in ends) < 1e-12
    full = 4 * (0.15 if kind == "arched" else 0.12 / np.cos(np.radians(10.0)))  # wholly on walls
    assert sum(one.area for one in ends) == pytest.approx(full * (0.4 if dimension == 3 else 1.0), rel=1e-9)


@pytest.mark.parametrize("kind", ["straight", "arched"])
def test_flyers_hold_up_a_portal_that_would_fall(kind: str) -> None:
    """A6.2: piers of .3 stand up to 1.32 R alone."""
    parts = leaning(kind)
    assert solve(parts[:1]).outcome == "no_equilibrium"
    result = solve(parts)
    assert result.outcome == "equilibrium"
    made = result.built.model.assembly
    weight = (
        DENSITY
        * G
        * sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)
    )
    total = np.sum([one.force for one in result.summary.supports.values()], axis=0)
    assert total == pytest.approx([0.0, weight], rel=1e-6, abs=1e-6 * weight)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"camber": 1.6}, r"camber is 1.6.*less than half the chord \(1.50111 m\)"),
        ({"ends": "vertical", "camber": 0.9}, "another where the axis is as steep as 91.9 degrees"),
    ],
)
def test_what_cannot_be_built(keys: dict, words: str) -> None:
    scene = Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": Material(density=DENSITY)},
        structures=(spec(**keys),),
        joints=(Joint(friction=0.6),),
    )
    with pytest.raises(SceneError, match=words):
        check(scene, base=Path())


def test_joints_that_would_cross_are_refused() -> None:
    with pytest.raises(GeometryError, match="voussoirs is 60, expected fewer"):
        flyer(voussoirs=60, ends="vertical")
