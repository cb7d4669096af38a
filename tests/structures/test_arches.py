"""Arches of all forms: closed forms of areas, joints where they belong, who stands and who falls."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec import structs
from scipy.integrate import quad
from scipy.optimize import brentq, linprog

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.meshing.mesher import mesh_shape
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
from masonry_fem.structures import build_structure
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.catenary_arch import CatenaryArchStructure
from masonry_fem.structures.elliptical_arch import EllipticalArchStructure
from masonry_fem.structures.flat_arch import FlatArchStructure
from masonry_fem.structures.parts.curve import Catenary, Ellipse, Offset, equal_parts, length
from masonry_fem.structures.pointed_arch import PointedArchStructure
from tests.meshing.test_meshing import check as check_mesh
from tests.meshing.test_meshing import volumes

G, DENSITY = 9.81, 2000.0
FORMS = {
    "pointed": (PointedArchStructure, {"span": 2.0, "rise": 1.5}),
    "pointed, vertical": (PointedArchStructure, {"span": 2.0, "rise": 1.5, "cut": "vertical"}),
    "flat": (FlatArchStructure, {"span": 2.0}),
    "elliptical": (EllipticalArchStructure, {"span": 3.0, "rise": 1.0}),
    "elliptical, vertical": (EllipticalArchStructure, {"span": 3.0, "rise": 1.0, "cut": "vertical"}),
    "catenary": (CatenaryArchStructure, {"span": 2.0, "rise": 1.5}),
    "catenary, vertical": (CatenaryArchStructure, {"span": 2.0, "rise": 1.5, "cut": "vertical"}),
    "circular, vertical": (ArchStructure, {"radius": 1.0, "cut": "vertical"}),
}


def spec(form: str, **keys) -> AnyStructure:
    kind, own = FORMS[form]
    return kind(**({"name": "arch", "material": "stone", "thickness": 0.2, "voussoirs": 11} | own | keys))


def built(form: str, dimension: int = 2, **keys) -> Assembly:
    return build_structure(spec(form, **keys), dimension, Path(), MeshSettings())


def area(made: Assembly) -> float:
    return sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)


def solved(structure: AnyStructure, friction: float, **keys) -> RunResult:
    down = (0.0, -G) if keys.setdefault("dimension", 2) == 2 else (0.0, 0.0, -G)
    given = {
        "fidelity": "rigid",
        "materials": {"stone": Material(density=DENSITY, young=10e9, poisson=0.2)},
        "structures": (structure,),
        "joints": (Joint(friction=friction),),
        "loads": Loads(gravity=down),
        "solver": Solver(tolerance=1e-12) if keys.get("fidelity", "rigid") == "rigid" else Solver(),
        "analysis": Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6),
    } | keys
    return solve_scene(Scene(**given))


# --- areas ---------------------------------------------------------------------------------------


def chain(rise: float) -> float:
    """Least radius c of a catenary of span 2: rise = c (cosh 1/c − 1)."""
    return brentq(lambda c: c * (np.cosh(1 / c) - 1) - rise, 0.1, 10.0, xtol=1e-14)


def exact_area(form: str) -> float:
    """Area between two faces at half the thickness from the mean line, the ends square to it."""
    t = 0.2
    if form == "flat":
        return t * (2.0 + t * np.tan(np.radians(30.0)))
    if form.startswith("circular"):
        return np.pi * t
    if form.startswith("elliptical"):
        return t * quad(lambda p: np.hypot(1.5 * np.sin(p), np.cos(p)), 0, np.pi, epsabs=1e-13)[0]
    if form.startswith("catenary"):
        c = chain(1.5)
        return t * 2 * c * np.sinh(1 / c)
    assert form.startswith("pointed")
    radius, e = 1.5**2 / 2 + 0.5, 1.5**2 / 2 - 0.5  # of the arcs, and of their centres from the middle

    def half(r: float) -> float:
        """Between the middle, the springing line and one arc."""
        return quad(lambda x: np.sqrt(r * r - (x + e) ** 2), 0, r - e, epsabs=1e-12)[0]

    return 2 * (half(radius + t / 2) - half(radius - t / 2))


@pytest.mark.parametrize("voussoirs", [1, 2, 10, 11])
@pytest.mark.parametrize("form", FORMS)
def test_areas_are_exact(form: str, voussoirs: int) -> None:
    assert area(built(form, voussoirs=voussoirs)) == pytest.approx(exact_area(form), rel=1e-10)


@pytest.mark.parametrize("form", ["pointed", "elliptical", "catenary"])
def test_straight_stones_lack_an_area_that_falls_with_their_square(form: str) -> None:
    lacking = [1 - area(built(form, voussoirs=n, straight=True)) / exact_area(form) for n in (20, 40)]
    assert lacking[0] / lacking[1] == pytest.approx(4.0, rel=0.05)


def test_a_pointed_arch_of_no_point_is_the_circular_one() -> None:
    circular = build_structure(
        ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.2, voussoirs=11),
        2, Path(), MeshSettings(),
    )  # fmt: skip
    pointed = built("pointed", rise=1.0)
    for one, two in zip(circular.blocks, pointed.blocks, strict=True):
        assert (one.name, one.groups, one.support) == (two.name, two.groups, two.support)
    middles = [
        [made.solid(i).mass_properties().centroid for i in range(2, 13)] for made in (circular, pointed)
    ]
    # the keystone has twice the facets there: its centroid is nearer to the sector's
    assert np.array(middles[0]) == pytest.approx(np.array(middles[1]), abs=3e-6)


def test_radius_and_rise_of_a_pointed_arch_say_the_same() -> None:
    equilateral = built("pointed", radius=2.0, rise=None)
    assert area(equilateral) == pytest.approx(area(built("pointed", rise=np.sqrt(3.0))), rel=1e-12)
    top = max(equilateral.solid(i).vertices[:, 1].max() for i in range(2, 13))
    assert top == pytest.approx(np.sqrt(2.1**2 - 1), rel=1e-3)


def test_joints_of_a_flat_arch_meet_in_one_point() -> None:
    made = built("flat", focus=3.0, centre=(5.0, 1.0))
    for interface in detect(made):
        a, b = interface.polygon
        along, to_focus = b - a, np.array([5.0, -2.0]) - a
        assert abs(along[0] * to_focus[1] - along[1] * to_focus[0]) < 1e-12
    skew = np.degrees(np.arctan(1 / 3.0))
    assert area(built("flat", skewback=skew)) == pytest.approx(area(made), rel=1e-12)


# --- joints --------------------------------------------------------------------------------------


@pytest.mark.parametrize("voussoirs", [1, 2, 7, 12])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("form", FORMS)
def test_every_joint_is_found_once_and_nothing_overlaps(form: str, dimension: int, voussoirs: int) -> None:
    made = built(form, dimension, voussoirs=voussoirs, depth=0.4)
    interfaces = detect(made)
    assert len(interfaces) == voussoirs + 1
    assert {block for one in interfaces for block in one.blocks} == set(range(voussoirs + 2))
    assert max(np.abs(one.gap).max() for one in interfaces) == 0.0
    assert overlapping(made) == []
    inner = "vertical" if "vertical" in form else "radial"
    assert Counter(one.label for one in interfaces) == Counter(["radial"] * 2 + [inner] * (voussoirs - 1))
    vertical = [one.normal[-1] for one in interfaces if one.label == "vertical"]
    assert vertical == pytest.approx([0.0] * len(vertical), abs=1e-12)
    for one in interfaces:
        areas = [
            np.linalg.norm(made.solid(block).area_vector(face))
            for block, face in zip(one.blocks, one.faces, strict=True)
            if not made.blocks[block].support
        ]
        assert areas == pytest.approx([one.area] * len(areas), rel=1e-12)
        if form in {"elliptical", "catenary"}:
            assert one.area == pytest.approx(0.2 * (0.4 if dimension == 3 else 1.0), rel=1e-12)


@pytest.mark.parametrize("form", FORMS)
def test_keystone_and_springers_have_names(form: str) -> None:
    made = built(form, voussoirs=5)
    of_group = {
        group: [b.name for b in made.blocks if group in b.groups]
        for group in ("arch.keystone", "arch.springers")
    }
    assert of_group == {"arch.keystone": ["arch.v03"], "arch.springers": ["arch.v01", "arch.v05"]}
    assert not any("arch.keystone" in block.groups for block in built(form, voussoirs=4).blocks)
    solids = [made.solid(i) for i in range(len(made.blocks))]
    places = [
        s.mass_properties().centroid[0] for s, b in zip(solids, made.blocks, strict=True) if not b.support
    ]
    assert places == sorted(places)
    for solid, block in zip(solids, made.blocks, strict=True):
        if not block.support:  # start is the left joint
            left, right = (solid.face_points(solid.names.index(n)).mean(axis=0)[0] for n in ("start", "end"))
            assert left < right


@settings(max_examples=30, deadline=None)
@given(
    kind=st.sampled_from([PointedArchStructure, EllipticalArchStructure, CatenaryArchStructure]),
    cut=st.sampled_from(["radial", "vertical"]),
    slender=st.floats(0.02, 0.9),
    rise=st.floats(0.15, 2.5),
    voussoirs=st.integers(1, 25),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_arches_of_any_proportions(kind, cut, slender, rise, voussoirs, scale) -> None:
    """What the checks let through is built: joints between all neighbours, no overlap, exact area."""
    rise = max(rise, 0.5) if kind is PointedArchStructure else rise
    keys = {"name": "arch", "material": "stone", "cut": cut, "voussoirs": voussoirs}
    line = {"span": scale, "rise": rise * scale}
    arch = kind(**keys, **line, thickness=slender * 0.3 * scale)
    assume(not list(arch.faults(2)))
    if kind is CatenaryArchStructure:
        assume(arch.thickness < 2 * Catenary.through(arch.span, arch.rise).scale)
    made = build_structure(arch, 2, Path(), MeshSettings())
    interfaces = detect(made)
    assert len(interfaces) == voussoirs + 1
    assert overlapping(made) == []
    one = build_structure(structs.replace(arch, voussoirs=1), 2, Path(), MeshSettings())
    assert area(made) == pytest.approx(area(one), rel=1e-7)
    solids = [made.solid(i) for i, block in enumerate(made.blocks) if not block.support]
    assert all(solid.mass_properties().volume > 0 for solid in solids)


def test_congruent_stones_share_a_shape() -> None:
    assert len({b.shape for b in built("pointed", 3, voussoirs=12).blocks if not b.support}) == 3
    assert len({b.shape for b in built("pointed", 3, voussoirs=13).blocks if not b.support}) == 2


def test_right_half_mirrors_the_left() -> None:
    for form in FORMS:
        made = built(form, voussoirs=10)
        stones = [made.solid(i).mass_properties() for i, b in enumerate(made.blocks) if not b.support]
        for one, two in zip(stones, stones[::-1], strict=True):
            assert one.volume == pytest.approx(two.volume, rel=1e-12)
            assert one.centroid == pytest.approx(two.centroid * [-1, 1], abs=1e-12)


# --- meshes --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("dimension", "element"), [(2, "Q1"), (2, "Q2"), (3, "Q1"), (3, "P1")])
@pytest.mark.parametrize("form", FORMS)
def test_stones_are_meshed_along_their_faces(form: str, dimension: int, element: str) -> None:
    """As many elements along the arc as facets reproduce the stone and its mass."""
    made = built(form, dimension, voussoirs=5)
    divisions = (32, 1, 2) if dimension == 3 else (32, 2)
    for shape in {block.shape for block in made.blocks if not block.support}:
        kind = made.shapes[shape]
        mesh = mesh_shape(kind, MeshSettings(element=element, divisions=divisions), dimension)
        check_mesh(mesh, kind.solid)


def test_nodes_lie_on_the_point_of_a_keystone() -> None:
    made = built("pointed", voussoirs=5)
    keystone = next(made.shapes[b.shape] for b in made.blocks if "arch.keystone" in b.groups)
    mesh = mesh_shape(keystone, MeshSettings(divisions=(3, 2)), 2)
    assert len(mesh.cells) == 4 * 2
    for rail in keystone.rails:
        apex = keystone.solid.vertices[rail[len(rail) // 2]]
        assert np.linalg.norm(mesh.points - apex, axis=1).min() < 1e-12


def test_size_of_elements_counts_along_the_stone() -> None:
    made = built("elliptical", 3, voussoirs=3, depth=0.5)
    keystone = next(made.shapes[b.shape] for b in made.blocks if "arch.keystone" in b.groups)
    mesh = mesh_shape(keystone, MeshSettings(size=0.11), 3)
    line = Offset(Ellipse(1.5, 1.0), 0.1)
    joints = equal_parts(line.line, -np.pi / 2, np.pi / 2, 3)
    along = np.ceil(length(line, joints[1], joints[2]) / 0.11)  # the extrados is longest
    assert len(mesh.cells) == along * np.ceil(0.5 / 0.11) * np.ceil(0.2 / 0.11)


# --- what cannot be built --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("form", "keys", "words"),
    [
        ("pointed", {"radius": 1.5}, "one of 'rise' and 'radius'"),
        ("pointed", {"rise": None}, "one of 'rise' and 'radius'"),
        ("pointed", {"rise": 0.9}, r"rise is 0.9.*at least half the span \(1 m\)"),
        ("pointed", {"rise": None, "radius": 0.9}, r"radius is 0.9.*at least half the span \(1 m\)"),
        ("pointed", {"thickness": 0.6, "rise": 3.0, "voussoirs": 51}, "joints beside the crown would cross"),
        ("flat", {"skewback": 20.0, "focus": 1.0}, "one of 'skewback' and 'focus'"),
        ("elliptical", {"thickness": 1.4}, r"least radius of curvature \(0.666667 m\)"),
        ("circular, vertical", {"embrace": 200.0}, "at most 180 with vertical joints"),
    ],
)
def test_forms_that_make_no_sense_are_refused(form: str, keys: dict, words: str) -> None:
    scene = Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": Material(density=DENSITY)},
        structures=(spec(form, **keys),),
        joints=(Joint(friction=0.6),),
    )
    with pytest.raises(SceneError, match=words):
        check(scene, base=Path())


def test_a_catenary_thicker_than_round_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"arch.thickness is 1.5 m, expected less than twice"):
        built("catenary", thickness=1.5)


# --- equilibrium -----------------------------------------------------------------------------------


def thrust_bounds(made: Assembly) -> tuple[float, float] | None:
    """Least and greatest horizontal thrust over weight without tension or sliding, by linear programming.

    Forces act at both ends of each joint; a force's two components push at will along the joint.
    """
    stones = [i for i, b in enumerate(made.blocks) if not b.support]
    ends = []
    for i in stones:
        solid = made.solid(i)
        for name in ("start", "end") if i == stones[-1] else ("start",):
            points = solid.face_points(solid.names.index(name))
            ends.append(points[::-1] if name == "start" else points)  # from intrados to extrados
    n, size = len(stones), 4 * len(ends)
    balance, load = np.zeros((3 * n, size)), np.zeros(3 * n)
    for row, i in enumerate(stones):
        mass = made.solid(i).mass_properties()
        load[3 * row : 3 * row + 3] = [0.0, mass.volume, mass.volume * mass.centroid[0]]
        for joint, sign in ((row, 1.0), (row + 1, -1.0)):
            normal, tangent = axes_of(ends[joint])
            for k, point in enumerate(ends[joint]):
                for c, axis in enumerate((normal, tangent)):
                    column = 4 * joint + 2 * k + c
                    balance[3 * row : 3 * row + 2, column] = sign * axis
                    balance[3 * row + 2, column] = sign * (point[0] * axis[1] - point[1] * axis[0])
    push = np.zeros(size)
    push[:4] = np.tile([axis[0] for axis in axes_of(ends[0])], 2)
    limits = [(0, None), (None, None)] * (2 * len(ends))
    found = [linprog(s * push, A_eq=balance, b_eq=load, bounds=limits) for s in (1, -1)]
    if found[0].status != 0:
        return None
    weight = load[1::3].sum()
    return tuple(
        s * one.fun / weight if one.status == 0 else np.inf for s, one in zip((1, -1), found, strict=True)
    )


def axes_of(joint: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal into the stone on the joint's right, and direction along the joint."""
    along = (joint[1] - joint[0]) / np.linalg.norm(joint[1] - joint[0])
    return np.array([along[1], -along[0]]), along


