"""Interfaces as arrays, and numbers of equal rows."""

import numpy as np
import pytest

from masonry_fem.contact.contacts import Interface
from masonry_fem.contact.interface_arrays import InterfaceArrays, numbered


@pytest.mark.parametrize("width", [1, 3])
def test_equal_rows_have_equal_numbers_as_they_first_come(width):
    rng = np.random.default_rng(width)
    rows = rng.integers(-1, 2, size=(200, width)).astype(float)
    rows[rows == 0] *= rng.choice([-1.0, 1.0], size=int((rows == 0).sum()))  # −0 is 0
    number, first = numbered(rows)
    seen: dict[tuple[float, ...], int] = {}
    assert number.tolist() == [seen.setdefault(tuple(row), len(seen)) for row in rows.tolist()]
    assert first.tolist() == [number.tolist().index(k) for k in range(len(seen))]


def test_no_rows_have_no_numbers():
    number, first = numbered(np.empty((0, 4)))
    assert len(number) == len(first) == 0


def test_polygons_of_any_number_of_corners_are_kept_one_after_another():
    polygons = [np.arange(3.0 * k).reshape(k, 3) for k in (4, 1, 3)]
    one = Interface((1, 0), (2, 3), np.array([0, 0, 1.0]), polygons[0], np.zeros(4), 0.5, "bed")
    interfaces = [
        one,
        Interface((5, 2), (0, 0), np.array([1.0, 0, 0]), polygons[1], np.zeros(1), 0.0, ""),
        Interface((6, 2), (-1, -1), np.array([1.0, 0, 0]), polygons[2], np.zeros(3), 0.0, "bed", tie=True),
    ]
    arrays = InterfaceArrays.of(interfaces, 3)
    assert arrays.blocks.tolist() == [[1, 0], [5, 2], [6, 2]]
    assert [arrays.labels[k] for k in arrays.label] == ["bed", "", "bed"]
    assert arrays.tie.tolist() == [False, False, True]
    for k, polygon in enumerate(polygons):
        assert np.array_equal(arrays.corners[arrays.first[k] : arrays.first[k + 1]], polygon)
    assert InterfaceArrays.of([], 2).corners.shape == (0, 2)
