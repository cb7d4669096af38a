"""SweepForm: what a problem is prepared to before ``sweeps`` run over it.

form = SweepForm(problem, relaxation=1.0, threads=2)
made, error = form.sweep(impulse, 100, 1e-6)    # changes the impulse
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.compliance import operator
from masonry_fem.nscd.local import Law, reduce_blocks
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale, free_speed, rigid_diagonal
from masonry_fem.nscd.solvers.colouring import Colouring, colour_bodies, colour_couplings
from masonry_fem.nscd.solvers.sweeps import kernel
from masonry_fem.nscd.threads import available_threads, several_threads

FloatArray = NDArray[np.float64]

# Sweeps between two measures of the natural map: a measure costs less than a sweep.
INTERVAL = 5


class SweepForm:
    """Sweeps over a problem: they carry the velocities of rigid bodies along, or have the block-sparse W.

    Parameters
    ----------
    problem : The contact problem.
    relaxation : ω of a visit.
    threads : Threads that share a colour; None: if nothing is relaxed, all contacts in a shuffled order.
    """

    def __init__(self, problem: ContactProblem, relaxation: float = 1.0, threads: int | None = None) -> None:
        self.problem, self.relaxation, self.begun = problem, relaxation, 0
        W = None if problem.rigid else problem.delassus()
        self.turns = relaxation != 1.0 or threads is not None
        self.colouring = _colouring(problem, W) if self.turns else _shuffled(problem.count)
        order = self.colouring.order
        own = rigid_diagonal(problem) if W is None else operator(W).diagonal()
        law, folded = _fold(problem, own)
        local = reduce_blocks(folded)
        fixed = (own, local, contact_scale(problem), problem.friction)
        free = problem.free_velocity if W is None else problem.plain_velocity()
        self.law: Law = None if law is None else (law[0][order], law[1][order], law[2][order])
        self.same = tuple(np.ascontiguousarray(part[order]) for part in (*fixed, free))
        # errors are measured by the largest free velocity, or by the velocities that impulses cause
        self.speed = free_speed(problem) if W is None else 0.0
        self.root = np.sqrt(np.where(problem.rigid_mass > 0, problem.rigid_mass, 1.0))
        self.coupling = _of_bodies(problem, self.root, order) if W is None else _of_blocks(W, order)
        self.sums = np.empty((len(self.colouring.groups) - 1, 5))
        self.slip = np.zeros(problem.count)
        # a single group gives nothing to share
        self.threads = threads if threads is not None and self.colouring.count > 1 else 1

    def sweep(self, impulse: FloatArray, count: int, tolerance: float) -> tuple[int, float]:
        """At most ``count`` sweeps that change the impulse; how many, and the error they left."""
        threads = available_threads(self.threads)
        with several_threads(threads):
            return self.swept(impulse, count, tolerance, parallel=threads > 1)

    def swept(
        self, impulse: FloatArray, count: int, tolerance: float, *, parallel: bool
    ) -> tuple[int, float]:
        """The same, on the threads that there are."""
        order = self.colouring.order
        ordered = np.ascontiguousarray(impulse[order])
        motion = None
        if self.problem.rigid:
            # made anew from the impulses, so that rounding does not pile up from batch to batch
            motion = np.ascontiguousarray(self.root * self.problem.balanced_velocity(impulse))
        data = (*self.coupling[:2], motion, *self.coupling[2:], *self.same, ordered, self.slip)
        head = (self.colouring.groups, self.colouring.colours, self.sums, self.speed, self.relaxation)
        turns = self.turns * np.arange(self.begun, self.begun + count)
        axes = tuple(range(self.problem.dimension))
        made, error = kernel(parallel=parallel)(*head, turns, INTERVAL, tolerance, axes, self.law, data)
        impulse[order] = ordered
        self.begun += made
        return made, error


def _colouring(problem: ContactProblem, W: sparse.bsr_array | None) -> Colouring:
    """Colours of contacts that have no body in common, or that no block of W couples."""
    if W is None:
        return colour_bodies(problem.bodies)
    stored = (np.ones(len(W.indices)), W.indices, W.indptr)
    return colour_couplings(sparse.csr_array(stored, shape=(problem.count, problem.count)))


@lru_cache(maxsize=1)
def _shuffled(count: int) -> Colouring:
    """One group, in a fixed shuffle.

    Errors travel with a regular order along courses and columns; on walls a shuffled one needs down
    to a third of the sweeps. It is the same in every run.
    """
    order = np.random.default_rng(0).permutation(count)
    return Colouring(order, np.array([0, count]), np.array([0, 1]))


def _of_bodies(problem: ContactProblem, root: FloatArray, order: NDArray[np.int64]) -> tuple[Any, ...]:
    """Bodies and B M^-½ of contacts in an order; no W."""
    inverse = np.concatenate([1.0 / root, np.zeros((1, root.shape[1]))])
    weighted = problem.rigid_map * inverse[problem.bodies][:, :, None, :]
    return problem.bodies[order].astype(np.int64), np.ascontiguousarray(weighted[order]), None, None, None


def _of_blocks(W: sparse.bsr_array, order: NDArray[np.int64]) -> tuple[Any, ...]:
    """No bodies; pointer, other contacts and blocks of W, rows and columns in an order."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    sizes = np.diff(W.indptr)[order]
    pointer = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    picked = np.repeat(W.indptr[:-1][order] - pointer[:-1], sizes) + np.arange(pointer[-1])
    return None, None, pointer, place[W.indices[picked]], np.ascontiguousarray(W.data[picked])


def _fold(problem: ContactProblem, own: FloatArray) -> tuple[Law, FloatArray]:
    """What the kernels need of the cohesion's stiffness, and the contacts' own blocks with it, (c, d, d)."""
    stiffness = problem.cohesion_stiffness
    if stiffness is None:
        return None, own
    turn = np.linalg.inv(np.eye(problem.dimension) + own @ stiffness)
    block = turn @ own
    return (turn, block, np.ascontiguousarray(stiffness)), block
