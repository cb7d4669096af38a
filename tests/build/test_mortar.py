"""Mortar beds and dilatancy from the scene to displacements in closed form."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.output.fields import contact_arrays
from masonry_fem.scene import check, specs
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure

K_N, K_T = 2e9, 0.8e9
MORTAR = specs.Mortar(normal_stiffness=K_N, tangential_stiffness=K_T)
WIDTH, HEIGHT, DENSITY, G = 0.4, 0.2, 2000.0, 9.81


def stack(dimension, joint, *, count=3, up=(0.0,), **keys):
    """Blocks one on another on the ground, one metre deep; ``up`` are loads besides gravity."""
    size = (WIDTH, HEIGHT) if dimension == 2 else (WIDTH, 1.0, HEIGHT)
    young = 1e10
    given = {
        "dimension": dimension,
        "materials": {"stone": specs.Material(density=DENSITY, young=young, poisson=0.0)},
        "structures": (StackStructure(name="s", material="stone", size=size, count=count),),
        "joints": (joint,),
        "fidelity": "rigid",
        "mesh": specs.MeshSettings(divisions=(2,) * dimension),
        "loads": specs.Loads(gravity=(*(0.0,) * (dimension - 1), -G)),
        "probes": (specs.Probe(name="top", block=f"s.b{count}", point=at(dimension, count * HEIGHT)),),
        "analysis": specs.Statics(),
        "solver": specs.Solver(tolerance=1e-12),
    }
    return specs.Scene(**(given | keys))


def at(dimension, height):
    return (WIDTH / 2, height) if dimension == 2 else (WIDTH / 2, 0.5, height)


def solved(scene):
    result = solve_scene(check(scene))
    marches = isinstance(scene.analysis, specs.Dynamics)
    assert result.outcome == ("finished" if marches else "equilibrium"), result.message
    return result


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_column_settles_by_its_weight_over_the_stiffness_of_its_beds(dimension, fidelity):
    scene = stack(dimension, specs.Joint(mortar=MORTAR), fidelity=fidelity)
    scene = msgspec.structs.replace(
        scene, overrides=(specs.Override(blocks="s.ground", fidelity="rigid"),) * (fidelity == "elastic")
    )
    stress = DENSITY * G * HEIGHT
    expected = (1 + 2 + 3) * stress / K_N
    if fidelity == "elastic":  # nodal values of a bar under its weight are exact
        expected += DENSITY * G * (3 * HEIGHT) ** 2 / 2 / 1e10
    result = solved(scene)
    moved = result.march.report.probes["top"]
    assert moved[-1] == pytest.approx(-expected, rel=1e-9)
    assert result.summary.certificate.max_penetration <= 1e-9 * expected
    assert moved[:-1] == pytest.approx(0.0, abs=1e-9 * expected)


def test_a_layer_by_its_thickness_and_moduli():
    mortar = specs.Mortar(thickness=0.01, young=1e9, poisson=0.25)
    moved = solved(stack(2, specs.Joint(mortar=mortar), count=1)).march.report.probes["top"]
    assert moved[1] == pytest.approx(-DENSITY * G * HEIGHT / 1.2e11, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_shear_slides_by_the_tangential_stiffness_before_friction_gives(dimension):
    """A push of a quarter of the weight; the blocks turn by the moment over the bed's, too."""
    joint = specs.Joint(friction=0.6, mortar=MORTAR)
    side = (0.25 * G, *(0.0,) * (dimension - 1))
    loads = specs.Loads(
        gravity=(*(0.0,) * (dimension - 1), -G), accelerations=(specs.Acceleration(vector=side),)
    )
    result = solved(stack(dimension, joint, count=1, loads=loads))
    jump = result.march.state.jump
    shear = 0.25 * DENSITY * G * HEIGHT
    along = np.linalg.norm(jump[:, 1:].mean(axis=0))
    assert along == pytest.approx(shear / K_T, rel=1e-9)
    turn = shear * WIDTH * HEIGHT / 2 / (K_N * WIDTH * (WIDTH / 2) ** 2)
    closing = DENSITY * G * HEIGHT / K_N + np.array([-1, 1]) * turn * WIDTH / 2
    assert np.unique(np.round(-jump[:, 0], 15)) == pytest.approx(closing, rel=1e-6)
    assert result.march.report.slip == 0


def test_crushing_caps_the_pressure():
    """σ = 3.924 kPa on a bed that crushes at 3 kPa and hardens."""
    mortar = msgspec.structs.replace(MORTAR, crushing=3e3, hardening=1e7)
    result = solved(stack(2, specs.Joint(mortar=mortar), count=1))
    stress = DENSITY * G * HEIGHT
    assert result.march.report.probes["top"][1] == pytest.approx(
        -stress / K_N - (stress - 3e3) / 1e7, rel=1e-9
    )
    crushed = (stress - 3e3) / 1e7
    lost = WIDTH * (3e3 + 0.5e7 * crushed) * crushed
    assert result.march.report.joint_dissipation == pytest.approx(lost, rel=1e-9)


