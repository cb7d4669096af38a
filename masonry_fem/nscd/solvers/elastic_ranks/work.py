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
    from masonry_fem.nscd.methods.newton import NewtonRun, ProximalNewton

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


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
    works: dict[int, Work] = member.kept.setdefault(KEPT, {})
    for done in sorted(works.keys() - others):
        works.pop(done).portion.close()
    works[number] = Work(Portion(member, share))


def begin(member: Member, given: tuple[int, Given]) -> Offered:
    """Begin a run; what it starts from.

    Parameters
    ----------
    member : The rank. given : Number of its contacts, and the rank's part of the problem.
    """
    number, problem = given
    found: Offered = member.kept[KEPT][number].begin(problem)
    return found


def step(member: Member, given: tuple[int, tuple[Quality, SolverSettings]]) -> Offered:
    """A step of the run that was begun last with some contacts.

    Parameters
    ----------
    member : The rank. given : Number of the contacts; quality of the last offer, and settings.
    """
    number, asked = given
    found: Offered = member.kept[KEPT][number].step(*asked)
    return found


class Work:
    """A rank's portion of some contacts, and the run that was begun last with it."""

    def __init__(self, portion: Portion) -> None:
        self.portion = portion
        self.run: NewtonRun | None = None

    def begin(self, given: Given) -> Offered:
        """As the function."""
        from masonry_fem.nscd.methods.newton import Means, NewtonRun  # noqa: PLC0415 - it calls on ranks

        portion = self.portion
        portion.begin(given)
        peers = Rank(portion.member, given.count)
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
            lambda held: OfAll(portion.member, held, given.whole),
        )
        self.run = NewtonRun(problem, given.method, given.start, means)
        return self._offered(self.run.guess())

    def step(self, quality: Quality, settings: SolverSettings) -> Offered:
        """As the function."""
        assert self.run is not None
        return self._offered(self.run.step(quality, settings))

    def _offered(self, offer: Iterate) -> Offered:
        assert self.run is not None
        known, problem = offer.products, self.run.problem
        if known is None or problem.any(np.array([not known.are_of(offer.impulse, offer.rigid_velocity)])):
            known = None
        moving = None if known is None else (known.elastic, known.velocity)
        rest = replace(offer, products=known) if self.portion.member.rank == 0 else None
        return Offered(offer.impulse, moving, rest)


class Rank:
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


class OfAll:
    """``Settling`` of a problem that ranks share: the leader sees to it.

    Parameters
    ----------
    member : This rank. held : The method that solves parts.
    whole : The problem, and which contacts each rank has, where this one leads; None elsewhere.
    """

    def __init__(
        self,
        member: Member,
        held: ProximalNewton,
        whole: tuple[ContactProblem, list[IntArray]] | None,
    ) -> None:
        self._member, self._whole = member, whole
        self._settling = None if whole is None else Settling(whole[0], held)
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
        assert self._settling is not None
        assert self._whole is not None
        settling, contacts = self._settling, self._whole[1]
        residuals, impulses, velocities = zip(*states, strict=True)
        pressed, products = whole(contacts, impulses), None
        if known is not None:
            moved = whole(contacts, velocities)
            products = Products(pressed, rigid_velocity, moved, moved, known.given)  # no part asks for W_el p

        def shares() -> list[Any]:
            left = whole(contacts, residuals)
            found = settling.settle(left, pressed, rigid_velocity, error, wanted, until, best, products)
            if found is None:
                return [(None, settling.linear_solves)] * self._member.size
            return [((some(found[0], own), found[1]), settling.linear_solves) for own in contacts]

        leader = team()
        assert isinstance(leader, Leader)
        settled, self.linear_solves = leader.lead(shares)
        return settled
