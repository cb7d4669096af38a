"""A9.7: units that must not matter."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.run import RunResult
from masonry_fem.scene.specs import (
    ArchStructure,
    BlockStructure,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Probe,
    Statics,
    Support,
    Traction,
)
from tests.validation.scenes import G, solved

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
