"""Rest: the state in which nothing moves, where impulses can hold it.

    solution = iterate(problem, Rest(), settings)

Whatever rigid blocks at rest are held by, the laws of contact hold: impulses within the friction cones
of closed contacts that balance the loads are a solution, one of many (``admissible``). That is a convex
problem. It does without any search for who sticks and who slides, in which Newton's method may cycle
close to a structure's limit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy import sparse

from masonry_fem.nscd.admissible import admissible_impulses
from masonry_fem.nscd.iterate import Iterate
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings, Start

# Unbalanced part of the loads to aim at: all that rounding leaves.
EXACT = 1e-14


@dataclass(frozen=True, slots=True)
class Rest:
    """The method; it needs no start and ends with its first offer."""

    name: ClassVar[str] = "rest"
    iterations: ClassVar[int] = 1

    def init(self, problem: ContactProblem, start: Start | None) -> RestRun:
        """A run on a problem."""
        return RestRun(problem)


class RestRun:
    """Impulses that hold everything where it is."""

    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem

    def guess(self) -> Iterate:
        """The state at rest; that without impulses where contacts move or overlap at rest."""
        problem = self._problem
        impulse = np.zeros_like(problem.free_velocity)
        at_rest = problem.free_velocity
        closed = at_rest[:, 0] <= 0
        if problem.cohesion_stiffness is None and not at_rest[closed].any():
            part = _closed_part(problem, np.flatnonzero(closed))
            impulse[closed] = admissible_impulses(part, tolerance=EXACT).impulse
        return Iterate(impulse, np.zeros_like(problem.rigid_velocity), verdict=Outcome.STALLED)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """Never called: the first offer has a verdict."""
        raise AssertionError("the first offer is the answer or there is none")


def _closed_part(problem: ContactProblem, contacts: np.ndarray) -> ContactProblem:
    """The problem without the open contacts, its blocks rigid."""
    d = problem.dimension
    size = len(contacts) * d
    return replace(
        problem,
        friction=problem.friction[contacts],
        free_velocity=problem.free_velocity[contacts],
        compliance=sparse.bsr_array((size, size), blocksize=(d, d) if size else (1, 1)),
        bodies=problem.bodies[contacts],
        rigid_map=problem.rigid_map[contacts],
    )
