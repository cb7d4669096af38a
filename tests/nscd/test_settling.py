"""Parts of a problem by themselves, and bodies that come to rest so."""

import pickle
from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.host.ranks import Leader
from masonry_fem.nscd import Outcome, SolverSettings
from masonry_fem.nscd import settings as limits
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods import newton
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from masonry_fem.nscd.methods.newton import NewtonRun, ProximalNewton
from masonry_fem.nscd.part import AROUND, Part, touched, unsettled
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import assess
from masonry_fem.nscd.settings import Start
from masonry_fem.nscd.solvers import settling
from tests.nscd.walls import wall

IntArray = NDArray[np.int64]

FRICTION = 0.5
SUPPORTS = 31


def boards(count: int) -> tuple[ContactProblem, np.ndarray]:
    """Bodies that do not turn, each on supports that move at speeds of their own, and these speeds (n, 31).

    Each rests on the support whose speed is the median: as many of the others drag it one way as the other.
    """
    under = np.random.default_rng(1).uniform(0.1, 1.0, (count, SUPPORTS))
    c = under.size
    free = np.zeros((c, 2))
    free[:, 1] = -under.ravel()
    maps = np.zeros((c, 2, 2, 3))
    maps[:, 0, 0, 1] = maps[:, 0, 1, 0] = 1.0
    problem = ContactProblem(
        friction=np.full(c, FRICTION),
        free_velocity=free,
        compliance=sparse.diags_array(np.full(2 * c, 1e-3)).tobsr((2, 2)),
        bodies=np.stack([np.repeat(np.arange(count), SUPPORTS), np.full(c, -1)], axis=1),
        rigid_map=maps,
        rigid_mass=np.zeros((count, 3)),
        rigid_impulse=np.tile([0.0, -float(SUPPORTS), 0.0], (count, 1)),
        rigid_velocity=np.zeros((count, 3)),
    )
    return problem, under


def sliding(problem: ContactProblem) -> Start:
    """All contacts bear as much, and slide the same way."""
    velocity = np.tile([0.0, -1e-3, 0.0], (problem.body_count, 1))
    return Start(np.tile([1.0, FRICTION], (problem.count, 1)), velocity, None)


def rest(problem: ContactProblem) -> tuple[np.ndarray, np.ndarray]:
    """Impulses and rigid velocities that solve a problem."""
    solution = iterate(problem, ProximalNewton(), SolverSettings(tolerance=1e-10))
    assert solution.converged
    return solution.impulse, solution.rigid_velocity


def test_a_part_sees_what_the_whole_sees() -> None:
    problem = wall(4, 2.0, (2, 1, 1)).problem()
    random = np.random.default_rng(3)
    impulse = random.normal(size=problem.free_velocity.shape)
    motion = random.normal(size=problem.rigid_mass.shape)
    chosen = np.zeros(problem.body_count, dtype=bool)
    chosen[[2, 3, 7]] = True
    part = Part.of(problem, chosen, impulse, motion)
    np.testing.assert_array_equal(part.contacts, np.flatnonzero(touched(problem, chosen)))
    inner, inside = part.impulse, part.rigid_velocity
    whole = problem.velocity(impulse, motion)
    scale = np.abs(whole).max()
    np.testing.assert_allclose(part.problem.velocity(inner, inside), whole[part.contacts], atol=1e-12 * scale)
    missing = problem.body_impulse(impulse) + problem.rigid_impulse
    own = part.problem.body_impulse(inner) + part.problem.rigid_impulse
    np.testing.assert_allclose(own, missing[part.bodies], atol=1e-12 * np.abs(missing).max())


def test_a_disturbed_part_of_a_solution_comes_back_to_it() -> None:
    problem = wall(4, 2.0, (2, 1, 1)).problem()
    impulse, motion = rest(problem)
    chosen = np.zeros(problem.body_count, dtype=bool)
    chosen[[5, 6]] = True
    part = Part.of(problem, chosen, impulse, np.where(chosen[:, None], 0.0, motion))
    solution = iterate(part.problem, ProximalNewton(), SolverSettings(tolerance=1e-11))
    assert solution.converged
    back = impulse.copy(), motion.copy()
    back[0][part.contacts], back[1][part.bodies] = solution.impulse, solution.rigid_velocity
    assert assess(problem, *back).error < 1e-9


