"""Stones that are heated: free, between walls, one on another, an arch between its abutments."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.march.equilibrium.dynamics import Dynamics
from masonry_fem.march.equilibrium.path import Path
from masonry_fem.march.rounds import NEWTON_TOLERANCE
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Contact,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Probe,
    Scene,
    Statics,
    Support,
    Table,
    Temperature,
    law_record,
    material_record,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure

YOUNG, POISSON, EXPANSION, CHANGE = 1e10, 0.2, 8e-6, 25.0
STRAIN = EXPANSION * CHANGE
STONE = Material(density=2000.0, young=YOUNG, poisson=POISSON, thermal_expansion=EXPANSION)
HEAT = (Temperature(on="bar", change=CHANGE),)
SIZE = (2.0, 0.5, 0.5)


def bar(held: tuple[str, ...], d: int = 2, material: Material = STONE, **keys: Any) -> RunResult:
    """A bar along x with some faces held along their normals; keys of the scene."""
    axes = {"left": "x", "right": "x", "bottom": "y" if d == 2 else "z", "front": "y"}
    size = SIZE[:d]
    told: dict[str, Any] = {
        "dimension": d,
        "plane": "stress" if d == 2 else "strain",
        "fidelity": "elastic",
        "materials": {"m": material},
        "structures": (
            BlockStructure(name="bar", material="m", size=size, mesh=MeshSettings(divisions=(2,) * d)),
        ),
        "supports": tuple(Support(on=f"bar/{face}", components=(axes[face],)) for face in held),
        "loads": Loads(temperatures=HEAT),
        "probes": (Probe(name="far", block="bar", point=size),),
        "analysis": Statics(load_steps=2),
    }
    return solve_scene(check(Scene(**(told | keys))))


def stress(result: RunResult) -> np.ndarray:
    """At all Gauss points, shape (q, 6)."""
    model, state = result.march.model, result.march.state
    (found,) = [
        group.stress(own) for group, own in zip(model.groups, state.bodies, strict=True) if group.deforms
    ]
    return found.gauss.reshape(-1, 6)


@pytest.mark.parametrize("d", [2, 3])
def test_what_is_free_expands_without_stress(d):
    result = bar(("left", "bottom", "front")[:d], d)
    assert np.abs(stress(result)).max() <= 1e-9 * YOUNG * STRAIN
    moved = result.march.report.probes["far"]
    np.testing.assert_allclose(moved, STRAIN * np.array(SIZE[:d]), rtol=1e-9)
    assert abs(result.march.ledger.strain) <= 1e-9 * 0.5 * YOUNG * STRAIN**2
    nothing_is_left_open(result)


def nothing_is_left_open(result: RunResult) -> None:
    """Forces and energies of a stone that nothing holds are rounding, and are no measure of each other."""
    assert result.march.message == "Equilibrium after 2 steps."
    assert not result.summary.remarks
    certificate, ledger = result.summary.certificate, result.march.ledger
    assert ledger.error <= ledger.rounding <= 1e-12 * 0.5 * YOUNG * STRAIN**2
    assert max(certificate.block_balance, certificate.global_balance) <= 1e-7
    assert certificate.written.balance.value <= 1e-7


@pytest.mark.parametrize("fidelity", ["elastic", "inelastic"])
@pytest.mark.parametrize("d", [2, 3])
def test_heat_is_all_that_acts_on_a_stone_on_its_ground(d, fidelity):
    law = material_record("drucker_prager", cohesion=1e6, friction_angle=30.0)
    stone = Material(density=2000.0, young=YOUNG, poisson=POISSON, thermal_expansion=EXPANSION, inelastic=law)
    stones = StackStructure(
        name="s", material="m", size=SIZE[:d], count=2, mesh=MeshSettings(divisions=(2,) * d)
    )
    heat = Loads(temperatures=(Temperature(on="*", change=CHANGE),))
    result = bar((), d, stone, fidelity=fidelity, structures=(stones,), probes=(), loads=heat)
    nothing_is_left_open(result)


@pytest.mark.parametrize("d", [2, 3])
def test_what_leaves_balance_beside_heat_is_seen(d):
    """A node of a free stone is moved by 1e-9 of what the stone expands: rounds would go on."""
    stone = yielding("drucker_prager", cohesion=1e6, friction_angle=30.0)
    last = bar(("left", "bottom", "front")[:d], d, stone, fidelity="inelastic").march
    (group,), made = last.model.groups, last.last
    ((before,), (after,)), scheme = (made.before.bodies, made.after.bodies), made.scheme

    def left(share: float) -> float:
        velocity = after.velocity.copy()
        velocity[:, -1] += share * STRAIN * SIZE[0] / scheme.step
        moved = group.between(before, after, replace(after, velocity=velocity), 1.0, scheme)
        still = np.zeros_like(moved.rigid_velocity)
        found = group.imbalance(before, before, moved, group.no_force(), still, None, scheme)
        return float((found / group.effort(moved, scheme)).max())

    assert left(0.0) <= 1e-3 * NEWTON_TOLERANCE
    assert left(1e-9) >= 10 * NEWTON_TOLERANCE


def test_plane_strain_holds_what_goes_out_of_the_plane():
    result = bar(("left", "bottom"), plane="strain")
    expected = [0, 0, -YOUNG * STRAIN, 0, 0, 0]
    np.testing.assert_allclose(stress(result), np.tile(expected, (16, 1)), atol=1e-9 * YOUNG * STRAIN)
    moved = result.march.report.probes["far"]
    np.testing.assert_allclose(moved, (1 + POISSON) * STRAIN * np.array(SIZE[:2]), rtol=1e-9)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("change", [-25.0, 25.0])
def test_between_walls_it_is_pressed(d, change):
    """σ = −E α ΔT, on both walls; all work is that of heat, half E (α ΔT)² of each volume."""
    loads = Loads(temperatures=(Temperature(on="bar", change=change),))
    result = bar(("left", "right", "bottom", "front")[: d + 1], d, loads=loads)
    expected = -YOUNG * EXPANSION * change
    np.testing.assert_allclose(stress(result)[:, 0], expected, rtol=1e-9)
    np.testing.assert_allclose(stress(result)[:, 1:], 0.0, atol=1e-9 * abs(expected))
    pushed = result.march.report.support_resultants["bar/right"][0]
    assert pushed == pytest.approx(expected * np.prod(SIZE[1:d]), rel=1e-9)
    ledger, volume = result.march.ledger, np.prod(SIZE[:d])
    energy = 0.5 * YOUNG * STRAIN**2 * volume
    assert ledger.strain == pytest.approx(energy, rel=1e-9)
    assert ledger.heat_work == pytest.approx(0.75 * 2 * energy, rel=1e-9)  # stresses of the end of two steps
    assert ledger.heat_work - ledger.numerical_dissipation == pytest.approx(energy, rel=1e-9)
    assert ledger.imbalance <= 1e-9


def test_two_stones_in_a_row_between_walls_share_what_they_may_not_expand():
    """Their joint is dry: p = (α₁ ΔT₁ l₁ + α₂ ΔT₂ l₂)/(l₁/E₁ + l₂/E₂)."""
    other = Material(density=2000.0, young=4e9, poisson=0.0, thermal_expansion=12e-6)
    stone = Material(density=2000.0, young=YOUNG, poisson=0.0, thermal_expansion=EXPANSION)
    mesh = MeshSettings(divisions=(2, 2))
    blocks = [
        BlockStructure(name="one", material="m", size=(2.0, 0.5), mesh=mesh),
        BlockStructure(name="two", material="n", size=(1.0, 0.5), position=(2.0, 0.0), mesh=mesh),
    ]
    held = [Support(on="one/left", components=("x",)), Support(on="two/right", components=("x",))]
    held += [Support(on=f"{name}/bottom", components=("y",)) for name in ("one", "two")]
    heat = Temperature(on="*", change=CHANGE), Temperature(on="two", change=5.0)
    result = bar(
        (), material=stone, materials={"m": stone, "n": other}, structures=tuple(blocks), probes=(),
        supports=tuple(held), loads=Loads(temperatures=heat), joints=(Joint(friction=0.0),),
    )  # fmt: skip
    pressure = (STRAIN * 2.0 + 12e-6 * 30.0 * 1.0) / (2.0 / YOUNG + 1.0 / 4e9)
    reaction = result.march.report.support_resultants["one/left"][0]
    assert reaction == pytest.approx(pressure * 0.5, rel=1e-8)
    assert result.march.ledger.imbalance <= 1e-9


@pytest.mark.parametrize("top", [0.0, CHANGE])
def test_stones_that_turn_expand_in_their_own_axes(top):
    """A dry column that nothing clamps: it grows by what each stone does, and its bed stays as it is."""
    mesh = MeshSettings(divisions=(2, 2))
    blocks = [
        BlockStructure(name="ground", material="m", size=(3.0, 0.5), position=(-1.0, -0.5), support=True)
    ]
    blocks += [
        BlockStructure(name=f"s{i}", material="m", size=(1.0, 0.5), position=(0, 0.5 * i), mesh=mesh)
        for i in range(2)
    ]
    heat = Temperature(on="s0", change=CHANGE), Temperature(on="s1", change=top)
    result = bar(
        (), structures=tuple(blocks), supports=(), joints=(Joint(friction=0.0),),
        probes=(Probe(name="top", block="s1", point=(0.5, 1.0)),),
        loads=Loads(gravity=(0.0, -1e-3), temperatures=heat),
    )  # fmt: skip
    weight = 1.0 * 2000 * 1e-3  # of a stone on each square metre, of half a metre each: too light to count
    grown = 0.5 * EXPANSION * (CHANGE + top)
    assert result.march.report.probes["top"][1] == pytest.approx(grown, abs=2 * weight / YOUNG)
    assert np.abs(stress(result)).max() <= 10 * weight
    assert result.march.ledger.imbalance <= 1e-9


def test_an_arch_between_its_abutments_thrusts():
    """A fixed arch of the half angle β: H (∫ (y − ȳ)² ds/EI + ∫ cos² ds/EA) = 2 R sin β α ΔT."""
    radius, depth, beta = 5.0, 0.25, np.radians(60.0)
    arch = ArchStructure(
        name="bar", material="m", radius=radius, thickness=depth, voussoirs=1, springings=False,
        embrace=120.0, mesh=MeshSettings(element="Q2", divisions=(24, 1)),
    )  # fmt: skip
    heat = Loads(temperatures=(Temperature(on="*", change=CHANGE),))
    held = tuple(Support(on=f"bar.*/{end}") for end in ("start", "end"))
    found = bar((), structures=(arch,), probes=(), supports=held, loads=heat)
    along = beta + np.sin(beta) * np.cos(beta)
    bending = radius**3 * (along - 2 * np.sin(beta) ** 2 / beta) / (YOUNG * depth**3 / 12)
    expected = 2 * radius * np.sin(beta) * STRAIN / (bending + radius * along / (YOUNG * depth))
    thrust = [abs(force[0]) for force in found.march.report.support_resultants.values()]
    np.testing.assert_allclose(thrust, expected, rtol=1e-2)


def yielding(law: str, **keys: float) -> Material:
    """The stone with a law."""
    record = material_record(law, **keys)
    return Material(
        density=2000.0, young=YOUNG, poisson=POISSON, thermal_expansion=EXPANSION, inelastic=record
    )


@pytest.mark.parametrize("fidelity", ["inelastic", "auto"])
@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_stone_between_walls_is_crushed_by_heat(fidelity, plane):
    """With free sides at f_c; what heat works is stored, lost, or a step's."""
    stone = yielding("mohr_coulomb", cohesion=0.5e6, friction_angle=0.0)  # f_c = 1 MPa
    held, steps = ("left", "right", "bottom"), Statics(load_steps=8)
    result = bar(held, material=stone, fidelity=fidelity, plane=plane, analysis=steps)
    if plane == "stress":
        np.testing.assert_allclose(stress(result)[:, 0], -1e6, rtol=1e-8)
    else:  # along z the stone is pressed as well, and nowhere by more than f_c
        np.testing.assert_allclose(stress(result)[:, [0, 2]], -1e6, rtol=1e-8)
    ledger = result.march.ledger
    assert ledger.material_dissipation > 0.1 * ledger.heat_work
    assert ledger.imbalance <= 1e-9
    elastic = bar(held, plane=plane, analysis=steps)
    strong = bar(held, material=yielding("mohr_coulomb", cohesion=1e8, friction_angle=0.0), fidelity=fidelity,
                 plane=plane, analysis=steps)  # fmt: skip
    np.testing.assert_allclose(stress(strong), stress(elastic), atol=1e-9 * YOUNG * STRAIN)
    assert strong.march.ledger.heat_work == pytest.approx(elastic.march.ledger.heat_work, rel=1e-9)
    assert strong.march.ledger.strain == pytest.approx(elastic.march.ledger.strain, rel=1e-9)


