"""What iterations multiply by, beside the same products of dense matrices."""

import numpy as np
import pytest

from masonry_fem.nscd.solvers.elastic_kernel import add_solutions, rows_product, take_followed

SETS, CONTACTS, BODIES = 4, 3, 6


@pytest.fixture
def group(random: np.random.Generator) -> np.ndarray:
    """Contacts of each set; some contacts are in none."""
    return random.permutation(SETS * CONTACTS + 5)[: SETS * CONTACTS].reshape(SETS, CONTACTS)


@pytest.fixture
def random() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.mark.parametrize("d", [2, 3])
def test_solutions_of_sets(random: np.random.Generator, group: np.ndarray, d: int) -> None:
    inverse = random.normal(size=(SETS, CONTACTS * d, CONTACTS * d))
    force, before = random.normal(size=(2, SETS * CONTACTS + 5, d))
    impulse = before.copy()
    add_solutions(group, inverse, force, impulse)
    expected = before.copy()
    expected[group] += np.einsum("nij,nj->ni", inverse, force[group].reshape(SETS, -1)).reshape(
        *group.shape, d
    )
    np.testing.assert_allclose(impulse, expected, rtol=1e-13)


@pytest.mark.parametrize(("d", "m"), [(2, 3), (3, 6)])
def test_what_follows_bodies(random: np.random.Generator, group: np.ndarray, d: int, m: int) -> None:
    """The second body of a set may be none, which does not move."""
    bodies = random.integers(0, BODIES, (SETS, 2))
    bodies[1:3, 1] = -1
    followed = random.normal(size=(SETS, CONTACTS * d, 2 * m))
    motion, before = random.normal(size=(BODIES, m)), random.normal(size=(SETS * CONTACTS + 5, d))
    impulse = before.copy()
    take_followed(group, followed, bodies, motion, impulse)
    moved = np.where(bodies[:, :, None] < 0, 0.0, motion[bodies]).reshape(SETS, -1)
    expected = before.copy()
    expected[group] -= np.einsum("nij,nj->ni", followed, moved).reshape(*group.shape, d)
    np.testing.assert_allclose(impulse, expected, rtol=1e-13)


def test_rows_of_contacts(random: np.random.Generator) -> None:
    by_velocity, own = random.normal(size=(2, 7, 3, 3))
    velocity, moved, x = random.normal(size=(3, 7, 3))
    found = rows_product(by_velocity, own, 0.25, velocity, moved, x)
    pushed = velocity / 0.25 + moved
    expected = np.einsum("cij,cj->ci", by_velocity, pushed) + np.einsum("cij,cj->ci", own, x)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)
