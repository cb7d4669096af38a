"""ElasticKrylov: a Newton step with elastic contacts by iteration, where its factor would fill.

The matrix of a step (``newton_system``) is that of a wall of rigid stones whose joints are springs, but for
what W_el couples through the stones from joint to joint. The *preconditioner* leaves that out: of W_el it has
the blocks between the contacts of one interface, so that the contacts are solved for interface by interface,
and a sparse matrix of the bodies' velocities is left, as that of a rigid wall. It takes the bodies' rows as
they are, and so does all that is iterated on: what remains is a residual at contacts. Contacts of several
interfaces that lie at one *seam* of stones are solved for together besides. Around a stone that yields all
interfaces are one: what it flows at one it does at all others. Residuals are measured as errors are, each
contact by what it gives way: those at such a stone would hide all others.

    undivided = Undivided(problem, elastic, scale)                # once for a problem
    solve = undivided.solver(terms, kept, ...)                    # once for a step

How many iterations that takes depends on how finely stones are divided, hardly on how many there are.

References
----------
C. Keller, N. I. M. Gould and A. J. Wathen, "Constraint preconditioning for indefinite linear systems", SIAM
Journal on Matrix Analysis and Applications 21 (2000). Z. Dostál, D. Horák and R. Kučera, "Total FETI: an
easier implementable variant of the FETI method for numerical solution of elliptic PDE", Communications in
Numerical Methods in Engineering 22 (2006).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, gmres

from masonry_fem.host.memory import keep
from masonry_fem.nscd.compliance import Operator, Shared
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.linear import Factorised, Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import multiplied
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix
from masonry_fem.nscd.solvers.elastic_kernel import add_solutions, coupled, rows_product, take_followed
from masonry_fem.nscd.solvers.elastic_matrix import Terms
from masonry_fem.nscd.solvers.seams import together
from masonry_fem.nscd.transfer import to_bodies, to_contacts

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]
Solve = Callable[[FloatArray], FloatArray]

# Elastic contacts from which iterations cost less than a factor, and contacts of one interface up to which
# they do: its block is dense. With 300 contacts either takes as long, with 700 a wall takes a third of it.
CONTACTS = 500
WIDEST = 400
# Elastic contacts from which Newton's method takes the weights and the parts of large walls in statics, and
# ranks share them. With 500 a tower that is pushed takes 98 steps for 42; with a million 20×20 bricks take 78
# for 12. In dynamics a wall of 20×20 that rebounds takes more than a minute a step so, and 2 s without.
MANY = 2_000
# Residual to reach, relative to that of the preconditioner's own solution: 40×40 bricks take half as many
# steps more with three times of it, and vaults a third longer with a third of it.
ACCURACY = 3e-3
# The same below MANY contacts: Newton's method then takes the steps that it takes with factors. With ACCURACY
# a wall whose head joints are open by 1e-12 m has not ended after 400 steps; so it takes 5.
EXACT = 1e-8
# The same of many in dynamics, whatever their number: walls that rebound take half as long again with 1e-3,
# and as long with 1e-4 or 1e-6.
MOVING = 1e-5
# What of solving for the contacts of a seam interface by interface is taken back where they are solved for
# together. With all of it rubble takes twice as many iterations in places, with half one more or two.
SHARE = 0.75
# Iterations after which they have failed: walls take 10 to 20; façades that hang together by a few lintels a
# hundred and more.
ITERATIONS = 50
# Change of a contact's values, relative to what contacts give way on average, from which its interface is
# solved for anew: 100×100 bricks take 33 s to solve for 35 with any change. Where half of a wall is a
# thousand times softer, iterations are no more. With 1e-3 walls take twice as many linear systems.
FELT = 1e-5
# Entries of matrices that are made at a time. All at once 100×100 bricks take 4.10 GB for 3.84, and 39 s to
# solve for 37; 40×40 take as long with any number from 2**14 on.
AT_ONCE = 2**20
# Contacts up to which a factor takes over then. Beyond, a step is taken as it is, in statics after fewer, and
# the line search judges it: where stones lie loosely it becomes too short, and fifty leave no less to do than
# twenty. The residual to reach is smaller: with ACCURACY two of 13 runs of 100×100 bricks, which differ in
# rounding, throw stones at one step or another and take 40 and 52 s for 33; all take 30 s so.
FACTORED = 20_000
BEYOND, CLOSER = 20, 1e-3


def iterable(problem: ContactProblem, library: Library) -> bool:
    """True for as many elastic contacts as iterations are worth a try for.

    Parameters
    ----------
    problem : The contact problem. library : How linear systems are solved.
    """
    if library == "auto":
        return iteration_pays(problem)
    return library == "krylov" and bool(problem.operator.elastic().any())


def at_rest(problem: ContactProblem) -> bool:
    """True in statics: some body has no inertia.

    Parameters
    ----------
    problem : The contact problem.
    """
    return bool((problem.rigid_mass <= 0).any())


def are_many(problem: ContactProblem, library: Library) -> bool:
    """True where contacts that iterations are worth a try for are many.

    Parameters
    ----------
    problem, library : As for ``iterable``.
    """
    return problem.count >= MANY or library == "krylov"


def iteration_pays(problem: ContactProblem) -> bool:
    """True for many contacts, all elastic, in many interfaces: iterations should cost less than a factor.

    Parameters
    ----------
    problem : The contact problem.
    """
    elastic = problem.operator.elastic()
    # rigid stones among elastic ones take Newton's method three times as many steps so
    if problem.count < CONTACTS or not problem.body_count or not elastic.all():
        return False
    return all(group.shape[1] <= WIDEST for group in interfaces_by_size(problem, elastic))


class Effort(NamedTuple):
    """What is asked of an iteration.

    Attributes
    ----------
    most : Iterations after which it has failed.
    accuracy : Residual to reach, relative to that of the preconditioner's own solution.
    """

    most: int
    accuracy: float

    @classmethod
    def of(cls, count: int, *, rests: bool) -> Self:
        """That for a step of so many contacts that are unknowns, between bodies at rest or in dynamics."""
        if not rests and count >= MANY:
            return cls(ITERATIONS, MOVING)
        if count > FACTORED:
            return cls(BEYOND, CLOSER)
        return cls(ITERATIONS, ACCURACY if count >= MANY else EXACT)


def interfaces_by_size(problem: ContactProblem, elastic: Mask) -> list[IntArray]:
    """Elastic contacts by the pair of bodies that they join.

    Parameters
    ----------
    problem : The contact problem. elastic : Contacts that have compliance, shape (c,).

    Returns
    -------
    For each number k of contacts those of the n interfaces that have as many, shape (n, k).
    """
    contacts = np.flatnonzero(elastic)
    pair = np.sort(problem.bodies[contacts], axis=1)
    key = (pair[:, 0] + 1) * (problem.body_count + 1) + pair[:, 1] + 1
    supports = key == 0  # contacts between supports: each is an interface of its own
    key[supports] = -1 - np.arange(supports.sum())
    order = np.argsort(key, kind="stable")
    _, first, size = np.unique(key[order], return_index=True, return_counts=True)
    return [contacts[order[first[size == k][:, None] + np.arange(k)]] for k in np.unique(size).tolist()]


@dataclass(frozen=True, slots=True)
class Sets:
    """Sets of contacts that are solved for together.

    Attributes
    ----------
    groups : Contacts of the n sets with k of them, an array (n, k) for each k.
    coupling : Blocks of W_el between them, an array (n, k d, k d) for each k.
    """

    groups: list[IntArray]
    coupling: list[FloatArray]

    @classmethod
    def of(cls, operator: Operator, groups: list[IntArray]) -> Self:
        """Those of an operator."""
        return cls(groups, [operator.among(group) for group in groups])

    def again(self, operator: Shared) -> Self:
        """The same of another operator of the same contacts, in the room of these."""
        rooms = zip(self.groups, self.coupling, strict=True)
        return replace(self, coupling=[operator.among(group, room) for group, room in rooms])


def numbered(interfaces: Sequence[IntArray], count: int) -> IntArray:
    """Number of the interface of each contact, −1 where there is none, shape (c,).

    Parameters
    ----------
    interfaces : Contacts of the n interfaces that have k of them, an array (n, k) for each k.
    count : Of all contacts, c.
    """
    number, made = np.full(count, -1), 0
    for group in interfaces:
        number[group] = made + np.arange(len(group))[:, None]
        made += len(group)
    return number


def bodies_of(bodies: IntArray, group: IntArray) -> tuple[IntArray, IntArray]:
    """Bodies that sets of contacts join, and which of them the two sides of each contact are.

    Parameters
    ----------
    bodies : Of all contacts, −1 for none, shape (c, 2). group : The n sets, shape (n, k).

    Returns
    -------
    The bodies, −1 where a set has fewer than others, (n, b), and places among them, (n, k, 2).
    """
    sides = bodies[group].reshape(len(group), -1)
    order = np.argsort(sides, axis=1, kind="stable")
    sides = np.take_along_axis(sides, order, axis=1)
    place = np.zeros_like(sides)
    place[:, 1:] = np.cumsum(sides[:, 1:] != sides[:, :-1], axis=1)
    found = np.full((len(group), place.max(initial=0) + 1), -1)
    np.put_along_axis(found, place, sides, axis=1)
    places = np.empty_like(place)
    np.put_along_axis(places, order, place, axis=1)
    return found, places.reshape(*group.shape, 2)


@dataclass(frozen=True, slots=True)
class Values:
    """What a step has at some contacts.

    Attributes
    ----------
    own : Derivative by the contact's own impulse, over the unit of impulses, shape (c, d, d).
    by_velocity : Derivative by its velocity, shape (c, d, d).
    closed : Contacts that take part, shape (c,).
    unit : Impulses are solved for as unit · p.
    """

    own: FloatArray
    by_velocity: FloatArray
    closed: Mask
    unit: float

    @classmethod
    def at(cls, terms: Terms) -> Self:
        """Those of all contacts of a problem."""
        return cls(terms.own / terms.unit, terms.by_velocity, terms.closed, terms.unit)

    def changed(self, before: Values) -> Mask:
        """Contacts that have others than before, by as much as iterations would feel, shape (c,)."""
        found: Mask = self.closed != before.closed
        for now, then in ((self.own, before.own), (self.by_velocity, before.by_velocity)):
            found |= (np.abs(now - then) > FELT).any(axis=(1, 2))
        return found


class Solved(NamedTuple):
    """What it takes to solve for the contacts of n interfaces with k of them.

    Attributes
    ----------
    inverse : (A + Bc W_el)⁻¹ within interfaces, shape (n, k d, k d).
    followed : It times Bc B of their b bodies, shape (n, k d, b m).
    given : Bᵀ times that: what is left between the bodies, negative, shape (n, b, b, m, m).
    """

    inverse: FloatArray
    followed: FloatArray
    given: FloatArray

    @classmethod
    def room(cls, n: int, k: int, b: int, d: int, m: int) -> Self:
        """Arrays that nothing is in yet, with d and m numbers of a contact and a body."""
        return cls(np.empty((n, k * d, k * d)), np.empty((n, k * d, b * m)), np.empty((n, b, b, m, m)))


class Rows:
    """The rows of some contacts without what W_el couples between interfaces; 1 where contacts are open.

    Parameters
    ----------
    bodies : On their two sides, shape (c, 2).
    maps : B by contact and side, shape (c, 2, d, m).
    interfaces : The contacts, interface by interface.
    seams : Those that are strongly coupled beyond.
    interface : Number of each one's interface, and of those that seams have beyond these, shape (c + s,);
        None: seams have no others.
    before : Those of a problem of the same contacts that is done with: its room is used again.

    Attributes
    ----------
    values : Of the step whose rows these are; None: of none. sets : The interfaces and the seams.
    """

    def __init__(
        self,
        bodies: IntArray,
        maps: FloatArray,
        interfaces: Sets,
        seams: Sets,
        interface: IntArray | None = None,
        before: Rows | None = None,
    ) -> None:
        c, _, d, m = maps.shape
        self.values: Values | None = None
        self.bodies, self.maps = bodies, maps
        self.sets = interfaces, seams
        self.groups, self.seams = interfaces.groups, seams.groups
        self._interface: IntArray = numbered(self.groups, c) if interface is None else interface
        self._joins: list[tuple[IntArray, IntArray]] = (
            [bodies_of(bodies, group) for group in self.groups] if before is None else before._joins
        )
        self.solved: list[Solved] = (
            [
                Solved.room(group.shape[0], group.shape[1], joined.shape[1], d, m)
                for group, (joined, _) in zip(self.groups, self._joins, strict=True)
            ]
            if before is None
            else before.solved
        )
        self.joined: list[FloatArray] = (
            [np.empty_like(W) for W in seams.coupling] if before is None else before.joined
        )
        self.own: FloatArray = np.empty((len(self._interface), d, d)) if before is None else before.own

    def take(self, values: Values) -> None:
        """Become the rows of a step, made anew where it has other values than the last.

        Parameters
        ----------
        values : Of the step, also at the contacts that seams have beyond.
        """
        before, self.values = self.values, None  # should this fail, nothing is known
        closed = values.closed
        changed = np.ones_like(closed) if before is None else values.changed(before)
        self.own[:] = values.own
        self.own[~closed] = np.eye(self.own.shape[1])
        by_velocity = values.by_velocity / values.unit
        interfaces, seams = (sets.coupling for sets in self.sets)
        for solved, join, group, W in zip(self.solved, self._joins, self.groups, interfaces, strict=True):
            for chosen in _in_turn(changed[group].any(axis=1), W):
                made = coupled(chosen, group, self._interface, W, self.own, by_velocity, closed)
                self._solve(solved, chosen, np.linalg.inv(made), values, group[chosen], join[1][chosen])
        together = np.zeros_like(self._interface)
        for joined, group, W in zip(self.joined, self.seams, seams, strict=True):
            for chosen in _in_turn(changed[group].any(axis=1), W):
                at_once, apart = (
                    coupled(chosen, group, sets, W, self.own, by_velocity, closed)
                    for sets in (together, self._interface)
                )
                joined[chosen] = np.linalg.inv(at_once) - SHARE * np.linalg.inv(apart)
        self.values = values

    def _solve(
        self,
        solved: Solved,
        chosen: IntArray,
        inverse: FloatArray,
        values: Values,
        group: IntArray,
        slots: IntArray,
    ) -> None:
        """Put down what solving for some interfaces takes, from their inverses and the bodies' places."""
        (n, k), (d, m), count = group.shape, self.maps.shape[2:], solved.given.shape[1]
        whole, given = np.zeros((n, k, d, count, m)), self.maps[group]
        given[~values.closed[group]] = 0.0
        row, column = np.arange(n)[:, None], np.arange(k)
        for side in range(2):
            whole[row, column, :, slots[:, :, side]] = given[:, :, side]
        maps = whole.reshape(n, k, d, count * m)
        of_each = values.by_velocity[group].reshape(n * k, d, d), maps.reshape(n * k, d, count * m)
        pushed = multiplied(*of_each).reshape(n, k * d, count * m)
        followed = inverse @ pushed
        left = maps.reshape(n, k * d, count * m).transpose(0, 2, 1) @ followed
        solved.inverse[chosen], solved.followed[chosen] = inverse, followed
        solved.given[chosen] = left.reshape(n, count, m, count, m).swapaxes(2, 3)

    def eliminated(self) -> Iterator[tuple[IntArray, FloatArray]]:
        """For each number of contacts the bodies of its sets, (n, b), and what solving for all leaves there.

        The latter negative, shape (n, b, b, m, m).
        """
        return ((bodies, solved.given) for (bodies, _), solved in zip(self._joins, self.solved, strict=True))

    def inside(self, force: FloatArray) -> FloatArray:
        """Impulses of given rows, interface by interface and seam by seam, both of shape (c + s, d)."""
        force, impulse = np.ascontiguousarray(force), np.zeros(force.shape)
        for group, solved in zip(self.groups, self.solved, strict=True):
            add_solutions(group, solved.inverse, force, impulse)
        for group, joined in zip(self.seams, self.joined, strict=True):
            add_solutions(group, joined, force, impulse)
        return impulse

    def moving(self, impulse: FloatArray, motion: FloatArray) -> FloatArray:
        """Impulses of given rows where bodies move, from those where they do not, both (c, d)."""
        motion, left = np.ascontiguousarray(motion), impulse.copy()
        for group, (bodies, _), solved in zip(self.groups, self._joins, self.solved, strict=True):
            take_followed(group, solved.followed, bodies, motion, left)
        return left

    def to_bodies(self, impulse: FloatArray, count: int) -> FloatArray:
        """Bᵀ p of closed contacts, shape (b, m)."""
        assert self.values is not None
        pressed = np.where(self.values.closed[: len(impulse), None], impulse, 0.0)
        given: FloatArray = to_bodies(self.bodies, self.maps, pressed, count)
        return given

    def product(self, x: FloatArray, given: FloatArray, motion: FloatArray) -> FloatArray:
        """The rows times x and U, where x at closed contacts makes velocities ``given``, shape (c, d)."""
        values, c = self.values, len(x)
        assert values is not None
        product: FloatArray = rows_product(
            values.by_velocity[:c],
            self.own[:c],
            values.unit,
            np.ascontiguousarray(given),
            to_contacts(self.bodies, self.maps, motion),
            x,
        )
        return product


