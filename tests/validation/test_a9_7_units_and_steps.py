"""A9.7, A9.8: units and time steps that must not matter, from 1e-12 s to far beyond the waves."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.run import RunResult
from masonry_fem.scene.specs import (
    ArchStructure,
    BlockStructure,
    Dynamics,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Probe,
    StackStructure,
    Statics,
    Support,
    Traction,
)
from tests.validation.scenes import G, solved

# --- A9.7 ------------------------------------------------------------------------------------------

UNITS = {"m, N, kg": (1.0, 1.0), "mm, N, t": (1e3, 1e-3), "km, MN, Gg": (1e-3, 1e-6)}


@pytest.mark.parametrize("system", UNITS)
def test_a9_7_units_change_nothing(system: str) -> None:
    """Thrust over γ t R of an elastic arch in three unit systems (length and mass factors)."""
    values = []
    for length, mass in (UNITS["m, N, kg"], UNITS[system]):
        force = mass * length  # s stays
        stone = Material(density=2400.0 * mass / length**3, young=1e10 * force / length**2, poisson=0.2)
        result = solved(
            dimension=2,
            materials={"stone": stone},
            structures=(
                ArchStructure(
                    name="arch", material="stone", radius=length, thickness=0.2 * length, voussoirs=7,
                ),
            ),
            mesh=MeshSettings(divisions=(3, 3)),
            loads=Loads(gravity=(0.0, -G * length)),
            analysis=Statics(),
        )  # fmt: skip
        assert result.outcome == "equilibrium"
        values.append(
            result.summary["supports"]["arch.springing_left"]["force"][0] / (force / length)
        )  # per depth
    assert values[1] == pytest.approx(values[0], rel=1e-8)


def sheared_cubes(shear: float, length: float, mass: float) -> RunResult:
    """A10.1, A10.2 at 2 × 2 × 2 elements, with so many units of length to a metre and of mass to a kg."""
    force, area = mass * length, length**2
    stone = Material(density=2400.0 * mass / length**3, young=1e10 * force / area, poisson=0.2)
    size = (length, length, length)
    return solved(
        materials={"stone": stone},
        structures=(
            BlockStructure(name="lower", material="stone", size=size),
            BlockStructure(name="upper", material="stone", size=size, position=(0, 0, length)),
        ),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        joints=(Joint(friction=0.6, placement="nodes"),),
        supports=(Support(on="lower/bottom"),),
        loads=Loads(
            gravity=(0, 0, -G * length),
            tractions=(Traction(on="upper/top", vector=(shear * force / area, 0.0, -1e6 * force / area)),),
        ),
        probes=(Probe(name="edge", block="upper", point=(length, length / 2, 2 * length)),),
    )


@pytest.mark.parametrize("system", UNITS)
@pytest.mark.parametrize("shear", [0.1e6, 0.3e6])
def test_a9_7_units_change_no_displacement_nor_reaction(shear: float, system: str) -> None:
    """A bonded joint, and one that opens and slides."""
    plain = sheared_cubes(shear, *UNITS["m, N, kg"])
    length, mass = UNITS[system]
    other = sheared_cubes(shear, length, mass)
    assert other.outcome == plain.outcome == "equilibrium"
    edge = plain.summary["probes"]["edge"]
    assert np.array(other.summary["probes"]["edge"]) / length == pytest.approx(
        edge, rel=1e-8, abs=1e-8 * max(map(abs, edge))
    )
    force, moment = (plain.summary["supports"]["lower/bottom"][key] for key in ("force", "moment"))
    found = other.summary["supports"]["lower/bottom"]
    largest = max(map(abs, force))
    assert np.array(found["force"]) / (mass * length) == pytest.approx(force, rel=1e-8, abs=1e-8 * largest)
    assert np.array(found["moment"]) / (mass * length**2) == pytest.approx(
        moment, rel=1e-8, abs=1e-8 * largest
    )
    reaction = other.march.state.reaction / (mass * length)
    assert reaction == pytest.approx(plain.march.state.reaction, rel=1e-8, abs=1e-8 * largest)
    assert other.summary["status"] == plain.summary["status"]


# --- A9.8 ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [1e-12, 1e-6, 1e-3, 1.0, 1e3])
def test_a9_8_any_step_gives_numbers(step: float) -> None:
    """From h → 0 to h ≫ L/c: no NaN; a long step with θ = 1 is statics (R = W)."""
    result = solved(
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=2),),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        analysis=Equilibrium(strategy="large_step", step=step, max_steps=2, tolerance=1e-6),
    )
    reaction = result.march.state.reaction
    assert np.isfinite(reaction).all()
    assert result.march.report.natural_map < 1e-8
    if step >= 1.0:
        base = result.summary["supports"]["stack.ground"]["force"][2]
        assert base == pytest.approx(2 * 2400 * G, rel=1e-6)


COLUMN = Material(density=2000.0, young=1e9, poisson=0.0)
PERIOD = 4 * 3.0 / np.sqrt(1e9 / 2000.0)  # of the column's first wave [s]


def column(step: float, theta: float, count: int = 1) -> RunResult:
    """A2.4: gravity at once on a 3 m column at rest."""
    return solved(
        dimension=2,
        materials={"stone": COLUMN},
        structures=(StackStructure(name="column", material="stone", size=(1.0, 3.0), count=1),),
        mesh=MeshSettings(divisions=(1, 12)),
        joints=(Joint(friction=0.0),),
        analysis=Dynamics(step=step, duration=count * step, theta=theta),
        probes=(Probe(name="top", block="column.b1", point=(0.5, 3.0)),),
    )


@pytest.mark.parametrize("ratio", [1e2, 1e3, 1e5, 1e8])
def test_a9_8_one_step_far_beyond_the_waves_is_statics(ratio: float) -> None:
    """θ = 1, h ≫ L/c: R = W and the settlement ρ g L²/2E after one step, up to (L/ch)²."""
    result = column(ratio * PERIOD, 1.0)
    weight = 2000.0 * G * 3.0
    bound = max(0.1 / ratio**2, 1e-8)
    assert result.march.report.step == 1
    base = result.summary["supports"]["column.ground"]["force"][1]
    assert base == pytest.approx(weight, rel=bound)
    assert result.summary["probes"]["top"][1] == pytest.approx(-8.829e-5, rel=max(bound, 1e-6))


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a9_8_steps_of_a_picosecond(theta: float) -> None:
    """h = 1e-12: the top falls freely, the base presses what is left of the weight's momentum."""
    h, steps = 1e-12, 5
    result = column(h, theta, steps)
    state = result.march.state
    assert np.isfinite(state.reaction).all()
    assert np.isfinite(state.velocity).all()
    # θ-scheme at constant acceleration: s_n = a h² n (n − 1 + 2θ)/2
    fallen = G * h**2 * steps * (steps - 1 + 2 * theta) / 2
    assert result.summary["probes"]["top"][1] == pytest.approx(-fallen, rel=1e-6)
    assert result.march.ledger.imbalance < 1e-10


@pytest.mark.parametrize(("h", "steps"), [(1e-12, 3), (1e-6, 3), (1.0, 3), (1e6, 1)])
def test_a9_8_rigid_stack_at_any_step(h: float, steps: int) -> None:
    """Rigid blocks press with their weight from the first step on, however short or long it is.

    After 1e6 s rounding of the free fall, 1e7 m/s, has moved the blocks by metres: one step only.
    """
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=3),),
        analysis=Dynamics(step=h, duration=steps * h, theta=1.0),
    )
    base = result.summary["supports"]["stack.ground"]["force"]
    assert base == pytest.approx([0, 0, 3 * 2400 * G], rel=1e-9, abs=1e-6)
    assert result.march.report.speed <= 1e-10 * G * h
