"""Program: the optimisation behind every question of limit analysis, whatever solver is used.

    maximise x    such that    A r + fixed + x · growing = 0,    r in the joints' strength,    x ≤ upper

Its dual is kinematic: velocities V of the blocks with growing · V = 1 at which no joint closes, and whose
power proves that no larger x exists. ``Optimum`` holds both sides. Its errors are computed here from r, x
and V
alone, relative to the largest load, so that they do not rely on what a solver reports.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.limit.strength import Strength
from masonry_fem.nscd.graphs import lengths

FloatArray = NDArray[np.float64]

AT_BOUND = 1e-6  # an x that is no more below its bound is at it
SMALL = 1e-3  # errors are relative to x, or to this where x is smaller


@dataclass(frozen=True, slots=True)
class Program:
    """c contact points in d dimensions, h reactions of held points, n equations.

    Attributes
    ----------
    matrix : A: columns of contact forces, component by component, then held reactions, (n, c d + h).
    fixed, growing : Right-hand sides, shape (n,).
    strength : Of the contact points.
    dimension : d.
    upper : Bound of x.
    """

    matrix: sparse.csr_array
    fixed: FloatArray
    growing: FloatArray
    strength: Strength
    dimension: int
    upper: float

    @property
    def count(self) -> int:
        """Number of contact points c."""
        return len(self.strength.friction)

    def contact(self, force: FloatArray) -> FloatArray:
        """The contact points' part of forces or velocities (c d + h,), shape (c, d)."""
        return force[: self.count * self.dimension].reshape(self.count, self.dimension)


@dataclass(frozen=True, slots=True)
class Optimum:
    """The answer to a program, from both sides.

    Attributes
    ----------
    value : x. force : Contact forces within the strength, and held reactions, shape (c d + h,).
    velocity : V, shape (n,); proves nothing where x is at its bound.
    unbalanced : Largest residual of the equations over the largest load.
    closing : Largest violation of growing · V = 1 and, where points bear any pressure, of v_N ≥ μ ‖v_T‖, over
        the largest velocity.
    gap : How far x may be from the true optimum, relative: the difference to the bound that V proves, and
        the power that the errors of forces and V could hide; nan where x is at its bound.
    """

    value: float
    force: FloatArray
    velocity: FloatArray
    unbalanced: float
    closing: float
    gap: float


def judged(program: Program, value: float, force: FloatArray, velocity: FloatArray) -> Optimum:
    """An optimum with its errors, from a solver's solution; forces are first projected into the strength.

    Parameters
    ----------
    program : What was solved.
    value : x of the solution.
    force : Contact forces r.
    velocity : Dual velocities V, shape (n,).
    """
    inside = within(program, force)
    residual = program.matrix @ inside + program.fixed + value * program.growing
    whole = 1.0 if np.isfinite(program.upper) else 0.0
    load = max(_largest(program.fixed), max(abs(value), whole) * _largest(program.growing))
    unbalanced = _largest(residual) / load if load else 0.0
    if not value < program.upper - AT_BOUND:
        return Optimum(value, inside, velocity, unbalanced, np.nan, np.nan)
    opening = program.matrix.T @ velocity
    motion = program.contact(opening)
    short = np.maximum(program.strength.friction * lengths(motion[:, 1:]) - motion[:, 0], 0.0)
    short[program.strength.bounded] = 0.0  # these give way at their greatest force
    fast = max(_largest(motion), _largest(velocity), np.finfo(float).tiny)
    wrong = max(_largest(short), _largest(opening[motion.size :]))
    closing = max(wrong / fast, abs(float(program.growing @ velocity) - 1.0))
    bound = float(program.strength.dissipation(motion).sum() - velocity @ program.fixed)
    # the errors of forces and motions change the power, and so the bounds, by at most this much
    pressed = program.contact(inside)[:, 0] + program.strength.apex
    hidden = float(short @ np.maximum(pressed, 0.0)) + float(np.abs(velocity) @ np.abs(residual))
    gap = (abs(bound - value) + hidden) / max(abs(value), SMALL)
    return Optimum(value, inside, velocity, unbalanced, closing, gap)


def within(program: Program, force: FloatArray) -> FloatArray:
    """Forces with as much pressure added as brings each contact into its strength, or taken, (c d + h,)."""
    strength, inside = program.strength, force.copy()
    reaction = program.contact(inside)
    needed = lengths(reaction[:, 1:])
    pressed = np.divide(needed, strength.friction, out=np.zeros_like(needed), where=strength.friction > 0)
    reaction[strength.friction == 0, 1:] = 0.0
    reaction[:, 0] = np.maximum(reaction[:, 0], np.maximum(pressed - strength.apex, -strength.tension))
    reaction[:, 0] = np.minimum(reaction[:, 0], strength.most)
    return inside


def _largest(values: FloatArray) -> float:
    return float(np.abs(values).max(initial=0.0))
