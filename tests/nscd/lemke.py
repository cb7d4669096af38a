"""Lemke's method: 0 ≤ z ⊥ M z + q ≥ 0 by complementary pivots, exact but for rounding.

    tableau = Lemke(M, q)
    while tableau.verdict is None: tableau.pivot()
    z = tableau.solution()                   # where the verdict is "solved"

Ties are broken lexicographically, so that no basis comes twice and degenerate problems, which
hyperstatic masonry always makes, end. Where M is copositive the method ends in a solution, or on a
secondary ray; a ray then means that there is none, unless q is special (Cottle, Pang and Stone, "The
linear complementarity problem", 1992, section 4.4).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, lapack

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Entries of the tableau below this are rounding, and so are differences of ratios.
TINY = 1e-12
SAME = 1e-10
# Of the largest variable: an artificial one that is smaller has left but for rounding.
NOTHING = 1e-13
# Exchanges by small pivots amplify rounding. Every LOOK pivots the right-hand side is held against M and q;
# where it has strayed by more than this the tableau is made anew.
LOOK = 10
STRAYED = 1e-12


class Lemke:
    """The dictionary of a problem: basic variables = right-hand side + columns · nonbasic variables.

    Variables are numbered: w = M z + q from 0, z from n, the artificial one 2 n.

    Parameters
    ----------
    M : Square, shape (n, n), entries of the size of 1. q : Shape (n,).
    """

    def __init__(self, M: FloatArray, q: FloatArray) -> None:
        n = len(q)
        self.M, self.q = M, q
        self.columns = np.asfortranarray(np.column_stack([M, np.ones(n)]))
        self.right = q.astype(float)
        self.basic = np.arange(n)
        self.free = np.arange(n, 2 * n + 1)
        # column of each w, −1 while it is basic, and its row
        self.column_of = np.full(2 * n + 1, -1)
        self.column_of[self.free] = np.arange(n + 1)
        self.pivots = 0
        self.verdict: Literal["solved", "ray"] | None = "solved" if (q >= 0).all() else None
        self.entering = 2 * n

    def pivot(self) -> None:
        """One complementary pivot; sets the verdict where it is the last."""
        n = len(self.q)
        if self.pivots % LOOK == 0 and self._strayed() > STRAYED:
            self._remake()
        column = int(self.column_of[self.entering])
        rates = self.columns[:, column]
        row = self._first() if self.pivots == 0 else self._blocking(rates)
        if row < 0:
            left = float(self.right[self.basic == 2 * n].max(initial=0.0))
            self.verdict = "solved" if left <= NOTHING * float(self.right.max()) else "ray"
            return
        leaving = int(self.basic[row])
        self._exchange(row, column)
        self.pivots += 1
        if leaving == 2 * n:
            self.verdict = "solved"
            return
        self.entering = leaving + n if leaving < n else leaving - n

    @property
    def chosen(self) -> NDArray[np.bool_]:
        """True for the z that are basic, shape (n,)."""
        n = len(self.q)
        chosen = np.zeros(n, dtype=bool)
        chosen[self.basic[(self.basic >= n) & (self.basic < 2 * n)] - n] = True
        return chosen

    def solution(self) -> FloatArray:
        """The z of the basis, solved for anew from M and q, shape (n,); the verdict is "solved"."""
        n = len(self.q)
        z, chosen = np.zeros(n), self.chosen
        rows = np.ones(n, dtype=bool)  # where w is not basic, it vanishes
        rows[self.basic[self.basic < n]] = False
        if chosen.any():
            # there is a row too many where the artificial variable stayed, at zero
            z[chosen] = np.linalg.lstsq(self.M[np.ix_(rows, chosen)], -self.q[rows])[0]
        return z

    def _first(self) -> int:
        """Row of the most negative q: the artificial variable takes its place."""
        low = np.flatnonzero(self.right <= self.right.min() + SAME)
        # all artificial rates are 1: lexicographically last among the lowest
        return int(low[-1])

    def _blocking(self, rates: FloatArray) -> int:
        """Row that first falls to zero as the entering variable grows, −1 where none does."""
        falling = np.flatnonzero(rates < -TINY * max(1.0, float(np.abs(rates).max())))
        if not len(falling):
            return -1
        speed = -rates[falling]
        ratio = np.maximum(self.right[falling], 0.0) / speed
        rows = falling[ratio <= ratio.min() + SAME * max(1.0, float(ratio.min()))]
        if len(rows) == 1:
            return int(rows[0])
        artificial = rows[self.basic[rows] == 2 * len(self.q)]
        if len(artificial):
            return int(artificial[0])
        return self._first_of(rows, rates)

    def _first_of(self, rows: IntArray, rates: FloatArray) -> int:
        """Of rows that fall to zero together the lexicographically first, by the basis's inverse."""
        n = len(self.q)
        place = self.column_of[:n]
        inverse = -self.columns[rows[:, None], np.maximum(place, 0)]
        inverse[:, place < 0] = self.basic[rows][:, None] == np.flatnonzero(place < 0)
        inverse /= -rates[rows][:, None]
        while len(rows) > 1:
            lowest = inverse.min(axis=0)
            spread = inverse.max(axis=0) - lowest > SAME * np.maximum(1.0, np.abs(lowest))
            if not spread.any():
                break
            first = int(spread.argmax())  # what came before is the same in all
            kept = inverse[:, first] <= lowest[first] + SAME * max(1.0, abs(float(lowest[first])))
            rows, inverse = rows[kept], inverse[kept, first + 1 :]
            if not inverse.shape[1]:
                break
        return int(rows[0])

    def _strayed(self) -> float:
        """How far the right-hand side is from w − M z − z_0 = q, over its largest entry."""
        n = len(self.q)
        values = np.zeros(2 * n + 1)
        values[self.basic] = self.right
        left = values[:n] - self.M @ values[n : 2 * n] - values[2 * n] - self.q
        return float(np.abs(left).max() / max(1.0, np.abs(self.right).max()))

    def _remake(self) -> None:
        """The tableau of its basis, from M and q: w − M z − z_0 = q solved for the basic variables."""
        n = len(self.q)
        matrix = np.column_stack([np.eye(n), -self.M, -np.ones(n)])
        factor, pivots, singular = lapack.dgetrf(matrix[:, self.basic])
        if singular:  # rounding chose a basis that is none; the tableau knows no better
            return
        given = np.column_stack([-matrix[:, self.free], self.q])
        made = lapack.dgetrs(factor, pivots, given)[0]
        made += lapack.dgetrs(factor, pivots, given - matrix[:, self.basic] @ made)[0]
        self.columns, self.right = np.asfortranarray(made[:, :-1]), np.maximum(made[:, -1], 0.0)

    def _exchange(self, row: int, column: int) -> None:
        """Swap the basic variable of a row with the nonbasic one of a column."""
        inverse = 1.0 / self.columns[row, column]
        line = -inverse * self.columns[row]
        line[column] = inverse
        right = -inverse * self.right[row]
        rates = self.columns[:, column].copy()
        self.columns[:, column] = 0.0
        self.columns = blas.dger(1.0, rates, line, a=self.columns, overwrite_a=1)
        self.right += rates * right
        self.columns[row], self.right[row] = line, max(right, 0.0)
        leaving, entering = self.basic[row], self.free[column]
        self.basic[row], self.free[column] = entering, leaving
        self.column_of[entering], self.column_of[leaving] = -1, column
