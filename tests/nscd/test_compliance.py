"""W_el by what stones share: the same answers as the matrix gives."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import block_diag

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.compliance import Kinds, Shared, Stored, only
from masonry_fem.nscd.problem import ContactProblem


def rotations(count, d, random):
    """Rotation matrices, shape (count, d, d)."""
    turned, _ = np.linalg.qr(random.normal(size=(count, d, d)))
    return turned


def whole(kinds, count, d, bed=None):
    """The sum of all stones, dense."""
    total = np.zeros((count, d, count, d))
    for kind in kinds:
        for contacts, turns, which in zip(kind.contacts, kind.turns, kind.kind, strict=True):
            T = block_diag(*turns)
            own = (T @ kind.matrices[which] @ T.T).reshape(len(contacts), d, len(contacts), d)
            there = np.flatnonzero(contacts >= 0)
            own = own[there][:, :, there].transpose(0, 2, 1, 3)
            total[contacts[there, None], :, contacts[there]] += own
    total = total.reshape(count * d, count * d)
    return total if bed is None else total + np.diag(bed.ravel())


@pytest.fixture(params=[2, 3])
def made(request):
    """Three stones of a kind and two of others in a ring, one of them unlike, contact 11 on rigid stones."""
    d, random = request.param, np.random.default_rng(request.param)
    contacts = [np.array([[0, 1, 2, 3], [4, 5, 2, 3], [4, 5, 6, 7]]), np.array([[6, 7, 8], [10, 9, 8]]),
                np.array([[9, -1, 10]])]  # fmt: skip
    kinds = []
    for own in contacts:
        n, s = own.shape
        root = random.normal(size=(s * d, s * d))
        turns = rotations(n * s, d, random).reshape(n, s, d, d)
        turns[1:] *= -1.0
        kinds.append(Kinds.alike(own, turns, root @ root.T))
    kinds[0].matrices[0][:, 0] *= 1.1  # stones that yield have no symmetric matrix
    return Shared(12, d, kinds, symmetric=False)


def equal(found, expected):
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("bedded", [False, True], ids=["bare", "bedded"])
@pytest.mark.parametrize("some", [False, True], ids=["all", "some"])
def test_answers_are_those_of_the_matrix(made, some, bedded):
    d, random, count = made.dimension, np.random.default_rng(1), 12
    dense = whole(made.kinds, count, d)
    if bedded:
        bed = random.uniform(size=(count, d))
        made, dense = made.plus(bed), dense + np.diag(bed.ravel())
    if some:
        contacts = np.array([9, 2, 0, 11, 5, 7, 6])
        dofs = (contacts[:, None] * d + np.arange(d)).ravel()
        made, dense, count = made.only(contacts), dense[np.ix_(dofs, dofs)], len(contacts)
    equal(made.matrix().toarray(), dense)
    stored = Stored(sparse.bsr_array(dense, blocksize=(d, d)))
    impulse = random.normal(size=count * d)
    equal(made @ impulse, dense @ impulse)
    equal(made.diagonal(), stored.diagonal())
    np.testing.assert_array_equal(made.elastic(), dense.reshape(count, d, -1).any(axis=(1, 2)))
    groups = random.permutation(count)[:6].reshape(2, 3)
    equal(made.among(groups), stored.among(groups))
    assert (made.terms() >= stored.terms()).all()  # stones that share two contacts are summed up one by one
    sizes = made.magnitudes() @ np.abs(impulse)
    assert (sizes >= (np.abs(dense) @ np.abs(impulse)) * (1 - 1e-12)).all()


def test_a_problem_takes_either(made):
    d = made.dimension
    plain = ContactProblem.plain(made.matrix(), np.ones((12, d)), 0.5)
    shared = replace(plain, compliance=made)
    impulse = np.random.default_rng(2).normal(size=(12, d))
    equal(shared.elastic_velocity(impulse), plain.elastic_velocity(impulse))
    assert not shared.rigid
    assert shared.without_compliance().rigid
    equal(shared.delassus().toarray(), plain.delassus().toarray())


@pytest.mark.parametrize("where", ["stone", "bed"])
def test_numbers_that_are_not_finite_are_told(made, where):
    if where == "stone":
        made.kinds[0].matrices[0][-1, 0] = np.nan
    else:
        made = made.plus(np.where(np.arange(12)[:, None] == 5, np.inf, np.zeros((12, made.dimension))))
    problem = ContactProblem.plain(np.zeros((12 * made.dimension,) * 2), np.ones((12, made.dimension)), 0.5)
    named = "contact 3: compliance to contact 0" if where == "stone" else "contact 5: compliance to contact 5"
    with pytest.raises(ProblemError, match=named):
        replace(problem, compliance=made)


def test_what_was_found_finite_is_not_looked_at_again(made):
    """Parts come by the hundred, and hold references to all matrices of the whole: a scan would cost more."""
    assert made.faulty() is None
    made.kinds[0].matrices[0][-1, 0] = np.nan
    assert made.faulty() is None
    assert made.only(np.arange(4)).faulty() is None


@pytest.mark.parametrize("looked", [False, True])
def test_other_beds_are_looked_at(made, looked):
    """Whether the operator was before or not."""
    assert not looked or made.faulty() is None
    bed = np.where(np.arange(12)[:, None] == 5, np.nan, np.ones((12, made.dimension)))
    assert made.plus(bed).faulty() == (5, 5)
    assert made.plus(bed).only(np.array([2, 5])).faulty() == (1, 1)


def test_matrices_that_no_stone_has_change_nothing(made):
    """A part holds those of the whole, but does not send them to other ranks."""
    part = made.only(np.array([9, 10]))
    bare = Shared(2, made.dimension, [kind.bare() for kind in part.kinds], symmetric=False)
    assert sum(len(kind.matrices) for kind in bare.kinds) < sum(len(kind.matrices) for kind in part.kinds)
    sent = pickle.loads(pickle.dumps(part))
    assert sum(len(kind.matrices) for kind in sent.kinds) == sum(len(kind.matrices) for kind in bare.kinds)
    impulse = np.arange(2.0 * made.dimension)
    np.testing.assert_array_equal(sent @ impulse, part @ impulse)
    np.testing.assert_array_equal(sent.matrix().toarray(), part.matrix().toarray())
    assert sent.nnz == part.nnz > 0
    np.testing.assert_array_equal(part.diagonal(), bare.diagonal())
    for one, other in zip(part.strongest(0.01), bare.strongest(0.01), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("chosen", [[], [2], [0, 3, 4], range(6)])
def test_a_part_of_a_stored_compliance_is_its_rows_and_columns(chosen):
    """Only neighbours share blocks that are stored, and contacts 2 and 4."""
    pattern = np.array([[abs(i - j) < 2 for i in range(6)] for j in range(6)])
    pattern[2, 4] = pattern[4, 2] = True
    dense = np.kron(pattern, np.ones((3, 3))) * np.random.default_rng(1).random((18, 18))
    contacts = np.array(chosen, dtype=np.int64)
    part = only(sparse.bsr_array(dense, blocksize=(3, 3)), contacts)
    dofs = (3 * contacts[:, None] + np.arange(3)).ravel()
    assert np.array_equal(part.toarray(), dense[np.ix_(dofs, dofs)])
    assert part.nnz == 9 * pattern[np.ix_(contacts, contacts)].sum()
