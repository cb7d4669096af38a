"""Stones that crack: a bar that is pulled apart, on several meshes.

A bar of 1 m is clamped at both ends and pulled. By its weight the row of elements at the top cracks first
and alone: the crack takes G_f, whatever the mesh is.
"""

from __future__ import annotations

from typing import Any

import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.fem.material import Plane
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Loads,
    Material,
    MeshSettings,
    Motion,
    Scene,
    Statics,
    Support,
    Table,
    material_record,
)
from masonry_fem.structures.block import BlockStructure

STRENGTH, ENERGY, YOUNG = 1e6, 200.0, 10e9
# small steps while the first row goes beyond its strength and the others do not
RAMP = Table(points=((0.0, 0.0), (0.05, 0.035), (0.65, 0.065), (1.0, 1.0)))


def torn(
    rows: int, energy: float = ENERGY, way: float = 2e-3, steps: int = 300, law: str = "brittle_damage",
    plane: Plane = "strain", **keys: float,
) -> Scene:  # fmt: skip
    """A bar of so many square elements on each other, its top lifted by ``way`` [m]."""
    record = material_record(law, tensile_strength=STRENGTH, fracture_energy=energy, **keys)
    stone = Material(density=2000.0, young=YOUNG, poisson=0.0, inelastic=record)
    mesh = MeshSettings(divisions=(1, rows))
    return Scene(
        dimension=2,
        plane=plane,
        fidelity="inelastic",
        materials={"m": stone},
        structures=(BlockStructure(name="bar", material="m", size=(1.0 / rows, 1.0), mesh=mesh),),
        supports=(
            Support(on="bar/bottom"),
            Support(on="bar/top", motion=Motion(displacement=(0.0, way), time=RAMP)),
        ),
        loads=Loads(gravity=(0.0, -100.0)),
        analysis=Statics(load_steps=steps),
    )


def pulled(rows: int, **keys: Any) -> RunResult:
    """What becomes of it."""
    return solve_scene(check(torn(rows, **keys)))


@pytest.mark.slow
@pytest.mark.parametrize("rows", [2, 8, pytest.param(16, marks=pytest.mark.slow)])
def test_a_crack_takes_the_fracture_energy_on_every_mesh(rows):
    """To 1 %, which is of the load steps: all is taken in one row, and the ledger closes."""
    result = pulled(rows)
    assert result.march.outcome == "equilibrium"
    ledger = result.march.ledger
    assert ledger.material_dissipation * rows == pytest.approx(ENERGY, rel=1e-2)  # the bar is 1/rows m wide
    assert ledger.imbalance <= 1e-9
    (told,) = result.summary.stress.yielded
    assert told.measure == "damage"
    assert told.greatest > 1 - 1e-5
    assert told.mean == pytest.approx(1 / rows, rel=1e-4)


@pytest.mark.slow
def test_a_bar_that_could_be_crushed_takes_it_in_its_crack():
    """Nothing is crushed in tension: all is the crack's, which takes what it does on any mesh."""
    strengths = {"compressive_strength": 1e7, "friction_angle": 35.0, "dilatancy_angle": 10.0}
    result = pulled(2, steps=150, law="damage_plasticity", **strengths)
    assert result.march.outcome == "equilibrium"
    assert result.march.ledger.material_dissipation * 2 == pytest.approx(ENERGY, rel=2e-3)
    assert result.march.ledger.imbalance <= 1e-9
    assert [told.measure for told in result.summary.stress.yielded] == ["damage"]


@pytest.mark.slow
@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_a_bar_of_mohr_and_coulomb_takes_it_too(plane):
    """Its strength falls along a straight line, to nothing where the two halves are 2 G_f/f_t apart."""
    result = pulled(4, law="mohr_coulomb", plane=plane, cohesion=5e6, friction_angle=40.0)
    assert result.march.outcome == "equilibrium"
    assert result.march.ledger.material_dissipation * 4 == pytest.approx(ENERGY, rel=1e-2)
    assert result.march.ledger.imbalance <= 1e-9
    (told,) = result.summary.stress.yielded
    assert told.measure == "plastic_strain"
    assert told.mean == pytest.approx(told.greatest / 4, rel=1e-2)


@pytest.mark.slow
def test_the_force_of_a_bar_before_and_after_its_peak():
    """Elastic up to f_t; then all opening is in the row that cracks (of ``test_brittle_damage``)."""
    before, after = pulled(4, way=0.9e-4, steps=10), pulled(4)
    force = [float(one.summary.supports["bar/top"].force[1]) * 4 for one in (before, after)]
    weight = 2000.0 * 100.0
    assert force[0] == pytest.approx(0.9e-4 * YOUNG + weight / 2, rel=1e-9)
    # above the crack hangs half of its row, where its Gauss points have the mean stress
    assert force[1] - weight / 8 == pytest.approx(0.0, abs=1e-2 * STRENGTH)


def test_elements_that_are_too_large_are_refused():
    with pytest.raises(SceneError, match=r"block 'bar': law 'brittle_damage': elements are up to 0.5 m wide"):
        pulled(2, energy=20.0)
