"""A9: numerical extremes with known answers (A9.1, A9.3, A9.4, A9.6 to A9.10)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.scene.specs import (
    ArchStructure,
    Dynamics,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Probe,
    StackStructure,
    Statics,
)
from tests.validation.scenes import G, cube_on_slope, rigid_arch, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-9)


@pytest.mark.parametrize("count", [10, 100])
def test_a9_1_stack_presses_with_its_whole_weight(count: int) -> None:
    """Base force nW to 1e-6: what a test on the change of r gets wrong on tall stacks."""
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=count),),
        analysis=ONE_STEP,
    )
    base = result.summary["supports"]["stack.ground"]["force"][2]
    assert base == pytest.approx(count * 2400 * G, rel=1e-6)
    assert result.outcome == "equilibrium"


def test_a9_1_elastic_stack_settles_by_its_weight() -> None:
    """ρ g L²/2E with ν = 0 and no friction; linear elements meet end displacements exactly."""
    column = Material(density=2400.0, young=10e9, poisson=0.0)
    result = solved(
        materials={"stone": column},
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=5),),
        mesh=MeshSettings(divisions=(1, 1, 2)),
        joints=(Joint(friction=0.0),),
        probes=(Probe(name="top", block="stack.b5", point=(0.5, 0.5, 5.0)),),
        analysis=Statics(),
    )
    assert result.summary["probes"]["top"][2] == pytest.approx(-2400 * G * 25 / 2 / 10e9, rel=1e-9)


@pytest.mark.parametrize("friction", [0.0, 0.6, 1e6])
def test_a9_3_four_corners_share_the_weight(friction: float) -> None:
    """Reactions of the four corners are not unique; their force and moment are."""
    result = cube_on_slope(0.0, friction, analysis=ONE_STEP)
    ground = result.summary["supports"]["cube.ground"]
    weight = 2400 * G
    assert ground["force"] == pytest.approx([0, 0, weight], abs=1e-8 * weight)
    assert ground["moment"] == pytest.approx([0.5 * weight, -0.5 * weight, 0], abs=1e-8 * weight)
    assert result.march.report.speed < 1e-12


def test_a9_6_slope_of_a_thousandth_of_a_degree_without_friction() -> None:
    result = cube_on_slope(
        0.001, 0.0, analysis=Dynamics(step=0.01, duration=1.0, theta=0.5),
        probes=(Probe(name="cube", block="cube.b1", point=(0.5, 0.5, 0.5)),),
    )  # fmt: skip
    a = G * np.sin(np.radians(0.001))
    assert result.summary["probes"]["cube"][0] == pytest.approx(a / 2, rel=1e-8)


def test_a9_6_frictionless_stack_stands_and_rough_one_sticks() -> None:
    smooth = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=5),),
        joints=(Joint(friction=0.0),),
        analysis=ONE_STEP,
    )
    assert smooth.outcome == "equilibrium"
    rough = cube_on_slope(44.0, 1e6, analysis=Dynamics(step=0.1, duration=0.5, theta=1.0))
    assert rough.march.report.speed < 1e-9


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


@pytest.mark.parametrize("contrast", [1e-6, 1e6])
def test_a9_9_stiffness_contrast_keeps_uniform_stress(contrast: float) -> None:
    """A soft and a stiff cube under pressure with ν = 0: σ = −p in both."""
    from masonry_fem.scene.specs import BlockStructure, Traction

    p = 1e6
    result = solved(
        materials={
            "one": Material(density=1.0, young=1e10, poisson=0.0),
            "two": Material(density=1.0, young=1e10 * contrast, poisson=0.0),
        },
        structures=(
            BlockStructure(
                name="ground", material="one", size=(3, 3, 1), position=(-1, -1, -1), support=True
            ),
            BlockStructure(name="lower", material="one", size=(1, 1, 1)),
            BlockStructure(name="upper", material="two", size=(1, 1, 1), position=(0, 0, 1)),
        ),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        loads=Loads(tractions=(Traction(on="upper/top", vector=(0, 0, -p)),)),
        joints=(Joint(friction=0.0),),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    stress = result.summary["stress"]
    assert stress["min_principal"]["value"] == pytest.approx(-p, rel=1e-8)
    assert abs(stress["max_principal"]["value"]) <= 1e-8 * p


def test_a9_6_thick_frictionless_arch_falls() -> None:
    result = rigid_arch(thickness=0.5, voussoirs=9, friction=0.0, analysis=ONE_STEP)
    assert result.outcome == "no_equilibrium"


AMPLIFICATION = {0.5: 1.0, 0.6: 0.99900309, 0.75: 0.99751089, 1.0: 0.99503719}


@pytest.mark.parametrize("theta", AMPLIFICATION)
def test_a9_4_amplification_of_a_mode(theta: float) -> None:
    """A free block that vibrates in one mode, ωh = 0.1: (Cq, u/ω) shrinks by the scheme's factor."""
    from scipy.linalg import eigh

    from masonry_fem.bodies.base import Scheme
    from masonry_fem.fem.groups import elastic_groups
    from masonry_fem.fem.material import ElasticMaterial
    from masonry_fem.geometry.meshing import mesh_shape
    from masonry_fem.solid.assembly import Assembly, Block, Shape
    from masonry_fem.solid.polytope import Polytope
    from masonry_fem.solid.pose import Pose

    shape = Shape("bar", Polytope.box((0.0, 0.0), (3.0, 1.0)))
    shape = replace(shape, mesh=mesh_shape(shape, MeshSettings(divisions=(4, 2)), 2))
    assembly = Assembly(2, (shape,), (Block("bar", 0, Pose.identity(2)),))
    (group,) = elastic_groups(assembly, {0: ElasticMaterial(young=1e9, poisson=0.2, density=2000.0)})
    stiffness, mass = (matrix.toarray() for matrix in (group.operators.stiffness, group.operators.mass))
    squares, modes = eigh(stiffness, mass)
    mode, omega = modes[:, 5], np.sqrt(squares[5])
    scheme = Scheme(step=0.1 / omega, theta=theta)
    state = replace(group.rest(), displacement=mode[None].copy())
    size = []
    for _ in range(11):
        size.append(np.sqrt(2 * float(group.kinetic_energy(state)[0] + group.strain_energy(state)[0])))
        free = group.free(state, state, group.acceleration_force(np.zeros(2)), scheme)
        state = group.advance(state, free, free.rigid_velocity, np.zeros_like(state.displacement), scheme)
    exact = np.sqrt((1 + (1 - theta) ** 2 * 0.01) / (1 + theta**2 * 0.01))
    assert exact == pytest.approx(AMPLIFICATION[theta], abs=1e-8)
    assert np.array(size[1:]) / np.array(size[:-1]) == pytest.approx(np.full(10, exact), rel=1e-10)
