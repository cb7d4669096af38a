"""Products of small blocks are those of NumPy, to rounding, however the blocks lie in memory."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.nscd.products import applied, inverted, multiplied


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


@pytest.mark.parametrize("size", [2, 3])
def test_inverses_are_those_of_numpy_whatever_the_order_of_rows(size):
    random = np.random.default_rng(size)
    blocks = random.normal(size=(60, size, size)) * 10.0 ** random.uniform(-9, 9, size=(60, 1, 1))
    blocks[:20, 0, 0] = 0.0  # no pivot on the diagonal
    blocks[20:40] += blocks[20:40].transpose(0, 2, 1)
    exact = np.linalg.inv(blocks)
    for given in (blocks, np.asfortranarray(blocks)):
        error = np.linalg.norm(inverted(given) - exact, axis=(1, 2)) / np.linalg.norm(exact, axis=(1, 2))
        assert (error < 1e-14 * np.linalg.cond(blocks)).all()
    assert inverted(blocks[:0]).shape == (0, size, size)


def test_a_singular_block_has_no_inverse():
    blocks = np.tile(np.eye(3), (4, 1, 1))
    blocks[2, 1] = blocks[2, 0]
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        inverted(blocks)
