"""Joints with cohesion, from the scene to the reactions."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.output.fields import contact_arrays
from masonry_fem.results.summary import Abrupt
from masonry_fem.scene import check, specs
from masonry_fem.structures.block import BlockStructure

AREA = 0.04
RCC = specs.law_record("fremond_cangemi", normal_stiffness=1e10, tangential_stiffness=1e10, energy=50.0)
GLUE = specs.law_record("elastic", normal_stiffness=1e13, tangential_stiffness=1e13)


def cubes(law, *, top=False, **keys):
    """A cube on a fixed one, both 0.2 m; with ``top`` a third one, held, glued to the free one."""
    blocks = [
        BlockStructure(
            name=name, material="stone", size=(0.2,) * 3, position=(0.0, 0.0, 0.2 * i), support=name != "mid"
        )
        for i, name in enumerate(("low", "mid", "top")[: 3 if top else 2])
    ]
    joints = [specs.Joint(friction=0.75, law=law)]
    if top:
        joints.append(specs.Joint(between=("top", "mid"), law=GLUE))
    given = {
        "materials": {"stone": specs.Material(density=2400.0)},
        "structures": tuple(blocks),
        "joints": tuple(joints),
        "fidelity": "rigid",
        "loads": specs.Loads(),
        "analysis": specs.Statics(),
        "solver": specs.Solver(tolerance=1e-12),
    }
    return specs.Scene(**(given | keys))


def pulled(law, stress, axis=2, **keys):
    vector = [0.0, 0.0, 0.0]
    vector[axis] = stress
    loads = specs.Loads(tractions=(specs.Traction(on="mid/top", vector=tuple(vector)),))
    return solve_scene(check(cubes(law, loads=loads, **keys)))


@pytest.mark.parametrize(
    ("law", "strength"),
    [
        (specs.law_record("mohr_coulomb", cohesion=0.35e6), 0.35e6 / 0.75),
        (specs.law_record("mohr_coulomb", cohesion=0.35e6, tensile_strength=0.2e6), 0.2e6),
        (specs.law_record("constant_threshold", strength=0.3e6), 0.3e6),
    ],
    ids=["cone's tip", "cut-off", "threshold"],
)
def test_a_joint_holds_a_pull_up_to_its_strength(law, strength):
    assert pulled(law, 0.98 * strength).outcome == "equilibrium"
    assert pulled(law, 1.02 * strength).outcome == "no_equilibrium"


def test_springs_stretch_by_stress_over_stiffness():
    law = specs.law_record("elastic", normal_stiffness=2e9, tangential_stiffness=1e9)
    probes = (specs.Probe(name="p", block="mid", point=(0.1, 0.1, 0.3)),)
    result = pulled(law, 1e5, probes=probes)
    assert result.outcome == "equilibrium"
    assert result.march.report.probes["p"] == pytest.approx([0, 0, 1e5 / 2e9], abs=1e-15)


def test_adhesion_decays_as_the_joint_opens():
    """Validation A7.1: r = w²/(c u³) beyond u_0 = √(w/c), here in series with stiff glue."""
    u0 = np.sqrt(50.0 / 1e10)
    motion = specs.Support(on="top", motion=specs.Motion(displacement=(0.0, 0.0, 3 * u0)))
    scene = cubes(RCC, top=True, supports=(motion,), analysis=specs.Statics(load_steps=6))
    result = solve_scene(check(scene))
    assert result.outcome == "equilibrium"
    force = -result.march.report.support_resultants["low"][2]
    opening = result.march.state.jump[:4, 0]
    joints = result.march.state.joints
    assert force / AREA == pytest.approx(50.0**2 / (1e10 * opening.mean() ** 3), rel=1e-9)
    assert opening.mean() + force / AREA / 1e13 == pytest.approx(3 * u0, rel=1e-9)
    assert joints.adhesion[:4] == pytest.approx((u0 / opening) ** 2, rel=1e-9)
    assert joints.dissipated[:4].sum() == pytest.approx(50.0 * AREA * (1 - joints.adhesion[0]), rel=1e-9)
    assert result.summary.certificate.block_balance <= 1e-9
    assert result.summary.certificate.cone_violation <= 1e-9
    assert result.summary.certificate.min_normal_reaction >= -1e-6


def test_dry_joints_beside_cohesive_ones_are_not_damaged():
    """The joint above rests on its weight and has no adhesion to lose."""
    dry = specs.Joint(friction=0.4, between=("high", "mid"))
    high = BlockStructure(name="high", material="stone", size=(0.2,) * 3, position=(0.0, 0.0, 0.4))
    scene = cubes(RCC, loads=specs.Loads(gravity=(0.0, 0.0, -9.81)))
    scene = msgspec.structs.replace(
        scene, structures=(*scene.structures, high), joints=(*scene.joints, dry)
    )  # fmt: skip
    result = solve_scene(check(scene))
    assert result.outcome == "equilibrium"
    model, state = result.built.model, result.march.state
    adhesion = contact_arrays(model, state)["adhesion"]
    assert list(adhesion[:4]) == [1.0] * 4
    assert np.isnan(adhesion[4:]).all()
    assert len(adhesion) == 8
    friction = result.march.last.problem.friction
    np.testing.assert_array_equal(friction, [0.75] * 4 + [0.4] * 4)


def test_without_cohesion_a_law_changes_nothing():
    push = specs.Loads(gravity=(0.0, 0.0, -9.81), accelerations=(specs.Acceleration(vector=(2.0, 0.0, 0.0)),))
    dry, law = (
        solve_scene(check(cubes(one, loads=push)))
        for one in (None, specs.law_record("mohr_coulomb", cohesion=0.0))
    )
    np.testing.assert_array_equal(dry.march.state.reaction, law.march.state.reaction)


def test_what_laws_do_not_go_with():
    bed = specs.Mortar(normal_stiffness=1e10, tangential_stiffness=5e9)
    joint = specs.Joint(law=RCC, mortar=bed, form="velocity")
    with pytest.raises(SceneError, match=r"joints.0.form is 'velocity' beside a mortar"):
        build(check(cubes(RCC, joints=(joint,))), Path())


def test_parameters_that_contradict_each_other():
    law = specs.law_record("bilinear",
        normal_stiffness=1e9, tangential_stiffness=1e9, normal_strength=1e6, tangential_strength=1e6,
        normal_energy=1.0, tangential_energy=1.0,
    )  # fmt: skip
    with pytest.raises(SceneError, match=r"joints.0.law: .*normal_energy is 1 J/m².*500 J/m²"):
        build(check(cubes(law)), Path())


def stretched(**analysis):
    """A joint that softens from 0.7 MPa in series with one 40 times as compliant, pulled at its end.

    Local snap-back: the compliant joint gives more than the soft branch lets go.
    """
    compliant = specs.law_record("elastic", normal_stiffness=2.5e8, tangential_stiffness=2.5e8)
    peak = np.sqrt(50.0 * 1e10)
    end = 1.5 * (peak / 2.5e8 + peak / 1e10)
    motion = specs.Support(on="top", motion=specs.Motion(displacement=(0.0, 0.0, end)))
    scene = cubes(RCC, top=True, supports=(motion,), analysis=specs.Statics(**analysis))
    joints = (scene.joints[0], specs.Joint(between=("top", "mid"), law=compliant))
    return solve_scene(check(msgspec.structs.replace(scene, joints=joints)))


@pytest.mark.slow
def test_a_snap_back_is_told_and_narrowed_down_by_substeps(caplog):
    """The joint breaks at 2/3 of the path; the step around it is divided, the others are not."""
    whole, divided = stretched(load_steps=10), stretched(load_steps=10, substeps=100)  # halves: 64
    assert whole.march.report.step == 10
    assert whole.summary.abrupt == Abrupt(steps=1, first=0.7, last=0.7)
    assert "joints gave way abruptly in 1 of 10 steps, first at t = 0.7" in caplog.text
    assert divided.march.report.step == 10 + 6
    assert divided.summary.abrupt.first == pytest.approx(2 / 3, abs=0.1 / 64)
    assert "even in 1/64 of a load step: the structure snaps back" in caplog.text
    for result in (whole, divided):
        assert result.outcome == "equilibrium"
    np.testing.assert_allclose(
        divided.march.state.reaction, whole.march.state.reaction, rtol=1e-6, atol=1e-6 * 2e4
    )


def test_softening_that_is_followed_is_not_called_abrupt():
    u0 = np.sqrt(50.0 / 1e10)
    motion = specs.Support(on="top", motion=specs.Motion(displacement=(0.0, 0.0, 3 * u0)))
    scene = cubes(RCC, top=True, supports=(motion,), analysis=specs.Statics(load_steps=20, substeps=8))
    result = solve_scene(check(scene))
    assert result.summary.abrupt is None
    assert result.march.report.step == 20


BOUNCY = {"form": "velocity", "restitution": 0.8, "friction": 0.75}


def dropped(law, height, **keys):
    """A cube dropped on another; heights that its base has been at [m]."""
    scene = cubes(law, **keys)
    low, mid = scene.structures
    raised = msgspec.structs.replace(mid, position=(0.0, 0.0, 0.2 + height))
    scene = msgspec.structs.replace(
        scene,
        structures=(low, raised),
        joints=(specs.Joint(law=law, **BOUNCY),),
        contact=specs.Contact(reach=2 * height + 1e-3),
        loads=specs.Loads(gravity=(0.0, 0.0, -9.81)),
        analysis=specs.Dynamics(step=1e-3, duration=0.5),
        probes=(specs.Probe(name="p", block="mid", point=(0.1, 0.1, 0.2 + height)),),
    )
    seen = []

    class Watch:
        def record(self, model, state, report):
            seen.append(height + report.probes["p"][2])

    assert solve_scene(check(scene), observers=(Watch(),)).outcome == "finished"
    return np.array(seen)


@pytest.mark.slow
def test_a_joint_with_restitution_bounces_once_its_cohesion_is_gone():
    """Faces that meet for the first time in flight are not bonded: c = 0 and dry are the same to rounding."""
    dry, loose = (dropped(law, 0.05) for law in (None, specs.law_record("mohr_coulomb", cohesion=0.0)))
    np.testing.assert_allclose(dry, loose, rtol=0, atol=1e-14 * dry.max())
    landed = int((dry < 1e-3).argmax())
    assert dry[landed + 5 :].max() == pytest.approx(0.64 * 0.05, rel=0.05)


@pytest.mark.slow
def test_cohesion_holds_across_a_gap_in_the_velocity_form():
    """Springs let the joint open and stay in force though the contact is open: it swings."""
    law = specs.law_record("elastic", normal_stiffness=1e7, tangential_stiffness=1e7)
    weight, area = 2400.0 * 0.008 * 9.81, AREA
    sag = weight / (1e7 * area)
    period = 2 * np.pi * np.sqrt(2400.0 * 0.008 / (1e7 * area))

    def swung(step):
        scene = cubes(
            law,
            joints=(specs.Joint(law=law, **BOUNCY),),
            loads=specs.Loads(gravity=(0.0, 0.0, 9.81)),
            analysis=specs.Dynamics(step=step, duration=2.2 * period, theta=0.5),
            probes=(specs.Probe(name="p", block="mid", point=(0.1, 0.1, 0.2)),),
        )
        seen = []

        class Watch:
            def record(self, model, state, report):
                seen.append(report.probes["p"][2])

        assert solve_scene(check(scene), observers=(Watch(),)).outcome == "finished"
        return np.array(seen)

    coarse, fine = swung(period / 200), swung(period / 400)
    short = [1 - seen.max() / (2 * sag) for seen in (coarse, fine)]
    assert 0 < short[1] < short[0] < 0.03
    assert short[0] / short[1] == pytest.approx(2, rel=0.1)  # springs are implicit: order 1
    assert fine[:300].argmax() + 1 == pytest.approx(200, abs=2)
    assert fine[400:].max() > 1.8 * sag  # it comes again
    assert fine.min() > -1e-2 * sag


def parts_of_the_energy(steps: int) -> dict[str, float]:
    """Springs that soften in series with glue, and friction; supports pull."""
    u0 = np.sqrt(50.0 / 1e10)
    motion = specs.Support(on="top", motion=specs.Motion(displacement=(2 * u0, 0.0, 3 * u0)))
    scene = cubes(RCC, top=True, supports=(motion,), analysis=specs.Statics(load_steps=steps))
    result = solve_scene(check(scene))
    assert "missing from its ledger" in result.message  # softening is not resolved to 1e-6
    energy = asdict(result.summary.energy)
    given = sum(energy[name] for name in ("start", "external_work", "support_work", "unaccounted"))
    kept = sum(energy[name] for name in ("kinetic", "strain", "joints"))
    lost = sum(v for k, v in energy.items() if k.endswith(("dissipation", "viscosity")) or "impact" in k)
    assert given == pytest.approx(kept + lost, rel=1e-12)
    return energy | {"given": given}


@pytest.mark.slow
def test_the_parts_of_the_energy_are_its_work():
    """Nothing is in no item, and what the laws cannot name vanishes as steps shorten."""
    missing = [abs(one["unaccounted"]) / one["given"] for one in map(parts_of_the_energy, (30, 120, 480))]
    assert missing[2] < 0.02 * missing[0] < 1e-4
