"""Determinacy: what a contact problem says of the reactions, and what it leaves open.

    least = least_norm_reaction(problem, solution)
    least.impulse                             # of all solutions the one of least norm
    known = determined_resultants(problem, solution, interface)
    known.determined                          # by interface and component: the same in all solutions

Where blocks touch at more points than balance can tell apart, the reactions that a solver returns
are one of many. "All solutions" are the impulses that leave every velocity as it is
and keep to the laws of contact (``solution_set``). In joints with cohesion what the norm is of, and what is
least, are the contact parts p̃.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.central_path import INSIDE, CentralPath
from masonry_fem.nscd.outcome import Solution
from masonry_fem.nscd.polish import polished
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.residuals import Quality, assess
from masonry_fem.nscd.solution_set import SolutionSet, solution_set
from masonry_fem.nscd.threads import one_thread

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

# On the way to the least norm: when to turn to its end, when that is near, and steps to either.
CENTRED, NEAR, STEPS = 1e-8, 1e-9, 80
# Distance from the least norm at which it is attained, relative to ‖p‖.
ATTAINED = 1e-6
# How much worse than the given solution it may be, and what is good enough in any case.
TIMES, EXACT = 10.0, 1e-7
# Random differences of solutions that the resultants are tried on.
PROBES = 12
# A resultant that differs by less than this between unit differences of solutions is determined.
SAME = 1e-6


@dataclass(frozen=True, slots=True)
class LeastNorm:
    """The solution of least norm.

    Attributes
    ----------
    impulse : p that minimises Σ ω_i‖p̃_i‖² among the solutions [N s], shape (c, d).
    quality : Its error measures with the rigid velocities of the given solution.
    norm, given_norm : √(Σ ω_i‖p̃_i‖²) of it and of the given solution [N s].
    attained : False where the way to the least norm broke off; the impulse then is the given one.
    """

    impulse: FloatArray
    quality: Quality
    norm: float
    given_norm: float
    attained: bool


@dataclass(frozen=True, slots=True)
class Determined:
    """Resultants of k interfaces, and which of their components are facts.

    Attributes
    ----------
    interface : Their numbers, ascending, shape (k,).
    resultant : Resultants of the given solution, shape (k, r).
    determined : True where every solution has the same, shape (k, r).
    unique : Contacts whose impulse is the same in every solution, shape (c,).
    """

    interface: NDArray[np.int64]
    resultant: FloatArray
    determined: Mask
    unique: Mask


def least_norm_reaction(
    problem: ContactProblem,
    solution: Solution,
    weight: ArrayLike = 1.0,
    *,
    solutions: SolutionSet | None = None,
) -> LeastNorm:
    """Of all impulses that solve the problem with the velocities found, those of least norm.

    Parameters
    ----------
    problem : The contact problem. solution : A converged solution.
    weight : ω_i > 0 without unit, one for all or shape (c,): 1 shares forces equally between points;
        the mean area over a point's area makes tractions even instead.
    solutions : ``solution_set(problem, solution)`` where the caller has it.

    Raises
    ------
    ProblemError : The solution has not converged; a weight is not positive.
    """
    omega = np.broadcast_to(np.asarray(weight, dtype=float), (problem.count,)).copy()
    if not (np.isfinite(omega) & (omega > 0)).all():
        raise ProblemError(
            f"weight is {omega.min(initial=0.0)}, expected numbers above 0; 1 weighs all alike"
        )
    found = solution_set(problem, solution) if solutions is None else solutions
    problem = found.problem  # of contact parts
    impulse, attained = found.member, True
    if not _single(found):
        omega /= omega.mean()
        path = CentralPath(problem, found.allowed, found.member, found.balance, omega, found.scale)
        with one_thread():
            path.follow(INSIDE, CENTRED, STEPS)
            path.finish(NEAR, STEPS)
            impulse, distance = polished(path)
        attained = distance <= ATTAINED
    quality = assess(problem, impulse, solution.rigid_velocity, found.scale)
    worse = quality.error > max(TIMES * solution.quality.error, EXACT)
    if worse or _norm(impulse, omega) > (1 + ATTAINED) * _norm(found.member, omega):
        impulse, attained = found.member, False
        quality = assess(problem, impulse, solution.rigid_velocity, found.scale)
    given = solution.impulse if found.cohesion is None else solution.impulse + found.cohesion
    return LeastNorm(found.on_blocks(impulse), quality, _norm(impulse, omega), _norm(given, omega), attained)


def determined_resultants(
    problem: ContactProblem,
    solution: Solution,
    interface: ArrayLike,
    wrench: FloatArray | None = None,
    *,
    solutions: SolutionSet | None = None,
    seed: int = 0,
) -> Determined:
    """Which resultants of interfaces are the same in all solutions.

    A component is tried on random differences of solutions, drawn within the least faces that hold
    all of them; one that differs escapes all ``PROBES`` with a chance below 1e-30. What is left to
    tolerances is what counts as rest, as an edge and as no difference (docs/determinacy.md).

    Parameters
    ----------
    problem : The contact problem. solution : A converged solution.
    interface : Number of each contact's interface, shape (c,).
    wrench : Rows that make a contact's share of the components from its impulse, shape (c, r, d);
        default: the impulse on the rigid modes of the block on one side, that of the candidate if it
        is free, which knows as much as force and moment.
    solutions : ``solution_set(problem, solution)`` where the caller has it.
    seed : Of the random numbers.

    Raises
    ------
    ProblemError : The solution has not converged; ``interface`` or ``wrench`` do not fit.
    """
    number = np.asarray(interface)
    rows = _wrench(problem) if wrench is None else np.asarray(wrench, dtype=float)
    c, d = problem.free_velocity.shape
    if number.shape != (c,) or rows.ndim != 3 or (rows.shape[0], rows.shape[2]) != (c, d):
        raise ProblemError(
            f"interface has shape {number.shape} and wrench {rows.shape}, expected ({c},) and ({c}, r, {d}): "
            "one number and one matrix a contact"
        )
    names, group = np.unique(number, return_inverse=True)
    found = solution_set(problem, solution) if solutions is None else solutions
    differences = found.differences(PROBES, seed)
    # of a unit difference, as the probes measure it
    length = _sums(((rows**2).sum(axis=2) / found.scale[:, None]), group, len(names))
    spread = np.zeros_like(length)
    for difference in differences:
        spread += _sums(_apply(rows, difference), group, len(names)) ** 2
    spread = np.sqrt(spread / PROBES)
    return Determined(
        interface=names,
        resultant=_sums(_apply(rows, found.on_blocks(found.member)), group, len(names)),
        determined=spread <= SAME * np.sqrt(length),
        unique=_difference(found, differences) <= SAME,
    )


def summarise_contacts(problem: ContactProblem, solution: Solution) -> tuple[FloatArray, dict[str, Any]]:
    """The least-norm impulses, shape (c, d) [N s], and in numbers how far the impulses are determined.

    Parameters
    ----------
    problem : The contact problem.
    solution : One solution of it.
    """
    found = solution_set(problem, solution)
    least = least_norm_reaction(problem, solution, solutions=found)
    known = determined_resultants(problem, solution, np.arange(problem.count), solutions=found)
    count = int(known.unique.sum())
    return least.impulse, {
        "unique": count == problem.count,
        "unique_contacts": count,
        "least_norm_attained": least.attained,
        "least_norm": least.norm,
        "norm_found": least.given_norm,
        "least_norm_error": least.quality.error,
        "contacts_not_unique": np.flatnonzero(~known.unique).tolist(),
    }


def _single(found: SolutionSet) -> bool:
    """True where the solution is the only one."""
    return bool((_difference(found, found.differences(1)) <= SAME).all())


def _difference(found: SolutionSet, differences: FloatArray) -> FloatArray:
    """Root mean square of unit differences at each contact, shape (c,)."""
    size: FloatArray = np.sqrt((differences**2).sum(axis=2).mean(axis=0) * found.scale)
    return size


def _wrench(problem: ContactProblem) -> FloatArray:
    """Impulses on the rigid modes of one side's block; the impulse itself where no side is free."""
    c, d = problem.free_velocity.shape
    if not problem.body_count:
        return np.tile(np.eye(d), (c, 1, 1))
    side = np.where(problem.bodies[:, 0] >= 0, 0, 1)
    rows: FloatArray = problem.rigid_map[np.arange(c), side].transpose(0, 2, 1)
    return rows


def _apply(rows: FloatArray, impulse: FloatArray) -> FloatArray:
    shares: FloatArray = applied(rows, impulse)
    return shares


def _sums(shares: FloatArray, group: NDArray[np.int64], count: int) -> FloatArray:
    total = np.zeros((count, shares.shape[1]))
    np.add.at(total, group, shares)
    return total


def _norm(impulse: FloatArray, weight: FloatArray) -> float:
    return float(np.sqrt((weight[:, None] * impulse**2).sum()))
