"""The loop: who stops it, what it keeps."""

from importlib import import_module

import numpy as np
import pytest

from masonry_fem.errors import ExtensionError, ProblemError
from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, Start, solve
from masonry_fem.nscd.iterate import Iterate, iterate
from masonry_fem.nscd.methods import make_method, names

PROBLEM = ContactProblem.plain(np.eye(3), [[-1.0, 0.0, 0.0]], 0.5)


class Scripted:
    """A method that offers a normal impulse after the other."""

    name = "scripted"
    iterations = 100

    def __init__(self, *normals, verdict=None):
        self.offers = [np.array([[n, 0.0, 0.0]]) for n in normals]
        self.verdict = verdict

    def init(self, problem, start):
        self.at = 0
        return self

    def guess(self):
        return Iterate(self.offers[0], np.zeros((0, 6)), iterations=0)

    def step(self, quality, settings):
        self.at += 1
        last = self.at == len(self.offers) - 1
        verdict = self.verdict if last else None
        return Iterate(self.offers[self.at], np.zeros((0, 6)), 1, 2, verdict)


def test_stops_when_the_measures_hold():
    solution = iterate(PROBLEM, Scripted(0.1, 0.5, 1.0, 7.0), SolverSettings())
    assert solution.outcome is Outcome.CONVERGED
    assert solution.converged
    assert (solution.iterations, solution.linear_solves) == (2, 4)
    assert solution.velocity == pytest.approx(np.zeros((1, 3)))
    assert solution.history[:, 0].tolist() == [0, 1, 2]
    assert (np.diff(solution.history[:, 1]) < 0).all()


def test_keeps_the_best():
    solution = iterate(PROBLEM, Scripted(0.1, 0.9, 0.5, 5.0, verdict=Outcome.STALLED), SolverSettings())
    assert solution.outcome is Outcome.STALLED
    assert solution.impulse[0, 0] == 0.9
    assert solution.quality.error == pytest.approx(0.1 / 0.9)


def test_a_first_guess_that_holds_is_kept_as_it_is():
    given = np.array([[1.0, 1e-12, 0.0]])
    solution = iterate(PROBLEM, Scripted(0.1), SolverSettings(tolerance=1e-9), Start(given))
    assert solution.converged
    assert solution.iterations == 0
    assert (solution.impulse == given).all()
    solution = iterate(PROBLEM, Scripted(0.1, 1.0), SolverSettings(tolerance=1e-13), Start(given))
    assert (solution.iterations, solution.impulse[0, 1]) == (1, 0.0)


def test_limits():
    run = Scripted(*np.linspace(0.1, 0.8, 200))
    assert iterate(PROBLEM, run, SolverSettings(max_iterations=7)).iterations == 7
    assert iterate(PROBLEM, run, SolverSettings()).outcome is Outcome.MAX_ITERATIONS
    hurried = iterate(PROBLEM, run, SolverSettings(time_limit=1e-9))
    assert hurried.outcome is Outcome.TIME_LIMIT
    assert hurried.impulse[0, 0] == pytest.approx(0.1)


def test_not_a_number_is_a_failure_with_the_last_good_state():
    solution = iterate(PROBLEM, Scripted(0.1, 0.7, np.nan, 0.8), SolverSettings())
    assert solution.outcome is Outcome.FAILED
    assert solution.impulse[0, 0] == 0.7


def test_a_method_that_blows_up_is_stopped_before_its_squares_overflow():
    solution = iterate(PROBLEM, Scripted(0.5, 1.2, 1e160), SolverSettings())
    assert solution.outcome is Outcome.FAILED
    assert solution.impulse[0, 0] == 1.2


@pytest.mark.parametrize("name", names())
def test_flight_needs_no_method(name):
    """Blocks that all drift aside while they touch: no method comes to zero impulses exactly."""
    drifting = ContactProblem.plain(np.eye(3), [[0.0, 0.3, 0.1]], 0.5)
    solution = solve(drifting, SolverSettings(method=name, tolerance=1e-14))
    assert solution.outcome is Outcome.CONVERGED
    assert solution.iterations == 0
    assert not solution.impulse.any()


