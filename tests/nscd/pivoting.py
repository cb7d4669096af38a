"""Pivoting: small plane problems solved to rounding, as linear complementarity problems; an oracle.

In 2D Coulomb's cone has two edges, and with p_T = β⁺ − β⁻ and the sliding speed λ

    0 ≤ p_N ⊥ v_N ≥ 0,    0 ≤ β⁺ ⊥ λ + v_T ≥ 0,    0 ≤ β⁻ ⊥ λ − v_T ≥ 0,    0 ≤ λ ⊥ μ p_N − β⁺ − β⁻ ≥ 0

(Stewart and Trinkle 1996). Rigid velocities that are not eliminated enter as U⁺ − U⁻ with their
balance as two inequalities. The matrix is copositive where W is positive semi-definite, so that
Lemke's method finds a solution of every step whose blocks have inertia and can be at rest (Anitescu
and Potra 1997). Otherwise it may end on a secondary ray, which does not prove that there is none:
bodies wedged by prescribed motions, statics without an equilibrium, or statics of blocks that only
the friction of a self-stress holds.

Where cohesion has a stiffness, it is eliminated first: W, B and M become those by p̃ (``_fold``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.linalg import lapack

from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale
from tests.nscd.lemke import Lemke

FloatArray = NDArray[np.float64]

REFINEMENTS = 2


def pivoted(problem: ContactProblem) -> tuple[FloatArray, FloatArray] | None:
    """Impulses (c, 2) and rigid velocities (b, 3) of a plane problem; None where the way ends on a ray."""
    table = ComplementarityTable(problem)
    tableau = Lemke(table.M, table.q)
    while tableau.verdict is None:
        tableau.pivot()
    return table.resolve(tableau.chosen) if tableau.verdict == "solved" else None


class ComplementarityTable:
    """The linear complementarity problem of a plane contact problem, scaled to entries of 1.

    Attributes
    ----------
    M, q : Of z = (p_N, β⁺, β⁻, λ, U⁺, U⁻), shapes (n, n) and (n,).
    """

    def __init__(self, problem: ContactProblem) -> None:
        self.problem = problem
        c, m = problem.count, problem.rigid_mass.shape[1]
        # rigid blocks in motion are eliminated; elastic ones not, whose W would drown in B M⁻¹ Bᵀ
        self.condensed = problem.rigid and bool((problem.rigid_mass > 0).all())
        own = problem.delassus() if self.condensed else problem.compliance
        free = problem.plain_velocity() if self.condensed else problem.free_velocity
        root = np.sqrt(contact_scale(problem))
        self.impulse_unit = np.repeat(1.0 / root, 2).reshape(c, 2)
        W = own.toarray() * self.impulse_unit.ravel()[:, None] * self.impulse_unit.ravel()
        B = np.zeros((2 * c, 0)) if self.condensed else problem.rigid_matrix().toarray()
        B = B * self.impulse_unit.ravel()[:, None]
        length = np.linalg.norm(B, axis=0)
        self.motion_unit = 1.0 / np.where(length > 0, length, 1.0)
        B = B * self.motion_unit
        mass = np.zeros(0) if self.condensed else problem.rigid_mass.ravel() * self.motion_unit**2
        mass = np.diag(mass)
        load = np.zeros(0)
        if not self.condensed:
            load = (problem.rigid_impulse + problem.rigid_mass * problem.rigid_velocity).ravel()
            load = load * self.motion_unit
        moved = free.ravel() * self.impulse_unit.ravel()
        self.size = max(float(np.abs(moved).max(initial=0.0)), float(np.abs(load).max(initial=0.0))) or 1.0
        self.bodies, self.modes = problem.body_count, m
        self.springs: FloatArray | None = None
        parts: tuple[FloatArray, ...] = (W, B, B.T, mass, moved / self.size, load / self.size)
        if problem.cohesion_stiffness is not None:
            self.springs = linalg.block_diag(*problem.cohesion_stiffness)
            self.springs = self.springs / self.impulse_unit.ravel()[:, None] / self.impulse_unit.ravel()
            parts = _fold(self.springs, *parts)
        self.parts = parts
        self.M, self.q = _assemble(problem.friction, *parts)

    def resolve(self, chosen: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """Impulses and rigid velocities of a basis, with what slides on its cone's edge to the last digit.

        λ and β are eliminated by hand: sliding speeds lie orders of magnitude above elastic ones, and
        would leave their rounding in the impulses.

        Parameters
        ----------
        chosen : True for the entries of z that are basic, shape (n,).
        """
        W, B, push, mass, free, load = self.parts
        c, k = self.problem.count, len(mass)
        normal, plus, minus, slides = chosen[: 4 * c].reshape(4, c)
        slides = slides & (plus != minus)
        ratio = np.where(slides, np.where(plus, 1.0, -1.0) * self.problem.friction, 0.0)
        moves = chosen[4 * c : 4 * c + k] | chosen[4 * c + k :]
        tangent = normal & ~slides & (plus | minus)
        one, two, count = np.flatnonzero(normal), np.flatnonzero(tangent), int(normal.sum())
        span = np.zeros((2 * c, count + len(two)))  # impulses by the unknowns
        span[2 * one, np.arange(count)] = 1.0
        span[2 * one + 1, np.arange(count)] = ratio[one]
        span[2 * two + 1, count + np.arange(len(two))] = 1.0
        rows = np.concatenate([2 * one, 2 * two + 1])  # velocities that vanish
        turn = B[:, moves]
        matrix = np.block([[W[rows] @ span, turn[rows]], [push[moves] @ span, -mass[np.ix_(moves, moves)]]])
        unknown = _solved(matrix, -np.concatenate([free[rows], load[moves]]))
        motion = np.zeros(k)
        motion[moves] = unknown[span.shape[1] :]
        return self._in_units(span @ unknown[: span.shape[1]], motion)

    def _in_units(self, pressed: FloatArray, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
        """P (c, 2) and U (b, m) of the table's p̃ (2 c,) and U (k,)."""
        if self.springs is not None:
            W, B, _, _, free, _ = self.parts
            pressed = pressed - self.springs @ (W @ pressed + B @ motion + free)
        impulse = pressed.reshape(-1, 2) * self.impulse_unit * self.size
        if self.condensed:
            return impulse, self.problem.balanced_velocity(impulse)
        motion = motion * self.motion_unit * self.size
        return impulse, motion.reshape(self.bodies, self.modes)


