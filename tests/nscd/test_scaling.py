"""Scale of contacts: against NumPy's own 2-norm."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem
from masonry_fem.nscd.scaling import contact_scale


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("size", [1e-200, 1e-9, 1.0, 1e200])
def test_scale_is_the_norm_of_the_diagonal_block(d: int, size: float) -> None:
    rng = np.random.default_rng(d)
    blocks = size * rng.normal(size=(20, d, d))
    blocks[0] = size * np.eye(d)
    blocks[1] = size * np.diag([1.0] + [1e-12] * (d - 1))
    blocks[2] = size * np.ones((d, d))
    W = np.zeros((20 * d, 20 * d))
    for i, block in enumerate(blocks):
        W[i * d : (i + 1) * d, i * d : (i + 1) * d] = block
    expected = np.linalg.norm(blocks, ord=2, axis=(1, 2))
    problem = ContactProblem.plain(W, np.zeros((20, d)), 0.5)
    np.testing.assert_allclose(contact_scale(problem), expected, rtol=1e-12)


def test_what_nothing_moves_gets_the_mean_of_the_others() -> None:
    problem = ContactProblem.plain(np.diag([2.0, 2, 2, 0, 0, 0, 4, 4, 4]), np.zeros((3, 3)), 0.5)
    np.testing.assert_allclose(contact_scale(problem), [2, 3, 4])
