"""Forms of sweeps: what a problem is prepared to before ``sweeps`` or ``coloured_sweeps`` run over it.

``PlainForm`` for a block-sparse W and ``BodyForm`` for rigid bodies visit the contacts in a shuffled order,
``ColouredForm`` either colour after colour.

    form = make_form(problem, relaxation=1.0, threads=2)
    made, error = form.sweep(impulse, 100, 1e-6)    # changes the impulse
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.local import Law, reduce_blocks
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale, diagonal_blocks, free_speed, rigid_diagonal
from masonry_fem.nscd.solvers import sweeps
from masonry_fem.nscd.solvers.coloured_sweeps import kernel
from masonry_fem.nscd.solvers.colouring import Colouring, colour_bodies, colour_couplings
from masonry_fem.nscd.threads import available_threads, several_threads

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Sweeps between two measures of the natural map: a measure costs less than a sweep.
INTERVAL = 5


class PlainForm:
    """Sweeps over the block-sparse W."""

    name = "plain"
    # errors are measured by the velocities that impulses cause
    speed = 0.0

    def __init__(self, problem: ContactProblem) -> None:
        c, d = problem.count, problem.dimension
        W = problem.delassus()
        rows = np.repeat(np.arange(c), np.diff(W.indptr))
        off = rows != W.indices
        own = diagonal_blocks(W, c, d)
        self.pointer = np.concatenate([[0], np.cumsum(np.bincount(rows[off], minlength=c))])
        self.other = W.indices[off].astype(np.int64)
        self.blocks = np.ascontiguousarray(W.data[off].reshape(-1, d * d))
        self.own = own.reshape(c, d * d)
        self.law, own = _fold(problem, own)
        self.local = reduce_blocks(own)
        self.scale = contact_scale(problem)
        self.friction = np.ascontiguousarray(problem.friction)
        self.free = np.ascontiguousarray(problem.plain_velocity())
        self.slip = np.zeros(c)
        self.order = _visiting_order(c)

    def sweep(self, impulse: FloatArray, count: int, tolerance: float) -> tuple[int, float]:
        """At most ``count`` sweeps that change the impulse; how many, and the error they left."""
        head = (self.order, self.pointer, self.other, self.blocks, self.own, self.local, self.scale)
        tail = (count, INTERVAL, tolerance, self.law)
        if impulse.shape[1] == 2:
            made: tuple[int, float] = sweeps.plain_2d(*head, self.friction, self.free, impulse, *tail)
        else:
            made = sweeps.plain_3d(*head, self.friction, self.free, impulse, self.slip, *tail)
        return made

    def colouring(self) -> Colouring:
        """Colours of contacts that no block of W couples."""
        c = len(self.friction)
        couplings = sparse.csr_array((np.ones(len(self.other)), self.other, self.pointer), shape=(c, c))
        return colour_couplings(couplings)

    def ordered(self, order: IntArray) -> tuple[Any, ...]:
        """What stays the same in all sweeps, the contacts in an order."""
        c = len(order)
        place = np.empty(c, dtype=np.int64)
        place[order] = np.arange(c)
        sizes = np.diff(self.pointer)[order]
        pointer = np.concatenate([[0], np.cumsum(sizes)])
        picked = np.repeat(self.pointer[order] - pointer[:-1], sizes) + np.arange(pointer[-1])
        same = (self.own, self.local, self.scale, self.friction, self.free)
        return (
            pointer,
            place[self.other[picked]],
            self.blocks[picked],
            *(array[order] for array in same),
            _ordered(self.law, order),
        )

    def moving(self, impulse: FloatArray) -> tuple[FloatArray, ...]:
        """What sweeps carry along besides the impulses: nothing."""
        return ()


class BodyForm:
    """Sweeps that carry the velocities of rigid bodies along."""

    name = "bodies"

    def __init__(self, problem: ContactProblem) -> None:
        c, d = problem.count, problem.dimension
        own = rigid_diagonal(problem)
        root = np.sqrt(np.where(problem.rigid_mass > 0, problem.rigid_mass, 1.0))
        self.problem, self.root = problem, root
        inverse = np.concatenate([1.0 / root, np.zeros((1, root.shape[1]))])
        weighted = problem.rigid_map * inverse[problem.bodies][:, :, None, :]
        self.bodies = np.ascontiguousarray(problem.bodies, dtype=np.int64)
        self.maps = np.ascontiguousarray(weighted.reshape(c, 2, -1))
        self.own = own.reshape(c, d * d)
        self.law, own = _fold(problem, own)
        self.local = reduce_blocks(own)
        self.scale = contact_scale(problem)
        self.speed = free_speed(problem)
        self.friction = np.ascontiguousarray(problem.friction)
        self.free = np.ascontiguousarray(problem.free_velocity)
        self.slip = np.zeros(c)
        self.order = _visiting_order(c)

    def sweep(self, impulse: FloatArray, count: int, tolerance: float) -> tuple[int, float]:
        """At most ``count`` sweeps that change the impulse; how many, and the error they left."""
        (motion,) = self.moving(impulse)
        head = (
            self.order,
            self.bodies,
            self.maps,
            self.own,
            self.local,
            self.scale,
            self.friction,
            self.free,
        )
        tail = (self.speed, count, INTERVAL, tolerance, self.law)
        if impulse.shape[1] == 2:
            made: tuple[int, float] = sweeps.bodies_2d(*head, impulse, motion, *tail)
        else:
            made = sweeps.bodies_3d(*head, impulse, motion, self.slip, *tail)
        return made

    def colouring(self) -> Colouring:
        """Colours of contacts that have no body in common."""
        return colour_bodies(self.bodies)

    def ordered(self, order: IntArray) -> tuple[Any, ...]:
        """What stays the same in all sweeps, the contacts in an order."""
        same = (self.bodies, self.maps, self.own, self.local, self.scale, self.friction, self.free)
        return (*(array[order] for array in same), _ordered(self.law, order))

    def moving(self, impulse: FloatArray) -> tuple[FloatArray, ...]:
        """What sweeps carry along besides the impulses: M^½ U."""
        # made anew from the impulses, so that rounding does not pile up from batch to batch
        return (self.root * self.problem.balanced_velocity(impulse),)


class ColouredForm:
    """Sweeps of another form colour after colour, relaxed, shared by threads."""

    def __init__(self, form: PlainForm | BodyForm, relaxation: float, threads: int) -> None:
        self.form, self.relaxation = form, relaxation
        self.colouring = form.colouring()
        self.same = form.ordered(self.colouring.order)
        self.sums = np.empty((len(self.colouring.groups) - 1, 5))
        self.slip = np.zeros(len(self.colouring.order))
        # a single group gives nothing to share
        self.threads = threads if self.colouring.count > 1 else 1
        self.begun = 0

    def sweep(self, impulse: FloatArray, count: int, tolerance: float) -> tuple[int, float]:
        """At most ``count`` sweeps that change the impulse; how many, and the error they left."""
        order, threads = self.colouring.order, available_threads(self.threads)
        ordered = impulse[order]
        data = (*self.same, ordered, *self.form.moving(impulse), self.slip)
        head = (self.colouring.groups, self.colouring.colours, self.sums, self.form.speed, self.relaxation)
        with several_threads(threads):
            swept = kernel(f"{self.form.name}_{impulse.shape[1]}d", parallel=threads > 1)
            made, error = swept(*head, self.begun, count, INTERVAL, tolerance, data)
        impulse[order] = ordered
        self.begun += made
        return made, error


Form = PlainForm | BodyForm | ColouredForm


def make_form(problem: ContactProblem, relaxation: float, threads: int | None) -> Form:
    """The sweeps for a problem: in a shuffled order, but coloured where relaxed or for given threads."""
    form = BodyForm(problem) if problem.rigid else PlainForm(problem)
    if relaxation == 1.0 and threads is None:
        return form
    return ColouredForm(form, relaxation, 1 if threads is None else threads)


def _fold(problem: ContactProblem, own: FloatArray) -> tuple[Law, FloatArray]:
    """What the kernels need of the cohesion's stiffness, and the contacts' own blocks with it, (c, d, d)."""
    stiffness = problem.cohesion_stiffness
    if stiffness is None:
        return None, own
    c, d = problem.free_velocity.shape
    turn = np.linalg.inv(np.eye(d) + own @ stiffness)
    block = turn @ own
    flat = (np.ascontiguousarray(part.reshape(c, d * d)) for part in (turn, block, stiffness))
    return (next(flat), next(flat), next(flat)), block


def _ordered(law: Law, order: IntArray) -> Law:
    return None if law is None else (law[0][order], law[1][order], law[2][order])


def _visiting_order(count: int) -> NDArray[np.int64]:
    """A fixed shuffle of the contacts.

    Errors travel with a regular order along courses and columns; on walls a shuffled one needs down
    to a third of the sweeps. It is the same in every run.
    """
    return np.random.default_rng(0).permutation(count)
