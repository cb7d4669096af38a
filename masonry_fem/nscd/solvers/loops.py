"""Loops: impulses that go round stones at a point that they share, so that no stone feels them.

Where a head joint ends on a bed joint, three stones have a point in common, and any two of them a contact
there. Impulses that go round add up to nothing on each stone: W_el and B leave them as they are, and nothing
but the contacts' own rows tells how large they are: the proximal weight, or that contacts slip. What solves
for one interface after the other knows nothing of that, and is wrong by orders of magnitude.

    places = Places(operator)                   # once for a problem
    loops = Loops(places, own, closed)          # once for a step
    impulse, rest = loops.taken(force)          # round the loops, and what that leaves of the rows

References
----------
Redundant constraints at points that several subdomains share: C. Farhat and F.-X. Roux, "A method of finite
element tearing and interconnecting and its parallel solution algorithm", International Journal for Numerical
Methods in Engineering 32 (1991). Solving for a space by itself before a preconditioner: J. M. Tang,
R. Nabben, C. Vuik and Y. A. Erlangga, "Comparison of two-level preconditioners derived from deflation, domain
decomposition and multigrid methods", Journal of Scientific Computing 39 (2009).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.nscd.compliance import Alike, Operator, Shared

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Difference of what two contacts at one point of a stone feel of a load, over the largest.
SAME = 1e-9


class Places:
    """Points of stones that contacts are at, where some of these may form a loop.

    Parameters
    ----------
    operator : W_el; stones are known where it is ``Shared``.

    Attributes
    ----------
    contacts : Those that may, shape (k,).
    ends : Point on each side, −1 where nothing there gives way, shape (k, 2).
    turns : What turns velocities from the axes of the stone there into the frame, shape (k, 2, d, d).
    """

    def __init__(self, operator: Operator) -> None:
        kinds = operator.kinds if isinstance(operator, Shared) else ()
        d = operator.blocksize[0]
        sides, points, turns = (
            [np.zeros(0, dtype=np.int64)],
            [np.zeros(0, dtype=np.int64)],
            [np.zeros((0, d, d))],
        )
        count = 0
        for kind in kinds:
            point = _points(kind)
            number = count + np.arange(len(kind.contacts))[:, None] * (point.max(initial=0) + 1) + point
            there = (kind.contacts >= 0) & (point >= 0)
            sides.append(kind.contacts[there])
            points.append(number[there])
            turns.append(kind.turns[there])
            count = int(number.max(initial=count - 1)) + 1
        side = np.concatenate(sides)
        order = np.argsort(side, kind="stable")
        side, second = side[order], np.zeros(len(order), dtype=np.int64)
        second[1:] = side[1:] == side[:-1]
        self.contacts, place = np.unique(side, return_inverse=True)
        self.ends = np.full((len(self.contacts), 2), -1)
        self.turns = np.zeros((len(self.contacts), 2, d, d))
        self.ends[place, second] = np.concatenate(points)[order]
        self.turns[place, second] = np.concatenate(turns)[order]
        meetings = Meetings(self.ends)
        some = meetings.loops[meetings.of_contact] > 0
        self.contacts, self.ends, self.turns = self.contacts[some], self.ends[some], self.turns[some]


def _points(kind: Alike) -> IntArray:
    """Number of the point of each contact of a kind, −1 where nothing gives way, shape (s,)."""
    s, d = kind.turns.shape[1:3]
    # what a load that is like no other moves: only contacts at one point feel it alike
    felt = (kind.matrix @ np.cos(np.arange(s * d))).reshape(s, d) @ np.cos(np.arange(d))
    order = np.argsort(felt, kind="stable")
    least = SAME * np.abs(felt).max(initial=0.0)
    point = np.empty(s, dtype=np.int64)
    point[order] = np.cumsum(np.diff(felt[order], prepend=felt[order[:1]]) > least)
    point[np.abs(kind.matrix.reshape(s, d, -1)).max(axis=(1, 2), initial=0.0) == 0] = -1
    return point


class Meetings:
    """Contacts sorted by where stones meet: those that are joined through points belong together.

    Parameters
    ----------
    ends : Points of the k contacts, shape (k, 2).

    Attributes
    ----------
    of_contact : Meeting of each contact, shape (k,).
    sizes : Contacts and points of each, shape (n, 2).
    anchored : Meetings at which a side gives way nowhere, shape (n,).
    loops : How many loops each has that are independent, shape (n,).
    place : Number of each contact's points within its meeting, −1 where there is none, shape (k, 2).
    """

    def __init__(self, ends: IntArray) -> None:
        point, number = np.unique(ends, return_inverse=True)
        number = number.reshape(ends.shape) - (len(point) > 0 and point[0] < 0)
        count = int(number.max(initial=-1)) + 1
        both = (number >= 0).all(axis=1)
        edges = (np.ones(both.sum()), tuple(number[both].T))
        n, of_point = connected_components(sparse.coo_array(edges, shape=(count, count)), directed=False)
        self.of_contact = of_point[number.max(axis=1)].astype(np.int64)
        points = np.bincount(of_point, minlength=n)
        self.sizes = np.stack([np.bincount(self.of_contact, minlength=n), points], axis=1)
        self.anchored = np.bincount(self.of_contact, weights=~both, minlength=n) > 0
        self.loops = self.sizes[:, 0] - points + ~self.anchored
        order = np.argsort(of_point, kind="stable")
        within = np.empty(count + 1, dtype=np.int64)
        within[order] = np.arange(count) - (np.cumsum(points) - points)[of_point[order]]
        within[-1] = -1
        self.place = within[number]


class Loops:
    """The loops of contacts that are closed.

    Parameters
    ----------
    places : Points that contacts are at.
    own : Derivative of each contact's row by its own impulse, shape (c, d, d).
    closed : Contacts that take part, shape (c,).
    before : Those of a step before: where the same contacts are closed they are kept.
    """

    def __init__(self, places: Places, own: FloatArray, closed: Mask, before: Loops | None = None) -> None:
        self._closed = closed[places.contacts]
        kept = before is not None and np.array_equal(before._closed, self._closed)
        self._spaces: list[tuple[IntArray, FloatArray]] = (
            before._spaces if before is not None and kept else list(_spaces(places, self._closed))
        )
        self._solved = []
        for contacts, space in self._spaces:
            rows = own[contacts]
            inverse = _inverted(space, rows)
            n, e, d = rows.shape[:3]
            product = (rows @ inverse.reshape(n, e, d, e * d)).reshape(inverse.shape)
            self._solved.append((contacts, inverse, product))

    def taken(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Impulses round the loops that solve the rows there, and what that leaves of the rows, both (c, d).

        Parameters
        ----------
        force : The rows, shape (c, d).
        """
        impulse, rest = np.zeros_like(force), force.copy()
        for contacts, inverse, product in self._solved:
            given = force[contacts].reshape(len(contacts), -1, 1)
            impulse[contacts] = (inverse @ given).reshape(*contacts.shape, -1)
            rest[contacts] -= (product @ given).reshape(*contacts.shape, -1)
        return impulse, rest