def test_a_bonded_bed_stretches_both_ways_and_breaks():
    joint = specs.Joint(friction=0.75, law=specs.law_record("mohr_coulomb", cohesion=0.3e6), mortar=MORTAR)

    def pulled(stress):
        loads = specs.Loads(tractions=(specs.Traction(on="s.b1/top", vector=(0.0, stress)),))
        return solve_scene(check(stack(2, joint, count=1, loads=loads)))

    held = pulled(0.39e6)
    assert held.outcome == "equilibrium"
    assert held.march.report.probes["top"][1] == pytest.approx(0.39e6 / K_N, rel=1e-9)
    assert pulled(0.41e6).outcome == "no_equilibrium"


def test_springs_on_a_bed_are_in_series():
    law = specs.law_record("elastic", normal_stiffness=1e9, tangential_stiffness=1e9)
    loads = specs.Loads(tractions=(specs.Traction(on="s.b1/top", vector=(0.0, 0.0, 1e5)),))
    scene = stack(3, specs.Joint(law=law, mortar=MORTAR), count=1, loads=loads)
    moved = solved(scene).march.report.probes["top"]
    assert moved[2] == pytest.approx(1e5 / K_N + 1e5 / 1e9, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_on_mortar_swings_at_its_frequency(dimension):
    """Half a period after its weight acts at once it is lowest, nearly twice as low as it settles."""
    mass, steps = DENSITY * HEIGHT, 100
    half = np.pi * np.sqrt(mass / K_N)
    scene = stack(dimension, specs.Joint(mortar=MORTAR), count=1, solver=specs.Solver(),
                  analysis=specs.Dynamics(step=half / steps, duration=half))  # fmt: skip
    lowest = solved(scene).march.report.probes["top"][-1]
    damped = np.exp(-np.pi * np.pi / steps / 2)  # reactions act at the end of a step: ζ = ω h/2
    assert lowest == pytest.approx(-(1 + damped) * mass * G / K_N, rel=1e-3)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("mortar", [None, specs.Mortar(normal_stiffness=1e12, tangential_stiffness=1e12)])
def test_a_sliding_block_rises_by_the_dilatancy(dimension, mortar):
    tangent, bound, speed = 0.2, 1e-3, 0.3
    joint = specs.Joint(friction=0.5, mortar=mortar, dilatancy=specs.Dilatancy(tangent=tangent, bound=bound))
    scene = stack(
        dimension, joint, count=1,
        initial=(specs.Initial(blocks="s.b1", velocity=(speed, *(0.0,) * (dimension - 1))),),
        analysis=specs.Dynamics(step=1e-3, duration=0.08), solver=specs.Solver(),
    )  # fmt: skip
    moved = solved(scene).march.report.probes["top"]
    assert moved[0] == pytest.approx(speed**2 / (2 * 0.5 * G), rel=0.1)  # nearly: it is lifted as well
    assert moved[-1] == pytest.approx(-bound * np.expm1(-tangent * moved[0] / bound), rel=1e-3)


@pytest.mark.parametrize("element", ["P2", "Q2"])
def test_points_without_an_area_bear_nothing_on_mortar(element):
    """The corner nodes of quadratic triangles."""
    scene = stack(3, specs.Joint(mortar=MORTAR), count=1, fidelity="elastic",
                  mesh=specs.MeshSettings(element=element, size=0.2))  # fmt: skip
    moved = solved(scene).march.report.probes["top"]
    expected = DENSITY * G * (HEIGHT / K_N + HEIGHT**2 / 2e10)
    assert moved[2] == pytest.approx(-expected, rel=1e-4)


def test_points_without_an_area_have_no_cohesion():
    joint = specs.Joint(law=specs.law_record("mohr_coulomb", cohesion=0.3e6))
    scene = stack(3, joint, count=1, fidelity="elastic", mesh=specs.MeshSettings(element="P2", size=0.2))
    model = solved(scene).built.model
    kinds = {law.name: len(points) for law, points in model.laws.parts}
    assert kinds["dry"] == (model.contacts.area <= 1e-12 * WIDTH).sum() > 0
    assert kinds["mohr_coulomb"] + kinds["dry"] == model.contacts.count


def test_what_beds_and_roughness_did_is_a_field():
    mortar = msgspec.structs.replace(MORTAR, crushing=3e3, hardening=1e7)
    rough = specs.Dilatancy(tangent=0.2, bound=1e-3)
    result = solved(stack(3, specs.Joint(mortar=mortar, dilatancy=rough), count=1))
    arrays = contact_arrays(result.built.model, result.march.state)
    settled = DENSITY * G * HEIGHT / K_N
    crushed = (DENSITY * G * HEIGHT - 3e3) / 1e7
    np.testing.assert_allclose(arrays["crushed"], -crushed, rtol=1e-9)
    np.testing.assert_allclose(arrays["bed"], np.array([[0, 0, -settled - crushed]] * 4), atol=1e-15)
    np.testing.assert_allclose(arrays["dilation"], 0.0, atol=1e-12)
    dry = solved(stack(3, specs.Joint(), count=1))
    assert not {"bed", "crushed", "dilation"} & set(contact_arrays(dry.built.model, dry.march.state))


@pytest.mark.parametrize(
    ("mortar", "words"),
    [
        ({"normal_stiffness": 1e9}, r"joints\.0\.mortar lacks 'tangential_stiffness'"),
        ({"thickness": 0.01}, r"joints\.0\.mortar lacks 'young'"),
        ({}, r"joints\.0\.mortar lacks 'normal_stiffness', expected .*or thickness and young"),
        ({"normal_stiffness": 1e9, "tangential_stiffness": 1e9, "young": 1e9}, "both stiffnesses and"),
        ({"normal_stiffness": 1e9, "tangential_stiffness": 1e9, "poisson": 0.2}, "both stiffnesses and"),
        ({"thickness": 0.01, "young": 1e9, "hardening": 1e9}, "hardening is .* expected a crushing strength"),
    ],
)  # fmt: skip
def test_a_mortar_is_given_in_one_of_two_ways(mortar, words):
    with pytest.raises(SceneError, match=words):
        check(stack(2, specs.Joint(mortar=specs.Mortar(**mortar))))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"friction": 0.1}, r"joints\.0\.dilatancy: .*0\.2, expected at most the friction 0\.1"),
        (
            {"law": specs.law_record("mohr_coulomb", cohesion=1e5, residual_friction=0.15)},
            r"at most the friction 0\.15",
        ),
        ({"dynamic_friction": 0.15}, r"at most the friction 0\.15"),
        ({"form": "velocity"}, r"joints\.0\.form is 'velocity' beside a dilatancy"),
    ],
)
def test_dilatancy_must_not_create_energy(keys, words):
    joint = specs.Joint(dilatancy=specs.Dilatancy(tangent=0.2, bound=1e-3), **keys)
    with pytest.raises(SceneError, match=words):
        build(check(stack(2, joint)), Path())


