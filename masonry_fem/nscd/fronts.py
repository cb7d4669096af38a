"""Fronts: sparse LU of a matrix made of dense blocks, by elimination of whole groups of unknowns.

The unknowns come in *groups* (the contacts of one interface, the velocities of one body). A group
is eliminated at once, as a dense *front*: its own rows and columns bordered by those that are still
to come. All arithmetic is LAPACK's and BLAS's on fronts, which is what the contact problem of
deformable blocks needs: the interfaces of one block are coupled densely, two blocks only through
their interface.

    order = eliminate_order(neighbours, sizes, after)      # once for a pattern
    plan = FrontPlan(matrix, groups, order)                # once for the entries that are stored
    factor = FrontFactor(plan, matrix.data)                # as often as the values change
    x = factor.solve(rhs)
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import blas, lapack

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A pivot below this fraction of its front's largest entry is replaced by it: the solution then
# grows instead of overflowing, and the caller sees a singular matrix in the size of the answer.
TINY_PIVOT = 1e-15
# Fronts with fewer own unknowns than this are joined with their parent when that fills little.
JOIN_BELOW = 48
JOIN_FILL = 1.3


@dataclass(frozen=True, slots=True)
class Elimination:
    """Order of elimination of groups, joined to fronts.

    Attributes
    ----------
    fronts : Groups eliminated by each front, in order.
    borders : Groups that each front's elimination touches, still to be eliminated.
    parents : Front that takes each front's remainder, −1 at a root.
    """

    fronts: tuple[IntArray, ...]
    borders: tuple[IntArray, ...]
    parents: tuple[int, ...]


def eliminate_order(neighbours: list[set[int]], sizes: IntArray, after: list[set[int]]) -> Elimination:
    """Minimum-degree order of groups.

    Parameters
    ----------
    neighbours : Groups coupled with each group (not itself); symmetric. Consumed.
    sizes : Unknowns of each group, shape (n,).
    after : Groups that must be eliminated before each group (its pivots come from them).
    """
    count = len(neighbours)
    size = [int(s) for s in sizes]
    degree = [sum(size[j] for j in neighbours[i]) for i in range(count)]
    waiting = [len(first) for first in after]
    releases: list[list[int]] = [[] for _ in range(count)]
    for group, first in enumerate(after):
        for other in first:
            releases[other].append(group)
    buckets = _Queue()
    for group in range(count):
        if not waiting[group]:
            buckets.put(degree[group], group)
    order: list[int] = []
    borders: list[list[int]] = []
    done = [False] * count
    while len(order) < count:
        group = buckets.take(degree, done)
        border = neighbours[group]
        done[group] = True
        order.append(group)
        borders.append(sorted(border))
        for other in border:
            near = neighbours[other]
            near |= border
            near.discard(other)
            near.discard(group)
            degree[other] = sum([size[j] for j in near])
            if not waiting[other]:
                buckets.put(degree[other], other)
        neighbours[group] = set()
        for other in releases[group]:
            waiting[other] -= 1
            if not waiting[other]:
                buckets.put(degree[other], other)
    return _join(order, borders, size)


class _Queue:
    """Groups by degree; stale entries are skipped when taken. Ties go to the lowest number."""

    def __init__(self) -> None:
        self.heap: list[tuple[int, int]] = []

    def put(self, degree: int, group: int) -> None:
        heapq.heappush(self.heap, (degree, group))

    def take(self, degree: list[int], done: list[bool]) -> int:
        while True:
            value, group = heapq.heappop(self.heap)
            if not done[group] and value == degree[group]:
                return group


def _join(order: list[int], borders: list[list[int]], size: list[int]) -> Elimination:
    """Merge small fronts with their parents where that stores few explicit zeros."""
    place = {group: i for i, group in enumerate(order)}
    count = len(order)
    parent = [min((place[g] for g in border), default=-1) for border in borders]
    own = [[group] for group in order]
    weight = [size[group] for group in order]
    border_weight = [sum(size[g] for g in border) for border in borders]
    into = list(range(count))
    stored = [w * (w + 2 * b) for w, b in zip(weight, border_weight, strict=True)]
    for i in range(count):
        p = parent[i]
        if p < 0:
            continue
        joined = weight[i] + weight[p]
        cost = joined * (joined + 2 * border_weight[p])
        if (weight[i] < JOIN_BELOW and cost <= JOIN_FILL * (stored[i] + stored[p])) or (
            border_weight[i] == weight[p] + border_weight[p]
        ):
            own[p] = own[i] + own[p]
            own[i] = []
            weight[p], stored[p], into[i] = joined, cost, p
    for i in range(count - 1, -1, -1):
        into[i] = i if into[i] == i else into[into[i]]
    kept = [i for i in range(count) if own[i]]
    number = {i: k for k, i in enumerate(kept)}
    ranked = [sorted(borders[i], key=place.__getitem__) for i in kept]
    return Elimination(
        tuple(np.array(own[i]) for i in kept),
        tuple(np.array(border, dtype=np.int64) for border in ranked),
        tuple(number[into[parent[i]]] if parent[i] >= 0 else -1 for i in kept),
    )


class FrontPlan:
    """Where the entries of a matrix go: made once for a pattern, for factors of any values.

    Parameters
    ----------
    matrix : Square, structurally within the pattern that the order was made for; its values do not matter.
    groups : Group of each unknown, shape (n,).
    elimination : From ``eliminate_order``.
    """

    def __init__(self, matrix: sparse.csr_array, groups: IntArray, elimination: Elimination) -> None:
        count = int(sum(len(f) for f in elimination.fronts))
        sequence = np.concatenate([*elimination.fronts, np.zeros(0, np.int64)]).astype(np.int64)
        rank = np.empty(count, np.int64)
        rank[sequence] = np.arange(count)
        self.order = np.argsort(rank[groups], kind="stable")
        sizes = np.bincount(rank[groups], minlength=count)
        stops = np.cumsum(sizes)
        place = np.empty(len(self.order), np.int64)
        place[self.order] = np.arange(len(self.order))
        # the entries are followed by their numbers
        numbers = (np.arange(matrix.nnz), matrix.indices, matrix.indptr)
        rows = sparse.csr_array(numbers, shape=matrix.shape)[self.order]
        # relabelled columns stay unsorted: fronts scatter them anyway
        rows.indices = place[rows.indices].astype(rows.indices.dtype)
        self.fronts = _plan_fronts(rows, elimination, rank, stops - sizes, stops)


@dataclass(frozen=True, slots=True)
class _Front:
    """One dense front: unknowns, and what is written into it.

    Attributes
    ----------
    own, border : Unknowns that it eliminates, and those that it touches, in elimination order.
    entries, target : Matrix entries that go into it, and their flat places (column by column).
    parent : Front that takes its remainder, −1 at a root.
    inside : Places of its border in the parent, shape (border,).
    """

    own: slice
    border: IntArray
    entries: IntArray
    target: IntArray
    parent: int
    inside: IntArray


def _plan_fronts(
    rows: sparse.csr_array, elimination: Elimination, rank: IntArray, starts: IntArray, stops: IntArray
) -> list[_Front]:
    columns = rows.tocsc()
    place = np.zeros(rows.shape[0], np.int64)  # of an unknown within a front
    owns, borders = [], []
    for groups, border_groups in zip(elimination.fronts, elimination.borders, strict=True):
        owns.append((int(starts[rank[groups[0]]]), int(stops[rank[groups[-1]]])))
        borders.append(_ranges(starts[rank[border_groups]], stops[rank[border_groups]]))
    number, kept = np.full(len(owns) + 1, -1), 0
    for index, (first, last) in enumerate(owns):
        if last > first or len(borders[index]):
            number[index] = kept
            kept += 1
    fronts = []
    for index, ((first, last), border) in enumerate(zip(owns, borders, strict=True)):
        if number[index] < 0:
            continue  # a group without unknowns
        k, m = last - first, last - first + len(border)
        place[first:last] = np.arange(k)
        place[border] = np.arange(k, m)
        row, column, entry = _entries(rows, first, last)
        other_column, other_row, other_entry = _entries(columns, first, last)
        below = other_row >= last  # the square of own unknowns came with the rows
        target = np.concatenate(
            [place[row] + m * place[column], place[other_row[below]] + m * place[other_column[below]]]
        )
        parent = elimination.parents[index]
        inside = border
        if parent >= 0:
            start, stop = owns[parent]
            beyond = np.searchsorted(borders[parent], border) + stop - start
            inside = np.where(border < stop, border - start, beyond)
        fronts.append(
            _Front(
                slice(first, last), border, np.concatenate([entry, other_entry[below]]), target,
                int(number[parent]), inside,
            )
        )  # fmt: skip
    return fronts


def _entries(
    compressed: sparse.csr_array | sparse.csc_array, first: int, last: int
) -> tuple[IntArray, IntArray, IntArray]:
    """Rows, columns and numbers of the entries of some rows, without those left of the first.

    Of a matrix that is compressed by columns: columns, rows and numbers.
    """
    begin, end = compressed.indptr[first], compressed.indptr[last]
    other = compressed.indices[begin:end].astype(np.int64)
    own = np.repeat(np.arange(first, last), np.diff(compressed.indptr[first : last + 1]))
    keep = other >= first
    return own[keep], other[keep], compressed.data[begin:end][keep]


class FrontFactor:
    """LU factor of a square matrix, eliminated front by front.

    Parameters
    ----------
    plan : Made for the matrix's pattern.
    values : Its entries in the order of that matrix, shape (nnz,).
    """

    def __init__(self, plan: FrontPlan, values: FloatArray) -> None:
        from masonry_fem.nscd.scatter import extend_add  # noqa: PLC0415 - Numba is slow to import

        self.plan = plan
        self.small_pivots = 0
        self._factors: list[tuple[FloatArray, IntArray, FloatArray, FloatArray]] = []
        remainders: list[list[tuple[IntArray, FloatArray]]] = [[] for _ in plan.fronts]
        for index, front in enumerate(plan.fronts):
            k = front.own.stop - front.own.start
            m = k + len(front.border)
            dense = np.zeros((m, m), order="F")
            dense.T.reshape(-1)[front.target] = values[front.entries]
            for inside, remainder in remainders[index]:
                extend_add(dense, inside, remainder)
            remainders[index] = []
            factor, remainder = self._factorise(dense, k)
            self._factors.append(factor)
            if front.parent >= 0:
                remainders[front.parent].append((front.inside, remainder))

    def _factorise(
        self, front: FloatArray, k: int
    ) -> tuple[tuple[FloatArray, IntArray, FloatArray, FloatArray], FloatArray]:
        if k == 0:
            empty = np.zeros((0, 0), order="F")
            return (empty, np.zeros(0, np.int32), front[:k, k:], front[k:, :k]), front
        scale = np.abs(front[:k, :k]).max()
        lu, pivots, _ = lapack.dgetrf(front[:k, :k])
        diagonal = np.diagonal(lu)
        small = np.abs(diagonal) <= TINY_PIVOT * scale
        if small.any():
            self.small_pivots += int(small.sum())
            where = np.nonzero(small)[0]
            lu[where, where] = np.where(diagonal[small] < 0, -1, 1) * max(TINY_PIVOT * scale, 1e-300)
        swaps = row_order(pivots)
        upper = blas.dtrsm(1.0, lu, front[swaps, k:], lower=1, diag=1)
        lower = blas.dtrsm(1.0, lu, front[k:, :k], side=1)
        remainder = blas.dgemm(-1.0, lower, upper, beta=1.0, c=front[k:, k:]) if len(lower) else front[k:, k:]
        return (lu, swaps, upper, lower), remainder

    def sign(self) -> int:
        """Sign of the determinant, 1 or -1."""
        total = 1
        for lu, swaps, _, _ in self._factors:
            total *= determinant_sign(lu, swaps)
        return total

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution of matrix @ x = rhs, shape (n,)."""
        order, fronts = self.plan.order, self.plan.fronts
        x = rhs[order].astype(float)
        for front, (lu, swaps, _, lower) in zip(fronts, self._factors, strict=True):
            own, border = front.own, front.border
            part = blas.dtrsv(lu, x[own][swaps], lower=1, diag=1) if len(lu) else x[own]
            x[own] = part
            if len(border):
                x[border] -= lower @ part
        for front, (lu, _, upper, _) in zip(reversed(fronts), reversed(self._factors), strict=True):
            if len(lu):
                x[front.own] = blas.dtrsv(lu, x[front.own] - upper @ x[front.border])
        result = np.empty_like(x)
        result[order] = x
        return result


def determinant_sign(lu: FloatArray, order: NDArray[np.integer]) -> int:
    """Sign of a determinant from its factor and the order that its rows were taken in.

    Parameters
    ----------
    lu : Factor, L without its unit diagonal below U, shape (n, n).
    order : Row of the matrix that stands in each row of the factor, shape (n,).
    """
    negative = bool((np.diagonal(lu) < 0).sum() % 2)
    left, even = order.tolist(), True
    for place in range(len(left)):
        while left[place] != place:
            other = left[place]
            left[place], left[other] = left[other], other
            even = not even
    return -1 if negative == even else 1


def _ranges(starts: IntArray, stops: IntArray) -> IntArray:
    """The integers of several half-open ranges, one after the other."""
    lengths = stops - starts
    total = int(lengths.sum())
    jump = np.repeat(starts - np.r_[0, np.cumsum(lengths)[:-1]], lengths) if total else np.zeros(0, np.int64)
    return np.arange(total) + jump


def row_order(pivots: NDArray[np.integer]) -> IntArray:
    """Row order that LAPACK's successive swaps make."""
    order = np.arange(len(pivots))
    for i, j in enumerate(pivots.tolist()):
        if i != j:
            order[i], order[j] = order[j], order[i]
    return order