def _spaces(places: Places, closed: Mask) -> Iterator[tuple[IntArray, FloatArray]]:
    """Contacts (n, e) of n meetings that are alike, and impulses round their loops, shape (n, e d, l).

    Parameters
    ----------
    places : Points that contacts are at. closed : Those of its contacts that take part, shape (k,).
    """
    contacts, turns = places.contacts[closed], places.turns[closed]
    meetings = Meetings(places.ends[closed])
    order = np.argsort(meetings.of_contact, kind="stable")
    first = np.cumsum(meetings.sizes[:, 0]) - meetings.sizes[:, 0]
    looped = np.flatnonzero(meetings.loops > 0)
    alike = np.column_stack([meetings.sizes, meetings.anchored])[looped]
    for size, points, anchored in np.unique(alike, axis=0).tolist():
        chosen = looped[(alike == (size, points, anchored)).all(axis=1)]
        at = order[first[chosen][:, None] + np.arange(size)]
        yield contacts[at], _space(meetings.place[at], turns[at], points, bool(anchored))


def _space(place: IntArray, turns: FloatArray, points: int, anchored: bool) -> FloatArray:
    """Impulses that add up to nothing at the points of n meetings of e contacts, orthonormal, (n, e d, l).

    Parameters
    ----------
    place : Points of each contact within its meeting, −1 where there is none, shape (n, e, 2).
    turns : From the axes of their stones into the contacts' frames, shape (n, e, 2, d, d).
    points : How many each meeting has. anchored : Whether one of its sides is of nothing that gives way.
    """
    n, e, _, d = turns.shape[:4]
    summed: FloatArray = np.zeros((n, e, d, points + 1, d))  # the last is that of sides without a point
    index, contact = np.arange(n)[:, None], np.arange(e)
    for side in range(2):
        summed[index, contact, :, place[:, :, side]] += turns[:, :, side]
    # without a support the sum at one of the points follows from the others
    sums = summed[:, :, :, : points if anchored else points - 1].reshape(n, e * d, -1)
    space: FloatArray = np.linalg.qr(sums, mode="complete")[0][:, :, sums.shape[2] :]
    return space


def _inverted(space: FloatArray, own: FloatArray) -> FloatArray:
    """What solves the contacts' own rows within a space, shape (n, e d, e d).

    Parameters
    ----------
    space : Shape (n, e d, l). own : The blocks of the rows, shape (n, e, d, d).
    """
    n, e, d = own.shape[:3]
    rows = (own @ space.reshape(n, e, d, -1)).reshape(space.shape)
    back = space.swapaxes(1, 2)
    inverse: FloatArray = space @ np.linalg.solve(back @ rows, back)
    return inverse