def reactions(result: RunResult) -> np.ndarray:
    return np.array([result.summary.supports[f"arch.springing_{s}"].force for s in ("left", "right")])


@pytest.mark.parametrize("form", FORMS)
def test_thrust_lies_between_the_bounds_of_linear_programming(form: str) -> None:
    """Rigid stones: the base force is the weight and the thrust is admissible."""
    structure = spec(form, voussoirs=9)
    made = build_structure(structure, 2, Path(), MeshSettings())
    result = solved(structure, 5.0)
    assert result.outcome == "equilibrium"
    left, right = reactions(result)
    weight = area(made) * DENSITY * G
    assert left[1] + right[1] == pytest.approx(weight, rel=1e-9)
    assert left[0] == pytest.approx(-right[0], rel=1e-9)
    low, high = thrust_bounds(made)
    assert low * 0.999 <= abs(left[0]) / weight <= high * 1.001


def least_thickness(form: str, low: float, high: float, accuracy: float = 1e-3, **keys) -> float:
    """By halving: the thinnest arch that linear programming finds to stand."""
    while high - low > accuracy * high:
        middle = (low + high) / 2
        low, high = (low, middle) if thrust_bounds(built(form, thickness=middle, **keys)) else (middle, high)
    return high


def test_the_program_knows_the_semicircle() -> None:
    """A3.2: t/R = .10491 for 11 voussoirs; a pointed arch without a point is one."""
    assert least_thickness("pointed", 0.05, 0.2, 1e-5, rise=1.0) == pytest.approx(0.10491, abs=2e-5)