@pytest.mark.parametrize("dimension", [2, 3])
def test_cohesion_across_a_gap_is_told(dimension, caplog):
    """A rigid law pulls faces together that were apart at the start; springs wait until they open."""
    stacked = StackStructure(
        name="s", material="stone", size=(WIDTH,) * (dimension - 1) + (HEIGHT,), count=3, gap=1e-4
    )
    for law, told in (
        (specs.law_record("mohr_coulomb", cohesion=1e5), True),
        (specs.law_record("elastic", normal_stiffness=1e9, tangential_stiffness=1e9), False),
    ):
        caplog.clear()
        scene = stack(dimension, specs.Joint(law=law), structures=(stacked,), probes=())
        with caplog.at_level("WARNING"):
            build(check(scene), Path())
        assert ("up to 0.0001 m apart at the start, and mohr_coulomb pulls" in caplog.text) == told
    caplog.clear()
    with caplog.at_level("WARNING"):
        build(
            check(stack(dimension, specs.Joint(law=specs.law_record("mohr_coulomb", cohesion=1e5)))), Path()
        )
    assert not caplog.records


def test_a_corner_on_a_face_has_no_mortar():
    """A tilted square on its corner, held from tipping by nothing but symmetry."""
    block = BlockStructure(
        name="tilted", material="stone", size=(0.2, 0.2), position=(0.0, 0.0), rotation=45.0
    )
    floor = BlockStructure(
        name="floor", material="stone", size=(2.0, 0.2), position=(-1.0, -0.2), support=True
    )
    joint = specs.Joint(law=specs.law_record("mohr_coulomb", cohesion=1e5), mortar=MORTAR)
    scene = stack(
        2, joint, structures=(block, floor), probes=(), analysis=specs.Dynamics(step=1e-3, duration=5e-3)
    )
    result = solved(scene)
    assert [law.name for law, _ in result.built.model.laws.parts] == ["dry"]
    assert result.march.state.reaction[0, 0] == pytest.approx(0.04 * DENSITY * G, rel=1e-3)


@pytest.mark.parametrize("joint", [
    specs.Joint(mortar=MORTAR),
    specs.Joint(mortar=msgspec.structs.replace(MORTAR, crushing=3e3, hardening=1e8)),
    specs.Joint(friction=0.3, dynamic_friction=0.2, mortar=MORTAR,
                dilatancy=specs.Dilatancy(tangent=0.1, bound=1e-3)),
], ids=["elastic", "crushing", "rough"])  # fmt: skip
def test_what_joints_take_of_the_work_is_accounted_for(joint):
    """Stored, burnt and rubbed; the rest is what backward steps damp, never negative, and goes with them."""
    rests = []
    for step in (5e-5, 2.5e-5):
        loads = specs.Loads(gravity=(0.0, -G), accelerations=(specs.Acceleration(vector=(0.5 * G, 0.0)),))
        scene = stack(2, joint, count=1, loads=loads, analysis=specs.Dynamics(step=step, duration=0.003),
                      solver=specs.Solver())  # fmt: skip
        made = solved(scene).march
        ledger, stored = made.ledger, made.report.joint_energy
        rests.append(
            (-ledger.contact_work - ledger.joint_dissipation - ledger.friction_dissipation - stored)
            / ledger.external_work
        )
    assert 0 < rests[1] < 0.75 * rests[0]
