"""Walls: bonds, wythes tied by headers, openings with lintels, courses listed brick by brick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import SceneError
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Opening,
    Scene,
    Statics,
)
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import assemble, build_structure
from masonry_fem.structures.parts.bond import rows_of
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import G, solved

L, B, H = 0.4, 0.2, 0.1
BONDS = ("running", "stack", "header", "english", "flemish")
ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
WINDOW = Opening(position=(0.75, 0.2), size=(0.5, 0.3))
DOOR = Opening(position=(1.6, 0.0), size=(0.4, 0.6))


def wall(dimension: int = 2, **keys) -> WallStructure:
    brick = (L, H) if dimension == 2 else (L, B, H)
    given_keys = {"name": "w", "material": "stone", "brick": brick, "columns": 7, "courses": 8} | keys
    if "pattern" in keys:
        del given_keys["columns"]
    return WallStructure(**given_keys)


def built(spec: WallStructure) -> Assembly:
    dimension = len(spec.brick)
    assert list(spec.faults(dimension)) == []
    return build_structure(spec, dimension, Path(), MeshSettings())


def opening(x: float, z: float, width: float, height: float, **keys) -> Opening:
    return Opening(position=(x, z), size=(width, height), **keys)


def volume(made: Assembly) -> float:
    return sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)


def group(made: Assembly, name: str) -> list[int]:
    return [number for number, block in enumerate(made.blocks) if name in block.groups]


def refusal(spec: WallStructure) -> str:
    scene = Scene(dimension=len(spec.brick), fidelity="rigid", structures=(spec,),
                  materials={"stone": Material(density=2000.0)})  # fmt: skip
    with pytest.raises(SceneError) as caught:
        check(scene)
    return str(caught.value)


# --- bonds --------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("columns", [1, 2.5, 4, 5.5, 7, 8.5])
@pytest.mark.parametrize("bond", BONDS)
def test_a_bond_fills_its_wall(bond, columns, dimension) -> None:
    """Volume, bed joints over the whole area at every level, no overlap, no sliver."""
    wythes = dimension - 1
    spec = wall(dimension, bond=bond, columns=columns, courses=3, wythes=wythes)
    made = built(spec)
    depth = B * wythes if dimension == 3 else 1.0
    assert volume(made) == pytest.approx(columns * L * depth * 3 * H, rel=1e-12)
    assert overlapping(made) == []
    beds = sum(one.area for one in detect(made) if one.label == "bed")
    assert beds == pytest.approx(3 * columns * L * depth, rel=1e-9)
    lengths = [np.ptp(made.solid(i).vertices[:, 0]) for i in group(made, "w")[1:]]
    assert min(lengths) >= L / 4 * (1 - 1e-9)


@pytest.mark.parametrize(
    ("bond", "counts"),
    [("running", (4, 5)), ("stack", (4, 4)), ("header", (8, 7)), ("english", (4, 9)), ("flemish", (5, 7))],
)
def test_bricks_of_a_course(bond, counts) -> None:
    """Four bricks' length in the face: pencil and paper; a header shows half a brick, a closer a quarter."""
    made = built(wall(bond=bond, columns=4, courses=2))
    assert tuple(len(group(made, f"w.c{course}")) for course in (1, 2)) == counts


@pytest.mark.parametrize("columns", [4, 7, 10])
@pytest.mark.parametrize(("bond", "lap"), [("running", 2), ("header", 1), ("english", 1), ("flemish", 1)])
def test_head_joints_are_lapped(bond, lap, columns) -> None:
    """No head joint stands nearer than ``lap`` quarters over another; in stack bond all do."""
    spec = wall(bond=bond, columns=columns)
    joints = [
        {round(4 * piece.end / L) for row in rows_of(spec, course) for piece in row.pieces[:-1]}
        for course in (1, 2, 3)
    ]
    gaps = [abs(a - b) for one, two in ((0, 1), (1, 2)) for a in joints[one] for b in joints[two]]
    assert min(gaps) == lap


@pytest.mark.parametrize("wythes", [2, 3, 4, 5])
@pytest.mark.parametrize("keys", [{"bond": "english"}, {"bond": "header"}, {"header_courses": 2},
                                  {"bond": "flemish", "through": True},
                                  {"header_courses": 3, "through": True}])  # fmt: skip
def test_headers_tie_all_wythes(wythes, keys) -> None:
    made = built(wall(3, columns=4, courses=6, wythes=wythes, **keys))
    assert volume(made) == pytest.approx(1.6 * wythes * B * 0.6, rel=1e-12)
    assert overlapping(made) == []
    for number in range(1, wythes):
        plane = number * B
        sides = [made.solid(i).vertices[:, 1] for i in group(made, "w.headers")]
        assert any(y.min() < plane - 1e-9 and y.max() > plane + 1e-9 for y in sides)