@pytest.mark.parametrize(
    ("form", "keys"),
    [
        ("pointed", {}),
        ("pointed", {"voussoirs": 12}),
        ("pointed", {"rise": 1.2}),
        ("elliptical", {}),
        ("elliptical, vertical", {}),
        ("circular, vertical", {"voussoirs": 20}),
    ],
    ids=str,
)
def test_least_thickness_is_that_of_limit_analysis(form: str, keys: dict) -> None:
    least = least_thickness(form, 0.01, 0.4, **keys)
    assert solved(spec(form, **keys, thickness=1.02 * least), 5.0).outcome == "equilibrium"
    assert solved(spec(form, **keys, thickness=0.98 * least), 5.0).outcome == "no_equilibrium"


def test_vertical_joints_ask_for_a_thicker_semicircle() -> None:
    """With many of them t/R = .1095 (Makris and Alexakis 2013), against .1075 with radial ones."""
    for form, keys, least in (("circular, vertical", {}, 0.1095), ("pointed", {"rise": 1.0}, 0.1075)):
        made = [built(form, thickness=least + by, voussoirs=80, **keys) for by in (-1.5e-4, 1.5e-4)]
        assert [thrust_bounds(one) is not None for one in made] == [False, True]


@pytest.mark.parametrize("skewback", [10.0, 20.0, 30.0])
def test_a_flat_arch_of_one_stone_is_a_wedge(skewback: float) -> None:
    """A1.9: between faces without friction its thrust is W / (2 tan a)."""
    result = solved(spec("flat", voussoirs=1, span=0.5, skewback=skewback), 0.0)
    assert result.outcome == "equilibrium"
    left, right = reactions(result)
    assert left == pytest.approx(right * [-1, 1], rel=1e-9)
    assert abs(left[0]) / (2 * left[1]) == pytest.approx(1 / (2 * np.tan(np.radians(skewback))), rel=1e-9)