def test_stone_between_walls_that_cools_cracks():
    stone = yielding("brittle_damage", tensile_strength=1e6, fracture_energy=2000.0)
    cold = Loads(temperatures=(Temperature(on="*", change=-CHANGE),))
    result = bar(("left", "right", "bottom"), material=stone, fidelity="inelastic", loads=cold,
                 analysis=Statics(load_steps=8))  # fmt: skip
    assert 0 < stress(result)[:, 0].max() < 0.99e6
    (told,) = result.summary.stress.yielded
    assert told.measure == "damage"


@pytest.mark.parametrize("fidelity", ["elastic", "inelastic"])
@pytest.mark.parametrize("theta", [0.5, 0.7])
def test_dynamics_accounts_for_heat(fidelity, theta):
    """A bar that is heated as fast as sound runs through it: waves, and no energy that has no name."""
    stone = yielding("mohr_coulomb", cohesion=1e5, friction_angle=30.0)
    fast = Temperature(on="bar", change=CHANGE, time=Table(points=((0.0, 0.1), (2e-3, 1.0), (3e-3, 0.2))))
    march = Dynamics(step=1e-4, duration=3e-3, theta=theta)
    result = bar(("left", "bottom"), material=stone, fidelity=fidelity, loads=Loads(temperatures=(fast,)),
                 analysis=march)  # fmt: skip
    ledger = result.march.ledger
    assert ledger.start > 0  # a tenth of the change is there, and nothing has moved
    assert ledger.kinetic > 0
    assert abs(ledger.heat_work) > 0
    assert (ledger.material_dissipation > 0) == (fidelity == "inelastic")
    assert ledger.imbalance <= 1e-9


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"fidelity": "rigid", "supports": ()}, r"block 'bar' is rigid and cannot expand"),
        (
            {"materials": {"m": Material(density=1.0, young=1e9)}},
            r"materials\.m\.thermal_expansion is missing",
        ),
        ({"loads": Loads(temperatures=(Temperature(on="wall.*", change=1.0),))}, r"selects no block"),
        (
            {"analysis": Path(probe="far", direction=(1.0, 0.0), distance=1e-3)},
            r"loads\.temperatures\.0\.on is 'bar', expected none with analysis\.kind = 'path'",
        ),
    ],
)
def test_what_cannot_expand_is_said(keys, message):
    with pytest.raises(SceneError, match=message):
        bar(("left",), **keys)


