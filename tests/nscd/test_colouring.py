"""Colouring: groups of a colour share nothing, whatever the graph, and walls need few colours."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from masonry_fem.nscd.solvers.colouring import colour_bodies, colour_couplings
from tests.nscd.walls import rigid_wall


def pieces(colouring):
    """Contacts of each group of each colour."""
    return [
        [colouring.order[slice(*colouring.groups[g : g + 2])] for g in range(*colouring.colours[k : k + 2])]
        for k in range(colouring.count)
    ]


def check_partition(colouring, count):
    visited = [contact for groups in pieces(colouring) for group in groups for contact in group]
    assert sorted(visited) == list(range(count))
    assert (np.diff(colouring.groups) > 0).all()
    assert (np.diff(colouring.colours) > 0).all()


def check_bodies(colouring, bodies):
    check_partition(colouring, len(bodies))
    for groups in pieces(colouring):
        touched = [set(bodies[group].ravel()) - {-1} for group in groups]
        assert sum(map(len, touched)) == len(set().union(*touched))


def check_couplings(colouring, stored):
    """``stored`` (c, c): where W has blocks."""
    check_partition(colouring, len(stored))
    for groups in pieces(colouring):
        owner = np.full(len(stored), -1)
        for number, group in enumerate(groups):
            owner[group] = number
        one, other = np.nonzero(stored)
        both = (owner[one] >= 0) & (owner[other] >= 0)
        assert (owner[one][both] == owner[other][both]).all()


@st.composite
def random_bodies(draw):
    count = draw(st.integers(1, 12))
    side = st.integers(-1, count - 1)
    pairs = draw(st.lists(st.tuples(side, side), max_size=60))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


@given(random_bodies(), st.integers(1, 5))
def test_no_body_is_shared(bodies, fewest):
    """Any pairs: contacts repeated, between a body and the ground, itself or nothing."""
    colouring = colour_bodies(bodies, fewest)
    check_bodies(colouring, bodies)
    small = [k for k, groups in enumerate(pieces(colouring)) if len(groups) < fewest]
    assert small in ([], [colouring.count - 1])  # what is left is one group at the end
    assert all(len(pieces(colouring)[k]) == 1 for k in small)


@given(st.integers(0, 20), st.lists(st.tuples(st.integers(0, 19), st.integers(0, 19)), max_size=60),
       st.integers(1, 5))  # fmt: skip
def test_no_block_is_shared(count, pairs, fewest):
    """Any pattern, one-sided and without diagonal, too."""
    stored = np.zeros((count, count), dtype=bool)
    for i, j in pairs:
        if i < count and j < count:
            stored[i, j] = True
    check_couplings(colour_couplings(sparse.csr_array(stored), fewest), stored)


def test_a_wall_has_few_colours_and_a_group_is_an_interface():
    problem = rigid_wall(10, 8)
    colouring = colour_bodies(problem.bodies, fewest=1)
    check_bodies(colouring, problem.bodies)
    assert colouring.count <= 11  # a brick has at most six neighbours: 2 * 6 - 1 are always enough
    pairs = np.unique(np.sort(problem.bodies, axis=1), axis=0)
    assert len(colouring.groups) - 1 == len(pairs)
    assert (np.diff(colouring.groups) == 4).all()


def test_both_forms_of_a_wall_have_the_same_groups():
    problem = rigid_wall(6, 4)
    W = problem.delassus()
    couplings = sparse.csr_array((np.ones(len(W.indices)), W.indices, W.indptr))
    kept, formed = colour_bodies(problem.bodies, 1), colour_couplings(couplings, 1)
    check_couplings(formed, couplings.toarray() > 0)
    sets = [{frozenset(group) for groups in pieces(made) for group in groups} for made in (kept, formed)]
    assert sets[0] == sets[1]


def test_one_body_under_all_leaves_nothing_to_share():
    """A slab that carries a hundred blocks: a hundred colours of one group would only cost."""
    bodies = np.stack([np.arange(1, 101), np.zeros(100, int)], axis=1)
    assert colour_bodies(bodies, fewest=1).count == 100
    assert colour_bodies(bodies).count == 1


@pytest.mark.parametrize("bodies", [np.zeros((0, 2), int), np.full((3, 2), -1)])
def test_nothing_to_colour(bodies):
    check_bodies(colour_bodies(bodies), bodies)
