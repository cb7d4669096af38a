"""A9.7: units that must not matter: the same dimensionless results in m, N, kg; mm, N, t; km, MN, Gg."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    Contact,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Probe,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
    Traction,
    law_record,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.file import FileStructure
from tests.validation.discs import RADIUS, half_discs, line_contact
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
        values.append(result.summary.supports["arch.springing_left"].force[0] / (force / length))  # per depth
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
    edge = plain.summary.probes["edge"]
    assert np.array(other.summary.probes["edge"]) / length == pytest.approx(
        edge, rel=1e-8, abs=1e-8 * max(map(abs, edge))
    )
    held = plain.summary.supports["lower/bottom"]
    force, moment = held.force, held.moment
    found = other.summary.supports["lower/bottom"]
    largest = max(map(abs, force))
    assert np.array(found.force) / (mass * length) == pytest.approx(force, rel=1e-8, abs=1e-8 * largest)
    assert np.array(found.moment) / (mass * length**2) == pytest.approx(moment, rel=1e-8, abs=1e-8 * largest)
    reaction = other.march.state.reaction / (mass * length)
    assert reaction == pytest.approx(plain.march.state.reaction, rel=1e-8, abs=1e-8 * largest)
    assert other.summary.status == plain.summary.status


# --- A3.3, A2.7, A7.7 ---------------------------------------------------------------------------------

ARCHES = {(20, 0.12): (0.071890, 0.078149), (20, 0.2): (0.096589, 0.159958), (11, 0.2): (0.094247, 0.160027)}


def rigid_arch_thrust(voussoirs: int, thickness: float, spread: float, length: float, mass: float) -> float:
    """A3.3 with springings moved apart by ``spread`` R: thrust over γ R² by the metre of depth."""
    force = mass * length
    result = solved(
        dimension=2,
        fidelity="rigid",
        materials={"stone": Material(density=2400.0 * mass / length**3)},
        structures=(
            ArchStructure(
                name="arch", material="stone", radius=length, thickness=thickness * length,
                voussoirs=voussoirs,
            ),
        ),
        joints=(Joint(friction=5.0),),
        supports=(Support(on="arch.springing_right", motion=Motion(displacement=(spread * length, 0.0))),),
        loads=Loads(gravity=(0.0, -G * length)),
        analysis=Statics(load_steps=2),
    )  # fmt: skip
    assert result.outcome == "equilibrium"
    # per unit of depth: γ R² in force over length
    return abs(result.summary.supports["arch.springing_left"].force[0]) / (force / length) / (2400 * G)


@pytest.mark.slow
@pytest.mark.parametrize("system", list(UNITS)[1:])
@pytest.mark.parametrize(("voussoirs", "thickness"), ARCHES)
def test_a9_7_units_leave_the_bounds_of_the_thrust(voussoirs: int, thickness: float, system: str) -> None:
    """Springings that part by 1e-4 R leave the least thrust, on three hinges: the same to 1e-8.

    Those that close leave the greatest one, and one joint that may rest or slip: it is met to 1e-5 only.
    """
    for spread, bound, share in zip((1e-4, -1e-4), ARCHES[voussoirs, thickness], (1e-8, 1e-5), strict=True):
        plain = rigid_arch_thrust(voussoirs, thickness, spread, *UNITS["m, N, kg"])
        assert plain == pytest.approx(bound, rel=0.01)
        other = rigid_arch_thrust(voussoirs, thickness, spread, *UNITS[system])
        assert other == pytest.approx(plain, rel=share)


def series_bar(length: float, mass: float) -> tuple[list[float], list[float]]:
    """A7.7: jumps over u0 and stresses over r_max of a bar and a joint in series, per load step."""
    force = mass * length
    area = length**2
    young, stiffness, energy = 10e9 * force / area, 1e10 * force / length**3, 50.0 * force / length
    opening, peak = np.sqrt(energy / stiffness), np.sqrt(energy * stiffness)
    bar, width = 0.1 * length, 0.05 * length
    ends = [ratio * opening * (1 + stiffness * bar / young) for ratio in (0.5, 1.0, 1.1, 1.5, 2.0, 4.0)]
    path = Table(points=((0.0, 0.0), *(((i + 1) / len(ends), end) for i, end in enumerate(ends))))
    law = law_record(
        "fremond_cangemi", normal_stiffness=stiffness, tangential_stiffness=stiffness, energy=energy
    )
    scene = Scene(
        dimension=2,
        plane="stress",
        materials={"stone": Material(density=2000.0 * mass / length**3, young=young, poisson=0.0)},
        structures=(
            BlockStructure(name="base", material="stone", size=(width, bar), support=True),
            BlockStructure(name="bar", material="stone", size=(width, bar), position=(0.0, bar)),
        ),
        mesh=MeshSettings(divisions=(1, 4)),
        joints=(Joint(law=law),),
        supports=(Support(on="bar/top", motion=Motion(displacement=(0.0, 1.0), time=path)),),
        analysis=Statics(load_steps=len(ends)),
        solver=Solver(tolerance=1e-12),
    )
    tape = Tape()
    assert solve_scene(scene, observers=[tape]).outcome == "equilibrium"
    # a metre of depth is a unit of length in 2D: forces are by that
    return [jump / opening for jump in tape.jump], [pull / width / peak for pull in tape.pull]


class Tape:
    """Mean jump of the joint and pull of its base, by step."""

    def __init__(self) -> None:
        self.jump: list[float] = []
        self.pull: list[float] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        self.jump.append(float(state.jump[:, 0].mean()))
        self.pull.append(-float(report.support_resultants["base"][1]))


@pytest.mark.slow
@pytest.mark.parametrize("system", list(UNITS)[1:])
def test_a9_7_units_leave_a_softening_joint(system: str) -> None:
    plain, other = series_bar(*UNITS["m, N, kg"]), series_bar(*UNITS[system])
    assert plain[0] == pytest.approx([0.5, 1.0, 1.143040, 1.626772, 2.190486, 4.398825], rel=1e-6)
    assert other[0] == pytest.approx(plain[0], rel=1e-8)
    assert other[1] == pytest.approx(plain[1], rel=1e-8)


def hertz(folder: Path, length: float, mass: float) -> tuple[np.ndarray, np.ndarray]:
    """A2.7: places over a and pressures over p0 under a cylinder of R = 0.1 m pressed by 1e5 N/m."""
    folder.mkdir()
    stress = mass / length
    half_width, peak = line_contact(1e5)
    (folder / "disc.geo").write_text(half_discs(("disc",), half_width, 6, 1.6, halves=(1,)))
    floor = BlockStructure(
        name="floor", material="stone", support=True,
        size=(0.3 * length, 0.05 * length), position=(-0.1 * length, -0.05 * length),
    )  # fmt: skip
    scene = Scene(
        dimension=2,
        materials={"stone": Material(density=2400 * mass / length**3, young=10e9 * stress, poisson=0.2)},
        structures=(
            FileStructure(name="c", material="stone", path="disc.geo", scale=length, trusted=True),
            floor,
        ),
        mesh=MeshSettings(element="P1"),
        supports=(Support(on="c.disc/disc_cut", components=("x",)),),
        joints=(Joint(friction=0.0),),
        contact=Contact(reach=(1.6 * half_width) ** 2 / (2 * RADIUS) * length),
        loads=Loads(tractions=(Traction(on="c.disc/disc_flat", vector=(0.0, -1e5 / 2 / RADIUS * stress)),)),
    )
    result = solve_scene(scene, folder)
    assert result.outcome == "equilibrium"
    contacts = result.built.model.contacts
    force = result.march.state.reaction[:, 0]
    return contacts.points[:, 0, 0] / (half_width * length), force / contacts.area / (peak * stress)


@pytest.mark.slow
@pytest.mark.parametrize("system", ["mm, N, t", "km, MN, Gg"])
def test_a9_7_units_leave_a_pressed_cylinder(tmp_path: Path, system: str) -> None:
    """A drawing in metres, scaled: the same pressures to 1e-8 of the peak, and Hertz's to 5 %."""
    plain, other = hertz(tmp_path / "plain", *UNITS["m, N, kg"]), hertz(tmp_path / "other", *UNITS[system])
    assert plain[1].max() == pytest.approx(1.0, rel=0.05)
    assert other[0] == pytest.approx(plain[0], abs=1e-8)
    assert other[1] == pytest.approx(plain[1], abs=1e-8)