def test_only_some_stones_of_a_scene_are_heated():
    """Two bars of one shape and material are one group."""
    mesh = MeshSettings(divisions=(2, 2))
    blocks = [
        BlockStructure(name=f"b{i}", material="m", size=(1.0, 0.5), position=(0, 2.0 * i), mesh=mesh)
        for i in range(2)
    ]
    held = [Support(on=f"b{i}/left", components=("x",)) for i in range(2)]
    held += [Support(on=f"b{i}/bottom", components=("y",)) for i in range(2)]
    probes = tuple(Probe(name=f"b{i}", block=f"b{i}", point=(1.0, 2.0 * i + 0.5)) for i in range(2))
    heat = Loads(temperatures=(Temperature(on="b1", change=CHANGE),))
    result = bar((), structures=tuple(blocks), supports=tuple(held), probes=probes, loads=heat)
    np.testing.assert_allclose(result.march.report.probes["b1"], STRAIN * np.array([1.0, 0.5]), rtol=1e-9)
    np.testing.assert_array_equal(result.march.report.probes["b0"], 0.0)


def test_two_strips_that_are_bonded_bend_as_bimetal_does():
    """Timoshenko (1925): strips of one thickness and modulus bend by κ = 3/2 Δε/t, t that of both."""
    length, thick = 2.0, 0.1
    mesh = MeshSettings(element="Q2", divisions=(20, 1))
    blocks = tuple(
        BlockStructure(name=f"s{i}", material="m", size=(length, thick), position=(0, thick * i), mesh=mesh)
        for i in range(2)
    )
    held = (*(Support(on=f"s{i}/left", components=("x",)) for i in range(2)), Support(on="s0/left"))
    bond = Joint(law=law_record("mohr_coulomb", cohesion=1e12), friction=1.0)
    result = bar(
        (), structures=blocks, supports=held, joints=(bond,),
        probes=(Probe(name="tip", block="s0", point=(length, thick)),),
        loads=Loads(temperatures=(Temperature(on="s0", change=CHANGE),)),
    )  # fmt: skip
    assert result.outcome == "equilibrium"
    moved = result.march.report.probes["tip"]
    curvature = 1.5 * STRAIN / (2 * thick)
    assert moved[1] == pytest.approx(curvature * length**2 / 2, rel=1e-2)
    assert moved[0] == pytest.approx(STRAIN / 2 * length, rel=1e-2)  # where they meet both have half of it


