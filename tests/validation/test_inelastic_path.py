"""A bar that cracks and snaps back, followed by the opening of its crack, against its closed form.

A bar of n square elements hangs from a load at its top. By its weight the top row cracks first and alone. The
opening o of this row gives its strain o/h, stress s(o/h) by the law, load and displacement of the top,

    F = s + ρ g h/2,     u = o + Σ_j h/E (F − ρ g h (j + ½)),     s(e) = f_t exp(−2 H (E e/f_t − 1))

Beyond the peak u goes back where the bar is longer than 2 E G_f/f_t².
"""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.march.equilibrium.path import Path
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Probe,
    Scene,
    Statics,
    Support,
    Table,
    Traction,
    law_record,
    material_record,
)
from masonry_fem.structures.block import BlockStructure

STRENGTH, ENERGY, YOUNG, WEIGHT = 1e6, 50.0, 10e9, 2e5
LENGTH, ROWS = 2.0, 4  # twice 2 E G_f/f_t²
ROW = LENGTH / ROWS
OPENING = 1.2e-4
STAY = Table(points=((0.0, 1.0),))
STIFF = {"normal_stiffness": 1e11, "tangential_stiffness": 1e11}
ENERGIES = {"normal_energy": 50.0, "tangential_energy": 50.0}


class Curve:
    """Load factor, displacement of the top and opening of the top row [m], step by step."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float, float]] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        top, below = report.probes["top"][-1], report.probes["below"][-1]
        self.rows.append((report.time, top, top - below))


def hung(dimension: int = 2, **keys: Any) -> Scene:
    """The bar; keys of the analysis."""

    def up(value: float) -> tuple[float, ...]:
        return (*(0.0,) * (dimension - 1), value)

    sides = dimension - 1
    law = material_record("brittle_damage", tensile_strength=STRENGTH, fracture_energy=ENERGY)
    control = {"probe": "top", "against": "below", "direction": up(2.0), "distance": OPENING}
    return Scene(
        dimension=dimension,
        fidelity="inelastic",
        materials={"m": Material(density=2000.0, young=YOUNG, poisson=0.0, inelastic=law)},
        structures=(
            BlockStructure(
                name="bar",
                material="m",
                size=(*(ROW,) * sides, LENGTH),
                mesh=MeshSettings(divisions=(*(1,) * sides, ROWS)),
            ),
        ),
        supports=(Support(on="bar/bottom"),),
        probes=(
            Probe(name="top", block="bar", point=up(LENGTH)),
            Probe(name="below", block="bar", point=up(LENGTH - ROW)),
        ),
        loads=Loads(
            gravity=up(-WEIGHT / 2000.0),
            gravity_time=STAY,
            tractions=(Traction(on="bar/top", vector=up(STRENGTH)),),
        ),
        analysis=Path(**(control | {"load_steps": 60} | keys)),
    )


def followed(scene: Scene) -> tuple[RunResult, Curve]:
    curve = Curve()
    return solve_scene(check(scene), observers=[curve]), curve


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_bar_that_snaps_back_follows_its_closed_form(dimension):
    result, curve = followed(hung(dimension))
    assert result.outcome == "finished"
    factor, top, opening = np.array(curve.rows).T
    np.testing.assert_allclose(opening, OPENING * np.arange(1, 61) / 60, rtol=1e-8)
    H = ROW / (2 * YOUNG * ENERGY / STRENGTH**2 - ROW)
    strain = opening / ROW
    stress = np.minimum(YOUNG * strain, STRENGTH * np.exp(-2 * H * (YOUNG * strain / STRENGTH - 1)))
    load = stress + WEIGHT * ROW / 2
    np.testing.assert_allclose(factor * STRENGTH, load, rtol=1e-8)
    others = sum(ROW / YOUNG * (load - WEIGHT * ROW * (row + 0.5)) for row in range(1, ROWS))
    np.testing.assert_allclose(top, opening + others, rtol=1e-8)
    peak = int(factor.argmax())
    assert top.min() < top[peak] - 1e-6  # it went back
    assert top[peak:].argmin() > 0
    assert result.march.ledger.imbalance <= 1e-9


def test_a_control_that_no_load_moves_is_told():
    sideways = hung(direction=(1.0, 0.0), load_steps=1)
    result, _ = followed(sideways)
    assert result.outcome == "no_convergence"
    assert "no load factor was found that takes the control, a point of 'bar', to its place" in result.message


@pytest.mark.slow
def test_a_peak_is_told_and_what_leads_past_it():
    """In statics the load ends at the strength; nothing balances beyond."""
    scene = hung()
    pull = Traction(on="bar/top", vector=(0.0, 2 * STRENGTH))
    loads = msgspec.structs.replace(scene.loads, tractions=(pull,))
    result, _ = followed(msgspec.structs.replace(scene, loads=loads, analysis=Statics(load_steps=1)))
    assert result.outcome == "no_convergence"
    reached = result.march.state.time
    peak = (STRENGTH + WEIGHT * ROW / 2) / (2 * STRENGTH)
    assert peak - 1 / 32 <= reached <= peak
    assert f"The last state in balance, at load factor {reached:.6g}, is what is written" in result.message
    assert "past a peak" in result.message
    assert "analysis.kind = 'path'" in result.message


def test_a_path_of_rigid_blocks_is_told():
    scene = hung(load_steps=1)
    floor = BlockStructure(name="floor", material="m", size=(ROW, ROW), position=(0.0, -ROW), support=True)
    stones = {"structures": (*scene.structures, floor), "supports": (), "joints": (Joint(friction=0.5),)}
    result, _ = followed(msgspec.structs.replace(scene, fidelity="rigid", **stones))
    assert result.outcome == "no_convergence"
    assert "a path cannot follow mechanisms" in result.message


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"probe": "side"}, r"analysis.probe is 'side', expected the name of a probe \('top', 'below'\)"),
        ({"direction": (0.0, 0.0)}, "analysis.direction"),
        ({"direction": (0.0, 0.0, 1.0)}, "analysis.direction"),
    ],
)
def test_what_does_not_fit_is_refused(keys, message):
    with pytest.raises(SceneError, match=message):
        followed(hung(**keys))


def test_supports_that_move_are_refused():
    scene = hung()
    moved = Support(on="bar/bottom", motion=Motion(displacement=(0.0, 1e-3)))
    with pytest.raises(SceneError, match=r"supports\.0\.motion .* with analysis.kind = 'path'"):
        followed(msgspec.structs.replace(scene, supports=(moved,)))


@pytest.mark.parametrize(
    "law",
    [
        law_record("mohr_coulomb", cohesion=1e6),
        law_record("elastic_brittle", **STIFF, normal_strength=1e6, tangential_strength=1e6),
        law_record("fremond_cangemi", **STIFF, energy=20.0),
        law_record("bilinear", **STIFF, normal_strength=1e6, tangential_strength=1e6, **ENERGIES),
    ],
)
def test_joints_that_soften_are_refused(law):
    scene = msgspec.structs.replace(hung(), joints=(Joint(law=law),))
    with pytest.raises(
        SceneError, match=rf"joints\.0\.law\.kind is '{law.kind}', expected 'elastic', or no law"
    ):
        check(scene)


def test_joints_that_stay_elastic_are_not():
    scene = msgspec.structs.replace(hung(), joints=(Joint(law=law_record("elastic", **STIFF)),))
    assert check(scene).joints[0].law.kind == "elastic"
