"""Admissible impulses: the static theorem, on blocks whose limits are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, admissible, solve
from masonry_fem.nscd.admissible import admissible_impulses
from tests.nscd.walls import rigid_wall


def block(push: float, friction: float = 0.5, height: float = 0.5, width: float = 1.0) -> ContactProblem:
    """A plane block of weight 1 on two corners under a horizontal force at its centroid; no inertia."""
    c, d, m = 2, 2, 3
    rigid_map = np.zeros((c, 2, d, m))
    for contact, x in enumerate((-width / 2, width / 2)):
        # normal up, tangent along x; turning moves the corner (x, −height) by (height, x)
        rigid_map[contact, 0] = [[0.0, 1.0, x], [1.0, 0.0, height]]
    return ContactProblem(
        friction=np.full(c, friction),
        free_velocity=np.zeros((c, d)),
        compliance=sparse.bsr_array(sparse.eye_array(c * d), blocksize=(d, d)),
        bodies=np.array([[0, -1], [0, -1]]),
        rigid_map=rigid_map,
        rigid_mass=np.zeros((1, m)),
        rigid_impulse=np.array([[push, -1.0, 0.0]]),
        rigid_velocity=np.zeros((1, m)),
    )


@pytest.mark.parametrize(("friction", "limit"), [(0.5, 0.5), (2.0, 1.0)])
def test_limits_of_sliding_and_tipping(friction: float, limit: float) -> None:
    """Slides at µ where µ < width / (2 height), tips there otherwise."""
    assert admissible_impulses(block(0.999 * limit, friction)).unbalanced <= 1e-6
    assert admissible_impulses(block(1.01 * limit, friction)).unbalanced > 1e-4


def test_impulses_lie_in_the_cones_and_balance() -> None:
    problem = block(0.3)
    found = admissible_impulses(problem)
    assert (np.abs(found.impulse[:, 1]) <= 0.5 * found.impulse[:, 0] + 1e-12).all()
    left = problem.body_impulse(found.impulse) + problem.rigid_impulse
    assert np.linalg.norm(left) <= 1.1e-6 * np.linalg.norm(problem.rigid_impulse)


def test_without_loads_nothing_is_needed() -> None:
    assert admissible_impulses(replace(block(0.0), rigid_impulse=np.zeros((1, 3)))).unbalanced == 0.0


@pytest.mark.parametrize(("share", "expected"), [(0.99, Outcome.CONVERGED), (1.01, Outcome.NO_EQUILIBRIUM)])
def test_verdict_of_the_solver_agrees(share: float, expected: Outcome) -> None:
    assert solve(block(share * 0.5), SolverSettings(tolerance=1e-9)).outcome is expected


@pytest.mark.parametrize("share", [1e-6, 4e-7, -4e-7, -1e-6])
def test_next_to_the_limit_a_proof_decides_and_not_how_near_a_method_came(share: float) -> None:
    """The error of a state without balance is below what is acceptable here."""
    made = solve(block((1 + share) * 0.5), SolverSettings(acceptable=1e-6))
    assert made.outcome is Outcome.AT_LIMIT if share > 0 else made.solved


@pytest.mark.parametrize("lacking", [1.5e-7, 5e-7])
def test_what_rounded_coordinates_leave_without_friction_is_no_limit_of_it(lacking: float) -> None:
    """A face that is tilted by the rounding of a file pushes a block aside."""
    made = solve(block(lacking, friction=0.0), SolverSettings(acceptable=1e-6))
    assert made.outcome is Outcome.INEXACT
    assert lacking / 2 <= made.quality.error <= 1e-6


@pytest.mark.parametrize("ratio", [1e-12, 1e-8, 1e8, 1e12])
def test_light_and_heavy_blocks(ratio: float) -> None:
    """A block on another, weights far apart, modes of unit mass: what carries them is found."""
    heavy = block(0.0)
    masses = np.array([1.0, ratio])
    roots = np.sqrt(masses)
    rigid_map = np.zeros((4, 2, 2, 3))
    rigid_map[:2, 0], rigid_map[2:, 0] = heavy.rigid_map[:, 0], heavy.rigid_map[:, 0] / roots[1]
    rigid_map[2:, 1] = -heavy.rigid_map[:, 0] * [1.0, 1.0, -1.0]  # from above, the arm is the other way
    pair = replace(
        heavy,
        friction=np.full(4, 0.5),
        free_velocity=np.zeros((4, 2)),
        compliance=sparse.bsr_array(sparse.eye_array(8), blocksize=(2, 2)),
        bodies=np.array([[0, -1], [0, -1], [1, 0], [1, 0]]),
        rigid_map=rigid_map,
        rigid_mass=np.zeros((2, 3)),
        rigid_impulse=np.array([[0.0, -1.0, 0.0], [0.0, -roots[1], 0.0]]),
        rigid_velocity=np.zeros((2, 3)),
    )
    found = admissible_impulses(pair)
    assert found.unbalanced <= 1e-6
    base = found.impulse[:2, 0].sum()
    assert base == pytest.approx(1 + ratio, rel=1e-5)
    pushed = replace(pair, rigid_impulse=pair.rigid_impulse + np.outer([1, 0], [0.6 * (1 + ratio), 0, 0]))
    beyond = admissible_impulses(pushed)
    assert beyond.unbalanced > 1e-3
    assert beyond.motion is not None


def looks(monkeypatch: pytest.MonkeyPatch, problem: ContactProblem) -> int:
    """How often the balance was looked at."""
    seen = []
    bound = admissible._least_unbalanced

    def counted(*args: object) -> float:
        seen.append(bound(*args))  # type: ignore[arg-type]
        return seen[-1]

    monkeypatch.setattr(admissible, "_least_unbalanced", counted)
    admissible_impulses(problem)
    return len(seen)


@pytest.mark.parametrize(
    "problem",
    [block(0.5001), block(1.01, friction=2.0), rigid_wall(4, 3, horizontal=0.8, inertia=0.0),
     rigid_wall(4, 3, horizontal=0.3, friction=0.2, inertia=0.0)],
    ids=["slides", "tips", "wall tips", "wall slides"],
)  # fmt: skip
def test_a_proof_ends_the_search(monkeypatch: pytest.MonkeyPatch, problem: ContactProblem) -> None:
    """Farkas: what no impulses can balance is known to be so long before the last iteration."""
    assert looks(monkeypatch, problem) <= admissible.ITERATIONS / 3
    short = admissible_impulses(problem).unbalanced
    monkeypatch.setattr(admissible, "_least_unbalanced", lambda *_: 0.0)
    least = admissible_impulses(problem).unbalanced
    assert 0 < least <= short <= 2 * least


def test_no_proof_where_loads_can_be_carried() -> None:
    """The bound is below what impulses of that size leave, at every motion."""
    problem = rigid_wall(4, 3, horizontal=0.3, inertia=0.0)
    found = admissible_impulses(problem)
    rigid_map, load = admissible.static_part(problem)
    generator = np.random.default_rng(0)
    size = float(np.linalg.norm(found.impulse))
    for _ in range(100):
        motion = generator.normal(size=len(load))
        least = admissible._least_unbalanced(problem, rigid_map, load, motion, size)
        assert least <= found.unbalanced * np.linalg.norm(load)