def test_unsettled_bodies_are_the_fewest() -> None:
    problem, _ = boards(5)
    residual = np.zeros_like(problem.free_velocity)
    of_body = problem.bodies[:, 0]
    residual[:, 0] = np.array([1e-3, 3.0, 0.0, 2.0, 1e-2])[of_body]
    left = float(np.linalg.norm(residual[np.isin(of_body, [0, 2, 4])]))
    np.testing.assert_array_equal(np.flatnonzero(unsettled(problem, residual, 1.01 * left)), [1, 3])
    np.testing.assert_array_equal(np.flatnonzero(unsettled(problem, residual, 0.99 * left)), [1, 3, 4])
    assert unsettled(problem, residual, 0.0).sum() == 4
    assert not unsettled(problem, residual, 1e3).any()


def beside(problem: ContactProblem, bodies: list[int]) -> IntArray:
    """Some bodies and those that touch them."""
    pair = problem.bodies[np.isin(problem.bodies, bodies).any(axis=1)]
    return np.unique(pair[pair >= 0])


def test_rings_of_bodies_around_unsettled_ones_belong_to_them() -> None:
    problem = wall(7, 2.0, (2, 1, 1)).problem()
    residual = np.zeros_like(problem.free_velocity)
    one = int(np.flatnonzero((problem.bodies >= 0).all(axis=1))[0])
    residual[one] = 1.0
    expected = problem.bodies[one]
    for _ in range(AROUND):
        expected = beside(problem, expected.tolist())
    assert len(expected) < problem.body_count
    np.testing.assert_array_equal(np.flatnonzero(unsettled(problem, residual, 0.1)), expected)


def whole_of(problem: ContactProblem) -> Part:
    """All of a problem as a part."""
    random = np.random.default_rng(4)
    impulse = random.normal(size=problem.free_velocity.shape)
    motion = random.normal(size=problem.rigid_mass.shape)
    return Part.of(problem, np.ones(problem.body_count, dtype=bool), impulse, motion)


def test_bodies_that_do_not_touch_are_clusters_of_their_own() -> None:
    problem, _ = boards(4)
    found = list(whole_of(problem).groups())
    np.testing.assert_array_equal([group.bodies for group in found], [[0], [1], [2], [3]])
    for group in found:
        of_body = np.flatnonzero(problem.bodies[:, 0] == group.bodies)
        np.testing.assert_array_equal(group.contacts, of_body)
    np.testing.assert_array_equal(whole_of(problem).clusters(), np.eye(4, dtype=bool))
    standing = wall(4, 2.0, (2, 1, 1)).problem()
    (whole,) = whole_of(standing).groups()
    np.testing.assert_array_equal(whole.bodies, np.arange(standing.body_count))
    (all_of_it,) = whole.clusters()
    assert all_of_it.all()


def test_groups_have_nothing_to_do_with_each_other() -> None:
    """Loads and motions of a group are those that it has where the others stay, whatever they do."""
    problem = wall(8, 2.0, (2, 1, 1)).problem()
    random = np.random.default_rng(5)
    impulse = random.normal(size=problem.free_velocity.shape)
    motion = random.normal(size=problem.rigid_mass.shape)
    last = problem.body_count - 1
    chosen = np.zeros(problem.body_count, dtype=bool)
    chosen[[0, last]] = True
    groups = list(Part.of(problem, chosen, impulse, motion).groups())
    assert [group.bodies.tolist() for group in groups] == [[0], [last]]
    for group, other in zip(groups, groups[::-1], strict=True):
        alone = np.zeros_like(chosen)
        alone[group.bodies] = True
        moved = impulse.copy()
        moved[other.contacts] += 1.0
        part = Part.of(problem, alone, moved, motion)
        np.testing.assert_array_equal(group.contacts, part.contacts)
        np.testing.assert_array_equal(group.impulse, part.impulse)
        for got, expected in (
            (group.problem.free_velocity, part.problem.free_velocity),
            (group.problem.rigid_impulse, part.problem.rigid_impulse),
        ):
            np.testing.assert_allclose(got, expected, atol=1e-12 * np.abs(expected).max())