def test_a_material_is_heated_among_the_blocks_that_are_named():
    warm = Material(density=2000.0, young=YOUNG, poisson=POISSON, thermal_expansion=EXPANSION)
    plain = Material(density=2000.0, young=YOUNG, poisson=POISSON)
    parts = tuple(
        BlockStructure(name=name, material=own, size=SIZE[:2], position=(2.0 * SIZE[0] * place, 0.0),
                       mesh=MeshSettings(divisions=(1, 1)))
        for place, (name, own) in enumerate({"a": "warm", "b": "plain"}.items())
    )  # fmt: skip

    def heated(**keys: Any) -> dict[str, np.ndarray]:
        probes = tuple(
            Probe(name=part.name, block=part.name, point=(part.position[0] + SIZE[0], 0.0)) for part in parts
        )
        held = tuple(Support(on=f"{part.name}/{face}", components=(axis,))
                     for part in parts for face, axis in (("left", "x"), ("bottom", "y")))  # fmt: skip
        loads = Loads(temperatures=(Temperature(change=CHANGE, **keys),))
        materials = {"warm": warm, "plain": plain}
        made = bar(
            (), 2, warm, materials=materials, structures=parts, supports=held, probes=probes, loads=loads
        )
        return made.march.report.probes

    moved = heated(material="warm")
    assert moved["a"][0] == pytest.approx(STRAIN * SIZE[0], rel=1e-9)
    assert abs(moved["b"][0]) <= 1e-12 * STRAIN
    with pytest.raises(SceneError, match=r"material = 'warm' is that of no free block among 'b'"):
        heated(on="b", material="warm")


