"""Portion: what one rank does of a problem and of its steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.memory import keep
from masonry_fem.host.ranks import Member
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.mumps import petsc
from masonry_fem.nscd.solvers.body_matrix import scaled
from masonry_fem.nscd.solvers.elastic_krylov import Effort, Rows, Sets, Values
from masonry_fem.nscd.solvers.elastic_ranks.bodies import BodiesOfEach, BodiesTogether
from masonry_fem.nscd.solvers.elastic_ranks.exchange import Exchange
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT, Given, Share, Step

FloatArray = NDArray[np.float64]


def take_share(member: Member, given: tuple[int, frozenset[int], Share]) -> None:
    """Make a rank's portion of some contacts, and let go those that are done with.

    Parameters
    ----------
    member : The rank.
    given : Number of the contacts, those of others that are still met, and the rank's part of them.
    """
    number, others, share = given
    portions: dict[int, Portion] = member.kept.setdefault(KEPT, {})
    for done in sorted(portions.keys() - others):
        portions.pop(done).close()
    portions[number] = Portion(member, share)


def take_problem(member: Member, given: tuple[int, Given]) -> None:
    """Prepare a problem.

    Parameters
    ----------
    member : The rank. given : Number of its contacts, and the rank's part of the problem.
    """
    number, problem = given
    member.kept[KEPT][number].begin(problem)


def take_step(member: Member, given: tuple[int, Step]) -> None:
    """Prepare a step.

    Parameters
    ----------
    member : The rank. given : Number of the contacts, and the rank's part of the step.
    """
    number, step = given
    member.kept[KEPT][number].take(*step)


def solve_step(
    member: Member, given: tuple[int, tuple[FloatArray, FloatArray, FloatArray, Effort]]
) -> tuple[FloatArray, FloatArray, bool]:
    """Impulses and motions of a rank's own contacts and bodies, and whether iterations have ended.

    Parameters
    ----------
    member : The rank.
    given : Number of the contacts; right-hand sides of the rank's contacts (c, d) and bodies (b, m), w of
        contacts that are unknowns, 0 of others, (c,), and what is asked of the iteration.
    """
    number, sides = given
    solved: tuple[FloatArray, FloatArray, bool] = member.kept[KEPT][number].solve(*sides)
    return solved


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
        self.operator: Shared | None = None
        self._rows: Rows | None = None
        self.contacts = Exchange(member, share.contacts, share.count, share.dimension)
        self.met = Exchange(member, share.contacts[: share.met], share.count, share.dimension)
        self.bodies = (BodiesTogether if share.library is None else BodiesOfEach)(member, share)

    @property
    def rows(self) -> Rows:
        """Rows of its contacts in the step."""
        assert self._rows is not None
        return self._rows

    def close(self) -> None:
        """Let go what PETSc holds."""
        for made in (self.contacts, self.met, self.bodies):
            made.destroy()

    def begin(self, problem: Given) -> None:
        """Prepare a problem."""
        self._rows = self.member.together(lambda: self._begun(problem))

    def _begun(self, problem: Given) -> Rows:
        """Rows of the rank's own contacts for any step of a problem; and the operator of its own stones."""
        share = self.share
        t, d = len(share.contacts), share.dimension
        bed = mine = None
        if problem.bed is not None:
            bed = np.concatenate([problem.bed, np.zeros((t - share.met, d))])
            mine = np.where(np.arange(t)[:, None] < share.count, bed, 0.0)
        own = [kind.some(some) for kind, some in zip(problem.kinds, share.stones, strict=True) if some.any()]
        self.operator = Shared(t, d, own, bed=mine) if own else None
        with self.member.on("interfaces"):
            whole = Shared(t, d, problem.kinds, bed=bed)
            if self._rows is None:
                sets = Sets.of(whole, share.groups), Sets.of(whole, share.seams)
            else:
                sets = self._rows.sets[0].again(whole), self._rows.sets[1].again(whole)
            maps = scaled(problem.maps, share.bodies, problem.column)
            return Rows(share.bodies, maps, *sets, share.interface, self._rows)

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
        """As ``solve_step``."""
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
        impulse = self.contacts.spread(np.where(rows.values.closed[: len(x), None], x, 0.0))
        with member.on("products"):
            velocity = np.zeros_like(impulse)
            if self.operator is not None:
                velocity[:] = (self.operator @ impulse.ravel()).reshape(impulse.shape)
        given = self.contacts.summed(velocity)
        with member.on("products"):
            product: FloatArray = rows.product(x, given, motion)
            return product


class _Shell:
    """What PETSc multiplies by."""

    def __init__(self, apply: Callable[[FloatArray], FloatArray]) -> None:
        self._apply = apply

    def mult(self, _: Any, x: Any, y: Any) -> None:
        """Y = A x."""
        y.array[:] = self._apply(x.array_r)
