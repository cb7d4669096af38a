"""Iterated Newton steps: the same answers as a factor gives, in few iterations at any size of wall."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.nscd import SolverSettings, solve
from masonry_fem.nscd.methods.newton import ProximalNewton
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.settings import Start
from masonry_fem.nscd.solvers import elastic_krylov
from masonry_fem.nscd.solvers.elastic_krylov import interfaces_by_size, iteration_pays
from masonry_fem.nscd.solvers.linearisation import linearise
from masonry_fem.nscd.solvers.newton_system import NewtonSystem

from .walls import wall

SIZE = {"courses": 3, "length": 1.5, "elements": (2, 1, 1)}


@pytest.fixture
def counts(monkeypatch):
    """Residuals after each iteration of all systems so far."""
    found = []

    def counted(operator, rhs, **settings):
        return gmres(operator, rhs, callback=found.append, callback_type="pr_norm", **settings)

    gmres = elastic_krylov.gmres
    monkeypatch.setattr(elastic_krylov, "gmres", counted)
    return found


def step(problem, seed, library, system=None):
    """Factor of a step, of a system if given, at random impulses: contacts are open, slide and stick."""
    random = np.random.default_rng(seed)
    pressed = random.normal(size=problem.free_velocity.shape) + np.array([1.5, 0.0, 0.0])
    scale = np.abs(problem.compliance.diagonal()).reshape(-1, 3).max(axis=1)
    scale[scale == 0] = scale[scale > 0].mean()
    line = linearise(pressed, np.zeros_like(pressed), problem.friction, 1 / scale)
    states = [line.open.any(), line.plain.any(), (~line.open & ~line.plain).any()]
    assert all(states)
    own = line.by_impulse * scale[:, None, None] + 1e-3 * scale[:, None, None] * line.by_velocity
    system = NewtonSystem(problem, scale, library) if system is None else system
    mass = 1e-3 * system.column**2 / system.unit
    return system.factor(own, line.by_velocity, ~line.open, line.plain, mass)


@pytest.mark.parametrize("rigid", [(), (3, 4)], ids=["elastic", "mixed"])
@pytest.mark.parametrize("seed", range(3))
def test_a_step_is_that_of_the_factor(seed, rigid, monkeypatch):
    monkeypatch.setattr(elastic_krylov, "EXACT", 1e-12)
    problem = wall(**SIZE).problem(rigid=rigid)
    random = np.random.default_rng(10 + seed)
    force, balance = (
        random.normal(size=problem.free_velocity.shape),
        random.normal(size=(problem.body_count, 6)),
    )
    scale = np.abs(problem.compliance.diagonal()).mean()
    found = step(problem, seed, "krylov").solve(scale * force, balance)
    expected = step(problem, seed, "direct").solve(scale * force, balance)
    for one, other in zip(found, expected, strict=True):
        assert np.abs(one - other).max() <= 1e-7 * np.abs(other).max()


def test_a_step_is_the_same_when_another_has_come_after_it():
    """All steps of a problem have their rows in the same room."""
    problem = wall(**SIZE).problem()
    random = np.random.default_rng(4)
    force, balance = (
        random.normal(size=problem.free_velocity.shape),
        random.normal(size=(problem.body_count, 6)),
    )
    older = step(problem, 0, "krylov")
    before = older.solve(force, balance)
    newer = step(problem, 1, "krylov", older.system).solve(force, balance)
    after = older.solve(force, balance)
    for one, same, other in zip(before, after, newer, strict=True):
        np.testing.assert_array_equal(one, same)
        assert np.abs(one - other).max() > 1e-3 * np.abs(one).max()


def test_iterations_hardly_grow_with_the_wall(counts):
    most = []
    for courses, length in ((3, 1.5), (6, 3.0)):
        counts.clear()
        problem = wall(courses, length, (2, 1, 1)).problem()
        made = solve(problem, SolverSettings(method="newton", tolerance=1e-9, linear="krylov"))
        assert made.converged
        most.append(len(counts) / made.linear_solves)
    assert most[1] <= 1.3 * most[0]
    assert max(most) <= 30


@pytest.mark.parametrize(("fits", "most"), [(10_000, 50), (10, 20)], ids=["a factor fits", "none does"])
def test_a_step_without_an_end_is_left_sooner_where_no_factor_fits(fits, most, counts, monkeypatch):
    for name, value in {"EXACT": 0.0, "CLOSER": 0.0, "FACTORED": fits}.items():
        monkeypatch.setattr(elastic_krylov, name, value)
    problem = wall(**SIZE).problem()
    force = np.random.default_rng(3).normal(size=problem.free_velocity.shape)
    scale = np.abs(problem.compliance.diagonal()).mean()
    found = step(problem, 0, "krylov").solve(scale * force, np.zeros((problem.body_count, 6)))
    assert len(counts) == most
    expected = step(problem, 0, "direct").solve(scale * force, np.zeros((problem.body_count, 6)))
    for one, other in zip(found, expected, strict=True):
        assert np.abs(one - other).max() <= 1e-3 * np.abs(other).max()


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-8, 1e-4])
def test_newton_takes_the_steps_that_factors_lead_to(gap, counts):
    """With systems of few contacts solved as those of many are, joints open by 1e-12 m took 400."""
    structure = wall()
    problem = structure.problem()
    assert elastic_krylov.CONTACTS <= problem.count < elastic_krylov.MANY
    heads = np.abs(np.array([frame[0, 0] for *_, frame in structure.pairs])) > 0.5
    free = problem.free_velocity.copy()
    free[heads, 0] += gap
    opened = replace(problem, free_velocity=free)
    found, expected = (
        solve(opened, SolverSettings(method="newton", tolerance=1e-9, linear=linear))
        for linear in ("auto", "direct")
    )
    assert counts
    assert found.converged
    assert found.linear_solves <= expected.linear_solves + 1  # near the tolerance rounding decides
    size = np.abs(expected.impulse).max()
    np.testing.assert_allclose(found.impulse, expected.impulse, atol=1e-6 * size)


@pytest.mark.parametrize("inertia", [0.0, 1.0], ids=["statics", "dynamics"])
def test_a_wall_is_solved_as_by_factors(inertia):
    structure = wall(**SIZE, inertia=inertia)
    problem = structure.problem(inertia=inertia)
    settings = {"method": "newton", "tolerance": 1e-11}
    found = solve(problem, SolverSettings(**settings, linear="krylov"))
    expected = solve(problem, SolverSettings(**settings, linear="direct"))
    assert found.converged
    assert expected.converged
    size = np.abs(expected.velocity).max()
    np.testing.assert_allclose(found.velocity, expected.velocity, atol=1e-8 * size)


@pytest.mark.parametrize(("inertia", "most", "accuracy"), [(0.0, 50, 3e-3), (1.0, 50, 1e-5)])
def test_dynamics_of_many_contacts_are_solved_as_those_of_few(inertia, most, accuracy, monkeypatch):
    """Parts, weights and a search along each step are for statics; systems are solved more closely."""
    problem = wall(**SIZE, inertia=inertia).problem(inertia=inertia)
    monkeypatch.setattr(elastic_krylov, "MANY", problem.count)
    still = inertia == 0
    assert elastic_krylov.at_rest(problem) is still
    assert NewtonSystem(problem, np.ones(problem.count), "krylov").many is still
    assert elastic_krylov.Effort.of(problem.count, rests=still) == (most, accuracy)
    beyond = elastic_krylov.Effort.of(10 * elastic_krylov.FACTORED, rests=still)
    assert beyond == ((20, 1e-3) if still else (most, accuracy))


def test_many_contacts_go_on_from_a_guess_with_the_least_weight():
    """What sticks is nearly known then, and no path of weights has to lead there again."""
    problem = wall(**SIZE).problem()
    guess = Start(np.ones_like(problem.free_velocity))
    for library, least in (("krylov", True), ("direct", False)):
        method = ProximalNewton(library=library)
        cold, warm = method.init(problem, None), method.init(problem, guess)
        assert warm.weight == (cold.least_weight if least else cold.weight)
        assert cold.weight > cold.least_weight
    assert ProximalNewton(library="krylov", weight=1e-3).init(problem, guess).weight == 1e-3


def test_interfaces_hold_every_elastic_contact_once():
    problem = wall(**SIZE).problem(rigid=(3, 4))
    elastic = problem.operator.elastic()
    assert 0 < elastic.sum() < problem.count
    groups = interfaces_by_size(problem, elastic)
    together = np.concatenate([group.ravel() for group in groups])
    np.testing.assert_array_equal(np.sort(together), np.flatnonzero(elastic))
    for group in groups:
        pairs = np.sort(problem.bodies[group], axis=2)
        assert (pairs == pairs[:, :1]).all()


def test_few_contacts_and_plain_problems_are_factorised(monkeypatch):
    problem = wall(**SIZE).problem()
    assert not iteration_pays(problem)
    monkeypatch.setattr(elastic_krylov, "CONTACTS", 10)
    assert iteration_pays(problem)
    monkeypatch.setattr(elastic_krylov, "WIDEST", 1)  # one interface of many contacts would be a dense block
    assert not iteration_pays(problem)
    plain = ContactProblem.plain(problem.compliance, problem.free_velocity, problem.friction)
    assert not iteration_pays(plain)