def _in_turn(chosen: Mask, coupling: FloatArray) -> Iterator[IntArray]:
    """Numbers of chosen sets (n,), some at a time: what is made of each of them is as large as its W_el."""
    numbers, some = (
        np.flatnonzero(chosen),
        max(1, AT_ONCE // max(1, coupling[0].size if len(coupling) else 1)),
    )
    return (numbers[first : first + some] for first in range(0, len(numbers), some))


class Undivided:
    """A problem that one rank solves: its elastic contacts by the pair of bodies that they join.

    Parameters
    ----------
    problem : The contact problem.
    elastic : Contacts that have compliance, shape (c,).
    scale : w of each contact, by which residuals are measured, shape (c,).

    Attributes
    ----------
    of_bodies : Contacts of each interface, or of several that are solved for as one.
    seams : Those that are strongly coupled beyond.
    """

    def __init__(self, problem: ContactProblem, elastic: Mask, scale: FloatArray) -> None:
        keep()  # each step makes arrays of a hundred megabytes
        self.problem, self.scale = problem, scale
        operator, interfaces = problem.operator, interfaces_by_size(problem, elastic)
        found, joined = together(operator, numbered(interfaces, problem.count))
        self.of_bodies = Sets.of(operator, interfaces if found is None else found)
        self.seams = Sets.of(operator, joined)
        self.rows: Rows | None = None  # of the last step

    def solver(
        self,
        terms: Terms,
        kept: IntArray,
        body_matrix: BodyMatrix,
        factorised: Callable[[sparse.bsr_array], Factorised],
    ) -> Solve:
        """The solver of one step.

        Parameters
        ----------
        terms : What the step has at each contact, and between bodies.
        kept : Contacts that are unknowns, shape (k,).
        body_matrix : What makes the bodies' matrix, and B by contact and side.
        factorised : Makes the factor of a matrix of bodies.
        """
        if self.rows is None:
            self.rows = Rows(self.problem.bodies, body_matrix.maps, self.of_bodies, self.seams)
        return Preconditioned(self.problem, self.rows, self.scale, terms, kept, body_matrix, factorised)


class Preconditioned:
    """The solver of one step.

    Parameters
    ----------
    problem : The contact problem. rows : Of its contacts.
    scale : w of each contact, by which residuals are measured, shape (c,).
    terms, kept, body_matrix, factorised : As for ``Undivided.solver``.
    """

    def __init__(
        self,
        problem: ContactProblem,
        rows: Rows,
        scale: FloatArray,
        terms: Terms,
        kept: IntArray,
        body_matrix: BodyMatrix,
        factorised: Callable[[sparse.bsr_array], Factorised],
    ) -> None:
        self.problem, self.rows, self.scale = problem, rows, scale
        self.values, self.kept = Values.at(terms), kept
        rows.take(self.values)
        self.of_bodies = factorised(self._schur(terms.coupled, body_matrix))

    def _schur(self, coupled: sparse.bsr_array, body_matrix: BodyMatrix) -> sparse.bsr_array:
        """What is left between bodies where contacts are solved for set by set."""
        pattern, m = body_matrix.pattern, body_matrix.size
        blocks, count = coupled.data.copy(), pattern.count
        beyond = []  # between bodies that no contact joins
        for bodies, given in self.rows.eliminated():
            pair = np.stack(np.broadcast_arrays(bodies[:, :, None], bodies[:, None]))
            there = (pair >= 0).all(axis=0)
            key, left = pair[0][there] * count + pair[1][there], given[there]
            slot = np.searchsorted(pattern.keys, key)
            known = pattern.keys[np.minimum(slot, len(blocks) - 1)] == key
            np.subtract.at(blocks, slot[known], left[known])
            beyond.append((key[~known], left[~known]))
        matrix = sparse.bsr_array((blocks, coupled.indices, coupled.indptr), coupled.shape, blocksize=(m, m))
        keys, left = (np.concatenate(parts) for parts in zip(*beyond, strict=True))
        if not len(keys):
            return matrix
        at = np.arange(m)
        rows, columns = np.broadcast_arrays(
            (keys // count * m)[:, None, None] + at[:, None], (keys % count * m)[:, None, None] + at
        )
        more = sparse.coo_array((left.ravel(), (rows.ravel(), columns.ravel())), matrix.shape)
        return sparse.bsr_array(matrix - more, blocksize=(m, m))

    def __call__(self, rhs: FloatArray) -> FloatArray:
        """The solution of a step, ordered as ``ElasticMatrix`` orders it, with rows for ``kept``.

        Raises
        ------
        StagnationError : It has failed, and a factor fits.
        """
        if self.rows.values is not self.values:
            self.rows.take(self.values)
        problem, kept, d = self.problem, self.kept, self.problem.dimension
        size = len(kept) * d
        bodies = rhs[size:].reshape(problem.body_count, -1)
        x, motion = self._precondition(self._spread(rhs[:size]), bodies)
        left = rhs[:size] - self._product(x, motion)[kept].ravel()
        if left.any():
            nothing = np.zeros_like(bodies)

            scale = np.repeat(self.scale[kept], d)

            def apply(y: FloatArray) -> FloatArray:
                met = self._precondition(self._spread(scale * y), nothing, refined=False)
                return self._product(*met)[kept].ravel() / scale

            operator = LinearOperator((size, size), matvec=apply, dtype=float)
            most, accuracy = Effort.of(len(kept), rests=at_rest(problem))
            y, failed = gmres(operator, left / scale, rtol=accuracy, restart=most, maxiter=1)
            y *= scale
            if failed and len(kept) <= FACTORED:
                raise StagnationError(f"residual above {accuracy:.0e} of the first after {most} iterations")
            more, moved = self._precondition(self._spread(y), nothing)
            x, motion = x + more, motion + moved
        return np.concatenate([x[kept].ravel(), motion.ravel()])

    def _spread(self, y: FloatArray) -> FloatArray:
        """Values of the contacts that are unknowns, among all, shape (c, d)."""
        force = np.zeros_like(self.problem.free_velocity)
        force[self.kept] = y.reshape(-1, force.shape[1])
        return force

    def _precondition(
        self, force: FloatArray, bodies: FloatArray, *, refined: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Impulses and U of given rows, with W_el within interfaces only."""
        rows = self.rows
        solve = self.of_bodies if refined else self.of_bodies.bare
        at_rest = rows.inside(force)
        given = rows.to_bodies(at_rest, len(bodies))
        motion = solve((bodies - given).ravel()).reshape(bodies.shape)
        return rows.moving(at_rest, motion), motion

    def _product(self, x: FloatArray, motion: FloatArray) -> FloatArray:
        """The contacts' rows of the matrix times x and U, shape (c, d)."""
        given = self.problem.elastic_velocity(np.where(self.values.closed[:, None], x, 0.0))
        return self.rows.product(x, given, motion)
