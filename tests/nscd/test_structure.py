"""What solvers keep from problem to problem: patterns with rows to spare, and the last factor."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.nscd import SolverSettings, Start, solve
from masonry_fem.nscd.compliance import Kinds, Shared
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.solvers.block_pattern import BlockPattern, Family
from masonry_fem.nscd.solvers.chord import continued
from masonry_fem.nscd.solvers.newton_system import NewtonSystem
from masonry_fem.nscd.structure import Structure
from tests.nscd import walls

SETTINGS = SolverSettings()


@pytest.fixture(scope="module")
def problem():
    return walls.arch(5, (3, 2, 2)).problem()


def guess(solution):
    return Start(solution.impulse, solution.rigid_velocity, solution.velocity)


@given(seed=st.integers(0, 10**6))
def test_blocks_stand_where_they_belong(seed):
    rng = np.random.default_rng(seed)
    heights = rng.integers(1, 4, 6)
    begin = np.cumsum(heights) - heights
    size = int(heights.sum())
    families, blocks, dense, filled = [], [], np.zeros((size, size)), rng.random((6, 6)) < 0.6
    for height in np.unique(heights):
        for width in np.unique(heights):
            i, j = np.nonzero(filled & (heights[:, None] == height) & (heights == width))
            order = rng.permutation(len(i))
            families.append(Family(begin[i[order]], begin[j[order]], height, width))
            blocks.append(rng.normal(size=(len(i), height, width)))
            for row, column, block in zip(families[-1].rows, families[-1].columns, blocks[-1], strict=True):
                dense[row : row + height, column : column + width] = block
    matrix = BlockPattern(size, families).filled(blocks)
    assert np.array_equal(matrix.toarray(), dense)
    assert matrix.has_canonical_format


def step(system, problem, closed, seed=0):
    """Newton's change on some contacts, of random terms."""
    rng = np.random.default_rng(seed)
    c, d = problem.free_velocity.shape
    own = np.tile(1e-2 * np.eye(d), (c, 1, 1)) * contact_scale(problem)[:, None, None]
    slope = np.eye(d) + 0.1 * rng.normal(size=(c, d, d))
    factor = system.factor(own, slope, closed, np.zeros(c, dtype=bool), problem.rigid_mass)
    return factor.solve(rng.normal(size=(c, d)), rng.normal(size=problem.rigid_mass.shape))


def test_rows_to_spare_change_no_step(problem):
    """An open contact with a row of its own: its impulse stays, and the others' change as without it."""
    scale, closed = contact_scale(problem), np.ones(problem.count, dtype=bool)
    kept = replace(problem, structure=Structure())
    step(NewtonSystem(kept, scale, "direct"), kept, closed)
    pattern = kept.structure.matrix
    closed[[2, 7]] = False
    change, motion = step(NewtonSystem(kept, scale, "direct"), kept, closed)
    assert kept.structure.matrix is pattern
    alone, moved = step(NewtonSystem(problem, scale, "direct"), problem, closed)
    assert not change[~closed].any()
    np.testing.assert_allclose(change, alone, rtol=1e-9, atol=1e-11 * np.abs(alone).max())
    np.testing.assert_allclose(motion, moved, rtol=1e-9, atol=1e-11 * np.abs(moved).max())
    closed[: problem.count // 2] = False
    step(NewtonSystem(kept, scale, "direct"), kept, closed)
    assert np.array_equal(kept.structure.matrix.contacts, np.flatnonzero(closed))


def test_a_dense_factor_takes_the_same_step_without_the_matrix(monkeypatch):
    rng = np.random.default_rng(3)
    count = 24
    root = rng.normal(size=(3 * count, 3 * count))
    turns = np.linalg.qr(rng.normal(size=(1, count, 3, 3)))[0]
    stone = Kinds.alike(rng.permutation(count)[None], turns, root @ root.T)
    plain = ContactProblem.plain(Shared(count, 3, [stone]).matrix(), np.ones((count, 3)), 0.5)
    sides = np.tile([0, -1], (count, 1))
    bodily = {name: np.zeros((1, 6)) for name in ("rigid_mass", "rigid_impulse", "rigid_velocity")}
    stored = replace(plain, bodies=sides, rigid_map=rng.normal(size=(count, 2, 3, 6)), **bodily)
    problem = replace(stored, compliance=Shared(count, 3, [stone]))
    monkeypatch.setattr(Shared, "matrix", pytest.fail)
    systems = [NewtonSystem(one, contact_scale(one)) for one in (stored, problem)]
    for opened in ([], [7]):  # its row is kept
        closed = ~np.isin(np.arange(count), opened)
        expected, found = (step(system, stored, closed) for system in systems)
        for one, other in zip(expected, found, strict=True):
            np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-11 * np.abs(one).max())
    assert len(systems[1].structure.matrix.contacts) == count
    x = rng.normal(size=3 * count + 6)
    answer, other = (system.structure.factor.answer.matrix @ x for system in systems)
    np.testing.assert_allclose(other, answer, rtol=1e-12, atol=1e-12 * np.abs(answer).max())


def test_a_pattern_serves_its_own_coupling_only(problem):
    kept = replace(problem, structure=Structure())
    closed = np.ones(problem.count, dtype=bool)
    step(NewtonSystem(kept, contact_scale(kept), "direct"), kept, closed)
    pattern, contacts = kept.structure.matrix, np.arange(problem.count)
    assert pattern.serves(kept, contacts)
    assert not pattern.serves(replace(kept, bodies=kept.bodies[:, ::-1]), contacts)
    assert not pattern.serves(kept.without_compliance(), contacts)


def turned(problem, angle):
    """The problem with its blocks and loads turned a little, each in its own way."""
    rng = np.random.default_rng(1)
    return replace(
        problem,
        rigid_map=problem.rigid_map * (1 + angle * rng.uniform(-1, 1, problem.rigid_map.shape)),
        rigid_impulse=problem.rigid_impulse * (1 + angle * rng.uniform(-1, 1, problem.rigid_impulse.shape)),
    )


def test_the_last_factor_solves_a_problem_that_is_nearly_the_same(problem):
    kept = replace(problem, structure=Structure())
    first = solve(kept, SETTINGS)
    assert first.converged
    assert first.linear_solves > 0
    further = turned(kept, 1e-6)
    led = solve(further, SETTINGS, guess(first))
    assert led.converged
    assert led.linear_solves == 0
    anew = solve(replace(further, structure=None), SETTINGS, guess(first))
    assert anew.linear_solves > 0
    size = np.abs(anew.impulse).max()
    assert np.abs(led.impulse - anew.impulse).max() < 1e-8 * size
    assert np.abs(led.impulse - first.impulse).max() > 1e-8 * size


def test_where_contacts_change_the_guess_is_left_as_it_is(problem):
    kept = replace(problem, structure=Structure())
    first = guess(solve(kept, SETTINGS))
    pushed = replace(kept, rigid_impulse=kept.rigid_impulse + 0.2 * np.abs(kept.rigid_impulse).max())
    assert continued(pushed, first, SETTINGS) is first
    assert continued(problem, first, SETTINGS) is first  # without a structure
    opened = np.where(first.impulse.any(axis=1)[:, None], 1.0, 0.0) * [1.0, 0.0, 0.0]
    elsewhere = replace(first, impulse=0.0 * first.impulse, velocity=opened)
    assert continued(turned(kept, 1e-6), elsewhere, SETTINGS) is elsewhere
