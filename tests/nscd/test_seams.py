"""Contacts that several joints have at the same corners: found, and solved for together."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.march import coupling
from masonry_fem.nscd import compliance
from masonry_fem.nscd.compliance import Kinds, Shared
from masonry_fem.nscd.solvers import elastic_krylov
from masonry_fem.nscd.solvers import seams as seaming
from masonry_fem.nscd.solvers.elastic_krylov import Rows, Sets, Values
from masonry_fem.nscd.solvers.seams import seams, together
from masonry_fem.scene import check
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Scene, Solver, Statics
from masonry_fem.structures.wall import WallStructure


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
        size = d * (points.max() + 1)  # points far from each other move each other little
        root = np.eye(size) + 0.05 * random.normal(size=(size, size))
        at = (points[:, None] * d + np.arange(d)).ravel()
        matrix = (root @ root.T)[np.ix_(at, at)]
        turns = signs[:, None, None] * frames[contacts] @ axes
        kinds.append(Kinds.alike(contacts[None], turns[None], matrix))
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
    ("sides", "count", "expected"),
    [(THREE, 6, [[0, 1, 2]]), (ON_SUPPORT, 5, [[0, 1, 2]]), (FOUR, 7, [[0, 1, 2, 3, 4, 5]])],
    ids=["three", "on a support", "four"],
)
def test_contacts_at_one_point_of_stones_are_a_seam(sides, count, expected, d):
    operator = stones(sides, count, d, turned(count, d, np.random.default_rng(2)))
    found = [group.tolist() for group in seams(operator, np.arange(count))]
    assert [sorted(seam) for group in found for seam in group] == expected
    # the same entry by entry as by stones
    stored = compliance.Stored(operator.matrix())
    assert [group.tolist() for group in seams(stored, np.arange(count))] == found


def test_contacts_of_one_interface_make_no_seam():
    operator = stones(FOUR, 7, 3, turned(7, 3, np.random.default_rng(3)))
    assert not seams(operator, np.zeros(7, dtype=int))
    assert not seams(operator, np.full(7, -1))


def test_a_seam_has_no_more_contacts_than_can_be_solved_for_at_once(monkeypatch):
    operator = stones(FOUR, 7, 3, turned(7, 3, np.random.default_rng(3)))
    monkeypatch.setattr(seaming, "WIDEST", 5)
    assert all(group.shape[1] <= 5 for group in seams(operator, np.arange(7)))


def test_rows_of_a_step_before_are_kept_where_nothing_has_changed():
    random, d, count = np.random.default_rng(4), 3, 7
    operator = stones(FOUR, count, d, turned(count, d, random))
    interfaces = Sets.of(operator, [np.arange(count)[:, None]])
    joined = Sets.of(operator, seams(operator, np.arange(count)))
    bodies, maps = np.full((count, 2), -1), np.zeros((count, 2, d, 6))
    own = np.eye(d) + 0.1 * random.normal(size=(count, d, d))
    changed = own.copy()
    changed[2] *= 2.0
    force = random.normal(size=(count, d))

    def solved(rows, own):
        rows.take(Values(own, np.tile(np.eye(d), (count, 1, 1)), np.arange(count) != 5, 1.0))
        return rows.inside(force)

    kept, made = (Rows(bodies, maps, interfaces, joined) for _ in range(2))
    first, second = solved(kept, own), solved(kept, changed)
    np.testing.assert_array_equal(second, solved(made, changed))
    assert np.abs(first - second).max() > 1e-3
    # in the room of another problem's
    double = Sets(interfaces.groups, [2 * W for W in interfaces.coupling])
    twice = Shared(count, d, [replace(kind, matrices=2 * kind.matrices) for kind in operator.kinds])
    for one, other in zip(interfaces.again(twice).coupling, double.coupling, strict=True):
        np.testing.assert_array_equal(one, other)
    again = Rows(bodies, maps, double, joined, before=kept)
    np.testing.assert_array_equal(solved(again, changed), solved(Rows(bodies, maps, double, joined), changed))


def test_interfaces_of_a_stone_that_flows_are_one():
    # stone 0 between stones 1 and 2 flows, and so at all of its contacts at once; stones 1 and 2 meet, too
    random, d, count = np.random.default_rng(5), 3, 6
    way = random.normal(size=(4 * d, 1))
    flowing = Kinds.alike(
        np.arange(4)[None], np.tile(np.eye(d), (1, 4, 1, 1)), np.eye(4 * d) + 1e3 * way @ way.T
    )
    others = [
        Kinds.alike(np.array([at]), sign * np.tile(np.eye(d), (1, 4, 1, 1)), np.eye(4 * d))
        for at, sign in (([0, 1, 4, 5], -1), ([2, 3, 4, 5], -1))
    ]
    interface = np.array([0, 0, 1, 1, 2, 2])
    found, joined = together(Shared(count, d, [flowing, *others]), interface)
    assert [group.tolist() for group in found] == [[[4, 5]], [[0, 1, 2, 3]]]
    assert not joined
    # before it flows they are apart
    still = Kinds.alike(flowing.contacts, flowing.turns[0][None], np.eye(4 * d))
    assert together(Shared(count, d, [still, *others]), interface) == (None, [])


def test_contacts_between_any_number_of_bodies_are_eliminated_as_one():
    random, d, m = np.random.default_rng(6), 2, 3
    bodies = np.array([[1, 0], [0, 1], [2, 1], [-1, 2], [2, 3], [3, 2], [4, 3], [-1, 4]])
    maps = random.normal(size=(len(bodies), 2, d, m))
    maps[bodies < 0] = 0.0
    root = random.normal(size=(len(bodies) * d,) * 2)
    whole = root @ root.T + np.eye(len(root))
    groups = [np.arange(8).reshape(2, 4)]  # bodies −1, 0, 1, 2 and −1, 2, 3, 4
    coupling = [np.stack([whole[:8, :8], whole[8:, 8:]])]
    own, by_velocity = (np.eye(d) + 0.1 * random.normal(size=(len(bodies), d, d)) for _ in range(2))
    values = Values(own, by_velocity, np.ones(len(bodies), dtype=bool), 1.0)
    rows = Rows(bodies, maps, Sets(groups, coupling), Sets([], []))
    rows.take(values)
    joined = np.zeros((len(bodies), d, 5, m))
    for contact, sides in enumerate(bodies):
        for side, body in enumerate(sides):
            if body >= 0:
                joined[contact, :, body] += maps[contact, side]
    ((members, given),) = rows.eliminated()
    assert members.tolist() == [[-1, 0, 1, 2], [-1, 2, 3, 4]]
    motion = random.normal(size=(5, m))
    moved = rows.moving(np.zeros((len(bodies), d)), motion)
    for number in range(2):
        at = slice(4 * number, 4 * number + 4)
        block = np.zeros((4, d, 4, d))
        for one in range(4):
            inner = coupling[0][number].reshape(4, d, 4, d)[one].reshape(d, 4 * d)
            block[one] = (by_velocity[at][one] @ inner).reshape(d, 4, d)
            block[one, :, one] += own[at][one]
        pushed = (by_velocity[at] @ joined[at].reshape(4, d, -1)).reshape(4 * d, -1)
        followed = np.linalg.solve(block.reshape(4 * d, -1), pushed)
        np.testing.assert_allclose(moved[at].ravel(), -followed @ motion.ravel(), rtol=1e-9)
        between = (joined[at].reshape(4 * d, -1).T @ followed).reshape(5, m, 5, m)
        for i, one in enumerate(members[number]):
            for j, other in enumerate(members[number]):
                if min(one, other) >= 0:
                    np.testing.assert_allclose(given[number, i, j], between[one, :, other], rtol=1e-9)


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
    monkeypatch.setattr(elastic_krylov, "MANY", 0)
    assert solve_scene(check(pushed_wall())).outcome == "equilibrium"
    assert max(counts) <= 18  # 50 where nothing is done about seams
