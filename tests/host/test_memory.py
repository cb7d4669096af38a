"""Parked matrices: the same numbers, out of memory, and a file that goes with them."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.host.memory import park


def test_a_parked_matrix_is_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    rng = np.random.default_rng(1)
    matrix = sparse.csr_array(sparse.random_array((50, 50), density=0.2, rng=rng))
    dense, before = matrix.toarray(), (matrix.data, matrix.indices)
    park(matrix)
    for old, new in zip(before, (matrix.data, matrix.indices), strict=True):
        assert isinstance(new.base, np.memmap)
        assert new.dtype == old.dtype
        assert np.array_equal(new, old)
    assert np.array_equal(matrix @ np.eye(50), dense)
    assert np.array_equal(sparse.csr_array(2.0 * matrix + matrix.T).toarray(), 2.0 * dense + dense.T)
    here = matrix.data
    park(matrix)  # once is enough
    assert matrix.data is here
    matrix.data[0] = 7.0
    assert matrix.data[0] == 7.0
    assert list(tmp_path.iterdir()) == []  # the files have no name


def test_a_matrix_of_nothing_can_be_parked() -> None:
    matrix = sparse.csr_array((4, 4))
    park(matrix)
    assert matrix.nnz == 0