def test_clusters_that_touch_one_body_are_one_group() -> None:
    problem = wall(8, 2.0, (2, 1, 1)).problem()
    around = beside(problem, [0])
    two = [0, int(np.setdiff1d(beside(problem, around.tolist()), around)[0])]
    chosen = np.zeros(problem.body_count, dtype=bool)
    chosen[two] = True
    part = Part.of(problem, chosen, np.zeros_like(problem.free_velocity), problem.rigid_velocity)
    (group,) = part.groups()
    np.testing.assert_array_equal(group.bodies, sorted(two))
    assert len(group.clusters()) == 2


def solved(steps: int) -> tuple[int, float]:
    """How many of 80 boards rest within so many Newton steps, and the error."""
    problem, under = boards(80)
    settings = SolverSettings(tolerance=1e-8, max_iterations=steps)
    end = iterate(problem, ProximalNewton(), settings, sliding(problem))
    off = end.rigid_velocity[:, 0] - np.median(under, axis=1)
    return int((np.abs(off) <= 1.01e-3 * FRICTION).sum()), end.quality.error


def test_boards_come_to_rest_in_few_steps_of_the_whole() -> None:
    resting, error = solved(20)
    assert resting == 80
    assert error <= 1e-8


def test_without_parts_they_take_far_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settling, "MOST", -1.0)
    _, error = solved(20)
    assert error > 1e-6


@pytest.mark.parametrize(("large", "rests"), [(100, True), (10_000, False)])
def test_a_large_part_has_parts_of_its_own(monkeypatch: pytest.MonkeyPatch, large: int, rests: bool) -> None:
    """Eighty boards in one part, with slip held: by themselves they do not come to rest together."""
    monkeypatch.setattr(newton, "FACTORED", large)
    problem, _ = boards(80)
    held = ProximalNewton(weight=1e-5, grip=0.03)
    end = iterate(problem, held, SolverSettings(tolerance=1e-8), sliding(problem))
    assert end.converged is rests


def test_linear_solves_of_parts_count() -> None:
    problem, _ = boards(80)
    run = NewtonRun(problem, ProximalNewton(), sliding(problem))
    quality = assess(problem, run.impulse, run.rigid_velocity)
    settings = SolverSettings(tolerance=1e-8)
    offers = []
    for _ in range(8):
        offers.append(run.step(quality, settings))
        quality = assess(problem, offers[-1].impulse, offers[-1].rigid_velocity)
    assert all(offer.iterations == 1 for offer in offers)
    assert sum(offer.linear_solves for offer in offers) > run.factors


def test_no_step_begins_after_so_many_linear_systems() -> None:
    """Those of parts count."""
    problem, _ = boards(80)
    settings, start = SolverSettings(tolerance=1e-8), sliding(problem)
    whole = iterate(problem, ProximalNewton(), settings, start)
    most = whole.linear_solves // 2
    end = iterate(problem, ProximalNewton(systems=most), settings, start)
    assert end.outcome is Outcome.MAX_ITERATIONS
    assert most <= end.linear_solves < whole.linear_solves
    assert end.iterations < end.linear_solves


@pytest.mark.parametrize("in_time", [0, 3, 8])
def test_parts_end_with_the_time_that_is_left(monkeypatch: pytest.MonkeyPatch, in_time: int) -> None:
    """Of eight boards by a clock that reaches the limit after some."""
    problem, _ = boards(8)
    start = sliding(problem)
    assert start.impulse is not None
    assert start.rigid_velocity is not None
    clock = iter([0.0] * in_time + [2e3] * 8)
    monkeypatch.setattr(settling, "MOST", 1.0)
    monkeypatch.setattr(limits, "monotonic", lambda: next(clock))
    parts = NewtonRun(problem, ProximalNewton(), start).settling
    residual = np.ones_like(problem.free_velocity)
    settled = parts.settle(residual, start.impulse, start.rigid_velocity, 1.0, 1e-8, until=1e3)
    motion = start.rigid_velocity if settled is None else settled[1]
    assert (motion != start.rigid_velocity).any(axis=1).sum() == in_time


