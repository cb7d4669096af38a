"""Enumeration: all solutions of a small plane problem, by trying every combination of statuses.

    for found in enumerate_solutions(problem):
        found.status, found.velocity, found.freedom

Coulomb friction may have several solutions with different velocities, or none: Painlevé's rod, bodies
that stick or slide as they please. A solver finds one. In 2D each contact is open, sticks, or
slides either way, and with the statuses given what is left is linear: 4^c systems, for c contacts few
enough.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.problem import ContactProblem
from tests.nscd.pivoting import ComplementarityTable

FloatArray = NDArray[np.float64]

MOST_CONTACTS = 6
STATUSES = ("open", "stick", "slip_up", "slip_down")  # up: p_T = μ p_N, v_T ≤ 0
# Relative to the largest singular value, to the loads, and between two velocities that are the same.
RANK, HOLDS, SAME = 1e-11, 1e-9, 1e-7


@dataclass(frozen=True, slots=True)
class StatusSolution:
    """A solution, or a family of those that share their velocities.

    Attributes
    ----------
    status : "open", "stick", "slip_up" (p_T = μ p_N) or "slip_down" of each contact.
    impulse, velocity : p and v of one of the family, well inside it, shape (c, 2).
    rigid_velocity : U, shape (b, 3).
    freedom : Directions in which impulses (or a mechanism) may change with these statuses; 0: unique.
    """

    status: tuple[str, ...]
    impulse: FloatArray
    velocity: FloatArray
    rigid_velocity: FloatArray
    freedom: int


def enumerate_solutions(problem: ContactProblem) -> list[StatusSolution]:
    """All solutions of a plane problem, one for each distinct velocity of the contacts.

    Where several combinations of statuses have the same velocities, the one with most freedom stands
    for them. An empty list: there is no solution.

    Raises
    ------
    ProblemError : The problem is in 3D or has more than 6 contacts.
    """
    c = problem.count
    if problem.dimension != 2 or c > MOST_CONTACTS:
        raise ProblemError(
            f"enumeration got {c} contacts in {problem.dimension}D, expected at most {MOST_CONTACTS} in 2D, "
            "where statuses leave a linear problem; solve() finds one solution of any other"
        )
    if problem.cohesive:
        raise ProblemError("enumeration got joints with cohesion, expected dry ones; solve() knows both")
    systems = _Systems(problem)
    found: list[tuple[FloatArray, StatusSolution]] = []
    for codes in product(range(len(STATUSES)), repeat=c):
        made = systems.solution(np.array(codes, dtype=np.int64))
        if made is None:
            continue
        unknown, freedom = made
        velocity = systems.velocity(unknown)
        # a frictionless contact that slides also is one that slides the other way
        alike = [k for k, (other, _) in enumerate(found) if np.abs(other - velocity).max(initial=0.0) <= SAME]
        if alike and found[alike[0]][1].freedom >= freedom:
            continue
        entry = (velocity, systems.described(codes, unknown, freedom))
        if alike:
            found[alike[0]] = entry
        else:
            found.append(entry)
    return [solution for _, solution in found]


class _Systems:
    """The linear systems of all statuses, in scaled unknowns (p, U)."""

    def __init__(self, problem: ContactProblem) -> None:
        self.problem = problem
        self.table = ComplementarityTable(problem)
        W, B, push, mass, free, load = self.table.parts
        c, k = problem.count, len(mass)
        self.move = np.hstack([W, B])  # v − free, by the unknowns
        self.free = free
        self.push = np.hstack([np.eye(2 * c), np.zeros((2 * c, k))])
        self.balance = np.hstack([push, -mass])
        self.load = load
        self.friction = problem.friction

    def velocity(self, unknown: FloatArray) -> FloatArray:
        """Scaled v, shape (2 c,)."""
        velocity: FloatArray = self.move @ unknown + self.free
        return velocity

    def solution(self, codes: NDArray[np.int64]) -> tuple[FloatArray, int] | None:
        """Unknowns well inside what the statuses allow, and their freedom; None where nothing is."""
        matrix, right, above, offset = self._conditions(codes)
        left, size, rows = np.linalg.svd(matrix)
        rank = int((size > RANK * size.max(initial=0.0)).sum())
        unknown = rows[:rank].T @ ((left.T @ right)[:rank] / size[:rank])
        if np.abs(matrix @ unknown - right).max(initial=0.0) > HOLDS * (
            1.0 + np.abs(unknown).max(initial=0.0)
        ):
            return None
        inside = above @ unknown + offset
        null = rows[rank:].T
        tolerance = HOLDS * (1.0 + np.abs(unknown).max(initial=0.0))
        if not null.shape[1]:
            return (unknown, 0) if inside.min(initial=0.0) >= -tolerance else None
        depth, along = _deepest(above @ null, inside)
        if depth < -tolerance:
            return None
        return unknown + null @ along, null.shape[1] if depth > tolerance else 0

    def described(self, codes: tuple[int, ...], unknown: FloatArray, freedom: int) -> StatusSolution:
        """The solution in the problem's units."""
        c, table = self.problem.count, self.table
        impulse = unknown[: 2 * c].reshape(c, 2) * table.impulse_unit * table.size
        if table.condensed:
            rigid = self.problem.balanced_velocity(impulse)
        else:
            motion = unknown[2 * c :] * table.motion_unit * table.size
            rigid = motion.reshape(self.problem.rigid_mass.shape)
        velocity = self.problem.velocity(impulse, rigid)
        return StatusSolution(tuple(STATUSES[code] for code in codes), impulse, velocity, rigid, freedom)

    def _conditions(self, codes: NDArray[np.int64]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Equations A x = b, and what must not be negative, C x + e."""
        normal, tangent = 2 * np.arange(len(codes)), 2 * np.arange(len(codes)) + 1
        mu = self.friction[:, None]
        v_n, v_t = self.move[normal], self.move[tangent]
        q_n, q_t = self.free[normal], self.free[tangent]
        p_n, p_t = self.push[normal], self.push[tangent]
        opens, sticks, slides = codes == 0, codes == 1, codes >= 2
        sign = np.where(codes == 2, 1.0, -1.0)[slides]
        matrix = np.concatenate(
            [
                p_n[opens], p_t[opens], v_n[~opens], v_t[sticks],
                p_t[slides] - sign[:, None] * mu[slides] * p_n[slides], self.balance,
            ]
        )  # fmt: skip
        none = np.zeros(2 * int(opens.sum()))
        right = np.concatenate([none, -q_n[~opens], -q_t[sticks], np.zeros(int(slides.sum())), -self.load])
        above = np.concatenate(
            [
                v_n[opens], mu[sticks] * p_n[sticks] - p_t[sticks], mu[sticks] * p_n[sticks] + p_t[sticks],
                p_n[slides], -sign[:, None] * v_t[slides],
            ]
        )  # fmt: skip
        offset = np.concatenate(
            [q_n[opens], np.zeros(2 * int(sticks.sum()) + int(slides.sum())), -sign * q_t[slides]]
        )
        return matrix, right, above, offset


def _deepest(slopes: FloatArray, inside: FloatArray) -> tuple[float, FloatArray]:
    """The y that makes the least of ``slopes`` y + ``inside`` largest, up to 1, and that least."""
    count = slopes.shape[1]
    if not len(inside):
        return 1.0, np.zeros(count)
    bounds = np.hstack([-slopes, np.ones((len(inside), 1))])
    goal = np.r_[np.zeros(count), -1.0]
    made = linprog(goal, A_ub=bounds, b_ub=inside, bounds=[(-1e6, 1e6)] * count + [(None, 1.0)])
    if made.x is None:
        return -np.inf, np.zeros(count)
    return float(made.x[-1]), made.x[:-1]
