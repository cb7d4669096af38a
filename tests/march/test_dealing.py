"""What stones give way by, made by several processes: the same to the last bit as by one."""

import pickle
from contextlib import nullcontext

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import GeometryError
from masonry_fem.fem import attachment, condense
from masonry_fem.host.ranks import Leader, dealt
from masonry_fem.march import coupling, dealing
from masonry_fem.scene import loads
from tests.mpi.scenes import VAULT as UNLIKE

VAULT = UNLIKE.replace("size = 0.12", "size = 0.3")


class Sent:
    """A rank that gets and gives what can be sent."""

    def __init__(self, rank):
        self.rank, self.made = rank, 0

    def on(self, kind):
        return nullcontext()

    def together(self, local):
        found = local()
        self.made += len(found)
        return found


class Three(Leader):
    """Three ranks in one process."""

    def __init__(self):
        self.size, self.busy, self.calls = 3, False, 0
        self.ranks = [Sent(rank) for rank in range(3)]

    def call(self, work, shares):
        self.calls += 1
        found = [work(self.ranks[0], shares[0])]
        for rank, share in zip(self.ranks[1:], shares[1:], strict=True):
            found.append(pickle.loads(pickle.dumps(work(rank, pickle.loads(pickle.dumps(share))))))
        return found


@pytest.fixture
def three(monkeypatch):
    """Three ranks, for which no shape is too small."""
    leader = Three()
    monkeypatch.setattr(dealing, "team", lambda: leader)
    monkeypatch.setattr(attachment, "LEAST", 0)
    return leader


@pytest.mark.parametrize(
    ("shared", "dense"), [(False, True), (True, False)], ids=["assembled, dense", "by kinds, sparse"]
)
def test_a_march_is_the_same(shared, dense, three, monkeypatch):
    scene = loads(VAULT)
    if not dense:
        monkeypatch.setattr(condense, "DENSE_LIMIT", 0)
    monkeypatch.setattr(coupling, "MANY", 0 if shared else np.inf)
    found = solve_scene(scene)
    assert three.calls == 1
    made = [rank.made for rank in three.ranks]
    assert sum(made) == found.summary.shapes
    assert min(made) > 0
    three.busy = True  # and so no one's leader
    expected = solve_scene(scene)
    assert three.calls == 1
    assert found.summary.factorisations == expected.summary.factorisations
    last, other = found.march.last.after, expected.march.last.after
    np.testing.assert_array_equal(last.velocity, other.velocity)


def test_no_more_is_made_at_a_time_than_there_is_room_for(three, monkeypatch):
    monkeypatch.setattr(dealing, "ROOM", 0)
    solve_scene(loads(VAULT))
    assert not three.calls  # one stone at a time is the leader's own
    monkeypatch.setattr(dealing, "ROOM", 150_000)
    solve_scene(loads(VAULT))
    assert three.calls > 1


def test_a_shape_that_fails_is_told_as_by_one_process(three, monkeypatch):
    def failing(*given, **settings):
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(condense.DenseFactor, "_factorise", failing)
    with pytest.raises(GeometryError, match=r"block 'vault\.\S+': its stiffness is singular"):
        solve_scene(loads(VAULT))
    assert three.calls == 1


def test_works_are_dealt_the_largest_first():
    assert dealt([1.0, 5.0, 3.0, 2.0], 2) == [[1, 0], [2, 3]]
    assert dealt([1.0], 3) == [[0], [], []]
