"""PathFollowing: kinks are exact, folds are gone round, and what tips and slides at once is solved."""

import numpy as np
import pytest

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import Outcome, SolverSettings, Start, assess, solve
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.linear import DENSE_BELOW
from masonry_fem.nscd.plane import InPlane, plane_form
from masonry_fem.nscd.solvers.kinks import Walk, next_kink, statuses
from masonry_fem.nscd.solvers.normal_map import NormalMap
from masonry_fem.nscd.solvers.path import Path, PathFollowing
from tests.nscd import plane, walls


def tipping(bricks=6, courses=6):
    """A plane wall at the limit of friction, which tips and slides."""
    return plane.plane_wall(bricks, courses, friction=0.6, horizontal=0.6)


def shaken(problem, alpha, seed=0):
    """The regularised equation about zero, and a generic start."""
    equation = NormalMap(problem)
    equation.hold(np.zeros_like(problem.free_velocity), alpha)
    x = equation.start(equation.centre)
    noise = np.random.default_rng(seed).standard_normal(x.shape)
    return equation, x + 0.01 * np.abs(x).max() * noise


@pytest.mark.parametrize("alpha", [1e-2, 1e-4])
def test_each_kink_lies_on_the_path(alpha):
    equation, x = shaken(tipping(), alpha)
    piece = equation.at(x)
    walk = Walk(piece, piece.residual, 1.0, forwards=True)
    largest = np.abs(piece.residual).max()
    for _ in range(40):
        walk.cross()
        here = equation.at(walk.x)
        assert not walk.endless
        assert not walk.unsure
        assert here.residual == pytest.approx(walk.t * piece.residual, abs=1e-9 * largest)
    assert (statuses(walk.x, tipping().friction) != statuses(x, tipping().friction)).any()


def test_the_change_within_a_piece_is_exact():
    equation, x = shaken(tipping(), 1e-2)
    piece = equation.at(x)
    problem = equation.problem
    change = piece.change(piece.residual)
    length = next_kink(x, change, statuses(x, problem.friction), problem.friction)[0]
    ahead = equation.at(x + 0.9 * length * change)
    expected = (1 - 0.9 * length) * piece.residual
    assert ahead.residual == pytest.approx(expected, abs=1e-10 * np.abs(piece.residual).max())


def followed(equation, x, kinks):
    """The way from t = 1 to 0 in walks of a few kinks: (piece, t, forwards) at the end of each."""
    start = equation.at(x)
    piece, t, forwards = start, 1.0, True
    while t > 0:
        walk = Walk(piece, start.residual, t, forwards=forwards)
        for _ in range(kinks):
            walk.cross()
            if walk.t == 0:
                break
        assert not walk.endless
        assert not walk.unsure
        if walk.t > 0:
            walk.step_inside()
        piece, t, forwards = equation.at(walk.x), walk.t, walk.forwards
        yield piece, t, forwards


def test_walks_go_round_folds_to_the_end():
    equation, x = shaken(tipping(5, 5), 1e-5)
    ends = list(followed(equation, x, kinks=5))
    ts = np.array([t for _, t, _ in ends])
    assert (np.diff(ts) > 0).any()
    assert {forwards for _, _, forwards in ends} == {True, False}
    piece, t, _ = ends[-1]
    assert t == 0
    assert equation.relative(piece.residual, piece.impulse) < 1e-11


def test_the_sign_of_the_determinant_tells_the_way_along_the_path():
    equation, x = shaken(tipping(5, 5), 1e-5)
    sign = equation.at(x).sign
    for piece, t, forwards in followed(equation, x, kinks=5):
        assert t == 0 or (piece.sign == sign) == forwards


@pytest.mark.parametrize(("bricks", "courses"), [(6, 6), (10, 6), (8, 10)])
def test_plane_walls_from_a_state_that_is_near(bricks, courses):
    problem = tipping(bricks, courses)
    near = solve(problem, SolverSettings(method="interior_point", tolerance=1e-3))
    assert 1e-8 < near.quality.error <= 1e-3
    made = iterate(problem, PathFollowing(), SolverSettings(tolerance=1e-10), Start(impulse=near.impulse))
    assert made.converged
    assert made.method == "path"
    assert assess(problem, made.impulse, made.rigid_velocity).error <= 1e-10


def test_walls_in_space_are_followed_in_their_plane():
    problem = walls.rigid_wall(10, 8, friction=0.6, horizontal=0.6)
    near = solve(problem, SolverSettings(method="interior_point", tolerance=1e-3))
    assert near.quality.error > 1e-8
    method = InPlane(PathFollowing(), plane_form(problem))
    made = iterate(problem, method, SolverSettings(tolerance=1e-9), Start(impulse=near.impulse))
    assert made.converged
    assert made.method == "path"
    assert made.impulse.shape == problem.free_velocity.shape
    # no comparison with another method's velocities: Coulomb's friction allows several
    assert assess(problem, made.impulse, made.rigid_velocity).error <= 1e-9