@pytest.mark.parametrize(("best", "moved"), [(np.inf, [0]), (1e-6, [0, 3]), (0.0, [0])])
def test_all_that_is_farther_off_than_before_comes_to_rest(best: float, moved: list[int]) -> None:
    """Not only what most of the residual lies at, unless that is much of the whole: then a tenth is left."""
    problem, _ = boards(12)
    start = sliding(problem)
    assert start.impulse is not None
    assert start.rigid_velocity is not None
    parts = NewtonRun(problem, ProximalNewton(), start).settling
    missing = np.full(12, 1e-9)
    missing[[0, 3]] = 1.0, 0.03
    size = float(np.linalg.norm(start.impulse))
    residual = missing[problem.bodies.max(axis=1)][:, None] * np.full(3, 1e-2 * size)
    settled = parts.settle(residual, start.impulse, start.rigid_velocity, 1.0, 1e-8, best=best)
    assert settled is not None
    assert np.flatnonzero((settled[1] != start.rigid_velocity).any(axis=1)).tolist() == moved


class Two(Leader):
    """Two ranks in one process, to which shares go as they go to others."""

    def __init__(self) -> None:
        self.size, self.busy = 2, False
        self.loads: list[list[int]] = []

    def call(self, work, shares):
        member = MagicMock(together=lambda local: local())
        self.loads.append([sum(group.problem.count for group in groups) for groups, *_ in shares])
        return [work(member, pickle.loads(pickle.dumps(share))) for share in shares]


def test_ranks_share_what_comes_to_rest_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _ = boards(9)
    start = sliding(problem)
    monkeypatch.setattr(settling, "MOST", 1.0)
    parts = NewtonRun(problem, ProximalNewton(), start).settling
    given = (np.ones_like(problem.free_velocity), start.impulse, start.rigid_velocity, 1.0, 1e-8)
    alone = parts.settle(*given)
    ranks = Two()
    monkeypatch.setattr(settling, "team", lambda: ranks)
    shared = parts.settle(*given)
    assert alone is not None
    assert shared is not None
    for one, other in zip(alone, shared, strict=True):
        np.testing.assert_array_equal(one, other)
    ((first, second),) = ranks.loads
    assert first + second == problem.count
    assert abs(first - second) <= problem.count / 9


@pytest.mark.parametrize(("least", "loads"), [(0, []), (SUPPORTS + 1, [[SUPPORTS, 0]])])
def test_a_part_larger_than_a_share_is_solved_by_all_ranks(
    monkeypatch: pytest.MonkeyPatch, least: int, loads: list[list[int]]
) -> None:
    """The rank that leads solves it, and calls for the others in its linear systems."""
    problem, _ = boards(1)
    start, ranks = sliding(problem), Two()
    monkeypatch.setattr(settling, "MOST", 1.0)
    monkeypatch.setattr(settling, "MANY", least)
    monkeypatch.setattr(settling, "team", lambda: ranks)
    parts = NewtonRun(problem, ProximalNewton(), start).settling
    settled = parts.settle(
        np.ones_like(problem.free_velocity), start.impulse, start.rigid_velocity, 1.0, 1e-8
    )
    assert settled is not None
    assert ranks.loads == loads


@pytest.mark.parametrize(
    ("errors", "factor"),
    [
        ([1.01, 0.99, 1.03], 0.1),
        ([1.01, 2.0, 0.99, 5.0, 1.03], 0.1),  # with worse ones in between
        ([1.01, 0.99], 1.0),
        ([1.01, 0.99, 0.9, 0.91, 0.89], 1.0),  # it falls
        ([2.0, 3.0, 2.0, 2.0], 1.0),
    ],
)
@pytest.mark.parametrize("part", [False, True])
def test_weights_of_impulses_fall_where_the_error_comes_back(
    errors: list[float], factor: float, part: bool
) -> None:
    """Three times to what it was at best. Parts are left alone; they hold slip from the start."""
    problem, _ = boards(1)
    run = NewtonRun(problem, ProximalNewton(grip=0.03 if part else 0.0), None)
    run.best, least = 1e-6, run.least_weight
    for error in errors:
        run.error = error * 1e-6
        assert run._watch_settling() is None
    np.testing.assert_allclose(run.least_weight, least * (1.0 if part else factor))


