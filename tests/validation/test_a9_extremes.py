"""A9: numerical extremes with known answers (A9.1, A9.3, A9.4, A9.6)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.run import RunResult
from masonry_fem.scene.specs import (
    Dynamics,
    Equilibrium,
    Joint,
    Material,
    MeshSettings,
    Probe,
    Solver,
    StackStructure,
    Statics,
)
from tests.validation.scenes import G, cube_on_slope, rigid_arch, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-9)


def carried(result: RunResult) -> np.ndarray:
    """Sum of the normal reactions of each bed joint, from the ground up [N]."""
    state, joint = result.march.state, result.built.model.contacts.interface
    force, height = (np.bincount(joint, values) for values in (state.reaction[:, 0], state.points[:, 2]))
    return force[np.argsort(height / np.bincount(joint))]


@pytest.mark.parametrize("analysis", [ONE_STEP, Statics()], ids=["large step", "statics"])
@pytest.mark.parametrize("count", [10, 100, 1000])
def test_a9_1_stack_presses_with_its_whole_weight(count: int, analysis: Equilibrium | Statics) -> None:
    """Base force nW to 1e-6: what a test on the change of r gets wrong on tall stacks."""
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=count),),
        analysis=analysis,
        solver=Solver(tolerance=1e-12),
    )
    weight = 2400 * G
    assert result.outcome == "equilibrium"
    base = result.summary["supports"]["stack.ground"]["force"][2]
    assert base == pytest.approx(count * weight, rel=1e-6)
    assert carried(result) == pytest.approx(np.arange(count, 0, -1) * weight, rel=1e-6)


def test_a9_1_unsolved_steps_say_nothing_of_what_exists() -> None:
    """Cut short, sweeps leave two thirds of the weight uncarried; that is no proof of a fall.

    By impulses alone their error is below 1e-3.
    """
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=100),),
        analysis=ONE_STEP,
        solver=Solver(tolerance=1e-12, method="nsgs", max_iterations=1000),
    )
    assert result.march.report.natural_map < 1e-3
    assert result.outcome == "no_convergence"


@pytest.mark.parametrize(
    ("count", "divisions"),
    [(10, (1, 1, 1)), (10, (2, 2, 2)), (100, (1, 1, 1)), (100, (2, 2, 2)), (1000, (1, 1, 1))],
)
def test_a9_1_elastic_stack_settles_by_its_weight(count: int, divisions: tuple[int, int, int]) -> None:
    """ρ g L²/2E with ν = 0 and no friction; linear elements meet end displacements exactly."""
    column = Material(density=2400.0, young=10e9, poisson=0.0)
    result = solved(
        materials={"stone": column},
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=count),),
        mesh=MeshSettings(divisions=divisions),
        joints=(Joint(friction=0.0),),
        probes=(Probe(name="top", block=f"stack.b{count}", point=(0.5, 0.5, float(count))),),
        analysis=Statics(),
        solver=Solver(tolerance=1e-12 if count == 1000 else 1e-10),  # its error grows with the height
    )
    weight = 2400 * G
    assert result.outcome == "equilibrium"
    settlement = weight * count**2 / 2 / 10e9
    assert result.summary["probes"]["top"][2] == pytest.approx(-settlement, rel=1e-8)
    base = result.summary["supports"]["stack.ground"]["force"][2]
    assert base == pytest.approx(count * weight, rel=1e-8)
    assert carried(result) == pytest.approx(np.arange(count, 0, -1) * weight, rel=1e-8)


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


def test_a9_6_frictionless_stack_stands() -> None:
    smooth = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=5),),
        joints=(Joint(friction=0.0),),
        analysis=ONE_STEP,
    )
    assert smooth.outcome == "equilibrium"
    assert carried(smooth) == pytest.approx(np.arange(5, 0, -1) * 2400 * G, rel=1e-8)


@pytest.mark.parametrize("analysis", [Dynamics(step=0.1, duration=0.5, theta=1.0), Statics()])
@pytest.mark.parametrize("angle", [1.0, 30.0, 44.0, 44.99])
def test_a9_6_what_is_rough_sticks_until_it_tips(angle: float, analysis: Dynamics | Statics) -> None:
    """µ = 1e6; a cube tips from 45° on."""
    rough = cube_on_slope(angle, 1e6, analysis=analysis)
    assert rough.march.report.speed < 1e-9
    a, weight = np.radians(angle), 2400 * G
    force = rough.summary["supports"]["cube.ground"]["force"]
    assert force == pytest.approx([-weight * np.sin(a), 0, weight * np.cos(a)], abs=1e-8 * weight)


def test_a9_6_beyond_that_angle_it_tips() -> None:
    assert cube_on_slope(45.01, 1e6, analysis=Statics()).outcome == "no_equilibrium"


@pytest.mark.parametrize("thickness", [0.11, 0.5, 1.0, 1.9])
def test_a9_6_frictionless_arch_falls_however_thick(thickness: float) -> None:
    result = rigid_arch(thickness=thickness, voussoirs=9, friction=0.0, analysis=ONE_STEP)
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
