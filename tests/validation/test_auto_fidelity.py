"""Stones of fidelity auto: elastic until their stress comes near to their strength, then inelastic."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, run, solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.march.equilibrium.dynamics import Dynamics
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Output,
    Override,
    Probe,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
    Traction,
    material_record,
)
from masonry_fem.structures.stack import StackStructure

C, PHI = 1e6, 30.0
STRENGTH = 2 * C * np.cos(np.radians(PHI)) / (1 - np.sin(np.radians(PHI)))
RAMP = Table(points=((0.0, 0.0), (1.0, 1.0)))
LAW = material_record("drucker_prager", cohesion=C, friction_angle=PHI, dilatancy_angle=10.0)


def column(fidelity: str, *, count: int = 4, dimension: int = 3, steps: int = 6, **keys: Any) -> Scene:
    """A column of stones of which one is narrower, so that it is crushed first, under a platen."""
    d = dimension
    down = (0.0,) * (d - 1) + (-2.5e-3 * count,)
    weak = Material(density=2000.0, young=1e10, inelastic=LAW, **keys)
    strong = Material(
        density=2000.0,
        young=1e10,
        inelastic=material_record("drucker_prager", cohesion=10 * C, friction_angle=PHI),
    )
    return Scene(
        dimension=d,
        fidelity=fidelity,
        materials={"weak": weak, "strong": strong},
        structures=(
            StackStructure(
                name="s",
                material="strong",
                size=(1.0,) * d,
                count=count + 1,
                mesh=MeshSettings(element="Q1", divisions=(2,) * d),
            ),
        ),
        overrides=(Override(blocks="s.b2", material="weak"),),
        supports=(Support(on=f"s.b{count + 1}", motion=Motion(displacement=down, time=RAMP)),),
        joints=(Joint(friction=0.5),),
        loads=Loads(gravity=(0.0,) * (d - 1) + (-9.81,)),
        probes=(Probe(name="p", block="s.b2", point=(0.3,) * (d - 1) + (1.9,)),),
        analysis=Statics(load_steps=steps),
    )


def ran(scene: Scene) -> RunResult:
    return solve_scene(check(scene))


def displacements(result: RunResult) -> np.ndarray:
    """Of all nodes, in the order of the blocks."""
    groups = zip(result.march.model.groups, result.march.state.bodies, strict=True)
    by_block: dict[int, np.ndarray] = {}
    for group, state in groups:
        if group.deforms:
            moved = group.displacements(state).reshape(len(group.blocks), -1)
            by_block |= dict(zip(group.blocks.tolist(), moved, strict=True))
    return np.concatenate([by_block[block] for block in sorted(by_block)])


def promoted(result: RunResult) -> dict[str, float]:
    """Since when stones have been inelastic, of those that are."""
    blocks, since = result.march.model.assembly.blocks, {}
    for group, state in zip(result.march.model.groups, result.march.state.bodies, strict=True):
        if group.nonlinear:
            times = group.promoted(state)
            since |= dict(zip((blocks[b].name for b in group.blocks.tolist()), times.tolist(), strict=True))
    return {name: time for name, time in since.items() if np.isfinite(time)}


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_crushed_column_moves_as_one_of_inelastic_stones(dimension):
    auto, whole = ran(column("auto", dimension=dimension)), ran(column("inelastic", dimension=dimension))
    assert auto.summary.outcome == whole.summary.outcome == "equilibrium"
    assert whole.march.report.material_dissipation > 1.0
    size = np.abs(displacements(whole)).max()
    assert np.abs(displacements(auto) - displacements(whole)).max() <= 1e-8 * size
    assert auto.summary.probes["p"] == pytest.approx(whole.summary.probes["p"], abs=1e-8 * size)
    assert list(promoted(auto)) == ["s.b2"]
    assert auto.summary.certificate.energy_balance < 1e-6


def test_it_says_which_stones_when_and_why():
    result = ran(column("auto"))
    (made,) = (one for one in result.summary.remarks if one.code == "promoted")
    since = promoted(result)
    assert made.blocks == ("s.b2",) == tuple(since)
    assert "1 of 4 stones" in made.sentence
    assert f"'s.b2' at t = {since['s.b2']:.4g}" in made.sentence


def test_stones_are_promoted_in_the_step_in_which_they_come_near():
    # of uniform stress, growing in proportion: the axial one reaches σ_c + N_φ times the lateral one
    lateral = 1e4
    axial = STRENGTH + 2 * 0.2 * lateral
    final = (axial - (1 + np.sin(np.radians(PHI))) / (1 - np.sin(np.radians(PHI))) * lateral) / STRENGTH
    for share, step in ((0.35, 0.4), (0.55, 0.6), (0.9, 1.0)):
        result = ran(squeezed("auto", closing=STRENGTH / 1e10, promote_at=share))
        assert promoted(result) == {"s.b1": pytest.approx(step)}
        assert (step - 0.2) * final < share <= step * final


def squeezed(fidelity: str, closing: float, *, law: Any = LAW, steps: int = 5, **keys: Any) -> Scene:
    """One stone between platens, without friction, in uniform stress."""
    mesh = MeshSettings(element="Q1", divisions=(2, 2, 2))
    return Scene(
        dimension=3,
        fidelity=fidelity,
        materials={"m": Material(density=2000.0, young=1e10, inelastic=law, **keys)},
        structures=(StackStructure(name="s", material="m", size=(1.0,) * 3, count=2, mesh=mesh),),
        supports=(
            Support(on="s.b2", motion=Motion(displacement=(0.0, 0.0, -closing), time=RAMP)),
            Support(on="s.b1/left", components=("x",)),
            Support(on="s.b1/front", components=("y",)),
        ),
        joints=(Joint(friction=0.0),),
        loads=Loads(
            gravity=(0.0,) * 3,
            tractions=(Traction(on="s.b1/right", vector=(-1e4, 0.0, 0.0)),
                       Traction(on="s.b1/back", vector=(0.0, -1e4, 0.0))),
        ),
        probes=(Probe(name="p", block="s.b1", point=(0.3, 0.4, 0.7)),),
        analysis=Statics(load_steps=steps),
    )  # fmt: skip


def test_clamped_and_loaded_stones_are_promoted_with_their_loads_and_probes():
    auto, whole = ran(squeezed("auto", 2e-3)), ran(squeezed("inelastic", 2e-3))
    assert list(promoted(auto)) == ["s.b1"]
    assert whole.march.report.material_dissipation > 1.0
    assert auto.summary.probes["p"] == pytest.approx(whole.summary.probes["p"], abs=1e-12)
    assert auto.summary.certificate.energy_balance < 1e-6
    for name, wrench in whole.march.report.support_resultants.items():
        assert auto.march.report.support_resultants[name] == pytest.approx(wrench, abs=1e-3)  # of 1e6 N


def test_stones_far_from_their_strength_are_elastic_ones():
    closing = 0.5 * STRENGTH / 1e10
    exact = Solver(tolerance=1e-13)  # the usual one leaves up to 3e-12 between two ways to solve the same
    auto, elastic = (
        ran(msgspec.structs.replace(squeezed(fidelity, closing), solver=exact))
        for fidelity in ("auto", "elastic")
    )
    assert promoted(auto) == {}
    assert all(one.code != "promoted" for one in auto.summary.remarks)
    size = np.abs(displacements(elastic)).max()
    assert np.abs(displacements(auto) - displacements(elastic)).max() <= 1e-12 * size


def test_stones_without_a_law_stay_elastic_and_turn():
    scene = column("auto")
    bare = {name: msgspec.structs.replace(one, inelastic=None) for name, one in scene.materials.items()}
    auto = ran(msgspec.structs.replace(scene, materials=bare))
    elastic = ran(column("elastic"))
    assert promoted(auto) == {}
    assert np.array_equal(displacements(auto), displacements(elastic))


@pytest.mark.slow
def test_a_falling_stone_is_crushed_in_dynamics_as_an_inelastic_one():
    def scene(fidelity: str) -> Scene:
        made = column(fidelity, count=2)
        return msgspec.structs.replace(
            made,
            supports=(),
            joints=(Joint(friction=0.5),),
            loads=Loads(
                gravity=(0.0, 0.0, -9.81), tractions=(Traction(on="s.b3/top", vector=(0.0, 0.0, -4e6)),)
            ),
            analysis=Dynamics(step=1e-4, duration=2e-3),
        )

    auto, whole = ran(scene("auto")), ran(scene("inelastic"))
    assert list(promoted(auto)) == ["s.b2"]
    size = np.abs(displacements(whole)).max()
    assert np.abs(displacements(auto) - displacements(whole)).max() <= 1e-8 * size
    assert auto.summary.energy.material_dissipation > 1.0
    assert auto.summary.certificate.energy_balance < 1e-6


def test_fields_show_which_stones_are_inelastic(tmp_path):
    scene = msgspec.structs.replace(column("auto", count=3, steps=4), output=Output(pictures=False))
    result = run(check(scene), tmp_path)
    told = json.loads((tmp_path / "summary.json").read_text())
    assert [one["blocks"] for one in told["remarks"] if one["code"] == "promoted"] == [["s.b2"]]
    meshio = pytest.importorskip("meshio")
    last = meshio.read(sorted((tmp_path / "fields").glob("blocks_*.vtu"))[-1])
    blocks = result.march.model.assembly.blocks
    shown = {
        blocks[block].name
        for numbers, known in zip(last.cell_data["block"], last.cell_data["inelastic"], strict=True)
        for block, value in zip(numbers, known, strict=True)
        if value == 1
    }
    assert shown == {"s.b2"}


def test_a_plate_in_plane_stress_is_promoted():
    auto, whole = (
        ran(msgspec.structs.replace(column(fidelity, dimension=2), plane="stress"))
        for fidelity in ("auto", "inelastic")
    )
    assert list(promoted(auto)) == ["s.b2"]
    size = np.abs(displacements(whole)).max()
    assert np.abs(displacements(auto) - displacements(whole)).max() <= 1e-8 * size


@pytest.mark.parametrize("share", [0.0, 1.2, -1.0])
def test_a_share_out_of_range_is_refused(share):
    with pytest.raises(SceneError, match=r"promote_at"):
        ran(squeezed("auto", 1e-3, promote_at=share))


def test_a_law_that_does_not_go_with_the_elements_is_refused_at_the_start():
    law = material_record("brittle_damage", tensile_strength=2e6, fracture_energy=1.0)
    with pytest.raises(SceneError, match=r"block 's.b1': .*take smaller elements"):
        ran(squeezed("auto", 1e-6, law=law))
