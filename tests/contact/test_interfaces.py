"""Interfaces as arrays and one by one, and numbers of equal rows."""

import numpy as np
import pytest

from masonry_fem.contact.contacts import Interface
from masonry_fem.contact.interfaces import Interfaces, among, numbered


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
    arrays = Interfaces.of(interfaces, 3)
    assert arrays.blocks.tolist() == [[1, 0], [5, 2], [6, 2]]
    assert [arrays.labels[k] for k in arrays.label] == ["bed", "", "bed"]
    assert arrays.tie.tolist() == [False, False, True]
    for k, polygon in enumerate(polygons):
        assert np.array_equal(arrays.corners[arrays.first[k] : arrays.first[k + 1]], polygon)
    assert Interfaces.of([], 2).corners.shape == (0, 2)


def test_pairs_among_others():
    pairs = np.array([[0, 1], [0, 12], [1, 2], [3, 4]])
    assert among(pairs, np.array([[1, 2], [0, 1], [2, 3]])).tolist() == [True, False, True, False]
    assert not among(pairs, np.empty((0, 2), dtype=np.int64)).any()
    assert len(among(np.empty((0, 2), dtype=np.int64), pairs)) == 0


def same(one: Interface, other: Interface) -> bool:
    """Whether two interfaces have the same numbers and words."""
    plain = (one.blocks, one.faces, one.area, one.label, one.tie)
    arrays = ((one.normal, other.normal), (one.polygon, other.polygon), (one.gap, other.gap))
    return plain == (other.blocks, other.faces, other.area, other.label, other.tie) and all(
        np.array_equal(a, b) for a, b in arrays
    )


def some() -> list[Interface]:
    """Interfaces of four, one, two and three corners, the third of them a tie."""
    rng = np.random.default_rng(5)
    corners, labels, blocks = (4, 1, 2, 3), ("bed", "", "chain", "bed"), ((3, 1), (0, 2), (1, 0), (1, 3))
    return [
        Interface(
            blocks=pair, faces=(-1, -1) if label == "chain" else (k, 2), normal=rng.normal(size=3),
            polygon=rng.normal(size=(count, 3)), gap=rng.normal(size=count), area=0.5 * k, label=label,
            tie=label == "chain",
        )
        for k, (count, label, pair) in enumerate(zip(corners, labels, blocks, strict=True))
    ]  # fmt: skip


def test_each_interface_is_what_the_arrays_were_made_of():
    given = some()
    made = Interfaces.of(given, 3)
    assert len(made) == 4
    assert Interfaces.of(made, 3) is made
    assert all(same(one, other) for one, other in zip(made, given, strict=True))
    assert same(made[-1], given[3])
    assert all(same(one, other) for one, other in zip(made[1:3], given[1:3], strict=True))
    with pytest.raises(IndexError):
        made[4]


def test_some_of_the_interfaces_stay_what_they_are():
    given = some()
    made = Interfaces.of(given, 3)
    assert [one.label for one in made.only(~made.tie)] == ["bed", "", "bed"]
    order = np.array([2, 0, 3, 3])
    assert all(same(one, given[k]) for one, k in zip(made.only(order), order, strict=True))
    assert len(made.only(np.zeros(4, dtype=bool))) == 0


def test_two_sets_of_interfaces_become_one_with_common_labels():
    given = some()
    parts = [Interfaces.of(given[2:], 3), Interfaces.of([], 3), Interfaces.of(given[:2], 3)]
    made = Interfaces.joined(parts)
    assert all(same(one, other) for one, other in zip(made, [*given[2:], *given[:2]], strict=True))
    assert made.labels == ("chain", "bed", "")


def test_pairs_labels_and_least_gaps_are_those_of_the_objects():
    given = some()
    made = Interfaces.of(given, 3)
    assert made.pairs.tolist() == [sorted(one.blocks) for one in given]
    assert made.label_of_each == [one.label for one in given]
    assert made.nearest.tolist() == [one.gap.min() for one in given]
    none = Interfaces.of([], 2)
    assert (none.pairs.shape, none.label_of_each, len(none.nearest), none.dimension) == ((0, 2), [], 0, 2)


def test_interfaces_move_with_motions_of_their_own():
    given = some()
    turn = np.array([[[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]] * 2 + [np.eye(3)] * 2)
    shift = np.arange(12.0).reshape(4, 3)
    made = Interfaces.of(given, 3).moved(turn, shift)
    for k, one in enumerate(made):
        assert one.normal == pytest.approx(turn[k] @ given[k].normal)
        assert one.polygon == pytest.approx(given[k].polygon @ turn[k].T + shift[k])
        assert np.array_equal(one.gap, given[k].gap)
