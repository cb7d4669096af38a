"""Linear factors: all agree with dense algebra; fronts on any pattern, order and emptied groups."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from masonry_fem.nscd.fronts import FrontFactor, FrontPlan, eliminate_order
from masonry_fem.nscd.linear import factorise


def block_system(seed, count, *, empty=0.0):
    """A random block-sparse matrix on a chain with some long links; its groups and neighbours."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 9, count)
    sizes[rng.random(count) < empty] = 0
    sizes[0] = max(sizes[0], 1)
    links = [(i, i + 1) for i in range(count - 1)] + [
        tuple(rng.integers(0, count, 2)) for _ in range(count // 2)
    ]
    neighbours = [set() for _ in range(count)]
    for i, j in links:
        if i != j:
            neighbours[i].add(int(j))
            neighbours[j].add(int(i))
    groups = rng.permutation(np.repeat(np.arange(count), sizes))
    linked = np.eye(count, dtype=bool)
    for i, near in enumerate(neighbours):
        linked[i, list(near)] = True
    matrix = rng.normal(size=(len(groups), len(groups))) * linked[np.ix_(groups, groups)]
    matrix += np.diag(5.0 + np.abs(matrix).sum(axis=1))
    return sparse.csr_array(matrix), groups, neighbours, sizes, rng.normal(size=len(groups))


@given(seed=st.integers(0, 10**6), count=st.integers(1, 30), empty=st.sampled_from([0.0, 0.4]))
def test_fronts_solve_any_block_pattern(seed, count, empty):
    matrix, groups, neighbours, sizes, rhs = block_system(seed, count, empty=empty)
    elimination = eliminate_order(neighbours, sizes, [set() for _ in range(count)])
    found = FrontFactor(FrontPlan(matrix, groups, elimination), matrix.data).solve(rhs)
    np.testing.assert_allclose(found, np.linalg.solve(matrix.toarray(), rhs), rtol=1e-10, atol=1e-12)


def test_one_plan_serves_all_values_of_a_pattern():
    matrix, groups, neighbours, sizes, rhs = block_system(3, 12)
    plan = FrontPlan(matrix, groups, eliminate_order(neighbours, sizes, [set() for _ in range(12)]))
    for factor in (1.0, -2.5):
        matrix.data *= factor
        found = FrontFactor(plan, matrix.data).solve(rhs)
        np.testing.assert_allclose(matrix @ found, rhs, atol=1e-10)


def test_groups_that_must_wait_are_eliminated_last():
    """A saddle point with a zero block: its multipliers only get pivots from what comes before."""
    B = np.array([[1.0], [2.0], [-1.0]])
    matrix = sparse.csr_array(np.block([[np.diag([1.0, 2.0, 3.0]), B], [B.T, np.zeros((1, 1))]]))
    elimination = eliminate_order(
        [{3}, {3}, {3}, {0, 1, 2}], np.array([1, 1, 1, 1]), [set(), set(), set(), {0, 1, 2}]
    )
    assert elimination.fronts[-1][-1] == 3
    found = FrontFactor(FrontPlan(matrix, np.arange(4), elimination), matrix.data).solve(np.ones(4))
    np.testing.assert_allclose(matrix @ found, np.ones(4), atol=1e-14)


@pytest.mark.parametrize("library", ["auto", "dense", "fronts", "superlu", "mumps"])
def test_libraries_agree(library):
    if library == "mumps":
        pytest.importorskip("dolfinx_solver")
        pytest.importorskip("petsc4py")
    matrix, groups, neighbours, sizes, rhs = block_system(3, 80)
    elimination = eliminate_order(neighbours, sizes, [set() for _ in neighbours])
    found = factorise(matrix, groups, elimination, library)(rhs)
    np.testing.assert_allclose(matrix @ found, rhs, atol=1e-13)


@pytest.mark.parametrize("library", ["dense", "fronts", "superlu"])
def test_singular_matrix_raises_nothing(library):
    matrix = sparse.csr_array(np.array([[1.0, 1.0], [1.0, 1.0]]))
    elimination = eliminate_order([{1}, {0}], np.array([1, 1]), [set(), set()])
    with np.errstate(all="ignore"):
        found = factorise(matrix, np.arange(2), elimination, library)(np.array([1.0, 0.0]))
    assert not np.isfinite(found).all() or np.abs(found).max() > 1e10