def test_wythes_without_headers_are_not_tied() -> None:
    made = built(wall(3, wythes=2, courses=2, columns=3))
    assert group(made, "w.headers") == []
    assert len(group(made, "w.w1")) == len(group(made, "w.w2")) == 7
    collars = sum(one.area for one in detect(made) if one.label == "collar")
    assert collars == pytest.approx(3 * L * 2 * H)


def test_english_brick_and_a_half_shows_headers_on_one_face_and_stretchers_on_the_other() -> None:
    made = built(wall(3, bond="english", wythes=3, columns=4, courses=2))
    front = [[made.solid(i).vertices[:, 1].min() for i in group(made, f"w.c{c}")].count(0.0) for c in (1, 2)]
    assert front == [4, 9]
    headers = [np.ptp(made.solid(i).vertices, axis=0) for i in group(made, "w.headers")]
    assert np.array(headers)[:, 1] == pytest.approx(2 * B)


def test_equal_stones_share_a_shape() -> None:
    made = built(wall(3, bond="english", wythes=2, columns=4, courses=6))
    used = {block.shape for block in made.blocks if not block.support}
    assert len(used) == 3  # stretcher, header, closer


@pytest.mark.parametrize("bond", ["english", "flemish", "running"])
def test_whole_stretchers_of_any_bond_can_crack(bond) -> None:
    keys = {"bond": bond, "wythes": 2, "columns": 4, "courses": 4, "openings": (opening(0.9, 0.1, 0.4, 0.2),)}
    whole, cut = built(wall(3, **keys)), built(wall(3, cut=True, **keys))
    bricks = sum(np.ptp(whole.solid(i).vertices[:, 0]) > 0.99 * L for i in group(whole, "w.stretchers"))
    assert bricks > 4
    assert len(cut.blocks) == len(whole.blocks) + bricks
    assert [one.label for one in detect(cut)].count("brick") == bricks
    assert volume(cut) == pytest.approx(volume(whole), rel=1e-12)
    assert overlapping(cut) == []


# --- openings -----------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("bond", BONDS)
def test_openings_are_free_and_lintels_bear_on_both_jambs(bond, dimension) -> None:
    wythes = dimension - 1
    depth = B * wythes if dimension == 3 else 1.0
    made = built(wall(dimension, bond=bond, wythes=wythes, openings=(WINDOW, DOOR)))
    assert volume(made) == pytest.approx((7 * L * 0.8 - 0.5 * 0.3 - 0.4 * 0.6) * depth, rel=1e-12)
    assert overlapping(made) == []
    names = [block.name for block in made.blocks]
    for lintel, (left, right, level) in {
        "w.lintel1": (0.75, 1.25, 0.5),
        "w.lintel2": (1.6, 2.0, 0.6),
    }.items():
        stone = names.index(lintel)
        low, high = made.solid(stone).vertices.min(axis=0), made.solid(stone).vertices.max(axis=0)
        assert (low[0], high[0], low[-1], high[-1]) == pytest.approx(
            (left - L / 2, right + L / 2, level, level + H)
        )
        below = {"left": 0.0, "right": 0.0}
        for one in detect(made):
            if stone in one.blocks and one.label == "bed":
                other = one.blocks[one.blocks[0] == stone]
                centre = made.solid(other).mass_properties().centroid
                if centre[-1] < level:
                    below["left" if centre[0] < (left + right) / 2 else "right"] += one.area
        assert below == pytest.approx({"left": L / 2 * depth, "right": L / 2 * depth})


def test_door_up_to_the_top_has_no_lintel() -> None:
    made = built(wall(openings=(Opening(position=(1.0, 0.2), size=(0.7, 0.6)),)))
    assert group(made, "w.lintels") == []
    assert volume(made) == pytest.approx(7 * L * 0.8 - 0.7 * 0.6)


def test_lintel_of_two_courses_and_its_bearing() -> None:
    tall = Opening(position=(1.0, 0.1), size=(0.7, 0.3), lintel_courses=2, bearing=0.25)
    made = built(wall(openings=(tall,)))
    (stone,) = group(made, "w.lintels")
    assert made.solid(stone).vertices.min(axis=0) == pytest.approx([0.75, 0.4])
    assert made.solid(stone).vertices.max(axis=0) == pytest.approx([1.95, 0.6])
    assert overlapping(made) == []


