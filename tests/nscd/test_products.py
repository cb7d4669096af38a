"""Products of small blocks are those of NumPy, to rounding, however the blocks lie in memory."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.nscd.products import applied, multiplied


@pytest.mark.parametrize("count", [0, 1, 40])
@pytest.mark.parametrize(("rows", "columns", "width"), [(2, 2, 2), (3, 3, 3), (3, 3, 6)])
def test_products_are_those_of_numpy(count, rows, columns, width):
    random = np.random.default_rng(count)
    first, second = random.normal(size=(count, columns, rows)), random.normal(size=(count, columns, width))
    turned = first.transpose(0, 2, 1)
    both = np.einsum("nij,njk->nik", turned, second)
    assert np.allclose(multiplied(turned, second), both, rtol=1e-14, atol=1e-14)
    vectors = second[:, :, 0]
    assert np.allclose(applied(turned, vectors), both[:, :, 0], rtol=1e-14, atol=1e-14)


def test_one_block_serves_all_contacts():
    blocks = np.broadcast_to(2.0 * np.eye(3), (5, 3, 3))
    vectors = np.arange(15.0).reshape(5, 3)
    assert np.array_equal(applied(blocks, vectors), 2.0 * vectors)
