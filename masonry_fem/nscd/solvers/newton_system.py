"""NewtonSystem: the linear system of one Newton step in split form, with all that can go eliminated.

With A = ∂F/∂p, Bc = ∂F/∂v of the Alart–Curnier function and α w the proximal weight (formulation 2b):

    [ A + Bc (W_el + α w)   Bc B ] [dp]     [ F                         ]
    [ Bᵀ                    −M   ] [dU] = − [ Bᵀ p + f_r − M_r (U − U_0) ]

Open contacts leave it exactly (dp = −p). Contacts without compliance are eliminated one by one, and
what is left of them couples the velocities of their two bodies: rigid scenes are solved in U alone.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.fronts import Elimination, eliminate_order
from masonry_fem.nscd.linear import Library, factorise
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.linearisation import Linearisation

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


class NewtonSystem:
    """What does not change between the Newton steps of one problem.

    Parameters
    ----------
    problem : The contact problem.
    scale : w of each contact, shape (c,).
    library : Linear factor, see ``linear``.
    """

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        self.problem = problem
        self.scale = scale
        self.library = library
        self.unit = float(scale.mean()) if len(scale) else 1.0  # impulses are solved for as unit · p
        compliance = problem.compliance
        self.rows = block_rows(compliance)
        self.elastic = np.zeros(problem.count, dtype=bool)
        self.elastic[self.rows] = True
        self.contact, self.side = np.nonzero(problem.bodies >= 0)
        self.body = problem.bodies[self.contact, self.side]
        self.map = problem.rigid_map[self.contact, self.side]
        total = np.zeros_like(problem.rigid_mass)
        np.add.at(total, self.body, (self.map**2).sum(axis=1))
        self.column = np.sqrt(np.where(total > 0, total, 1.0))  # lengths of the columns of B, (b, m)
        self.scaled_map = self.map / self.column[self.body][:, None, :]

    @cached_property
    def order(self) -> tuple[IntArray, int, Elimination]:
        """Group of each contact, number of groups, and their elimination.

        Made at the first step: a warm start that already holds never needs it.
        """
        return _order(self.problem, self.rows, self.elastic)

    def solve(
        self, line: Linearisation, impulse: FloatArray, balance: FloatArray, mass: FloatArray, alpha: float
    ) -> tuple[FloatArray, FloatArray]:
        """One Newton step (dp, dU), shapes (c, d) and (b, m).

        Parameters
        ----------
        line : The contact function at p, v + α w (p − p_k).
        impulse : p, shape (c, d).
        balance : Bᵀ p + f_r − M (U − centre), shape (b, m).
        mass : M with the proximal mass, shape (b, m).
        alpha : Proximal weight, relative to w.
        """
        step = np.where(line.open[:, None], -impulse, 0.0)
        shift = (line.by_velocity @ self.problem.elastic_velocity(step)[:, :, None])[:, :, 0]
        force = line.residual / line.rho[:, None] + shift  # in velocities
        balance = balance + self.problem.body_impulse(step)
        closed = ~line.open
        kept = np.flatnonzero(closed & self.elastic)
        gone = np.flatnonzero(closed & ~self.elastic)
        slope, offset = self._eliminated(line, gone, force, alpha)
        reduced = np.zeros_like(step)
        reduced[gone] = offset
        balance = balance - self.problem.body_impulse(reduced)

        count, d = len(kept), step.shape[1]
        matrix = self._matrix(line, kept, gone, slope, mass, alpha)
        rhs = np.concatenate([-force[kept].ravel(), (-self.unit * balance / self.column).ravel()])
        group, bodies, elimination = self.order
        groups = np.concatenate(
            [np.repeat(group[kept], d), np.repeat(bodies + np.arange(len(mass)), mass.shape[1])]
        )
        answer = factorise(matrix, groups, elimination, self.library)(rhs)
        step[kept] = answer[: count * d].reshape(count, d) / self.unit
        motion = answer[count * d :].reshape(mass.shape) / self.column
        moved = self.problem.contact_velocity(motion)[gone]
        step[gone] = -offset - (slope @ moved[:, :, None])[:, :, 0]
        return step, motion

    def _eliminated(
        self, line: Linearisation, gone: IntArray, force: FloatArray, alpha: float
    ) -> tuple[FloatArray, FloatArray]:
        """D⁻¹ Bc and D⁻¹ F, D = A + α w Bc, of closed contacts without compliance."""
        by_velocity = line.by_velocity[gone]
        D = line.by_impulse[gone] / line.rho[gone, None, None]
        D = D + (alpha * self.scale[gone])[:, None, None] * by_velocity
        return np.linalg.solve(D, by_velocity), np.linalg.solve(D, force[gone][:, :, None])[:, :, 0]

    def _matrix(
        self,
        line: Linearisation,
        kept: IntArray,
        gone: IntArray,
        slope: FloatArray,
        mass: FloatArray,
        alpha: float,
    ) -> sparse.csr_array:
        d, m = self.problem.dimension, mass.shape[1]
        entries = _Entries()
        first = len(kept) * d
        place = np.full(self.problem.count, -1)
        place[kept] = np.arange(len(kept))
        if len(kept):
            compliance = self.problem.compliance
            inside = (place[self.rows] >= 0) & (place[compliance.indices] >= 0)
            rows, columns = self.rows[inside], compliance.indices[inside]
            blocks = compliance.data[inside] / self.unit
            turned = np.flatnonzero(~line.plain[rows])
            blocks[turned] = line.by_velocity[rows[turned]] @ blocks[turned]
            entries.add(d * place[rows], d * place[columns], blocks)
            own = line.by_impulse[kept] / line.rho[kept, None, None]
            own = own + (alpha * self.scale[kept])[:, None, None] * line.by_velocity[kept]
            entries.add(d * place[kept], d * place[kept], own / self.unit)
            sides = np.flatnonzero(place[self.contact] >= 0)
            at, body, map_ = place[self.contact[sides]], self.body[sides], self.scaled_map[sides]
            entries.add(d * at, first + m * body, line.by_velocity[self.contact[sides]] @ map_)
            entries.add(first + m * body, d * at, map_.transpose(0, 2, 1))
        self._couple_bodies(entries, first, gone, slope)
        diagonal = np.zeros((len(mass), m, m))
        diagonal[:, np.arange(m), np.arange(m)] = -self.unit * mass / self.column**2
        bodies = np.arange(len(mass))
        entries.add(first + m * bodies, first + m * bodies, diagonal)
        return entries.matrix(first + mass.size)

    def _couple_bodies(self, entries: _Entries, first: int, gone: IntArray, slope: FloatArray) -> None:
        """−Bᵀ D⁻¹ Bc B of the eliminated contacts, between the bodies on their two sides."""
        bodies, m = self.problem.bodies[gone], self.problem.rigid_mass.shape[1]
        maps = self.problem.rigid_map[gone]
        for one in range(2):
            for two in range(2):
                pick = np.flatnonzero((bodies[:, one] >= 0) & (bodies[:, two] >= 0))
                a, b = bodies[pick, one], bodies[pick, two]
                left = (maps[pick, one] / self.column[a][:, None, :]).transpose(0, 2, 1)
                right = maps[pick, two] / self.column[b][:, None, :]
                entries.add(first + m * a, first + m * b, -self.unit * (left @ slope[pick] @ right))


def block_rows(matrix: sparse.bsr_array) -> IntArray:
    """Block row of each stored block, shape (stored,)."""
    rows: IntArray = np.repeat(np.arange(len(matrix.indptr) - 1, dtype=np.int64), np.diff(matrix.indptr))
    return rows


class _Entries:
    """Dense blocks at (row, column) of their first entries, summed to a matrix."""

    def __init__(self) -> None:
        self.rows: list[IntArray] = []
        self.columns: list[IntArray] = []
        self.values: list[FloatArray] = []

    def add(self, rows: IntArray, columns: IntArray, blocks: FloatArray) -> None:
        height, width = np.arange(blocks.shape[1])[:, None], np.arange(blocks.shape[2])
        shape = blocks.shape
        self.rows.append(np.broadcast_to(rows[:, None, None] + height, shape).ravel())
        self.columns.append(np.broadcast_to(columns[:, None, None] + width, shape).ravel())
        self.values.append(blocks.ravel())

    def matrix(self, size: int) -> sparse.csr_array:
        where = (np.concatenate(self.rows), np.concatenate(self.columns))
        return sparse.coo_array((np.concatenate(self.values), where), shape=(size, size)).tocsr()


def _order(problem: ContactProblem, rows: IntArray, elastic: Mask) -> tuple[IntArray, int, Elimination]:
    """Group of each contact (those between the same two bodies), their number, and the elimination.

    Bodies are the groups after those of contacts. A body comes after its elastic interfaces: they
    give it its pivots where it has no mass.
    """
    pairs = np.sort(problem.bodies, axis=1)
    # contacts that no solved body tells apart form groups of their own
    alone = (pairs < 0).all(axis=1)
    keys = np.where(
        alone, -1 - np.arange(problem.count), pairs[:, 0] * (problem.body_count + 1) + pairs[:, 1]
    )
    _, leader, inverse = np.unique(keys, return_index=True, return_inverse=True)
    group, count = inverse.ravel(), len(leader)
    total = count + problem.body_count
    neighbours: list[set[int]] = [set() for _ in range(total)]
    after: list[set[int]] = [set() for _ in range(total)]
    pattern = np.unique(group[rows] * count + group[problem.compliance.indices]) if len(rows) else rows
    for one, two in zip((pattern // max(count, 1)).tolist(), (pattern % max(count, 1)).tolist(), strict=True):
        if one != two:
            neighbours[one].add(two)
            neighbours[two].add(one)
    has_elastic = np.zeros(count, dtype=bool)
    has_elastic[group[elastic]] = True
    for number, first in enumerate(leader.tolist()):
        own = sorted({count + int(body) for body in problem.bodies[first] if body >= 0})
        for body in own:
            neighbours[body].update(other for other in own if other != body)
            if has_elastic[number]:
                neighbours[body].add(number)
                neighbours[number].add(body)
                after[body].add(number)
    sizes = np.zeros(total, dtype=np.int64)
    np.add.at(sizes, group[elastic], problem.dimension)
    sizes[count:] = problem.rigid_mass.shape[1]
    return group, count, eliminate_order(neighbours, sizes, after)
