"""Work: what each rank does of Newton's method.

Each has a ``NewtonRun`` on its contacts and all bodies. Sums over ranks are the same on each of them, so that
all take the same turns. Parts that come to rest by themselves are the leader's, which calls on the others
meanwhile.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.ranks import Leader, Member, team
from masonry_fem.nscd.iterate import Iterate
from masonry_fem.nscd.problem import ContactProblem, Products
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings
from masonry_fem.nscd.solvers.elastic_ranks.division import some, whole
from masonry_fem.nscd.solvers.elastic_ranks.portion import Portion
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT, Given, Share
from masonry_fem.nscd.solvers.elastic_ranks.system import Divided, DividedSystem
from masonry_fem.nscd.solvers.settling import Settling
from masonry_fem.nscd.structure import Structure

if TYPE_CHECKING:
    import weakref

    from masonry_fem.nscd.methods.newton import NewtonRun, ProximalNewton
    from masonry_fem.nscd.solvers.elastic_ranks.run import RanksRun

FloatArray = NDArray[np.float64]


class Offered(NamedTuple):
    """What a rank has of an offer.

    Attributes
    ----------
    impulse : Of its own contacts, shape (c, d).
    moving : W_el p and v there, shapes (c, d), where they are those of the offer; None: they are not known.
    rest : The offer itself, where the rank leads; None elsewhere.
    """

    impulse: FloatArray
    moving: tuple[FloatArray, FloatArray] | None
    rest: Iterate | None


def take_share(member: Member, given: tuple[int, frozenset[int], Share]) -> None:
    """Make a rank's portion of some contacts, and let go those that are done with.

    Parameters
    ----------
    member : The rank.
    given : Number of the contacts, those of others that are still met, and the rank's part of them.
    """
    number, others, share = given
    workers: dict[int, Worker] = member.kept.setdefault(KEPT, {})
    for done in sorted(workers.keys() - others):
        workers.pop(done).portion.close()
    workers[number] = Worker(Portion(member, share))


def begin(member: Member, given: tuple[int, Given]) -> Offered:
    """Begin a run; what it starts from.

    Parameters
    ----------
    member : The rank. given : Number of its contacts, and the rank's part of the problem.
    """
    number, problem = given
    found: Offered = member.kept[KEPT][number].begin(problem)
    return found


def step(member: Member, given: tuple[int, tuple[int, Quality, SolverSettings]]) -> Offered:
    """A step of the run that was begun last with some contacts.

    Parameters
    ----------
    member : The rank. given : Number of the contacts; of the run, quality of its last offer, and settings.
    """
    number, asked = given
    found: Offered = member.kept[KEPT][number].step(*asked)
    return found


class Worker:
    """A rank's portion of some contacts, and the run that was begun last with it."""

    def __init__(self, portion: Portion) -> None:
        self.portion = portion
        self.run: NewtonRun | None = None
        self.number = -1  # of the run

    def begin(self, given: Given) -> Offered:
        """Begin a run in place of the last; what it starts from."""
        from masonry_fem.nscd.methods.newton import Means, NewtonRun  # noqa: PLC0415 - it calls on ranks

        portion = self.portion
        portion.begin(given)
        peers = Others(portion.member, given.count)
        problem = ContactProblem(
            compliance=Divided(portion),
            bodies=portion.share.sides,
            structure=Structure(pattern=portion.pattern),
            peers=peers,
            **given.arrays,
        )
        means = Means(
            given.scale,
            given.proximal,
            DividedSystem(problem, given.unfolded, given.method.library, portion),
            lambda held: SettlingOfAll(portion.member, held, given.run),
        )
        self.number = given.number
        self.run = NewtonRun(problem, given.method, given.start, means)
        return self._offered(self.run.guess())

    def step(self, number: int, quality: Quality, settings: SolverSettings) -> Offered:
        """A step of the run that was begun last, which has this number."""
        assert self.run is not None
        assert self.number == number
        return self._offered(self.run.step(quality, settings))

    def _offered(self, offer: Iterate) -> Offered:
        assert self.run is not None
        known, problem = offer.products, self.run.problem
        if known is None or problem.any(np.array([not known.are_of(offer.impulse, offer.rigid_velocity)])):
            known = None
        moving = None if known is None else (known.elastic, known.velocity)
        rest = replace(offer, products=known) if self.portion.member.rank == 0 else None
        return Offered(offer.impulse, moving, rest)


class Others:
    """The ranks that have the other contacts of a problem.

    Parameters
    ----------
    member : This rank. count : Contacts of all ranks.
    """

    def __init__(self, member: Member, count: int) -> None:
        self._member, self.count = member, count

    def summed(self, values: FloatArray) -> FloatArray:
        """Sums over all ranks of what each has, number by number."""
        return self._member.summed(values)

    def least(self, values: FloatArray) -> FloatArray:
        """The least values that any rank has, number by number; nan where one is."""
        least: FloatArray = self._member.everyone(values).min(axis=0)
        return least


class SettlingOfAll:
    """``Settling`` of a problem that ranks share: the leader sees to it.

    Parameters
    ----------
    member : This rank. held : The method that solves parts.
    run : The run of all ranks where this one leads; None elsewhere.
    """

    def __init__(self, member: Member, held: ProximalNewton, run: weakref.ref[RanksRun] | None) -> None:
        self._member, self._held, self._run = member, held, run
        self.linear_solves = 0

    def settle(
        self,
        residual: FloatArray,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        error: float,
        wanted: float,
        until: float | None = None,
        best: float = np.inf,
        known: Products | None = None,
    ) -> tuple[FloatArray, FloatArray] | None:
        """As ``Settling.settle``, with the rank's own contacts and all bodies."""
        velocity = None if known is None else known.velocity
        states = self._member.collected((residual, impulse, velocity))
        settled: tuple[FloatArray, FloatArray] | None
        if states is None:
            settled, self.linear_solves = self._member.serve()
            return settled
        leader, run = team(), None if self._run is None else self._run()
        assert isinstance(leader, Leader)
        assert run is not None
        settling, contacts = Settling(run.problem, self._held), run.division.contacts
        residuals, impulses, velocities = zip(*states, strict=True)

        def shares() -> list[Any]:
            left, pressed, products = whole(contacts, residuals), whole(contacts, impulses), None
            if known is not None:
                moved = whole(contacts, velocities)
                products = Products(pressed, rigid_velocity, moved[:0], moved, known.given)  # W_el p: unknown
            found = settling.settle(left, pressed, rigid_velocity, error, wanted, until, best, products)
            solves = self.linear_solves + settling.linear_solves
            if found is None:
                return [(None, solves)] * self._member.size
            return [((some(found[0], own), found[1]), solves) for own in contacts]

        settled, self.linear_solves = leader.lead(shares)
        return settled
