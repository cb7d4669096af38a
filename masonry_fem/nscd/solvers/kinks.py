"""Kinks: where a straight path through the pieces of a plane contact problem bends.

A path R(x) = t r is straight within a piece. At the edge of a piece one contact opens, closes, sticks or
slides, and the derivative changes by a matrix of rank one: the new direction costs one solution with a
factor that is there already. Where the determinant changes its sign, the path turns back in t.

    walk = Walk(piece, target, t, forwards)
    walk.cross()                               # to the next kink and into the piece behind it
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled
from masonry_fem.nscd.solvers.normal_map import Piece

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

OPEN, STICK, PLUS, MINUS = range(4)
# Share of its neighbours' determinant below which an update hides a piece's in rounding: a new factor is due.
SINGULAR = 1e-9


class Walk:
    """The way along a path from within a piece, kink by kink.

    Parameters
    ----------
    piece : Where it starts.
    target : r, shape (c, 2).
    t : R = t r at the start.
    forwards : True where t falls along the path.

    Attributes
    ----------
    x, t, forwards : Where it is, shape (c, 2), and which way it goes on.
    endless : True where the path leads away, and no kink lies ahead.
    unsure : True behind a kink where rounding hides which way the path goes on: a new factor is needed.
    """

    def __init__(self, piece: Piece, target: FloatArray, t: float, *, forwards: bool) -> None:
        self.piece = piece
        self.x, self.t, self.forwards = piece.x.copy(), t, forwards
        self.endless = self.unsure = False
        self._friction = piece.equation.problem.friction
        self._status = statuses(piece.x, self._friction)
        self._direction = piece.change(target)
        if not forwards:
            self._direction *= -1.0
        self._crossed: list[tuple[int, FloatArray, FloatArray]] = []

    def cross(self) -> None:
        """Go to the next kink and turn into the piece behind it; to t = 0 where no kink comes before."""
        length, contact, status = next_kink(self.x, self._direction, self._status, self._friction)
        if self.forwards and length >= self.t:
            self.x, self.t = self.x + self.t * self._direction, 0.0
            return
        if contact < 0:
            self.endless = True
            return
        self._go(length)
        push, by = _edge(self._status[contact], status, self._friction[contact])
        self._status[contact] = status
        answer = self.piece.response(contact, push)
        for other, slope, change in self._crossed:
            answer += (slope @ answer[other]) * change
        ratio = 1.0 - by @ answer[contact]  # of the determinants after and before
        if not abs(ratio) > SINGULAR:
            self.unsure = True
            return
        answer /= ratio
        self._crossed.append((contact, by, answer))
        self._direction = self._direction + (by @ self._direction[contact]) * answer
        if ratio < 0:
            self.forwards = not self.forwards
            self._direction *= -1.0

    def step_inside(self) -> None:
        """Go on halfway to the next kink: away from the edge it is plain which piece x lies in."""
        length = next_kink(self.x, self._direction, self._status, self._friction)[0]
        self._go(0.5 * min(length, self.t if self.forwards else 1.0))

    def _go(self, length: float) -> None:
        self.x = self.x + length * self._direction
        self.t += -length if self.forwards else length


def _edge(before: int, after: int, friction: float) -> tuple[FloatArray, FloatArray]:
    """The change of ∂p/∂x from one status to the next, as a product of two vectors (2,)."""
    change = _slope(after, friction) - _slope(before, friction)
    if change[0, 0] != 0:
        return change[:, 0], np.array([1.0, 0.0])
    return np.array([0.0, 1.0]), change[1]


def _slope(status: int, friction: float) -> FloatArray:
    """∂p/∂x of a contact, shape (2, 2)."""
    if status == OPEN:
        return np.zeros((2, 2))
    if status == STICK:
        return np.eye(2)
    return np.array([[1.0, 0.0], [friction if status == PLUS else -friction, 0.0]])


@compiled
def statuses(x: FloatArray, friction: FloatArray) -> IntArray:
    """Who is open, sticks, or slides which way, shape (c,)."""
    status = np.zeros(len(x), np.int64)
    for contact in range(len(x)):
        normal, tangent = x[contact]
        if normal < 0:
            continue
        if abs(tangent) <= friction[contact] * normal:
            status[contact] = STICK
        else:
            status[contact] = PLUS if tangent > 0 else MINUS
    return status


@compiled
def next_kink(
    x: FloatArray, direction: FloatArray, status: IntArray, friction: FloatArray
) -> tuple[float, int, int]:
    """Length to the first change of a status, its contact and the new one; infinite and -1 without one."""
    least, who, new = np.inf, -1, -1
    for contact in range(len(x)):
        normal, tangent = x[contact]
        by_normal, by_tangent = direction[contact]
        if status[contact] == OPEN:
            length, to = _closing(normal, tangent, by_normal, by_tangent)
        else:
            length, to = _changing(normal, tangent, by_normal, by_tangent, status[contact], friction[contact])
        if length < least:
            least, who, new = length, contact, to
    return least, who, new


@compiled(inline="always")
def _closing(normal: float, tangent: float, by_normal: float, by_tangent: float) -> tuple[float, int]:
    """Length after which an open contact closes, and which way it slides then."""
    if by_normal <= 0:
        return np.inf, OPEN
    length = max(-normal, 0.0) / by_normal
    return length, PLUS if tangent + length * by_tangent > 0 else MINUS


@compiled(inline="always")
def _changing(
    normal: float, tangent: float, by_normal: float, by_tangent: float, now: int, rough: float
) -> tuple[float, int]:
    """Length after which a closed contact opens, sticks or slides, and what it does then."""
    least, new = np.inf, now
    if now != STICK and by_normal < 0:
        least, new = max(normal, 0.0) / -by_normal, OPEN
    for side in (PLUS, MINUS):
        if now not in (STICK, side):
            continue
        sense = 1.0 if side == PLUS else -1.0
        beyond = sense * tangent - rough * normal  # of the cone's edge
        by_beyond = sense * by_tangent - rough * by_normal
        if now == STICK:
            beyond, by_beyond = -beyond, -by_beyond
        if by_beyond < 0:
            length = max(beyond, 0.0) / -by_beyond
            if length < least:
                least, new = length, side if now == STICK else STICK
    return least, new
