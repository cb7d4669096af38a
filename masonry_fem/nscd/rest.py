"""Rest: the state in which nothing moves, where impulses can hold it.

    solution = iterate(problem, Rest(), settings)

Whatever rigid blocks at rest are held by, the laws of contact hold: impulses within the friction cones
of closed contacts that balance the loads are a solution, one of many (``admissible``). That is a convex
problem. It does without any search for who sticks and who slides, in which Newton's method may cycle
close to a structure's limit.

The impulses that are found balance the loads to a millionth. The rest is put on the contacts by least
squares, weighted by what each carries: within the cones, as long as it is small.

A solution that another method came to is brought to rest by ``brought_to_rest``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from masonry_fem.nscd import graphs
from masonry_fem.nscd.admissible import BALANCED, CLOSED, admissible_impulses, static_part
from masonry_fem.nscd.iterate import Iterate, OneOffer
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import assess, balance_rounding
from masonry_fem.nscd.scaling import free_speed
from masonry_fem.nscd.settings import SolverSettings, Start

FloatArray = NDArray[np.float64]

# Unbalanced part of the loads that is all that rounding leaves; corrections that may lead there.
EXACT = 1e-14
CORRECTIONS = 4
LIGHT = 1e-6  # least weight of a contact, of the largest impulse: it may carry something after all
SOFT = 1e-14  # of the largest stiffness: what corrections take for the blocks that nothing holds


@dataclass(frozen=True, slots=True)
class Rest:
    """The method; it needs no start and ends with its first offer."""

    name: ClassVar[str] = "rest"
    iterations: ClassVar[int] = 1

    def init(self, problem: ContactProblem, start: Start | None) -> OneOffer:
        """Impulses that hold everything where it is; none where contacts move or overlap at rest."""
        impulse = np.zeros_like(problem.free_velocity)
        at_rest, least = problem.free_velocity, CLOSED * free_speed(problem)
        closed = at_rest[:, 0] <= least
        if problem.cohesion_stiffness is None and not (np.abs(at_rest[closed]) > least).any():
            impulse[closed] = holding_impulses(problem.without_compliance().only(np.flatnonzero(closed)))
        return OneOffer(Iterate(impulse, np.zeros_like(problem.rigid_velocity), verdict=Outcome.STALLED))


def holding_impulses(problem: ContactProblem) -> FloatArray:
    """Impulses within the cones of all contacts that balance the loads, as far as any do, (c, d)."""
    return _balanced(problem, admissible_impulses(problem).impulse)


def brought_to_rest(problem: ContactProblem, made: Solution, settings: SolverSettings) -> Solution:
    """The solution with the same impulses and no velocities, where that is at least as good.

    Among rigid blocks without inertia, velocities have no part in the balance of a block. Where contacts are
    closed at rest, (p, 0) has no larger a residual than (p, U): P_K(p) is the point of K nearest to p. Such a
    U is what the method's last step left. In structures that are nearly mechanisms it is a hundred times what
    shows in the gaps: more than tolerances promise, and different on each processor.

    Blocks with inertia are at rest where U is no more than impulses that are rounded make it. If friction is
    large that may be more than the tolerance: v̂ contains μ times as much.

    Parameters
    ----------
    problem : The contact problem.
    made : A state that solves it, or nearly. With inertia, one that has converged stays as it is.
    settings : How well it is to be solved.
    """
    inert = bool((problem.rigid_mass > 0).any())
    if not problem.rigid or problem.cohesive or (inert and made.converged):
        return made
    rests = np.zeros(problem.body_count, dtype=bool)
    rests[problem.bodies[problem.bodies >= 0]] = True  # what touches nothing flies on
    if inert:
        momentum = graphs.lengths(problem.rigid_mass * made.rigid_velocity)
        rests &= momentum <= balance_rounding(problem, made.impulse, made.rigid_velocity)
    still = np.where(rests[:, None], 0.0, made.rigid_velocity)
    quality = assess(problem, made.impulse, still, least_impulse=settings.least_impulse)
    if not quality.error <= made.quality.error:
        return made
    return replace(
        made,
        rigid_velocity=still,
        velocity=problem.velocity(made.impulse, still),
        quality=quality,
        outcome=Outcome.CONVERGED if quality.error <= settings.tolerance else made.outcome,
    )


def _balanced(problem: ContactProblem, impulse: FloatArray) -> FloatArray:
    """The impulses with what they leave of the loads put on them, as far as cones let it, (c, d)."""
    if problem.cohesive:  # springs carry what their stretch makes them carry
        return admissible_impulses(problem, tolerance=EXACT).impulse
    rigid_map, load = static_part(problem)
    transposed, size = rigid_map.T.tocsr(), float(np.linalg.norm(load))
    best, least = impulse, _unbalanced(transposed, load, impulse)
    for _ in range(CORRECTIONS):
        if least <= EXACT * size:
            break
        weight = (best[:, 0] + LIGHT * best[:, 0].max(initial=0.0)) ** 2
        weights = np.repeat(weight[:, None], problem.dimension, axis=1)
        weights[:, 1:] *= np.minimum(problem.friction, 1.0)[:, None] ** 2
        scaled = sparse.diags_array(weights.ravel()) @ rigid_map
        matrix = sparse.csc_array(transposed @ scaled)
        firmest = float(matrix.diagonal().max(initial=0.0))
        if firmest == 0:
            break
        factor = splu(sparse.csc_array(matrix + SOFT * firmest * sparse.eye_array(len(load))))
        left = transposed @ best.ravel() + load
        changed = best - (scaled @ factor.solve(left)).reshape(best.shape)
        changed = graphs.project_cone(changed, problem.friction)
        unbalanced = _unbalanced(transposed, load, changed)
        if not unbalanced < least:
            break
        best, least = changed, unbalanced
    if least > BALANCED * size:
        return admissible_impulses(problem, tolerance=EXACT).impulse
    return best


def _unbalanced(transposed: sparse.csr_array, load: FloatArray, impulse: FloatArray) -> float:
    return float(np.linalg.norm(transposed @ impulse.ravel() + load))
