"""Linear factors: they agree with dense algebra, tell the determinant's sign, and serve a pattern."""

import gc
import sys
import tempfile
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from masonry_fem.errors import InstallationError
from masonry_fem.nscd import linear, linear_cost, mumps
from masonry_fem.nscd.linear import DENSE_BELOW, factorise, library_for
from masonry_fem.nscd.mumps import Mumps, MumpsFactor
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.solvers.newton_system import NewtonSystem
from tests.nscd.masses import rigid_mass

needs_mumps = pytest.mark.skipif(mumps.petsc() is None, reason="PETSc with MUMPS is not installed")
LIBRARIES = ["dense", "superlu", pytest.param("mumps", marks=needs_mumps)]


def block_system(seed, count, *, strength=5.0):
    """A random block-sparse matrix on a chain with some long links, in any order, and a right-hand side."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 9, count)
    groups = rng.permutation(np.repeat(np.arange(count), sizes))
    linked = np.eye(count, dtype=bool)
    i, j = (
        np.r_[np.arange(count - 1), rng.integers(0, count, count // 2)],
        np.r_[np.arange(1, count), rng.integers(0, count, count // 2)],
    )
    linked[i, j] = linked[j, i] = True
    matrix = rng.normal(size=(len(groups), len(groups))) * linked[np.ix_(groups, groups)]
    matrix += np.diag(strength * (1.0 + np.abs(matrix).sum(axis=1)))
    return sparse.csr_array(matrix), rng.normal(size=len(groups))


def saddle_point(seed, count=90, bodies=15):
    """Contacts above bodies without mass: their pivots come from the contacts."""
    rng = np.random.default_rng(seed)
    blocks = sparse.block_diag(
        [sparse.csr_array(a @ a.T + 0.1 * np.eye(3)) for a in rng.normal(size=(count // 3, 3, 3))]
    )
    border = sparse.csr_array(rng.normal(size=(count, bodies)) * (rng.random((count, bodies)) < 0.3))
    nothing = sparse.csr_array((bodies, bodies))
    whole = sparse.vstack([sparse.hstack([nothing, border.T]), sparse.hstack([border, blocks])])
    return sparse.csr_array(whole), rng.normal(size=count + bodies)


@pytest.mark.parametrize("library", LIBRARIES)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 30))
def test_factors_solve_any_block_pattern(library, seed, count):
    matrix, rhs = block_system(seed, count)
    found = factorise(matrix, library)(rhs)
    np.testing.assert_allclose(found, np.linalg.solve(matrix.toarray(), rhs), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("make", [partial(block_system, count=60, strength=0.0), saddle_point])
def test_factors_find_pivots_off_the_diagonal(library, make):
    """Where there are none on the diagonal: solutions are as exact as those of dense algebra."""
    for seed in range(4):
        matrix, rhs = make(seed)
        found, expected = factorise(matrix, library)(rhs), np.linalg.solve(matrix.toarray(), rhs)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("size", [1, 2, 7, 60, 400])
def test_factors_tell_the_sign_of_the_determinant(library, size):
    random = np.random.default_rng(size)
    signs = set()
    for _ in range(6):
        matrix = random.standard_normal((size, size))
        expected = int(np.linalg.slogdet(matrix)[0])
        assert factorise(sparse.csr_array(matrix), library).sign() == expected
        signs.add(expected)
    assert signs == {1, -1}


@pytest.mark.parametrize("library", LIBRARIES)
def test_singular_matrix_raises_nothing(library):
    """The solution is infinite, or as large as a pivot of the size of rounding makes it."""
    matrix = sparse.csr_array(np.array([[1.0, 1.0], [1.0, 1.0]]))
    found = factorise(matrix, library)(np.array([1.0, 0.0]))
    assert np.abs(found).min() > 1e10


@pytest.mark.parametrize("library", ["superlu", pytest.param("mumps", marks=needs_mumps)])
def test_nearly_singular_matrix_gives_a_huge_solution(library):
    """Two parts that nothing but rounding holds to each other: the answer is large there only."""
    matrix, rhs = block_system(5, 20)
    loose = sparse.csr_array(np.array([[1.0, -1.0], [-1.0, 1.0 + 1e-15]]))
    whole = sparse.csr_array(sparse.block_diag([matrix, loose]))
    found = factorise(whole, library)(np.r_[rhs, 1.0, 1.0])
    assert np.abs(found[-2:]).min() > 1e10
    np.testing.assert_allclose(matrix @ found[:-2], rhs, atol=1e-12)


@pytest.mark.parametrize("library", LIBRARIES)
def test_a_matrix_that_is_not_finite_gives_no_solution(library):
    matrix, rhs = block_system(4, 60)
    matrix.data[7] = np.nan
    with np.errstate(invalid="ignore"):
        assert not np.isfinite(factorise(matrix, library)(rhs)).all()


@needs_mumps
def test_mumps_serves_all_values_of_a_pattern_in_any_order():
    first, rhs = block_system(3, 40)
    second = first.copy()
    second.data *= np.random.default_rng(1).uniform(-2.0, -1.0, first.nnz)
    second.setdiag(-10 * first.diagonal())
    kept = Mumps(first)
    solves = [factorise(matrix, "mumps", kept) for matrix in (first, second)]
    for number in (0, 1, 0, 0, 1):  # the factor of an earlier matrix is made again
        matrix = (first, second)[number]
        np.testing.assert_allclose(matrix @ solves[number](rhs), rhs, atol=1e-12)
        assert solves[number].sign() == int(np.linalg.slogdet(matrix.toarray())[0])


@needs_mumps
def test_mumps_goes_on_after_a_singular_matrix():
    matrix, rhs = block_system(3, 40)
    singular = matrix.copy()
    singular.data[singular.indptr[4] : singular.indptr[5]] = 0.0
    kept = Mumps(matrix)
    for _ in range(2):
        assert np.isinf(kept.solve(singular, rhs)).all()
        assert kept.sign(singular) == 0
        np.testing.assert_allclose(matrix @ kept.solve(matrix, rhs), rhs, atol=1e-10)


@needs_mumps
def test_mumps_gets_more_memory_where_it_was_too_little(monkeypatch):
    matrix, rhs = block_system(3, 400)
    monkeypatch.setattr(mumps, "SPACES", (-50,))
    assert np.isinf(factorise(matrix, "mumps")(rhs)).all()
    monkeypatch.setattr(mumps, "SPACES", (-50, -40, 50))
    np.testing.assert_allclose(matrix @ factorise(matrix, "mumps")(rhs), rhs, atol=1e-11)


def test_the_factor_is_chosen_by_size_and_fill(monkeypatch):
    large = DENSE_BELOW
    assert library_for(large - 1, fills=True) == library_for(large - 1, "krylov") == "dense"
    assert library_for(large) == library_for(large, "direct") == library_for(large, "krylov") == "superlu"
    assert library_for(3, "superlu") == "superlu"
    monkeypatch.setattr(linear, "petsc", lambda: None)
    assert library_for(large, fills=True) == "superlu"
    monkeypatch.setattr(linear, "petsc", object)
    assert library_for(large, fills=True) == "mumps"


@needs_mumps
def test_thick_masonry_is_factorised_by_mumps(monkeypatch):
    problem = rigid_mass(5, 5, 3)
    system = NewtonSystem(problem, contact_scale(problem), "direct")
    matrix = system.body_matrix.assemble(np.zeros((0, 3, 3)), np.arange(0), np.ones_like(problem.rigid_mass))
    makers = []
    for cheap in (np.inf, 0.0):
        monkeypatch.setattr(linear_cost, "CHEAP", cheap)
        makers.append(getattr(system._bodies_factorised(matrix).bare, "func", None))
    assert matrix.shape[0] >= DENSE_BELOW
    assert makers[0] is None
    assert isinstance(makers[1].__self__, Mumps)


def test_missing_mumps_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "petsc4py.PETSc", None)
    mumps.petsc.cache_clear()
    try:
        with pytest.raises(InstallationError, match="needs petsc4py with MUMPS, which is not installed"):
            factorise(sparse.csr_array(np.eye(2)), "mumps")
    finally:
        mumps.petsc.cache_clear()


@needs_mumps
@pytest.mark.parametrize("definite", [True, False])
def test_a_factor_on_disk_answers_and_leaves_no_files(definite, monkeypatch, tmp_path):
    monkeypatch.setattr(mumps, "LARGE", 10)
    monkeypatch.setattr(mumps, "AT_ONCE", 2)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    rng = np.random.default_rng(1)
    matrix = sparse.random_array((60, 60), density=0.1, rng=rng)
    matrix = sparse.csr_array(matrix @ matrix.T if definite else matrix) + sparse.eye_array(60)
    matrix = sparse.csr_array(matrix)
    matrix.sort_indices()
    dense, rhs = matrix.toarray(), rng.normal(size=(60, 3))
    some = np.array([3, 17, 50])
    factor = MumpsFactor(matrix, definite=definite)
    assert len(list(tmp_path.iterdir())) == 1
    np.testing.assert_allclose(factor.answer(rhs), np.linalg.solve(dense, rhs), rtol=1e-9, atol=1e-11)
    columns = np.array([3, 57])
    inverse = np.linalg.inv(dense)
    np.testing.assert_allclose(factor.columns(columns), inverse[:, columns], atol=1e-11)
    if definite:
        np.testing.assert_allclose(factor.among(some), inverse[np.ix_(some, some)], atol=1e-11)
    np.testing.assert_allclose(factor.answer(rhs), np.linalg.solve(dense, rhs), rtol=1e-9, atol=1e-11)
    del factor
    gc.collect()
    assert list(tmp_path.iterdir()) == []
