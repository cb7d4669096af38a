"""Linear: plane programs by SciPy's HiGHS.

In the plane a friction cone is what its two edges span, so that the forces are non-negative multiples of
them: a linear program, solved to a vertex and thus to rounding.
"""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from masonry_fem.limit.conic import maximise_cones
from masonry_fem.limit.program import FloatArray, Optimum, Program, judged

logger = logging.getLogger(__name__)

SIMPLEX = 500  # contacts beyond which the interior point with crossover is faster: at 9500 eight times
TOLERANCE = 1e-10  # HiGHS takes no smaller one
SOLVED, INFEASIBLE = 0, 2


def maximise_plane(program: Program) -> Optimum | None:
    """The optimum of a plane program; None where its equations have no solution."""
    edges = _edges(program.strength.friction)
    c = program.count
    contacts = sparse.csc_array(program.matrix)[:, : 2 * c]
    rest = sparse.csc_array(program.matrix)[:, 2 * c :]
    offset = np.zeros((c, 2))
    offset[:, 0] = program.strength.apex
    columns: list[Any] = [contacts @ edges, rest, sparse.csc_array(program.growing[:, None])]
    matrix = sparse.hstack(columns, format="csc")
    fixed = program.fixed - contacts @ offset.ravel()
    bounds: Any = np.full((matrix.shape[1], 2), [-np.inf, np.inf])
    bounds[: 2 * c, 0] = 0.0
    bounds[-1, 1] = program.upper
    cost = np.zeros(len(bounds))
    cost[-1] = -1.0
    rows, limits = _bounds(program, edges, len(cost))
    found: Any = linprog(
        cost, A_eq=matrix, b_eq=-fixed, A_ub=rows, b_ub=limits, bounds=bounds,
        method="highs" if c <= SIMPLEX else "highs-ipm",
        options={"primal_feasibility_tolerance": TOLERANCE, "dual_feasibility_tolerance": TOLERANCE},
    )  # fmt: skip
    if found.status == INFEASIBLE:
        return None
    if found.status != SOLVED:
        # so near the limit that the simplex method finds no feasible vertex: try the interior-point method
        logger.debug("HiGHS ended with '%s'; Clarabel takes over", found.message.strip())
        return maximise_cones(program)
    force = np.concatenate([edges @ found.x[: 2 * c] - offset.ravel(), found.x[2 * c : -1]])
    return judged(program, float(found.x[-1]), force, -np.asarray(found.eqlin.marginals))


def _edges(friction: FloatArray) -> sparse.csr_array:
    """Unit vectors along the two edges of each cone as columns, (2 c, 2 c)."""
    length = np.sqrt(1.0 + friction**2)
    blocks = np.array([[1.0 / length, 1.0 / length], [friction / length, -friction / length]])
    c = len(friction)
    edges = sparse.bsr_array(
        (blocks.transpose(2, 0, 1), np.arange(c), np.arange(c + 1)), shape=(2 * c, 2 * c)
    )
    return sparse.csr_array(edges)


def _bounds(program: Program, edges: sparse.csr_array, columns: int) -> tuple[Any, FloatArray | None]:
    """Rows −(r_N + apex) ≤ tension − apex of the cones that are cut off, and those of greatest forces.

    None where none is.
    """
    strength = program.strength
    cut, bounded = np.flatnonzero(strength.cut), np.flatnonzero(strength.bounded)
    if not len(cut) + len(bounded):
        return None, None
    normal = sparse.csr_array(sparse.vstack([-edges[2 * cut], edges[2 * bounded]]))
    rest = sparse.csr_array((normal.shape[0], columns - normal.shape[1]))
    limits = np.concatenate(
        [strength.tension[cut] - strength.apex[cut], strength.most[bounded] + strength.apex[bounded]]
    )
    return sparse.csr_array(sparse.hstack([normal, rest])), limits
