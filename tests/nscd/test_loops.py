"""Impulses that go round stones at a point that they share: found, and solved for exactly."""

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.march import coupling
from masonry_fem.nscd.compliance import Alike, Shared
from masonry_fem.nscd.solvers import elastic_krylov
from masonry_fem.nscd.solvers.loops import Loops, Places
from masonry_fem.scene import check
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Scene, Solver, Statics
from masonry_fem.structures.wall import WallStructure

from .walls import wall


def turned(count, d, random):
    """Rotation matrices, shape (count, d, d)."""
    made, _ = np.linalg.qr(random.normal(size=(count, d, d)))
    return made


def stones(sides, count, d, frames):
    """W_el of stones that give way at points, from (contact, point, sign) of their contacts.

    Parameters
    ----------
    sides : For each stone. count : How many contacts there are.
    frames : Rows of each contact's axes, shape (count, d, d).
    """
    random = np.random.default_rng(1)
    kinds = []
    for stone in sides:
        contacts, points, signs = map(np.array, zip(*stone, strict=True))
        axes = turned(1, d, random)[0]
        root = random.normal(size=(d * (points.max() + 1),) * 2)
        at = (points[:, None] * d + np.arange(d)).ravel()
        matrix = (root @ root.T)[np.ix_(at, at)]
        turns = signs[:, None, None] * frames[contacts] @ axes
        kinds.append(Alike(contacts[None], turns[None], matrix))
    return Shared(count, d, kinds)


# three stones that meet at a point (contacts 0, 1, 2), two of them on a support nearby (3, 4); contact 5 is
# elsewhere between the first two
THREE = [
    [(0, 0, 1), (1, 0, 1), (3, 1, 1), (5, 2, 1)],
    [(0, 0, -1), (2, 0, 1), (4, 1, 1), (5, 2, -1)],
    [(1, 0, -1), (2, 0, -1)],
]
# two stones that meet at a point of a support: one loop through it
ON_SUPPORT = [[(0, 0, 1), (1, 0, 1), (3, 1, 1)], [(0, 0, -1), (2, 0, 1), (4, 1, 1)]]
# four stones of which each meets each other at a point, as cells of rubble do: three loops
FOUR = [
    [(0, 0, 1), (1, 0, 1), (2, 0, 1), (6, 1, 1)],
    [(0, 0, -1), (3, 0, 1), (4, 0, 1)],
    [(1, 0, -1), (3, 0, -1), (5, 0, 1)],
    [(2, 0, -1), (4, 0, -1), (5, 0, -1)],
]


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize(
    ("sides", "count", "closed", "loops"),
    [
        (THREE, 6, range(6), 1),
        (THREE, 6, [0, 2, 3, 4, 5], 0),
        (ON_SUPPORT, 5, range(5), 1),
        (FOUR, 7, range(7), 3),
        (FOUR, 7, [0, 1, 2, 3, 4, 6], 2),
        (FOUR, 7, [0, 1, 2, 6], 0),
    ],
    ids=["three", "three, one open", "on a support", "four", "four, one open", "four, three open"],
)
def test_rows_are_solved_in_the_space_that_no_stone_feels(sides, count, closed, loops, d):
    random = np.random.default_rng(2)
    operator = stones(sides, count, d, turned(count, d, random))
    own = np.eye(d) + 0.3 * random.normal(size=(count, d, d))
    mask = np.isin(np.arange(count), list(closed))
    found = Loops(Places(operator), own, mask)
    space = np.zeros((count * d, count * d))
    for column in range(count * d):
        impulse, rest = found.taken(np.eye(count * d)[column].reshape(count, d))
        space[:, column] = impulse.ravel()
        # nothing of what was solved for is left in the loops
        assert np.abs(found.taken(rest)[0]).max() < 1e-12
        assert np.abs(impulse[~mask]).max(initial=0.0) == 0
    assert np.linalg.matrix_rank(space, tol=1e-10) == loops * d
    largest = np.abs(operator.matrix().data).max() * np.abs(space).max()
    assert np.abs(operator.matrix() @ space).max() <= 1e-12 * max(largest, 1e-300)
    # impulses round loops are recovered from their rows
    given = space @ random.normal(size=count * d)
    rows = (own @ given.reshape(count, d, 1))[..., 0]
    assert np.abs(found.taken(rows)[0].ravel() - given).max() <= 1e-10


def test_loops_of_a_step_before_are_kept_while_the_same_contacts_are_closed():
    random, closed = np.random.default_rng(3), np.ones(7, dtype=bool)
    operator = stones(FOUR, 7, 3, turned(7, 3, random))
    places, force = Places(operator), random.normal(size=(7, 3))
    rows = [np.eye(3) + 0.3 * random.normal(size=(7, 3, 3)) for _ in range(2)]
    last = Loops(places, rows[0], closed)
    for mask in (closed, np.arange(7) != 5):
        kept, made = Loops(places, rows[1], mask, last), Loops(places, rows[1], mask)
        for one, other in zip(kept.taken(force), made.taken(force), strict=True):
            np.testing.assert_array_equal(one, other)


def pushed_wall():
    """Bricks pushed sideways until most joints slide, by iterations."""
    wall = WallStructure(name="wall", material="stone", brick=(0.4, 0.2, 0.2), columns=6, courses=6)
    return Scene(
        materials={"stone": Material(density=2400.0, young=10e9, poisson=0.2)},
        structures=(wall,),
        joints=(Joint(friction=0.3),),
        loads=Loads(gravity=(2.0, 0.0, -9.81)),
        mesh=MeshSettings(divisions=(2, 1, 1)),
        analysis=Statics(),
        solver=Solver(tolerance=1e-9, linear="krylov"),
    )


def test_sliding_takes_no_more_iterations_than_sticking(monkeypatch):
    counts = []

    def counted(operator, rhs, **settings):
        counts.append(0)

        def one_more(_):
            counts[-1] += 1

        return gmres(operator, rhs, callback=one_more, callback_type="pr_norm", **settings)

    gmres = elastic_krylov.gmres
    monkeypatch.setattr(elastic_krylov, "gmres", counted)
    monkeypatch.setattr(coupling, "MANY", 0)  # stones are known, although they are few
    assert solve_scene(check(pushed_wall())).outcome == "equilibrium"
    assert max(counts) <= 18  # 50 where nothing is done about loops


def test_a_matrix_without_stones_has_no_loops():
    problem = wall(courses=3, length=1.5, elements=(2, 1, 1)).problem()
    assert len(Places(problem.operator).contacts) == 0
