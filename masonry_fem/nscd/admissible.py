"""Admissible impulses: whether any impulses within the friction cones balance the loads.

    found = admissible_impulses(problem)
    found.unbalanced        # ~0: there are some; else no equilibrium exists, whatever the motion

min ½‖Bᵀp + f_r‖² over the cones is convex. Where the minimum is zero the loads can be carried, by p;
where it is not, the unbalanced impulse is the rigid motion of a mechanism (Farkas), and no state of
sticking and sliding can be an equilibrium. It is the static theorem of limit analysis, and the
judge of a verdict that the nonlinear solution gave.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd import graphs
from masonry_fem.nscd.problem import ContactProblem

FloatArray = NDArray[np.float64]

# Unbalanced part of the loads below which they can be carried.
BALANCED = 1e-5
ITERATIONS = 20_000
INTERVAL = 100  # iterations between two looks at the balance
POWER_STEPS = 60  # for the largest eigenvalue of BBᵀ; the margin covers what they leave
MARGIN = 1.02


@dataclass(frozen=True, slots=True)
class Admissible:
    """The best balance found.

    Attributes
    ----------
    impulse : p within the cones [N s], shape (c, d).
    unbalanced : ‖Bᵀp + f_r‖ / ‖f_r‖ on the modes without inertia; 0 without loads.
    """

    impulse: FloatArray
    unbalanced: float


def admissible_impulses(
    problem: ContactProblem, tolerance: float = 1e-6, iterations: int = ITERATIONS
) -> Admissible:
    """Impulses within the cones that balance the loads on static modes as well as they can.

    Accelerated projected gradient with restarts (O'Donoghue and Candès 2015): products with B only,
    a fraction of a second for a thousand contacts. It stops at the relative ``tolerance``, or where
    the balance found is proven to be at most twice the best, and that to be above the tolerance.
    """
    impulse = np.zeros_like(problem.free_velocity)
    rigid_map, load = _static_part(problem)
    size = float(np.linalg.norm(load))
    if size == 0 or rigid_map.nnz == 0:
        return Admissible(impulse, float(size > 0))
    transposed = rigid_map.T.tocsr()
    slope = _largest_eigenvalue(rigid_map, transposed)
    ahead, momentum, shape, unbalanced = impulse, 1.0, impulse.shape, 1.0
    for made in range(1, iterations + 1):
        gradient = (rigid_map @ (transposed @ ahead.ravel() + load)).reshape(shape)
        new = graphs.project_cone(ahead - gradient / slope, problem.friction)
        if ((ahead - new) * (new - impulse)).sum() > 0:
            momentum = 1.0
        following = 0.5 * (1 + np.sqrt(1 + 4 * momentum**2))
        ahead = new + (momentum - 1) / following * (new - impulse)
        impulse, momentum = new, following
        if made % INTERVAL == 0:
            residual = transposed @ impulse.ravel() + load
            unbalanced = float(np.linalg.norm(residual)) / size
            if unbalanced <= tolerance:
                break
            # larger impulses leave more than the tolerance as rounding of their products with B
            largest = tolerance / np.finfo(float).eps * size / np.sqrt(slope)
            least = _least_unbalanced(problem, rigid_map, load, residual, largest) / size
            if least >= max(tolerance, 0.5 * unbalanced):
                break
    return Admissible(impulse, unbalanced)


def _least_unbalanced(
    problem: ContactProblem,
    rigid_map: sparse.csr_array,
    load: FloatArray,
    motion: FloatArray,
    largest: float,
) -> float:
    """What impulses in the cones with ‖p‖ ≤ ``largest`` leave unbalanced at least, by Farkas' lemma.

    ‖Bᵀp + f‖ ‖U‖ ≥ U·f + p·BU for any motion U, here the unbalanced impulse itself. In the cones
    p·BU ≥ −‖p‖ dist(BU, K*), and that distance is the length of −BU projected on K (Moreau). At the
    minimum it is zero and the bound the minimum itself.
    """
    opened = (rigid_map @ motion).reshape(problem.free_velocity.shape)
    closing = float(np.linalg.norm(graphs.project_cone(-opened, problem.friction)))
    return float(motion @ load - largest * closing) / float(np.linalg.norm(motion))


def _static_part(problem: ContactProblem) -> tuple[sparse.csr_array, FloatArray]:
    """B and f_r of the modes without inertia: (c d, k) and (k,)."""
    c, d = problem.free_velocity.shape
    bodies, m = problem.rigid_mass.shape
    contact, side = np.nonzero(problem.bodies >= 0)
    body, local = problem.bodies[contact, side], problem.rigid_map[contact, side]
    rows = np.broadcast_to((contact[:, None] * d + np.arange(d))[:, :, None], local.shape)
    columns = np.broadcast_to((body[:, None] * m + np.arange(m))[:, None, :], local.shape)
    where = (rows.ravel(), columns.ravel())
    whole = sparse.csr_array((local.ravel(), where), shape=(c * d, bodies * m))
    static = np.flatnonzero(problem.rigid_mass.ravel() <= 0)
    return sparse.csr_array(whole[:, static]), problem.rigid_impulse.ravel()[static]


def _largest_eigenvalue(rigid_map: sparse.csr_array, transposed: sparse.csr_array) -> float:
    vector = np.random.default_rng(0).normal(size=rigid_map.shape[0])
    length = 1.0
    for _ in range(POWER_STEPS):
        vector = rigid_map @ (transposed @ (vector / np.linalg.norm(vector)))
        length = float(np.linalg.norm(vector))
    return MARGIN * length