@pytest.mark.parametrize("outcome", list(Outcome))
@pytest.mark.parametrize("method", ["auto", "newton", "interior_point"])
def test_every_outcome_speaks(outcome, method):
    """And advises nothing that was done, nor to change what nobody has set."""
    assert outcome.sentence.endswith(".")
    aimed = outcome.advice(SolverSettings(method=method, acceptable=1e-6))
    held = outcome.advice(SolverSettings(method=method, tolerance=1e-12, max_iterations=7))
    assert bool(aimed) == bool(held) == (not outcome.solved)
    assert "tolerance" not in aimed
    assert "max_iterations" not in aimed
    if outcome in {Outcome.STALLED, Outcome.MAX_ITERATIONS, Outcome.UNDECIDED}:
        assert "1e-12" in held
        assert ("method 'auto'" in aimed) == (method != "auto")
    assert ("(7)" in held) == (outcome is Outcome.MAX_ITERATIONS)
    assert not [name for name in names() if f"ry method '{name}'" in aimed + held]


@pytest.mark.parametrize(
    ("acceptable", "outcome"), [(0.0, Outcome.STALLED), (1e-6, Outcome.INEXACT), (1e-9, Outcome.STALLED)]
)
def test_a_state_that_nothing_improves_is_an_answer_where_its_error_is_acceptable(
    acceptable, outcome, monkeypatch
):
    stalls = Scripted(0.9, 1 + 1e-8, verdict=Outcome.STALLED)
    monkeypatch.setattr(import_module("masonry_fem.nscd.portfolio"), "make_method", lambda name: stalls)
    made = solve(PROBLEM, SolverSettings(method="newton", acceptable=acceptable))
    assert made.quality.error == pytest.approx(1e-8, rel=1e-6)
    assert made.outcome is outcome
    assert made.solved == (outcome is Outcome.INEXACT)
    assert not made.converged


class Idle:
    """A method whose run makes no step."""

    name, iterations = "idle", 1

    def init(self, problem, start):
        return self

    def guess(self):
        return Iterate(np.zeros((1, 3)), np.zeros((0, 6)))


def test_a_run_that_makes_no_step_is_named():
    with pytest.raises(
        ExtensionError, match=r"Idle, which init makes, lacks step\(quality, settings\); write"
    ):
        iterate(PROBLEM, Idle(), SolverSettings())


def test_a_mechanism_is_shown_by_the_last_state():
    solution = iterate(PROBLEM, Scripted(0.9, 0.5, 5.0, verdict=Outcome.NO_EQUILIBRIUM), SolverSettings())
    assert solution.impulse[0, 0] == 5.0
    assert solution.quality.error > 0.1


@pytest.mark.parametrize("name", names())
def test_listed_methods_obey(name):
    solution = iterate(PROBLEM, make_method(name), SolverSettings(tolerance=1e-9))
    assert solution.method == name
    assert solution.converged
    assert solution.impulse[0, 0] == pytest.approx(1.0, abs=1e-9)
    assert solution.impulse[0, 1:] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", [*names(), "auto"])
def test_a_start_that_is_the_answer_costs_nothing(name):
    impulse = np.zeros_like(PROBLEM.free_velocity)
    impulse[0, 0] = 1.0
    solution = solve(PROBLEM, SolverSettings(method=name), Start(impulse=impulse))
    assert solution.converged
    assert solution.iterations == 0


def test_wrong_settings_and_starts_are_named():
    with pytest.raises(ProblemError, match="method is 'magic'"):
        SolverSettings(method="magic")
    with pytest.raises(ProblemError, match="tolerance is 0"):
        SolverSettings(tolerance=0.0)
    with pytest.raises(ProblemError, match="max_iterations is 0"):
        SolverSettings(max_iterations=0)
    with pytest.raises(ProblemError, match="time_limit is -1"):
        SolverSettings(time_limit=-1.0)
    with pytest.raises(ProblemError, match=r"start impulse has shape \(2, 3\), expected \(1, 3\)"):
        solve(PROBLEM, start=Start(impulse=np.zeros((2, 3))))
    with pytest.raises(ProblemError, match="not finite"):
        solve(PROBLEM, start=Start(impulse=np.full((1, 3), np.nan)))