@given(
    bond=st.sampled_from(BONDS),
    left=st.floats(0.1, 1.4),
    width=st.floats(0.1, 1.2),
    columns=st.sampled_from([7, 7.5]),
)
@settings(max_examples=60, deadline=None)
def test_no_opening_leaves_a_sliver(bond, left, width, columns) -> None:
    opening = Opening(position=(left, 0.1), size=(width, 0.3), lintel=False)
    spec = wall(bond=bond, columns=columns, courses=5, openings=(opening,))
    assume(not list(spec.faults(2)))
    made = built(spec)
    lengths = [np.ptp(made.solid(i).vertices[:, 0]) for i in group(made, "w")[1:]]
    assert min(lengths) >= L / 4 - 1e-6 * L
    assert max(lengths) <= L * (1 + 2e-6)
    assert volume(made) == pytest.approx(columns * L * 0.5 - width * 0.3, rel=1e-9)
    assert overlapping(made) == []


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        (
            {"openings": (opening(1.0, 0.25, 0.4, 0.2),)},
            "w.openings.0.position is [1.0, 0.25], expected an opening whose lower edge lies on a bed joint "
            "(a multiple of 0.1 m): at 0.2 m, not at 0.25 m",
        ),
        ({"openings": (opening(1.0, 0.2, 0.4, 0.25),)}, "w.openings.0.size is [0.4, 0.25], expected an open"),
        ({"openings": (opening(2.6, 0.2, 0.4, 0.3),)}, "an opening within the wall's length of 2.8 m"),
        ({"openings": (opening(0.15, 0.2, 0.4, 0.3),)}, "at least a quarter of a brick (0.1 m)"),
        ({"openings": (WINDOW, opening(1.3, 0.2, 0.4, 0.3))}, "between openings, lintels"),
        ({"openings": (opening(1.0, 0.2, 0.4, 0.5, lintel_courses=2),)}, "is 2, expected at most 1, so many"),
        ({"openings": (WINDOW,), "half_bricks": "none"}, "half_bricks is 'none', expected 'even' or 'odd'"),
        ({"bond": "english", "header_courses": 3}, "header_courses is 3, expected none in english bond"),
        ({"wythes": 2}, "wythes is 2, expected 1 in a 2D scene"),
        ({"columns": None}, "lacks the key 'columns'"),
        ({"pattern": ((1.0, 0.0),)}, "expected lengths that are not 0"),
        ({"pattern": ((1.0, 1.0),), "bond": "stack"}, "bond is 'stack', expected none beside a pattern"),
        ({"pattern": ((-1.0,),)}, "at least one brick"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(keys, expected) -> None:
    assert expected in refusal(wall(**keys))


def test_a_lintel_over_another_opening_is_refused() -> None:
    beside = Opening(position=(0.65, 0.4), size=(0.1, 0.1), lintel=False)
    assert "below both ends of its lintel" in refusal(wall(openings=(WINDOW, beside)))


# --- patterns (F&TL walls) --------------------------------------------------------------------------

E = (0.5, 1.0, 1.0, 1.0, 1.0, 0.5)
U = (1.0,) * 5
WU, WE = (1.0, -1.0, 1.0, -1.0, 1.0), (0.5, 0.5, -1.0, 0.5, 0.5, -1.0, 0.5, 0.5)
WALL_4 = (E, U, E, WU, WE, WU, WE, WU, E, U, E)


def test_pattern_repeats_to_the_number_of_courses() -> None:
    listed = built(wall(brick=(0.4, 0.175), pattern=(E, U), courses=6))
    bonded = built(wall(brick=(0.4, 0.175), columns=5, half_bricks="odd", courses=6))
    assert [b.name for b in listed.blocks] == [b.name for b in bonded.blocks]
    for number in range(len(listed.blocks)):
        assert np.array_equal(listed.solid(number).vertices, bonded.solid(number).vertices)


def test_pattern_with_openings() -> None:
    made = built(wall(pattern=WALL_4, courses=11))
    assert len(made.blocks) - 1 == sum(sum(length > 0 for length in course) for course in WALL_4)
    assert volume(made) == pytest.approx((11 * 5 - 5 * 2) * L * H)
    assert overlapping(made) == []


def test_pattern_in_a_thick_wall() -> None:
    made = built(wall(3, pattern=(E, U), courses=4, wythes=2))
    assert volume(made) == pytest.approx(5 * L * 2 * B * 4 * H)
    assert overlapping(made) == []


# --- mechanics --------------------------------------------------------------------------------------


@pytest.mark.parametrize("bond", BONDS)
def test_rigid_wall_with_openings_stands(bond) -> None:
    spec = wall(bond=bond, columns=6, courses=6, openings=(Opening(position=(0.9, 0.1), size=(0.5, 0.3)),))
    result = solved(dimension=2, fidelity="rigid", structures=(spec,), joints=(Joint(friction=0.6),),
                    analysis=ONE_STEP)  # fmt: skip
    assert result.outcome == "equilibrium"
    weight = 2400 * G * volume(built(spec))
    assert result.summary.supports["w.ground"].force[1] == pytest.approx(weight, rel=1e-6)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_thick_wall_stands(fidelity) -> None:
    spec = wall(3, bond="english", wythes=2, columns=2.5, courses=4)
    analysis = ONE_STEP if fidelity == "rigid" else Statics()
    result = solved(fidelity=fidelity, structures=(spec,), joints=(Joint(friction=0.6),), analysis=analysis,
                    mesh=MeshSettings(divisions=(1, 1, 1)))  # fmt: skip
    assert result.outcome == "equilibrium"
    weight = 2400 * G * volume(built(spec))
    assert result.summary.supports["w.ground"].force[2] == pytest.approx(weight, rel=1e-6)


def test_a4_3_wall_with_windows_from_a_pattern() -> None:
    """Five bricks wide, two windows over five courses: it rests at a body force of 0.25, not at 0.34."""
    spec = wall(brick=(0.4, 0.175), pattern=WALL_4, courses=11)

    def outcome(share: float) -> str:
        result = solved(dimension=2, fidelity="rigid", structures=(spec,), joints=(Joint(friction=0.65),),
                        loads=Loads(gravity=(share * G, -G)), analysis=ONE_STEP)  # fmt: skip
        return result.outcome

    assert outcome(0.25) == "equilibrium"
    assert outcome(1.02 * 0.33195) == "no_equilibrium"


# --- turned --------------------------------------------------------------------------------------------


def corners(made: Assembly) -> np.ndarray:
    return np.array([made.solid(i).vertices for i in range(len(made.blocks))])


@pytest.mark.parametrize("angle", [90.0, 180.0, 270.0, -90.0, 33.0])
def test_a_wall_turns_about_its_lower_left_front_corner(angle: float) -> None:
    place = (1.0, 2.0, 3.0)
    straight = built(wall(3, wythes=2, openings=(WINDOW,), position=place))
    turned = built(wall(3, wythes=2, openings=(WINDOW,), position=place, rotation=angle))
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = (corners(straight) - place) @ turn.T + place
    assert corners(turned) == pytest.approx(expected, abs=1e-12)
    assert [b.name for b in turned.blocks] == [b.name for b in straight.blocks]
    assert sorted(i.area for i in detect(turned)) == pytest.approx(sorted(i.area for i in detect(straight)))


def test_walls_bonded_into_a_tower_share_their_corners_and_touch_everywhere() -> None:
    """Patterns that leave the corners to each other in turns: a shaft without gap or overlap."""
    full, inset = [1.0, 1.0, 1.0], [-0.5, 1.0, 1.0, -0.5]
    side = 3 * L
    shaft = [
        wall(
            3,
            name=name,
            brick=(L, L / 2, H),
            pattern=pattern,
            courses=4,
            position=(x, y, 0.0),
            rotation=90.0 * quarter,
            ground=False,
        )
        for quarter, (name, pattern, x, y) in enumerate(
            (
                ("a", [full, inset], 0.0, 0.0),
                ("b", [inset, full], side, 0.0),
                ("c", [full, inset], side, side),
                ("d", [inset, full], 0.0, side),
            )
        )
    ]
    made = assemble([built(spec) for spec in shaft])
    ring = side**2 - (side - L) ** 2
    assert volume(made) == pytest.approx(ring * 4 * H, rel=1e-12)
    assert overlapping(made) == []
    joints = detect(made)
    assert max(np.abs(one.gap).max() for one in joints) < 1e-12
    beds = sum(one.area for one in joints if one.label == "bed")
    assert beds == pytest.approx(3 * ring, rel=1e-12)
    corner = [one for one in joints if len({made.blocks[b].name[0] for b in one.blocks}) == 2]
    upright = [one for one in corner if one.label != "bed"]
    assert len(upright) == 4 * 4  # each inset course leans on both neighbours
    assert sum(one.area for one in upright) == pytest.approx(16 * L / 2 * H, rel=1e-12)


def test_a_wall_in_the_plane_does_not_turn() -> None:
    ((key, expected),) = wall(2, rotation=90.0).faults(2)
    assert key == "rotation"
    assert expected.startswith("0 in a 2D scene")
