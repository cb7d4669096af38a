"""RanksRun: Newton's method on several ranks, as their leader has it."""

from __future__ import annotations

import logging
import weakref
from dataclasses import replace
from itertools import count
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.ranks import Leader
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.iterate import Iterate, Run
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import COHESION, ContactProblem, Products
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.scaling import SLENDER, SLENDER_OF_MANY, method_scales, proximal_scale
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.body_matrix import BodyPattern
from masonry_fem.nscd.solvers.elastic_krylov import are_many, at_rest, iterable
from masonry_fem.nscd.solvers.elastic_ranks.division import Division, some, whole
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT, Given
from masonry_fem.nscd.solvers.elastic_ranks.work import Offered, begin, step, take_share
from masonry_fem.nscd.solvers.resting import Resting
from masonry_fem.nscd.structure import Structure

if TYPE_CHECKING:
    from masonry_fem.nscd.methods.newton import ProximalNewton

IntArray = NDArray[np.int64]

logger = logging.getLogger(__name__)

_NUMBERS = count()  # of runs
OF_CONTACTS = ("friction", "free_velocity", "rigid_map", *COHESION)
OF_BODIES = ("rigid_mass", "rigid_impulse", "rigid_velocity")


def divisible(problem: ContactProblem, method: ProximalNewton) -> bool:
    """Whether ranks share a problem: one of many elastic contacts, solved by iterations.

    Parameters
    ----------
    problem : The contact problem. method : What solves it.
    """
    if not isinstance(problem.operator, Shared) or not problem.body_count:
        return False
    if problem.structure is not None and problem.structure.factored:
        return False
    return are_many(problem, method.library) and iterable(problem, method.library)


class RanksRun:
    """A run of all ranks.

    Parameters
    ----------
    problem, method, start : The contact problem, what solves it, and a first guess, None where there is none.
    leader : The ranks.

    Attributes
    ----------
    problem, division : The problem, and its contacts as they are dealt to ranks.
    """

    def __init__(
        self, problem: ContactProblem, method: ProximalNewton, start: Start | None, leader: Leader
    ) -> None:
        self._structure = Structure() if problem.structure is None else problem.structure
        self.problem, self._method, self._leader = problem, method, leader
        self._rests = Resting(problem)
        self.division, self._number = self._divided(), next(_NUMBERS)
        self._start = start  # from where the leader would go on by itself
        held: weakref.WeakSet[Division] = leader.held.setdefault(KEPT, weakref.WeakSet())
        number = self.division.number
        if self.division not in held:
            others = frozenset(division.number for division in held)
            leader.call(take_share, [(number, others, share) for share in self.division.shares])
            held.add(self.division)
        self._last = self._joined(leader.call(begin, [(number, given) for given in self._given(start)]))
        self._alone: Run | None = None  # where iterations have failed, the leader goes on by itself

    def guess(self) -> Iterate:
        """Where it starts."""
        return self._last

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """As ``NewtonRun.step``."""
        if self._alone is not None:
            return self._alone.step(quality, settings)
        last = self._last
        if self._rests.at(quality, settings.tolerance, last.impulse, last.rigid_velocity):
            return replace(last, iterations=0, linear_solves=0, verdict=Outcome.STALLED)
        asked = self.division.number, (self._number, quality, settings)
        try:
            made = self._leader.call(step, [asked] * self._leader.size)
        except StagnationError as failure:
            logger.info("iteration of a Newton step failed (%s); factors follow", failure)
            self._structure.factored = True
            self._alone = self._method.init(replace(self.problem, structure=self._structure), self._start)
            return self._alone.guess()
        self._last = self._joined(made)
        self._start = Start(self._last.impulse, self._last.rigid_velocity)
        return self._last

    def _divided(self) -> Division:
        """Its contacts and bodies as they are dealt to ranks."""
        problem, structure = self.problem, self._structure
        elastic, pattern = problem.operator.elastic(), structure.pattern
        if structure.division is None or not structure.division.serves(problem, elastic):
            if pattern is None or not pattern.serves(problem.bodies, problem.body_count):
                pattern = structure.pattern = BodyPattern(problem.bodies, problem.body_count)
            structure.division = Division(problem, elastic, pattern, self._leader)
        return structure.division

    def _given(self, start: Start | None) -> list[Given]:
        """What each rank is given of the problem."""
        problem, division, method = self.problem, self.division, self._method
        operator = problem.operator
        assert isinstance(operator, Shared)
        scale, unfolded = method_scales(problem, moving=method.moving)
        proximal = proximal_scale(problem, scale, SLENDER_OF_MANY if at_rest(problem) else SLENDER)
        bodies = {name: getattr(problem, name) for name in OF_BODIES}
        arrays = {name: getattr(problem, name) for name in OF_CONTACTS}
        of_contacts = {name: values for name, values in arrays.items() if values is not None}
        return [
            Given(
                kinds=division.kinds(operator, rank),
                bed=None if operator.bed is None else operator.bed[met],
                arrays=bodies
                | {name: division.taken(name, values, rank) for name, values in of_contacts.items()},
                count=problem.count,
                scale=some(scale, own),
                unfolded=some(unfolded, own),
                proximal=some(proximal, own),
                method=method,
                start=_at(start, own),
                number=self._number,
                run=None if rank else weakref.ref(self),
            )
            for rank, (own, met) in enumerate(zip(division.contacts, division.met, strict=True))
        ]

    def _joined(self, offered: list[Offered]) -> Iterate:
        """The offer of all ranks."""
        lead = offered[0].rest
        assert lead is not None
        contacts = self.division.contacts
        impulse = whole(contacts, [part.impulse for part in offered])
        products = None
        if lead.products is not None:
            elastic, velocity = (
                whole(contacts, [part.moving[which] for part in offered if part.moving is not None])
                for which in range(2)
            )
            products = Products(impulse, lead.rigid_velocity, elastic, velocity, lead.products.given)
        return replace(lead, impulse=impulse, products=products)


def _at(start: Start | None, contacts: IntArray) -> Start | None:
    """A first guess at some contacts, shape (k,)."""
    if start is None:
        return None
    impulse, velocity = (
        None if values is None else some(values, contacts) for values in (start.impulse, start.velocity)
    )
    known = start.products
    if known is not None and impulse is not None:
        elastic, moved = (some(values, contacts) for values in (known.elastic, known.velocity))
        known = Products(impulse, known.rigid_velocity, elastic, moved, known.given)
    return Start(impulse, start.rigid_velocity, velocity, known)
