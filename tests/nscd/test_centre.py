"""Centres of proximal problems: inside cones where contacts stick, and nowhere else."""

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.centre import MARGIN, inside

FRICTION, SCALE, ERROR = 0.5, 1e-3, 1e-4


def stones(sides: list[tuple[int, int]]) -> ContactProblem:
    """A problem whose contacts join bodies, −1 for none, in the plane."""
    c, b = len(sides), max(map(max, sides)) + 1
    return ContactProblem(
        friction=np.full(c, FRICTION),
        free_velocity=np.zeros((c, 2)),
        compliance=sparse.diags_array(np.full(2 * c, SCALE)).tobsr((2, 2)),
        bodies=np.array(sides),
        rigid_map=np.zeros((c, 2, 2, 3)),
        rigid_mass=np.zeros((b, 3)),
        rigid_impulse=np.zeros((b, 3)),
        rigid_velocity=np.zeros((b, 3)),
    )


def centre(
    normal: list[float],
    share: list[float],
    *,
    speed: list[float] | None = None,
    sides: list[tuple[int, int]] | None = None,
    weight: float = 1e-5,
) -> np.ndarray:
    """Tangential impulses of the centre over μ p_N; ``speed`` over that of the error at each contact."""
    problem = stones(sides or [(i, -1) for i in range(len(normal))])
    impulse = np.stack([np.array(normal), FRICTION * np.array(normal) * np.array(share)], axis=1)
    velocity = np.zeros_like(impulse)
    if speed is not None:
        velocity[:, 1] = -ERROR * SCALE * FRICTION * np.array(normal) * np.array(speed)
    found = inside(problem, impulse, velocity, np.full(len(normal), SCALE), ERROR, weight)
    np.testing.assert_array_equal(found[:, 0], impulse[:, 0])
    result: np.ndarray = found[:, 1] / (FRICTION * impulse[:, 0])
    return result


def test_what_sticks_at_the_edge_is_drawn_inside() -> None:
    """On either side of the cone; what lies deeper stays."""
    np.testing.assert_allclose(centre([2.0, 3.0, 1.0], [1.0, -1.0, 0.5]), [1 - MARGIN, MARGIN - 1, 0.5])


@pytest.mark.parametrize(("speed", "drawn"), [(0.0, 1.0), (0.25, 0.75), (1.0, 0.0), (50.0, 0.0)])
def test_the_share_falls_with_slip(speed: float, drawn: float) -> None:
    """Continuously: what is as fast as the error slips, and stays on its cone."""
    np.testing.assert_allclose(centre([2.0], [1.0], speed=[speed]), [1 - MARGIN * drawn])


def test_velocities_move_by_no_more_than_the_error() -> None:
    """α w times the way is at most the error of w μ p_N: with large weights the way is short."""
    weight = 1e-2
    np.testing.assert_allclose(centre([2.0], [1.0], weight=weight), [1 - ERROR / weight])


def test_neighbours_that_bear_next_to_nothing_hold_it_back() -> None:
    """A contact of the same stone with a thousandth of the normal impulse allows a thousandth of the way."""
    sides = [(0, 1), (1, -1), (2, -1)]
    found = centre([2.0, 2e-3, 2.0], [1.0, 0.0, 1.0], sides=sides)
    np.testing.assert_allclose(found, [1 - MARGIN * 1e-3, 0.0, 1 - MARGIN], atol=1e-12)


def test_open_contacts_bear_nothing_and_hold_nothing_back() -> None:
    """Impulses round a stone do not pass by them."""
    problem = stones([(0, -1), (0, -1)])
    impulse = np.array([[2.0, FRICTION * 2.0], [0.0, 0.0]])
    found = inside(problem, impulse, np.zeros((2, 2)), np.full(2, SCALE), ERROR, 1e-5)
    np.testing.assert_allclose(found, [[2.0, (1 - MARGIN) * FRICTION * 2.0], [0.0, 0.0]])