@pytest.mark.parametrize("update", ["moving", "fixed"])
def test_the_first_round_of_a_stone_that_may_crack_knows_how_warm_it_will_be(update):
    # cooled freely it has no stress; taken for as warm as before it would be torn by ten times its strength
    law = material_record("brittle_damage", tensile_strength=YOUNG * STRAIN / 10, fracture_energy=100.0)
    stone = Material(density=2000.0, young=YOUNG, poisson=POISSON, thermal_expansion=EXPANSION, inelastic=law)
    reports = []
    made = solve_scene(
        check(
            Scene(
                dimension=2,
                plane="stress",
                fidelity="inelastic",
                mesh=MeshSettings(divisions=(2, 2)),
                materials={"m": stone},
                structures=(StackStructure(name="s", material="m", size=(1.0, 0.5), count=2),),
                joints=(Joint(friction=0.6),),
                contact=Contact(update=update),
                loads=Loads(gravity=(0.0, -9.81), temperatures=(Temperature(on="s.b2", change=-CHANGE),)),
                analysis=Statics(),
            )
        ),
        observers=(lambda model, state, report: reports.append(report),),
    )
    assert made.outcome == "equilibrium"
    assert not made.summary.stress.yielded
    assert [report.time for report in reports] == [1.0]  # in one go
