"""Assembly of block-sparse operators."""

import numpy as np
import pytest

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.blocks import assemble_blocks


@pytest.mark.parametrize("d", [2, 3])
def test_equals_the_dense_sum(d):
    rng = np.random.default_rng(0)
    c, dense, contributions = 12, np.zeros((12 * d, 12 * d)), []
    for size in (1, 4, 5, 0, 7):
        contacts = rng.choice(c, size, replace=False)
        matrix = rng.normal(size=(size * d, size * d))
        matrix = matrix @ matrix.T
        dofs = (contacts[:, None] * d + np.arange(d)).ravel()
        dense[np.ix_(dofs, dofs)] += matrix
        contributions.append((contacts, matrix))
    W = assemble_blocks(c, d, contributions)
    assert W.blocksize == (d, d)
    assert W.toarray() == pytest.approx(dense, abs=1e-13)
    assert np.array_equal(W.toarray(), W.toarray().T)


def test_rounding_cannot_break_symmetry():
    rng = np.random.default_rng(1)
    matrix = np.eye(6) + 1e-16 * rng.normal(size=(6, 6))
    W = assemble_blocks(3, 3, [(np.array([2, 0]), matrix), (np.array([0, 2]), 3 * matrix)]).toarray()
    assert np.array_equal(W, W.T)


def test_a_block_may_touch_itself():
    W = assemble_blocks(2, 2, [(np.array([1, 1]), np.ones((4, 4)))])
    assert W.toarray() == pytest.approx(np.kron(np.diag([0, 1]), 4 * np.ones((2, 2))))


def test_nothing_to_assemble():
    assert assemble_blocks(0, 3, []).shape == (0, 0)
    assert assemble_blocks(4, 3, []).nnz == 0
    assert assemble_blocks(4, 3, []).shape == (12, 12)


def test_a_matrix_of_another_size_is_named():
    with pytest.raises(ProblemError, match=r"2 contacts has shape \(4, 4\), expected \(6, 6\)"):
        assemble_blocks(3, 3, [(np.array([0, 1]), np.eye(4))])