def _fold(
    springs: FloatArray,
    W: FloatArray,
    B: FloatArray,
    push: FloatArray,
    mass: FloatArray,
    free: FloatArray,
    load: FloatArray,
) -> tuple[FloatArray, ...]:
    """The laws of motion of p̃ = p + S v instead of p, where v = W p + q + B U and Bᵀ p + f − M U = 0."""
    turn = np.linalg.inv(np.eye(len(W)) + W @ springs)
    W, B, free = turn @ W, turn @ B, turn @ free
    held = push @ springs
    return W, B, push - held @ W, mass + held @ B, free, load - held @ free


def _assemble(
    friction: FloatArray,
    W: FloatArray,
    B: FloatArray,
    push: FloatArray,
    mass: FloatArray,
    free: FloatArray,
    load: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    c, k = len(friction), B.shape[1]
    # normal, tangent and its opposite: rows and columns of the velocities and impulses
    spread = np.zeros((2 * c, 3 * c))
    number = np.arange(c)
    spread[2 * number, number] = 1.0
    spread[2 * number + 1, c + number] = 1.0
    spread[2 * number + 1, 2 * c + number] = -1.0
    M = np.zeros((4 * c + 2 * k, 4 * c + 2 * k))
    M[: 3 * c, : 3 * c] = spread.T @ W @ spread
    M[c + number, 3 * c + number] = M[2 * c + number, 3 * c + number] = 1.0
    M[3 * c + number, number] = friction
    M[3 * c + number, c + number] = M[3 * c + number, 2 * c + number] = -1.0
    turn, back = spread.T @ B, push @ spread
    plus, minus = slice(4 * c, 4 * c + k), slice(4 * c + k, 4 * c + 2 * k)
    M[: 3 * c, plus], M[: 3 * c, minus] = turn, -turn
    M[plus, : 3 * c], M[minus, : 3 * c] = -back, back
    M[plus, plus] = M[minus, minus] = mass
    M[plus, minus] = M[minus, plus] = -mass
    return M, np.concatenate([spread.T @ free, np.zeros(c), -load, load])


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """The solution of a square system, refined with residuals in extended precision."""
    if not len(right):
        return right
    size = np.abs(matrix).max(axis=1)
    rows = 1.0 / np.where(size > 0, size, 1.0)
    matrix, right = matrix * rows[:, None], right * rows
    factor, pivots, singular = lapack.dgetrf(matrix)
    if singular:  # an artificial variable that vanished has left a gap
        answer: FloatArray = np.linalg.lstsq(matrix, right)[0]
        return answer
    exact = matrix.astype(np.longdouble)
    answer = lapack.dgetrs(factor, pivots, right)[0]
    for _ in range(REFINEMENTS):
        answer = answer + lapack.dgetrs(factor, pivots, (right - exact @ answer).astype(float))[0]
    return answer