def test_a_rebound_does_not_tell_how_exact_parts_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """A full step may throw the whole far off where it had come: parts are to bring it back there."""
    problem, _ = boards(1)
    run = NewtonRun(problem, ProximalNewton(), sliding(problem))
    asked: list[float] = []
    monkeypatch.setattr(run.settling, "settle", lambda *given: asked.append(given[3]))
    full = run._relative(run._natural_residual())
    for best in (full, 1e-3 * full):
        run.best = best
        run._settle()
    assert asked == [full, pytest.approx(0.1 * full)]


@pytest.mark.parametrize(("error", "holds"), [(1e-8, True), (1e-10, False)])
def test_slip_is_not_held_for_what_is_next_to_nothing(
    monkeypatch: pytest.MonkeyPatch, error: float, holds: bool
) -> None:
    """A step that no length makes a good one ends the round and holds slip, unless the error is tiny."""
    problem, _ = boards(200)
    run = NewtonRun(problem, ProximalNewton(), sliding(problem))
    assert run.system.many
    here = run._look(run.impulse, run.rigid_velocity)
    worse = replace(here, residual=2.0)
    monkeypatch.setattr(run, "_look", lambda *state: worse)
    run.round.residuals.append(1.0)
    run.error = error
    run._search(here, np.zeros_like(here.impulse), np.zeros_like(here.rigid_velocity), worse)
    assert run.jammed is holds


@pytest.mark.parametrize(("left", "taken"), [(0.04, True), (0.06, False)])
def test_what_is_far_better_than_before_is_taken(
    monkeypatch: pytest.MonkeyPatch, left: float, taken: bool
) -> None:
    """Though it is not good enough, where a tenth of the error is left or less."""
    problem, _ = boards(1)
    start, (impulse, motion) = sliding(problem), rest(problem)
    assert start.impulse is not None
    assert start.rigid_velocity is not None
    near = impulse * (1.0 - left)
    quality = assess(problem, near, motion)
    found = SimpleNamespace(impulse=near, rigid_velocity=motion, quality=quality, converged=False)
    monkeypatch.setattr(settling, "MOST", 1.0)
    monkeypatch.setattr(settling._Rest, "best", lambda _: found)
    parts = NewtonRun(problem, ProximalNewton(), start).settling
    given = np.ones_like(problem.free_velocity), start.impulse, start.rigid_velocity, 1e-6, 1e-8
    settled = parts.settle(*given)
    assert (settled is not None) is taken
    if settled is not None:
        np.testing.assert_array_equal(settled[0], near)


def stone(seed: int, contacts: int = 12) -> Part:
    """A stone between faces all around, which yields, as a part whose contacts part and meet on its way."""
    rng = np.random.default_rng(seed)
    mixed = rng.standard_normal((2 * contacts, 2 * contacts))
    compliance = 1e-3 * (mixed @ mixed.T / (2 * contacts) + 0.05 * np.eye(2 * contacts))
    angle = rng.uniform(0.0, 2.0 * np.pi, contacts)
    x, y = np.cos(angle), np.sin(angle)
    maps = np.zeros((contacts, 2, 2, 3))
    maps[:, 0, 0, 0], maps[:, 0, 0, 1] = -x, -y
    maps[:, 0, 1, 0], maps[:, 0, 1, 1], maps[:, 0, 1, 2] = y, -x, -1.0
    problem = ContactProblem(
        friction=np.full(contacts, 0.6),
        free_velocity=rng.uniform((0.0, -1e-3), (2e-3, 1e-3), (contacts, 2)),
        compliance=sparse.bsr_array(compliance, blocksize=(2, 2)),
        bodies=np.tile([0, -1], (contacts, 1)),
        rigid_map=maps,
        rigid_mass=np.zeros((1, 3)),
        rigid_impulse=np.array([[0.0, -1.0, 0.0]]),
        rigid_velocity=np.zeros((1, 3)),
    )
    part = whole_of(problem)
    return replace(part, impulse=np.abs(rng.standard_normal((contacts, 2))))