def test_it_gives_the_same_bits_again():
    problem = tipping()
    start = Start(impulse=solve(problem, SolverSettings(method="interior_point", tolerance=1e-3)).impulse)
    runs = [iterate(problem, PathFollowing(), SolverSettings(tolerance=1e-10), start) for _ in range(2)]
    assert np.array_equal(runs[0].impulse, runs[1].impulse)
    assert runs[0].iterations == runs[1].iterations


@pytest.mark.slow
@pytest.mark.parametrize(("weight", "outcome"), [(1e-4, Outcome.MAX_ITERATIONS), (1e-6, Outcome.CONVERGED)])
def test_a_cold_path_comes_back_and_counts_its_steps(weight, outcome):
    """It may run off backwards, where no kink stops it: once that took no steps, and no end."""
    method = PathFollowing(weight=weight)
    made = iterate(tipping(), method, SolverSettings(tolerance=1e-10, max_iterations=4000))
    assert made.outcome is outcome
    assert made.iterations >= len(made.history) - 2  # nothing is for nothing


def test_a_path_that_leads_away_is_lost():
    equation = NormalMap(tipping())
    centre = np.zeros_like(equation.problem.free_velocity)
    equation.hold(centre, 1e-6)
    path = Path(equation, equation.start(centre))
    path.t, path.forwards, path.stride = 900.0, False, 200.0
    for _ in range(200):
        path.advance()
        if path.lost:
            break
    assert path.lost


def test_what_it_cannot_follow_is_said():
    for problem in (walls.rigid_wall(4, 3), plane.plane_wall(3, 3, mass=0.0)):
        with pytest.raises(ProblemError, match="expected 2D, inertia of all bodies, and dry joints"):
            PathFollowing().init(problem, None)


def test_a_path_object_ends_at_a_solution_of_the_regularised_problem():
    equation, x = shaken(tipping(), 1e-2)
    path = Path(equation, x)
    while path.arrived is None and not path.lost:
        path.advance()
    assert path.t == 0
    assert equation.relative(path.piece.residual, path.piece.impulse) < 1e-12
    normal, tangent = path.arrived[:, 0], np.abs(path.arrived[:, 1])
    assert (normal >= 0).all()
    assert (tangent <= equation.problem.friction * normal * (1 + 1e-12)).all()


def test_pieces_tell_the_sign_of_the_determinant():
    problem = plane.plane_wall(12, 12, friction=0.6, horizontal=0.6)
    signs = set()
    for seed in range(6):
        equation, x = shaken(problem, 1e-6, seed)
        piece = equation.at(x)
        answer = piece.factor.answer
        assert answer.matrix.shape[0] >= DENSE_BELOW  # SuperLU's
        assert piece.sign == int(np.linalg.slogdet(answer.matrix.toarray())[0])
        walk = Walk(piece, piece.residual, 1.0, forwards=True)
        while walk.forwards:
            walk.cross()
        walk.step_inside()
        beyond = equation.at(walk.x)
        assert beyond.sign == int(np.linalg.slogdet(beyond.factor.answer.matrix.toarray())[0])
        signs |= {piece.sign, beyond.sign}
    assert signs == {1, -1}


def test_where_no_weaker_round_can_be_followed_the_centre_moves_on_with_the_last_weight():
    """Rounding decides whether a weak round gets through; a solved one again gets closer, too."""
    problem = tipping(6, 6)
    near = solve(problem, SolverSettings(method="interior_point", tolerance=1e-3))
    run = PathFollowing(weight=1e-3).init(problem, Start(impulse=near.impulse))
    settings, verdicts = SolverSettings(tolerance=1e-10), []

    def solve_round():
        centre = run.centre
        for _ in range(500):
            verdicts.append(run.step(near.quality, settings).verdict)
            if run.centre is not centre:
                break
        offer = run.guess()
        return assess(problem, offer.impulse, offer.rigid_velocity).error

    first = solve_round()
    weight = run.solved
    for _ in range(2):  # two that are lost, the second of them milder
        assert run._give_up_round() is None
        assert run.weight < weight
    assert run._give_up_round() is None
    assert run.weight == weight
    again = solve_round()
    assert run.solved == weight
    assert again < first
    assert verdicts[-1] is None
    # other shakes of the start may get through, but not for ever
    given_up = [run._give_up_round() for _ in range(run.settings.patience)]
    assert given_up == [None] * (run.settings.patience - 1) + [Outcome.STALLED]
    assert run.weight == weight
