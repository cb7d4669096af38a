"""A9.4: what θ takes from a vibration, and that it takes nothing from statics; θ from ½ to 1."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import MeshSettings
from tests.extremes.scenes import (
    bouncing,
    bouncing_gain,
    certificate,
    finite,
    sliding_block,
    sliding_error,
    standing_wall,
    wall_error,
)

AMPLIFICATION = {0.5: 1.0, 0.6: 0.99900309, 0.75: 0.99751089, 1.0: 0.99503719}
THETAS = [0.5, 0.501, 0.6, 0.75, 0.999, 1.0]


@pytest.mark.parametrize("theta", AMPLIFICATION)
def test_a9_4_amplification_of_a_mode(theta: float) -> None:
    """A free block that vibrates in one mode, ωh = 0.1: (Cq, u/ω) shrinks by the scheme's factor."""
    from scipy.linalg import eigh

    from masonry_fem.bodies.base import Scheme
    from masonry_fem.fem.groups import elastic_groups
    from masonry_fem.fem.material import ElasticMaterial
    from masonry_fem.meshing.mesher import mesh_shape
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


@pytest.mark.parametrize("theta", THETAS)
def test_a9_4_constant_acceleration_is_met_by_algebra(theta: float) -> None:
    """A1.2 with any θ: a h² n (n − 1 + 2θ)/2."""
    result = solve_scene(sliding_block(0.01, theta=theta))
    assert sliding_error(result, 0.01, theta=theta) < 1e-8


@pytest.mark.parametrize("theta", THETAS)
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a9_4_rest_stays_rest(fidelity, theta: float) -> None:
    """A wall that a push leaves standing: its energy balances and nothing creeps, whatever θ."""
    result = solve_scene(standing_wall(0.01, theta=theta, fidelity=fidelity))
    assert finite(result)
    assert max(certificate(result).values()) < 1e-9
    if fidelity == "rigid":
        assert wall_error(result) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a9_4_bouncing_never_gains_energy(restitution: float) -> None:
    result = solve_scene(bouncing(1e-3, restitution))
    gain = bouncing_gain(result)
    assert finite(result)
    assert gain < 1e-9
    if restitution == 1:
        assert abs(gain) < 1e-9
