"""Portion: what one rank does of the linear systems of a problem."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.memory import keep
from masonry_fem.host.ranks import Member
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.mumps import petsc
from masonry_fem.nscd.solvers.body_matrix import BodyPattern
from masonry_fem.nscd.solvers.elastic_krylov import Effort, Rows, Sets, Values
from masonry_fem.nscd.solvers.elastic_ranks.bodies import BodiesOfEach, BodiesTogether
from masonry_fem.nscd.solvers.elastic_ranks.exchange import Exchange
from masonry_fem.nscd.solvers.elastic_ranks.share import Given, Share

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Portion:
    """What a rank has of some contacts, of a problem of theirs, and of a step.

    Parameters
    ----------
    member : The rank.
    share : Its part of the contacts.
    """

    def __init__(self, member: Member, share: Share) -> None:
        keep()  # each step makes arrays of a hundred megabytes
        self.member, self.share = member, share
        self.operator: Shared | None = None  # of its own stones
        self.near: Shared | None = None  # of all stones at its contacts
        self.sets: tuple[Sets, Sets] | None = None
        self._rows: Rows | None = None
        self.pattern = BodyPattern(share.sides, len(share.everywhere))  # of its own contacts
        self.slots, coupled = self._beside_interfaces()
        wide = share.dimension**2
        self.contacts = Exchange(member, share.contacts, share.count, share.dimension)
        self.met = Exchange(member, share.contacts[: share.met], share.count, share.dimension)
        self.blocks = Exchange(member, share.contacts[: share.met], share.count, wide)
        self.bodies = (BodiesTogether if share.library is None else BodiesOfEach)(member, share, coupled)

    @property
    def rows(self) -> Rows:
        """Rows of its contacts in the step."""
        assert self._rows is not None
        return self._rows

    def close(self) -> None:
        """Let go what PETSc holds."""
        for made in (self.contacts, self.met, self.blocks, self.bodies):
            made.destroy()

    def _beside_interfaces(self) -> tuple[IntArray, IntArray]:
        """What it adds to the bodies' matrix beside its interfaces: mass, and what rigid joints leave.

        Returns
        -------
        Slots of the pattern of its contacts, (k,), and where these stand in the matrix of all ranks, (2, k).
        """
        share, pattern = self.share, self.pattern
        slots = pattern.slots[~share.elastic]
        mass = pattern.diagonal if self.member.rank == 0 else pattern.diagonal[:0]
        some = np.union1d(mass, slots[slots >= 0])
        at = np.empty_like(share.everywhere)
        at[share.everywhere] = np.arange(len(at))
        rows = np.repeat(np.arange(pattern.count), np.diff(pattern.pointer))
        return some, np.stack([at[rows], at[pattern.indices]])[:, some]

    def begin(self, problem: Given) -> None:
        """Prepare a problem."""
        self.member.together(lambda: self._begun(problem))

    def _begun(self, problem: Given) -> None:
        """The operators of its stones, and what W_el has within its interfaces and seams."""
        share = self.share
        t, d = len(share.contacts), share.dimension
        bed = mine = None
        if problem.bed is not None:
            bed = np.concatenate([problem.bed, np.zeros((t - share.met, d))])
            mine = np.where(np.arange(t)[:, None] < share.count, bed, 0.0)
        own = [kind.some(some) for kind, some in zip(problem.kinds, share.stones, strict=True) if some.any()]
        self.operator = Shared(t, d, own, bed=mine) if own else None
        with self.member.on("interfaces"):
            self.near = Shared(t, d, problem.kinds, bed=bed)
            if self.sets is None:
                self.sets = Sets.of(self.near, share.groups), Sets.of(self.near, share.seams)
            else:
                self.sets = self.sets[0].again(self.near), self.sets[1].again(self.near)

    def prepare(self, maps: FloatArray) -> None:
        """Make rows for any step of the problem.

        Parameters
        ----------
        maps : B of its own contacts, its columns divided, shape (c, 2, d, m).
        """
        assert self.sets is not None
        self._rows = Rows(self.share.bodies, maps, *self.sets, self.share.interface, self._rows)

    def at_seams(self, values: Values) -> Values:
        """What a step has at its own contacts with the same at the others of its seams."""
        if not self.share.divided:
            return values
        d = self.share.dimension
        own, by_velocity = (
            self.blocks.spread(part.reshape(len(part), d * d)).reshape(-1, d, d)
            for part in (values.own, values.by_velocity)
        )
        closed = np.repeat(values.closed[:, None].astype(float), d, axis=1)
        closed = self.met.spread(closed)
        return Values(own, by_velocity, closed[:, 0] > 0, values.unit)

    def take(self, values: Values, coupled: FloatArray) -> None:
        """Prepare a step."""
        member = self.member
        with member.on("interfaces"):
            blocks = member.together(lambda: self._prepared(values))
        self.bodies.factorise(
            np.concatenate([coupled, *(-given.reshape(-1, *coupled.shape[1:]) for given in blocks)])
        )

    def _prepared(self, values: Values) -> list[FloatArray]:
        self.rows.take(values)
        return [given for _, given in self.rows.eliminated()]

    def solve(
        self, force: FloatArray, balance: FloatArray, scale: FloatArray, effort: Effort
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Impulses and motions of its own contacts and bodies, and whether iterations have ended.

        Parameters
        ----------
        force, balance : Right-hand sides of its own contacts and bodies, shapes (c, d) and (b, m).
        scale : w of contacts that are unknowns, 0 of others, shape (c,).
        effort : What is asked of the iteration.
        """
        library, shape = petsc(), force.shape
        nothing = np.zeros_like(balance)
        x, motion = self._precondition(force, balance)
        weight = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)[:, None]
        left = weight * (force - self._product(x, motion))
        moved = motion[: len(balance)].copy()

        def apply(y: FloatArray) -> FloatArray:
            given = scale[:, None] * y.reshape(shape)
            product = self._product(*self._precondition(given, nothing, refined=False))
            return (weight * product).ravel()

        size = ((force.size, None),) * 2
        shell = library.Mat().createPython(size, _Shell(apply), comm=self.member.comm)
        shell.setUp()
        method = library.KSP().create(self.member.comm)
        method.setType("gmres")
        method.getPC().setType("none")
        method.setGMRESRestart(effort.most)
        method.setTolerances(rtol=effort.accuracy, atol=0.0, max_it=effort.most)
        method.setOperators(shell)
        given, found = shell.createVecs()
        given.array[:] = left.ravel()
        method.solve(given, found)
        ended = int(method.getConvergedReason()) > 0
        y = scale[:, None] * found.array.reshape(shape)
        for made in (method, shell, given, found):
            made.destroy()
        more, motion = self._precondition(y, nothing)
        return x + more, moved + motion[: len(balance)], ended

    def _precondition(
        self, force: FloatArray, balance: FloatArray, *, refined: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Impulses, and U of the rank's bodies, of given rows, with W_el within interfaces only.

        Bodies balance to rounding where they are ``refined``: iterations need less.
        """
        rows, member = self.rows, self.member
        at_rest = self._inside(force)
        with member.on("preconditioner"):
            given = rows.to_bodies(at_rest, len(self.share.places))
        motion = self.bodies.moved(balance, given, refined=refined)
        with member.on("preconditioner"):
            return rows.moving(at_rest, motion), motion

    def _inside(self, force: FloatArray) -> FloatArray:
        """Impulses of given rows where bodies do not move, of the rank's own contacts, shape (c, d)."""
        given = self.met.spread(force) if self.share.divided else force
        with self.member.on("preconditioner"):
            impulse = self.rows.inside(given)
        return self.met.summed(impulse) if self.share.divided else impulse

    def _product(self, x: FloatArray, motion: FloatArray) -> FloatArray:
        """The rows of the rank's own contacts times x and U, shape (c, d)."""
        rows, member = self.rows, self.member
        assert rows.values is not None
        given = self.moved(np.where(rows.values.closed[: len(x), None], x, 0.0))
        with member.on("products"):
            product: FloatArray = rows.product(x, given, motion)
            return product

    def moved(self, impulse: FloatArray) -> FloatArray:
        """W_el p of its own contacts, from their impulses, both of shape (c, d)."""
        pressed = self.contacts.spread(impulse)
        with self.member.on("products"):
            velocity = np.zeros_like(pressed)
            if self.operator is not None:
                velocity[:] = (self.operator @ pressed.ravel()).reshape(pressed.shape)
        return self.contacts.summed(velocity)

    @cached_property
    def its_bodies(self) -> IntArray:
        """Its own bodies, as they are numbered in the problem, (b,)."""
        return self.share.everywhere[self.share.places[: self.share.own]]

    def of_all(self, motion: FloatArray) -> FloatArray:
        """U of all bodies, from that of its own, shape (n, m)."""
        found = np.empty((len(self.share.everywhere), motion.shape[1]))
        found[self.share.everywhere] = self.member.joined(motion)
        return found


class _Shell:
    """What PETSc multiplies by."""

    def __init__(self, apply: Callable[[FloatArray], FloatArray]) -> None:
        self._apply = apply

    def mult(self, _: Any, x: Any, y: Any) -> None:
        """Y = A x."""
        y.array[:] = self._apply(x.array_r)
