"""Cohesion in the contact problem: closed forms, limits, a dense reference, and any solution's laws."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy import linalg, sparse

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import (
    ContactProblem,
    Outcome,
    SolverSettings,
    Start,
    assess,
    load_problem,
    rounding,
    save_problem,
    solve,
)
from masonry_fem.nscd.admissible import BALANCED, admissible_impulses
from masonry_fem.nscd.cohesion import without_offset
from masonry_fem.nscd.determinacy import determined_resultants, least_norm_reaction
from masonry_fem.nscd.scaling import contact_scale, free_speed
from tests.nscd.families import CASES, FAMILIES
from tests.nscd.plain_form import condensed
from tests.nscd.plane import plane_problem, plane_wall
from tests.nscd.walls import rigid_wall

TIGHT = SolverSettings(tolerance=1e-11)
WEIGHT, SIDE = 20.0, 7.0


def block(pull=0.0, push=0.0, *, d=3, friction=0.5, mass=0.0, compliance=0.0, **cohesion):
    """A block of unit mass that touches a support in one point at its centre, pulled up and pushed aside."""
    m = 3 if d == 2 else 6
    maps = np.zeros((1, 2, d, m))
    maps[0, 0, :, :d] = np.eye(d)
    load = np.zeros((1, m))
    load[0, :2] = pull - WEIGHT, push
    free = ContactProblem.plain(compliance * np.eye(d), np.zeros((1, d)), friction)
    return replace(
        free,
        bodies=np.array([[0, -1]]),
        rigid_map=maps,
        rigid_mass=np.full((1, m), mass),
        rigid_impulse=load,
        rigid_velocity=np.zeros((1, m)),
        **{name: np.array([value], dtype=float) for name, value in cohesion.items()},
    )


def springs(d, normal, tangential=None):
    """The stiffness of one contact."""
    return np.diag([normal] + [normal if tangential is None else tangential] * (d - 1))


def glued(problem, rng, scale=None):
    """Springs of any stiffness and offsets of the size of the loads at two contacts of three."""
    c, d = problem.free_velocity.shape
    w = contact_scale(problem)
    unit = 1.0
    if problem.body_count:
        unit = np.abs(problem.rigid_impulse).max() / np.abs(problem.rigid_map).max() / 3
    has = rng.random(c) < 2 / 3
    soft = 10.0 ** rng.uniform(-3, 3, c) if scale is None else np.full(c, scale)
    entries = soft[:, None] / w[:, None] * rng.uniform(0.3, 1, (c, d))
    entries[:, 1:] = entries[:, 1:2]
    return replace(
        problem,
        cohesion_offset=unit * rng.normal(size=(c, d)) * has[:, None],
        cohesion_stiffness=entries[:, :, None] * np.eye(d) * has[:, None, None],
    )


def defect(problem, solution):
    """Natural map on p̃ relative to ‖p‖, balance by p relative to the largest impulse on a body: dense.

    Both are ``Quality``'s, by this file alone. One contact's impulse on a body counts as much as a load.
    """
    c, d = problem.free_velocity.shape
    p, U = solution.impulse, solution.rigid_velocity
    v = problem.free_velocity + (problem.compliance.toarray() @ p.ravel()).reshape(c, d)
    gained = problem.rigid_mass * (U - problem.rigid_velocity)
    balance = problem.rigid_impulse - gained
    impulses = [*problem.rigid_impulse, *problem.body_impulse(p), *gained]
    for i, (bodies, maps) in enumerate(zip(problem.bodies, problem.rigid_map, strict=True)):
        for body, side in zip(bodies, maps, strict=True):
            if body >= 0:
                v[i] += side @ U[body]
                balance[body] += side.T @ p[i]
                impulses.append(side.T @ p[i])
    a = np.zeros((c, d)) if problem.cohesion_offset is None else problem.cohesion_offset
    S = np.zeros((c, d, d)) if problem.cohesion_stiffness is None else problem.cohesion_stiffness
    q = p + a + np.array([S[i] @ v[i] for i in range(c)])
    w, mu = contact_scale(problem), problem.friction
    missed = []
    for i in range(c):
        x = q[i] - v[i] / w[i]
        x[0] -= mu[i] * np.linalg.norm(v[i, 1:]) / w[i]
        size = np.linalg.norm(x[1:])
        if mu[i] * size <= -x[0]:
            x = np.zeros(d)
        elif size > mu[i] * x[0]:
            normal = (x[0] + mu[i] * size) / (1 + mu[i] ** 2)
            x = np.concatenate([[normal], mu[i] * normal / size * x[1:]])
        missed.append(q[i] - x)
    reference = np.linalg.norm(p)
    load = max(map(np.linalg.norm, impulses), default=0.0)
    rounding = 1e-13 * np.abs(problem.free_velocity).max()
    assert solution.velocity == pytest.approx(v, abs=1e-9 * np.abs(v).max() + rounding)
    assert reference > 0 or not v[:, 0].min() < 0
    unbalanced = max(map(np.linalg.norm, balance), default=0.0)
    return np.linalg.norm(missed) / (reference or 1.0), unbalanced / (load or 1.0)


# one block


@pytest.mark.slow
@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("mass", [0.0, 1.0])
@pytest.mark.parametrize("compliance", [0.0, 1e-4])
def test_a_spring_opens_by_force_over_stiffness(d, mass, compliance):
    spring = springs(d, 1e3, 4e2)
    pulled = block(WEIGHT + 50.0, SIDE, d=d, mass=mass, compliance=compliance, cohesion_stiffness=spring)
    found = solve(pulled, TIGHT)
    assert found.converged
    opening, slip = 50 / (1e3 + mass * (1 + 1e3 * compliance)), SIDE / (4e2 + mass * (1 + 4e2 * compliance))
    assert found.velocity[0, :2] == pytest.approx([opening, slip], rel=1e-9)
    assert found.impulse[0, :2] == pytest.approx([-1e3 * opening, -4e2 * slip], rel=1e-9)


@pytest.mark.parametrize("d", [2, 3])
def test_a_pressed_spring_shares_shear_with_friction(d):
    """Beyond the friction limit the rest goes to the tangential spring."""
    held = block(0.0, 25.0, d=d, cohesion_stiffness=springs(d, 1e3, 4e2))
    found = solve(held, TIGHT)
    assert found.velocity[0, :2] == pytest.approx([0.0, (25.0 - 0.5 * WEIGHT) / 4e2], abs=1e-12)
    assert found.impulse[0, :2] == pytest.approx([WEIGHT, -25.0], rel=1e-10)


@pytest.mark.parametrize("compliance", [0.0, 1e-4])
def test_an_offset_holds_against_pull_up_to_itself(compliance):
    glue = np.array([30.0, 0.0, 0.0])
    held = solve(block(WEIGHT + 29.0, 0.0, compliance=compliance, cohesion_offset=glue), TIGHT)
    assert held.converged
    assert held.impulse[0] == pytest.approx([-29.0, 0, 0], abs=1e-9)
    torn = solve(block(WEIGHT + 31.0, 0.0, compliance=compliance, cohesion_offset=glue))
    assert torn.outcome is Outcome.NO_EQUILIBRIUM
    flies = solve(block(WEIGHT + 31.0, 0.0, mass=1.0, compliance=compliance, cohesion_offset=glue), TIGHT)
    assert flies.impulse[0] == pytest.approx([-30.0, 0, 0], rel=1e-9)


def test_mohr_coulomb_slides_at_friction_plus_cohesion():
    """Cohesion c by an offset c/μ on the normal: the block slides at μ W + c."""
    glue = np.array([8.0 / 0.5, 0.0, 0.0])
    limit = 0.5 * WEIGHT + 8.0
    held = solve(block(0.0, 0.999 * limit, cohesion_offset=glue), TIGHT)
    assert held.impulse[0] == pytest.approx([WEIGHT, -0.999 * limit, 0], abs=1e-9)
    assert solve(block(0.0, 1.001 * limit, cohesion_offset=glue)).outcome is Outcome.NO_EQUILIBRIUM
    slides = solve(block(0.0, 1.1 * limit, mass=1.0, cohesion_offset=glue), TIGHT)
    assert slides.impulse[0] == pytest.approx([WEIGHT, -limit, 0], rel=1e-9, abs=1e-9)
    assert slides.velocity[0] == pytest.approx([0, 0.1 * limit, 0], rel=1e-9, abs=1e-9)


def test_springs_in_series():
    """Five blocks hung one below the other: each joint opens by the weight below it."""
    n, c = 5, 2e3
    points = [(x, -float(k)) for k in range(n) for x in (-0.5, 0.5)]
    owners = [(k - 1, k) for k in range(n) for _ in range(2)]
    load = np.array([[0.0, -WEIGHT, 0.0]] * n)
    stack = plane_problem(points, [(0.0, 1.0)] * (2 * n), owners, 0.5, load)
    stack = replace(stack, cohesion_stiffness=np.tile(springs(2, c), (2 * n, 1, 1)))
    found = solve(stack, TIGHT)
    assert found.converged
    below = np.repeat(WEIGHT * np.arange(n, 0, -1), 2)
    assert found.velocity[:, 0] == pytest.approx(below / (2 * c), rel=1e-9)
    assert found.rigid_velocity[:, 1] == pytest.approx(-np.cumsum(below[::2]) / (2 * c), rel=1e-9)


# limits


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("method", ["newton", "auto"])
def test_no_cohesion_is_dry_bit_for_bit(family, method):
    dry = FAMILIES[family](np.random.default_rng(3), 3)
    nothing = replace(
        dry, cohesion_offset=np.zeros((dry.count, 3)), cohesion_stiffness=np.zeros((dry.count, 3, 3))
    )
    assert not nothing.cohesive
    one, other = (solve(problem, SolverSettings(method=method)) for problem in (dry, nothing))
    assert (one.impulse == other.impulse).all()
    assert (one.rigid_velocity == other.rigid_velocity).all()


@pytest.mark.parametrize("family", ["elastic statics", "elastic dynamics"])
@pytest.mark.parametrize("d", [2, 3])
def test_little_cohesion_is_nearly_dry(family, d):
    dry = FAMILIES[family](np.random.default_rng(1), d)
    little = glued(dry, np.random.default_rng(6), 1e-9)
    little = replace(little, cohesion_offset=1e-9 * little.cohesion_offset)
    one = solve(dry, TIGHT)
    near = Start(one.impulse, one.rigid_velocity)
    other = solve(little, SolverSettings(method="newton", tolerance=1e-11), near)
    assert other.iterations > 0
    assert one.converged
    assert other.converged
    assert other.velocity == pytest.approx(one.velocity, abs=1e-6 * np.abs(one.velocity).max())


@pytest.mark.slow
@pytest.mark.parametrize("family", ["elastic statics", "elastic dynamics", "plain"])
@pytest.mark.parametrize("times", [1e6, 1e9])
def test_stiff_cohesion_is_bonded(family, times):
    """All contacts by springs so many times their own stiffness: bonded, all velocities nearly zero."""
    problem = FAMILIES[family](np.random.default_rng(7), 3)
    c, d = problem.free_velocity.shape
    stiff = times / contact_scale(problem)[:, None, None] * np.eye(d)
    bound = replace(problem, cohesion_stiffness=stiff)
    found = solve(bound, TIGHT)
    # S v of a v that is nearly rounding: known no better than that
    known = rounding(bound, found.impulse, found.rigid_velocity)
    assert found.quality.error <= max(TIGHT.tolerance, known.error)
    assert known.error < 1e-13 * times
    assert max(known.natural_map_velocity, found.quality.natural_map_velocity) < 1e-12
    W, B = problem.compliance.toarray(), problem.rigid_matrix().toarray()
    mass = np.diag(problem.rigid_mass.ravel())
    load = (problem.rigid_impulse + problem.rigid_mass * problem.rigid_velocity).ravel()
    bonded = linalg.solve(
        np.block([[W, B], [B.T, -mass]]), -np.concatenate([problem.free_velocity.ravel(), load])
    )
    p = bonded[: c * d].reshape(c, d)
    assert found.impulse == pytest.approx(p, abs=1e-5 * np.abs(p).max())
    # stiffness leaves no room for a wrong state: one that is 1e-5 off is seen
    off = found.impulse * (1 + 1e-5 * np.random.default_rng(0).normal(size=(c, d)))
    assert assess(replace(problem, cohesion_stiffness=stiff), off, found.rigid_velocity).error > 1e-7


# a reference by enumeration


def enumerated(problem):
    """The solution of a plane problem with W > 0, by one linear system for each list of statuses."""
    c = problem.count
    W, q = problem.delassus().toarray(), problem.plain_velocity().ravel()
    S = linalg.block_diag(*problem.cohesion_stiffness)
    a = problem.cohesion_offset.ravel()
    for statuses in product(("open", "stick", "left", "right"), repeat=c):
        # v = W p + q, and two equations a contact, rows (p | v)
        rows, right = np.zeros((4 * c, 4 * c)), np.zeros(4 * c)
        rows[: 2 * c] = np.hstack([W, -np.eye(2 * c)])
        right[: 2 * c] = -q
        part = np.hstack([np.eye(2 * c), S])  # p̃ − a
        for i, status in enumerate(statuses):
            n, t, at = 2 * i, 2 * i + 1, 2 * c + 2 * i
            if status == "open":
                rows[at], right[at] = part[n], -a[n]
                rows[at + 1], right[at + 1] = part[t], -a[t]
                continue
            rows[at, 2 * c + n] = 1.0
            if status == "stick":
                rows[at + 1, 2 * c + t] = 1.0
                continue
            mu = problem.friction[i] * (1 if status == "left" else -1)
            rows[at + 1], right[at + 1] = part[t] - mu * part[n], mu * a[n] - a[t]
        x = np.linalg.solve(rows, right)
        p, v = x[: 2 * c].reshape(c, 2), x[2 * c :].reshape(c, 2)
        pressed = (part @ x + a).reshape(c, 2)
        least = 1e-12
        good = (pressed[:, 0] >= -least).all() and (v[:, 0] >= -least).all()
        good &= (np.abs(pressed[:, 1]) <= problem.friction * pressed[:, 0] + least).all()
        good &= all(
            status in {"open", "stick"} or v[i, 1] * (1 if status == "left" else -1) <= least
            for i, status in enumerate(statuses)
        )
        if good:
            return p, v
    raise AssertionError("no statuses fit")


@pytest.mark.parametrize("seed", range(8))
def test_the_reference_by_enumeration(seed):
    rng = np.random.default_rng(seed)
    c = 4
    root = rng.normal(size=(2 * c, 2 * c))
    dry = ContactProblem.plain(root @ root.T + c * np.eye(2 * c), rng.normal(size=(c, 2)), 0.4)
    problem = glued(dry, rng)
    p, v = enumerated(problem)
    found = solve(problem, SolverSettings(method="newton", tolerance=1e-12))
    assert found.velocity == pytest.approx(v, abs=1e-9 * np.abs(v).max())
    assert found.impulse == pytest.approx(p, abs=1e-9 * np.abs(p).max())


# any solution


# What sweeps crawl on, and Newton's method alone may cycle on.
CRAWLS = [case for case in CASES if case[1] == "nsgs" and case[0] != "plain"]
CYCLES = [("elastic dynamics", "newton", d) for d in (2, 3)]
LOOSER = {"interior_point": 1e-6}  # it ends between that and 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("family", "method", "d"), [one for one in CASES if one not in CRAWLS + CYCLES])
@pytest.mark.parametrize("seed", [1, 2])
def test_contact_part_keeps_the_laws_and_bodies_balance(family, method, d, seed):
    rng = np.random.default_rng(seed)
    problem = glued(FAMILIES[family](rng, d), rng)
    tolerance = LOOSER.get(method, 1e-9)
    limit = None if method == "auto" else 500
    found = solve(problem, SolverSettings(method=method, tolerance=tolerance, max_iterations=limit))
    assert found.converged, (found.outcome, found.quality.error, found.method)
    natural, balance = defect(problem, found)
    assert found.quality.natural_map == pytest.approx(natural, rel=1e-3, abs=1e-12)
    assert natural <= 1.001 * tolerance
    assert balance <= 1.001 * tolerance


@pytest.mark.parametrize(
    ("family", "method", "d"),
    [pytest.param(*one, marks=pytest.mark.slow if one[0] == "hyperstatic" else ()) for one in CRAWLS],
)
def test_what_sweeps_do_not_end_is_measured(family, method, d):
    rng = np.random.default_rng(1)
    problem = glued(FAMILIES[family](rng, d), rng)
    found = solve(problem, SolverSettings(method=method, tolerance=1e-9, max_iterations=500))
    assert found.outcome is Outcome.MAX_ITERATIONS
    natural, _ = defect(problem, found)
    assert found.quality.natural_map == pytest.approx(natural, rel=1e-3)
    assert found.quality.error > 1e-3


@pytest.mark.parametrize(
    ("family", "method", "d"), [one for one in CASES if one not in CRAWLS and one[1] != "auto"]
)
def test_all_methods_agree(family, method, d):
    """Where joints hold: velocities are those of "auto" whatever the method; rigid walls stay at rest."""
    rng = np.random.default_rng(2)
    problem = replace(glued(FAMILIES[family](rng, d), rng), cohesion_offset=None)
    reference = solve(problem, TIGHT)
    assert reference.converged
    tolerance = LOOSER.get(method, 1e-8)
    found = solve(problem, SolverSettings(method=method, tolerance=tolerance, max_iterations=2000))
    assert found.converged, (found.outcome, found.quality.error)
    moves = family == "plain" or family.startswith("elastic")
    size = np.abs(reference.velocity).max() if moves else free_speed(problem)
    assert found.velocity == pytest.approx(reference.velocity, abs=1e2 * tolerance * size)


@pytest.mark.parametrize("soft", [1e-3, 1e-1])
def test_soft_springs_hold_a_sliding_wall_far_out(soft):
    """Without them it has no equilibrium; with them its blocks move thousands of times their first speeds."""
    wall = rigid_wall(12, 8, horizontal=0.6, friction=0.2, inertia=0.0)
    assert admissible_impulses(wall).unbalanced > BALANCED
    stiffness = soft / contact_scale(wall)[:, None, None] * springs(3, 1.0, 0.5)
    held = replace(wall, cohesion_stiffness=stiffness)
    assert solve(held, SolverSettings(method="interior_point", tolerance=1e-4)).converged
    found = solve(held, SolverSettings(tolerance=1e-9))
    assert found.converged
    assert max(defect(held, found)) <= 1.001e-9


@pytest.mark.parametrize("more", [{}, {"threads": 1}, {"threads": 2}])
@pytest.mark.parametrize("family", ["plain", "hyperstatic", "rigid dynamics"])
@pytest.mark.parametrize("d", [2, 3])
def test_sweeps_in_all_forms(more, family, d):
    """Where friction works a problem may have several solutions: each is told by the laws."""
    rng = np.random.default_rng(11)
    problem = glued(FAMILIES[family](rng, d), rng, 1e-2)
    sweeps = SolverSettings(method="nsgs", tolerance=1e-9, max_iterations=20_000, **more)
    pulled = solve(problem, sweeps)
    assert pulled.converged
    assert max(defect(problem, pulled)) <= 1.001e-9
    still = replace(problem, cohesion_offset=None)
    one, other = solve(still, sweeps), solve(still, SolverSettings(method="newton", tolerance=1e-11))
    assert one.converged
    assert other.velocity == pytest.approx(one.velocity, abs=1e-6 * free_speed(problem))


def test_relaxed_sweeps_refuse_stiffness():
    problem = glued(plane_wall(2, 2), np.random.default_rng(0))
    with pytest.raises(ProblemError, match=r"relaxation 1\.4 got .* contacts whose cohesion has stiffness"):
        solve(problem, SolverSettings(method="nsgs", relaxation=1.4))


def test_a_solution_is_a_fixed_point():
    problem = glued(plane_wall(), np.random.default_rng(2))
    found = solve(problem, TIGHT)
    again = solve(problem, SolverSettings(tolerance=1e-10), Start(found.impulse, found.rigid_velocity))
    assert again.iterations == 0
    assert (again.impulse == found.impulse).all()


def test_a_first_guess_is_of_the_impulses_on_blocks():
    problem = glued(FAMILIES["elastic statics"](np.random.default_rng(2), 3), np.random.default_rng(2))
    found = solve(problem, TIGHT)
    near = Start(found.impulse * (1 + 1e-6), found.rigid_velocity)
    warm = solve(problem, SolverSettings(method="newton", tolerance=1e-10), near)
    assert warm.converged
    assert warm.iterations < found.iterations


# what else is told of a problem


def test_offsets_can_carry_loads_and_fail_to():
    glue = np.array([30.0, 0.0, 0.0])
    held = admissible_impulses(block(WEIGHT + 29.0, cohesion_offset=glue))
    assert held.unbalanced <= 1e-6
    assert held.impulse[0, 0] == pytest.approx(-29.0, rel=1e-4)
    assert admissible_impulses(block(WEIGHT + 31.0, cohesion_offset=glue)).unbalanced > 0.01


@pytest.mark.parametrize(
    ("pull", "push", "normal", "tangential", "stands"),
    [
        (50.0, 500.0, 1e3, 4e2, True),
        (-1.0, 500.0, 0.0, 4e2, True),  # pressed: the tangential spring takes all shear
        (1.0, 0.0, 0.0, 4e2, False),  # nothing resists a pull
        (50.0, 0.0, 1e3, 0.0, True),
        (50.0, 10.0, 1e3, 0.0, True),  # statics alone would let a stretched spring press
    ],
)
def test_springs_carry_loads_in_their_directions(pull, push, normal, tangential, stands):
    problem = block(WEIGHT + pull, push, cohesion_stiffness=springs(3, normal, tangential))
    found = admissible_impulses(problem)
    assert (found.unbalanced <= BALANCED) == stands
    if not stands:
        assert solve(problem).outcome is Outcome.NO_EQUILIBRIUM


def test_what_is_determined_in_a_glued_joint():
    """Springs under a rigid plate: forces in springs are known, not the contact parts of pressed ones."""
    corners = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    maps = np.zeros((4, 2, 3, 6))
    for contact, (x, y) in zip(maps, corners, strict=True):
        # normal z, tangents x and y, about the centre
        contact[0] = [[0, 0, 1, y, -x, 0], [1, 0, 0, 0, 0, -y], [0, 1, 0, 0, 0, x]]
    load = np.array([[0.0, 0.0, -WEIGHT, 0.0, 0.0, 0.0]])
    pressed = ContactProblem(
        friction=np.full(4, 0.5),
        free_velocity=np.zeros((4, 3)),
        compliance=sparse.bsr_array((12, 12), blocksize=(3, 3)),
        bodies=np.array([[0, -1]] * 4),
        rigid_map=maps,
        rigid_mass=np.zeros((1, 6)),
        rigid_impulse=load,
        rigid_velocity=np.zeros((1, 6)),
        cohesion_offset=np.tile([4.0, 0.0, 0.0], (4, 1)),
        cohesion_stiffness=np.tile(springs(3, 1e3), (4, 1, 1)),
    )
    found = solve(pressed, TIGHT)
    least = least_norm_reaction(pressed, found)
    assert least.attained
    assert least.impulse[:, 0] == pytest.approx(np.full(4, WEIGHT / 4), rel=1e-6)
    known = determined_resultants(pressed, found, np.zeros(4))
    assert known.determined.all()
    assert known.resultant[0] == pytest.approx(-load[0], abs=1e-9)
    assert not known.unique.any()
    pulled = replace(pressed, rigid_impulse=-3 * load)
    found = solve(pulled, TIGHT)
    known = determined_resultants(pulled, found, np.arange(4))
    assert known.unique.all()
    assert known.resultant[:, 2] == pytest.approx(np.full(4, -3 * WEIGHT / 4), rel=1e-8)


# the problem itself


def test_an_offset_goes_into_loads():
    problem = glued(FAMILIES["elastic dynamics"](np.random.default_rng(1), 3), np.random.default_rng(1))
    moved = without_offset(problem)
    p, U = np.random.default_rng(2).normal(size=(2, problem.count, 3))[0], problem.rigid_velocity + 0.1
    shifted = p + problem.cohesion_offset
    v = problem.velocity(p, U)
    assert moved.velocity(shifted, U) == pytest.approx(v, rel=1e-9, abs=1e-12)
    assert moved.contact_part(shifted, v) == pytest.approx(problem.contact_part(p, v), rel=1e-9)
    assert moved.balanced_velocity(shifted) == pytest.approx(problem.balanced_velocity(p), rel=1e-9)
    dry = plane_wall()
    assert without_offset(dry) is dry


def test_condensed_keeps_cohesion():
    problem = glued(plane_wall(2, 2), np.random.default_rng(4))
    one, other = solve(problem, TIGHT), solve(condensed(problem), TIGHT)
    assert other.velocity == pytest.approx(one.velocity, abs=1e-7 * np.abs(one.velocity).max())


@pytest.mark.parametrize("problem", [glued(plane_wall(2, 2), np.random.default_rng(4)), plane_wall(2, 2)])
def test_files_keep_cohesion(problem, tmp_path):
    save_problem(problem, tmp_path / "problem.npz")
    again = load_problem(tmp_path / "problem.npz")
    for name in ("cohesion_offset", "cohesion_stiffness"):
        before, after = getattr(problem, name), getattr(again, name)
        assert (before is None) == (after is None)
        assert before is None or (before == after).all()


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("cohesion_offset", np.ones(3), r"cohesion_offset has shape \(3,\), expected \(1, 3\)"),
        (
            "cohesion_stiffness",
            np.ones((1, 3)),
            r"cohesion_stiffness has shape \(1, 3\), expected \(1, 3, 3\)",
        ),
        ("cohesion_offset", np.full((1, 3), np.nan), "contact 0: cohesion_offset is nan"),
        ("cohesion_stiffness", np.full((1, 3, 3), np.inf), "contact 0: cohesion_stiffness is inf"),
    ],
)
def test_what_does_not_fit_is_named(name, values, message):
    with pytest.raises(ProblemError, match=message):
        replace(block(), **{name: values})
