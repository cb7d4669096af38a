"""Conic: programs by Clarabel's interior point, on Coulomb's exact cones.

Reactions are scaled to the cone ‖s_T‖ ≤ s_N, so that smooth and non-slip joints are not special.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from masonry_fem.errors import ProblemError
from masonry_fem.limit.program import FloatArray, Optimum, Program, judged

TOLERANCE = 1e-11
SOLVED = ("Solved", "AlmostSolved", "InsufficientProgress")
INFEASIBLE = ("PrimalInfeasible", "AlmostPrimalInfeasible")
EXACT = 1e-5  # an attempt with a smaller error is accepted
ATTEMPTS: tuple[dict[str, Any], ...] = (
    {},
    {"equilibrate_enable": False},
    {"iterative_refinement_max_iter": 30, "iterative_refinement_reltol": 1e-14},
)
UNBALANCED = 1e-3  # relative imbalance above which a point is no solution


def maximise_cones(program: Program) -> Optimum | None:
    """The optimum of a program; None where its equations have no solution.

    Raises
    ------
    ProblemError : Clarabel gave up.
    """
    import clarabel  # noqa: PLC0415 - only scenes in space need it

    c, d, n = program.count, program.dimension, len(program.fixed)
    length = np.sqrt(1.0 + program.strength.friction**2)
    scale = np.repeat((program.strength.friction / length)[:, None], d, axis=1)
    scale[:, 0] = 1.0 / length
    width = program.matrix.shape[1] + 1
    offset = np.zeros((c, d))
    offset[:, 0] = program.strength.apex
    contacts = sparse.csc_array(program.matrix)[:, : c * d]
    rest = sparse.csc_array(program.matrix)[:, c * d :]
    columns: list[Any] = [contacts * scale.ravel(), rest, sparse.csc_array(program.growing[:, None])]
    equations = sparse.hstack(columns)
    linear, limits = _linear(program, scale, width)
    cones = sparse.hstack([-sparse.eye_array(c * d), sparse.csr_array((c * d, width - c * d))])
    rows = sparse.csc_matrix(sparse.vstack([equations, linear, cones]))
    right = np.concatenate([contacts @ offset.ravel() - program.fixed, limits, np.zeros(c * d)])
    kinds = [clarabel.ZeroConeT(n), clarabel.NonnegativeConeT(len(limits))]
    kinds += [clarabel.SecondOrderConeT(d)] * c
    cost = np.zeros(width)
    cost[-1] = -1.0
    nothing = sparse.csc_matrix((width, width))
    best, told = None, ""
    for attempt in ATTEMPTS:  # near the limit, Clarabel stalls with some settings and not with others
        settings = settings_of(clarabel, **attempt)
        found = clarabel.DefaultSolver(nothing, cost, rows, right, kinds, settings).solve()
        told = str(found.status)
        if told in INFEASIBLE:
            return None
        if told not in SOLVED:
            continue
        solution = np.array(found.x)
        force = np.concatenate([scale.ravel() * solution[: c * d] - offset.ravel(), solution[c * d : -1]])
        made = judged(program, float(solution[-1]), force, np.array(found.z)[:n])
        if best is None or _error(made) < _error(best):
            best = made
        if _error(best) <= EXACT:
            return best
    if best is None or not best.unbalanced <= UNBALANCED:
        raise ProblemError(
            f"limit analysis: Clarabel ended with '{told}', expected an optimum; check for blocks or "
            "friction coefficients of extreme size"
        )
    return best


def _error(made: Optimum) -> float:
    """The larger error of both sides."""
    return made.unbalanced if np.isnan(made.gap) else max(made.unbalanced, made.gap)


def settings_of(clarabel: Any, **others: Any) -> Any:
    """Tight tolerances, no output, one thread, and ``others``."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    for name, value in others.items():
        setattr(settings, name, value)
    return settings


def _linear(program: Program, scale: FloatArray, width: int) -> tuple[sparse.csr_array, FloatArray]:
    """Rows and limits of the bounds on tension, on normal forces and on x, rows · z ≤ limits."""
    strength = program.strength
    cut, bounded = np.flatnonzero(strength.cut), np.flatnonzero(strength.bounded)
    points = np.concatenate([cut, bounded])
    values = np.concatenate([-scale[cut, 0], scale[bounded, 0]])
    places = np.arange(len(points)), program.dimension * points
    normal = sparse.csr_array((values, places), shape=(len(points), width))
    limits = np.concatenate(
        [strength.tension[cut] - strength.apex[cut], strength.most[bounded] + strength.apex[bounded]]
    )
    if not np.isfinite(program.upper):
        return normal, limits
    bound = sparse.csr_array(([1.0], ([0], [width - 1])), shape=(1, width))
    return sparse.csr_array(sparse.vstack([normal, bound])), np.append(limits, program.upper)