@pytest.mark.parametrize("seed", [6, 25, 34, 42, 53])
def test_impulses_are_held_where_holding_slip_leads_nowhere(seed: int) -> None:
    part = stone(seed)
    held = NewtonRun(part.problem, ProximalNewton(), part.start).settling.held
    settings = SolverSettings(tolerance=1e-3)
    assert not iterate(part.problem, held, settings, part.start).converged
    found = settling._Rest(part, aimed(part.problem, part.start), settings, enough=1e-3).best()
    assert found.converged


def test_holding_impulses_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settling, "MOST_SYSTEMS", 1)
    part = stone(6)
    rest = settling._Rest(part, aimed(part.problem, part.start), SolverSettings(tolerance=1e-3), enough=1e-3)
    assert rest.best().outcome is Outcome.MAX_ITERATIONS


@pytest.mark.parametrize("small", [True, False])
def test_only_a_part_that_is_not_large_goes_further_than_what_is_good_enough(
    monkeypatch: pytest.MonkeyPatch, small: bool
) -> None:
    """Its error is good enough from the start."""
    part = stone(6)
    rough = iterate(part.problem, InteriorPoint(), SolverSettings(tolerance=1e-4))
    part = replace(part, impulse=(1 + 1e-5) * rough.impulse, rigid_velocity=rough.rigid_velocity)
    monkeypatch.setattr(settling, "FACTORED", part.problem.count - (not small))
    aim, settings = aimed(part.problem, part.start), SolverSettings(tolerance=1e-9)
    found = settling._Rest(part, aim, settings, enough=1e-3).best()
    assert (found.quality.error <= 1e-9) is small
    assert small or np.array_equal(found.impulse, part.impulse)


def aimed(problem: ContactProblem, start: Start) -> settling.Aim:
    """How Newton's method brings parts to rest."""
    parts = NewtonRun(problem, ProximalNewton(), start).settling
    return settling.Aim(parts.held, size=1.0, error=1e-3, least=1e-8)


def test_a_leader_at_work_on_a_part_asks_no_other_rank_for_parts_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    leader = object.__new__(Leader)
    leader.busy = True  # it has neither a communicator nor other ranks, and would fail if it called them
    part = stone(6)
    aim = aimed(part.problem, part.start)
    alone = settling._rested([part], part.impulse, aim, None)
    monkeypatch.setattr(settling, "team", lambda: leader)
    shared = settling._rested([part], part.impulse, aim, None)
    np.testing.assert_array_equal(shared[0].impulse, alone[0].impulse)


@pytest.mark.parametrize(
    ("sizes", "large"),
    [
        ([12_600, 1_000, 1_000, 270], [True, False, False, False]),  # who has the first would be last by far
        ([4_527, 4_500], [False, False]),  # one for each rank
        ([5_000, 60_000, 4_000], [False, True, False]),
        ([40_000, 30_000, 30_000, 30_000], [True, True, True, True]),  # all have parts of their own
        ([15_000, 15_000, 15_000, 15_000], [False, False, False, False]),
        ([1_900, 100], [False, False]),  # a factor is one rank's
        ([], []),
    ],
)
def test_two_ranks_share_groups_so_that_the_last_ends_soonest(sizes: list[int], large: list[bool]) -> None:
    assert settling._large(np.array(sizes, dtype=np.int64), 2).tolist() == large


def test_groups_are_dealt_by_the_decades_that_they_have_to_go() -> None:
    problem, _ = boards(1)
    start = sliding(problem)
    every = np.ones(problem.body_count, dtype=bool)
    part = Part.of(problem, every, start.impulse, start.rigid_velocity)
    aim = aimed(problem, start)
    wanted = aim.errors(part)[0] * float(np.linalg.norm(part.impulse))
    residual = np.zeros_like(part.impulse)
    works = []
    for left in (0.1, 1.0, 10.0, 100.0):
        residual[0, 0] = left * wanted
        works.append(aim.work(part, residual) / part.problem.count)
    assert works == pytest.approx([1.0, 1.0, 2.0, 3.0])
