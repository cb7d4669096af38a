"""Piers: corbels, buttresses and columns: their volumes, joints, and what they stand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import SceneError
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    AnyStructure,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    PointForce,
    Scene,
    Statics,
)
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import build_structure
from masonry_fem.structures.buttress import ButtressStructure
from masonry_fem.structures.column import ColumnStructure
from masonry_fem.structures.corbel import CorbelStructure
from tests.validation.scenes import G, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
DENSITY = 2400.0


def built(spec: AnyStructure, dimension: int) -> Assembly:
    assert list(spec.faults(dimension)) == []
    made = build_structure(spec, dimension, Path(), MeshSettings())
    assert overlapping(made) == []
    return made


def volume(made: Assembly) -> float:
    return sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)


def areas(made: Assembly) -> list[float]:
    return [one.area for one in detect(made) if one.label == "bed"]


def outcome(spec: AnyStructure, dimension: int = 2, friction: float = 0.6, **keys) -> str:
    result = solved(dimension=dimension, fidelity="rigid", structures=(spec,),
                    joints=(Joint(friction=friction),), analysis=ONE_STEP, **keys)  # fmt: skip
    return result.outcome


def refusal(spec: AnyStructure, dimension: int = 2) -> str:
    scene = Scene(dimension=dimension, fidelity="rigid", structures=(spec,),
                  materials={"stone": Material(density=DENSITY)})  # fmt: skip
    with pytest.raises(SceneError) as caught:
        check(scene)
    return str(caught.value)


# --- corbel -----------------------------------------------------------------------------------------


def corbel(dimension: int = 2, **keys) -> CorbelStructure:
    size = (1.0, 0.2) if dimension == 2 else (1.0, 0.5, 0.2)
    return CorbelStructure(**({"name": "c", "material": "stone", "size": size} | keys))


@pytest.mark.parametrize("offset", [0.125, -0.125])
@pytest.mark.parametrize("dimension", [2, 3])
def test_corbel_stands_out_evenly(dimension, offset) -> None:
    made = built(corbel(dimension, count=4, offset=offset, table=True), dimension)
    lows = [made.solid(i).vertices[:, 0].min() for i in range(1, 5)]
    assert lows == pytest.approx([offset * k for k in range(1, 5)])
    depth = 0.5 if dimension == 3 else 1.0
    assert areas(made) == pytest.approx([(1 - abs(offset)) * depth] * 4)


def test_harmonic_offsets_grow_towards_the_top() -> None:
    made = built(corbel(count=4, offset=0.5, profile="harmonic", table=True), 2)
    lows = [made.solid(i).vertices[:, 0].min() for i in range(1, 5)]
    assert np.diff([0.0, *lows]) == pytest.approx([1 / 8, 1 / 6, 1 / 4, 1 / 2])


@pytest.mark.parametrize(("count", "table"), [(3, False), (5, False), (3, True), (5, True)])
def test_a4_7_corbel_stands_to_one_over_n(count, table) -> None:
    limit = 1.0 / (count + table)
    assert outcome(corbel(count=count, offset=0.98 * limit, table=table)) == "equilibrium"
    assert outcome(corbel(count=count, offset=1.02 * limit, table=table)) == "no_equilibrium"


@pytest.mark.parametrize(("count", "overhang"), [(4, 1.041667), (10, 1.464484)])
def test_a4_7_harmonic_corbel(count, overhang) -> None:
    def stands(share: float) -> str:
        return outcome(corbel(count=count, offset=share / 2, profile="harmonic", table=True))

    made = built(corbel(count=count, offset=0.5, profile="harmonic", table=True), 2)
    assert made.solid(count).vertices[:, 0].min() == pytest.approx(overhang, abs=1e-6)
    assert stands(0.98) == "equilibrium"
    assert stands(1.02) == "no_equilibrium"


def test_corbel_of_boxes_beside_each_other_is_refused() -> None:
    assert "offset is 1.0, expected less than the length of a box (1 m)" in refusal(
        corbel(count=2, offset=1.0)
    )
    assert "table is true, expected false" in refusal(corbel(count=2, offset=0.1, table=True, ground=False))


# --- buttress ---------------------------------------------------------------------------------------


def buttress(**keys) -> ButtressStructure:
    return ButtressStructure(**({"name": "p", "material": "stone", "width": 1.0, "height": 3.0} | keys))


@pytest.mark.parametrize("stones", [1, 2, 3])
@pytest.mark.parametrize("lean", [-10.0, 0.0, 20.0])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("keys", "area"), [({}, 3.0), ({"top": 0.4}, 2.1), ({"top": 0.5, "stages": 3}, 2.25)]
)
def test_buttress_has_its_profile(keys, area, dimension, lean, stones) -> None:
    made = built(buttress(courses=6, depth=0.5, lean=lean, stones=stones, **keys), dimension)
    depth = 0.5 if dimension == 3 else 1.0
    assert volume(made) == pytest.approx(area * depth, rel=1e-12)
    width = keys.get("top", 1.0)
    widths = {  # of the bed below each course
        (): [1.0] * 6,
        ("top",): [1 - 0.6 * k / 6 for k in range(6)],
        ("top", "stages"): [1.0, 1.0, 0.75, 0.75, 0.5, 0.5],
    }[tuple(keys)]  # fmt: skip
    slope = np.tan(np.radians(lean)) * 0.5  # to the right, of the lower bed of a course: courses are flush
    assert sum(areas(made)) == pytest.approx(sum(widths) * depth, rel=1e-9)
    top = [made.solid(i).vertices for i, block in enumerate(made.blocks) if "p.c6" in block.groups]
    edge = np.concatenate(top)
    edge = edge[edge[:, -1] > 3 - 1e-9, 0]
    assert (edge.min(), edge.max()) == pytest.approx((6 * slope, 6 * slope + width), abs=1e-12)
    lengths = [np.ptp(made.solid(i).vertices[:, 0]) for i, b in enumerate(made.blocks) if not b.support]
    assert min(lengths) > 0.4 / stones


def test_stones_of_a_buttress_are_lapped_and_shared() -> None:
    made = built(buttress(courses=6, stones=3), 2)
    assert [sum(f"p.c{c}" in block.groups for block in made.blocks) for c in (1, 2)] == [3, 4]
    assert len({block.shape for block in made.blocks if not block.support}) == 2


def test_groups_of_a_stepped_buttress() -> None:
    made = built(buttress(courses=5, top=0.5, stages=2), 2)
    assert [sum(f"p.stage{s}" in block.groups for block in made.blocks) for s in (1, 2)] == [3, 2]


def thrust(limit: float, **keys) -> str:
    """Outcome under a horizontal force at the top left corner; friction that never slips."""
    courses = keys["courses"]
    load = PointForce(block=f"p.c{courses}.b1", point=(0.0, 3.0), vector=(limit, 0.0))
    loads = Loads(gravity=(0.0, -G), points=(load,))
    return outcome(buttress(**keys), friction=2.0, loads=loads)


@pytest.mark.parametrize("courses", [1, 4])
def test_a6_1_rectangular_buttress_overturns(courses) -> None:
    """H = γ b² / 2, whatever the height of the hinge."""
    limit = DENSITY * G / 2
    assert thrust(0.98 * limit, courses=courses) == "equilibrium"
    assert thrust(1.02 * limit, courses=courses) == "no_equilibrium"


def test_sloping_buttress_overturns() -> None:
    """About its toe: H h = γ (rectangle and triangle) times their arms."""
    top, height = 0.4, 3.0
    arm = top * height * (1 - top / 2) + 0.6 * height / 2 * (2 / 3 * 0.6)
    limit = DENSITY * G * arm / height
    assert thrust(0.98 * limit, courses=1, top=top) == "equilibrium"
    assert thrust(1.02 * limit, courses=1, top=top) == "no_equilibrium"


def test_leaning_buttress_falls_by_itself() -> None:
    """When its centroid, at tan(lean) h / 2 + b / 2, passes its toe: tan(lean) = b / h."""
    limit = np.arctan(1.0 / 3.0)
    assert outcome(buttress(lean=np.degrees(0.98 * limit))) == "equilibrium"
    assert outcome(buttress(lean=np.degrees(1.02 * limit))) == "no_equilibrium"


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"top": 1.5}, "top is 1.5, expected at most the width at the foot (1 m)"),
        ({"stages": 2, "courses": 4}, "lacks the key 'top'"),
        ({"stages": 2, "courses": 4, "top": 1.0}, "for stages to differ"),
        ({"stages": 3, "courses": 2, "top": 0.5}, "at most as many as courses (2)"),
    ],
)
def test_impossible_buttresses_are_refused(keys, expected) -> None:
    assert expected in refusal(buttress(**keys))


# --- column -----------------------------------------------------------------------------------------


def column(**keys) -> ColumnStructure:
    return ColumnStructure(
        **({"name": "c", "material": "stone", "drums": 4, "height": 4.0, "diameter": 1.0} | keys)
    )


@pytest.mark.parametrize("sides", [3, 4, 12, 25])
def test_drums_have_the_volume_of_the_cone(sides) -> None:
    made = built(column(sides=sides, top_diameter=0.8), 3)
    low, high = np.pi / 4, np.pi / 4 * 0.8**2
    assert volume(made) == pytest.approx(4.0 / 3 * (low + high + np.sqrt(low * high)), rel=1e-12)
    assert areas(made) == pytest.approx([np.pi / 4 * d**2 for d in (1.0, 0.95, 0.9, 0.85)], rel=1e-9)


def test_equal_drums_share_a_shape_between_plinth_and_capital() -> None:
    made = built(column(plinth=0.3, capital=0.4, projection=0.1), 3)
    names = [block.name for block in made.blocks]
    assert names == ["c.ground", "c.plinth", "c.d1", "c.d2", "c.d3", "c.d4", "c.capital"]
    assert len(made.shapes) == 4
    assert volume(made) == pytest.approx(np.pi + 1.2**2 * 0.7, rel=1e-12)
    assert made.solid(6).vertices[:, 2].max() == pytest.approx(4.7)
    assert sorted(areas(made)) == pytest.approx([np.pi / 4] * 5 + [1.44], rel=1e-9)


def test_entasis_swells_the_column_at_half_height() -> None:
    made = built(column(top_diameter=0.8, entasis=0.05), 2)
    feet = [np.ptp(made.solid(i).vertices[:2, 0]) for i in range(1, 5)]
    assert feet == pytest.approx([1.0, 0.95 + 0.0375, 0.9 + 0.05, 0.85 + 0.0375])


@pytest.mark.parametrize("dimension", [2, 3])
def test_column_overturns(dimension) -> None:
    """Under a horizontal acceleration of b / h: b is the distance between opposite sides."""
    wide = 1.0 if dimension == 2 else np.sqrt(np.pi / 12 / np.tan(np.pi / 12))

    def at(share: float) -> str:
        push = share * wide / 4.0 * G
        down = (push, -G) if dimension == 2 else (push, 0.0, -G)
        return outcome(column(), dimension, friction=1.0, loads=Loads(gravity=down))

    assert at(0.98) == "equilibrium"
    assert at(1.02) == "no_equilibrium"


def test_impossible_columns_are_refused() -> None:
    assert "projection is 0.1, expected 0 without a plinth" in refusal(column(projection=0.1), 3)
    assert "entasis is 0.1, expected 0 for a single drum" in refusal(column(entasis=0.1, drums=1), 3)


@pytest.mark.parametrize(
    "spec",
    [
        corbel(3, count=3, offset=0.2),
        buttress(courses=3, top=0.5, lean=5.0, stones=2),
        column(drums=2, height=1.0, top_diameter=0.9, sides=8, capital=0.2),
    ],
)
def test_elastic_piers_carry_their_weight(spec) -> None:
    # a corbel's box needs nodes at the edge of the one below: five elements in its length
    mesh = MeshSettings(element="P1" if isinstance(spec, ColumnStructure) else "Q1", divisions=(5, 1, 1))
    result = solved(fidelity="elastic", structures=(spec,), joints=(Joint(friction=0.6),), analysis=Statics(),
                    mesh=mesh)  # fmt: skip
    assert result.outcome == "equilibrium"
    weight = DENSITY * G * volume(built(spec, 3))
    (support,) = result.summary.supports.values()
    assert support.force[2] == pytest.approx(weight, rel=1e-6)
