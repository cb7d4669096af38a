"""Mechanisms: velocities that do the right work, the simplest of many, in words."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.limit import Mechanism, admissible, collapse_multiplier
from masonry_fem.scene.specs import Joint
from masonry_fem.structures.wall import WallStructure
from tests.limit.scenes import G, accelerated, arch, number, problem, scene


def wall(dimension: int, friction: float):
    brick = (0.5, 0.25, 0.25)[:dimension]
    stones = WallStructure(name="w", material="stone", brick=brick, columns=3, courses=4)
    made = scene(stones, dimension=dimension, joints=(Joint(friction=friction),))
    return problem(made, accelerated(1.0, *(0.0,) * (dimension - 1)))


def collapse(made) -> tuple[float, Mechanism]:
    found = collapse_multiplier(made)
    assert found.mechanism is not None
    return found.multiplier, found.mechanism


@pytest.mark.parametrize("dimension", [2, 3])
def test_of_many_sliding_mechanisms_the_whole_wall_moves_as_one(dimension: int) -> None:
    limit, motion = collapse(wall(dimension, 0.4))
    assert limit == pytest.approx(0.4, abs=1e-8)
    assert len(motion.groups) == 1
    assert motion.moving == len(motion.blocks)
    assert {joint.how for joint in motion.joints} == {"slides"}
    assert all("w.ground" in joint.between for joint in motion.joints)
    assert motion.sentence().startswith(f"{motion.moving} blocks move as one; 3 sliding joints: ")
    # associated: it rises by μ of what it slides
    np.testing.assert_allclose(motion.velocity[:, -1], 0.4 * motion.velocity[:, 0], atol=1e-7)


@pytest.mark.parametrize("dimension", [2, 3])
def test_weights_take_the_power_that_the_load_gives(dimension: int) -> None:
    """λ Σ m g u_x = Σ m g u_z, u of the centroids: hinges and cones take nothing."""
    ahead = (1.0,) + (0.0,) * (dimension - 1)
    made = problem(arch(0.2, 11, 5.0, dimension=dimension), accelerated(*ahead))
    limit, motion = collapse(made)
    given = taken = 0.0
    for row, block in enumerate(motion.blocks.tolist()):
        mass = made.model.assembly.solid(block).mass_properties()
        arm = mass.centroid - motion.centre[row]
        spin = motion.spin[row]
        turned = spin[0] * np.array([-arm[1], arm[0]]) if dimension == 2 else np.cross(spin, arm)
        velocity = motion.velocity[row] + turned
        given += limit * mass.volume * velocity[0]
        taken += mass.volume * velocity[-1]
    assert given == pytest.approx(taken, rel=1e-6)


def test_the_fastest_corner_moves_at_one_metre_a_second() -> None:
    _, motion = collapse(wall(2, 5.0))
    made = wall(2, 5.0)
    speeds = []
    for row, block in enumerate(motion.blocks.tolist()):
        arms = made.model.assembly.solid(block).vertices - motion.centre[row]
        turned = motion.spin[row] * np.column_stack([-arms[:, 1], arms[:, 0]])
        speeds.append(np.linalg.norm(motion.velocity[row] + turned, axis=1).max())
    assert max(speeds) == pytest.approx(1.0, rel=1e-9)


def test_an_arch_too_thin_of_an_odd_number_of_voussoirs_has_six_hinges() -> None:
    """Haunches, springings, and the two sides of the key."""
    made = problem(arch(0.104, 11, 100.0))
    found = admissible(made)
    assert found.mechanism is not None
    assert [joint.how for joint in found.mechanism.joints] == ["hinge"] * 6
    assert {frozenset(joint.between) for joint in found.mechanism.joints} == {
        frozenset(pair)
        for pair in (
            ("arch.springing_left", "arch.v01"), ("arch.v02", "arch.v03"), ("arch.v05", "arch.v06"),
            ("arch.v06", "arch.v07"), ("arch.v09", "arch.v10"), ("arch.v11", "arch.springing_right"),
        )
    }  # fmt: skip
    crown = found.mechanism.velocity[found.mechanism.blocks.tolist().index(number(made, "arch.v06"))]
    assert crown[1] < 0 < G