def test_a_catenary_stands_however_thin() -> None:
    """Its mean line is the line of thrust; at a hundredth of the semicircle's least thickness it stands."""
    thin = {"rise": 1.0, "thickness": 1e-3, "voussoirs": 21}
    result = solved(spec("catenary", **thin), 5.0)
    assert result.outcome == "equilibrium"
    made = built("catenary", **thin)
    thrust = abs(reactions(result)[0][0]) / (1e-3 * DENSITY * G)
    assert thrust == pytest.approx(chain(1.0), rel=5e-3)  # H = w c for a weight w per length
    assert thrust_bounds(made) is not None
    semicircle = ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.1, voussoirs=21)
    assert solved(semicircle, 5.0).outcome == "no_equilibrium"


@pytest.mark.parametrize("form", FORMS)
def test_elastic_stones_carry_their_weight(form: str) -> None:
    structure = spec(form, voussoirs=5, depth=0.3, mesh=MeshSettings(divisions=(4, 1, 3)))
    friction = 5.0 if "vertical" in form else 0.6  # steep thrust on upright joints
    result = solved(structure, friction, dimension=3, fidelity="elastic", analysis=Statics())
    assert result.outcome == "equilibrium"
    made = result.built.model.assembly
    masses = [
        DENSITY * volumes(made.shapes[block.shape].mesh).sum() for block in made.blocks if not block.support
    ]
    left, right = reactions(result)
    assert left + right == pytest.approx([0.0, 0.0, sum(masses) * G], rel=1e-8, abs=1e-6 * sum(masses) * G)
    assert left == pytest.approx(right * [-1, 1, 1], rel=1e-6, abs=1e-6 * sum(masses) * G)
    low, high = thrust_bounds(
        build_structure(structs.replace(structure, mesh=None), 2, Path(), MeshSettings())
    )
    assert low * 0.99 < left[0] / (sum(masses) * G) < high * 1.01
    assert sum(masses) == pytest.approx(0.3 * DENSITY * exact_area(form), rel=0.02)  # elements are chords
