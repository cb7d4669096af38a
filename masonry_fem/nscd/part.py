"""Part: some bodies of a contact problem as a problem of their own, while all others stay as they are.

    part = Part.of(problem, chosen, impulse, rigid_velocity)
    for group in part.groups():               # which have nothing to do with each other
        solution = iterate(group.problem, method, settings, group.start)
        impulse[group.contacts], rigid_velocity[group.bodies] = solution.impulse, solution.rigid_velocity

Its contacts are those of its bodies. What the other contacts push, and how the other bodies move, become
loads and motions of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.nscd.problem import ContactProblem, Products
from masonry_fem.nscd.settings import Start
from masonry_fem.nscd.structure import Structure

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Rings of bodies around those that are far from settled, which come to rest with them. With one an error
# comes back with each step of large walls; with three parts take longer than they save.
AROUND = 2


@dataclass(frozen=True, slots=True)
class Part:
    """Some bodies of a contact problem and their k contacts.

    Attributes
    ----------
    problem : Theirs alone.
    contacts, bodies : Their numbers in the whole, ascending, shapes (k,) and (n,).
    sides : Bodies of the whole on both sides of its contacts, shape (k, 2).
    impulse, rigid_velocity : State that they were in, shapes (k, d) and (n, m).
    """

    problem: ContactProblem
    contacts: IntArray
    bodies: IntArray
    sides: IntArray
    impulse: FloatArray
    rigid_velocity: FloatArray

    @classmethod
    def of(
        cls,
        whole: ContactProblem,
        chosen: Mask,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        known: Products | None = None,
    ) -> Part:
        """The part that some bodies make.

        Parameters
        ----------
        whole : The contact problem.
        chosen : Bodies, shape (b,).
        impulse, rigid_velocity : State in which the others stay, shapes (c, d) and (b, m).
        known : Products of the whole with it; None: they are not known.
        """
        inside, numbers = touched(whole, chosen), (np.arange(whole.count), np.arange(whole.body_count))
        if chosen.all() and inside.all():
            alone = replace(whole, structure=Structure())  # so that its factors go with it
            return cls(alone, *numbers, whole.bodies, impulse, rigid_velocity)
        every = cls(whole, *numbers, whole.bodies, impulse, rigid_velocity)
        part = every._only(np.flatnonzero(inside), np.flatnonzero(chosen))
        known = whole.products(impulse, rigid_velocity) if known is None else known
        # what others do is all but what its own contacts and bodies do
        alone, own = part.problem, part.problem.products(part.impulse, part.rigid_velocity)
        velocity = alone.free_velocity + (known.velocity[inside] - own.velocity)
        pushed = alone.rigid_impulse + (known.given[chosen] - own.given)
        return replace(part, problem=replace(alone, free_velocity=velocity, rigid_impulse=pushed))

    def groups(self) -> Iterator[Part]:
        """Parts of the same whole that have nothing to do with each other: no body touches two of them."""
        hanging = _hanging(self.sides, int(max(self.sides.max(initial=-1), self.bodies.max())) + 1)
        names, bodies = np.unique(hanging[self.bodies], return_inverse=True)
        contacts = np.searchsorted(names, hanging[self.sides.max(axis=1)])
        its = zip(_grouped(contacts, len(names)), _grouped(bodies, len(names)), strict=True)
        return (self._only(*own) for own in its)

    def clusters(self) -> list[Mask]:
        """Bodies that hang together by contacts of their own, cluster by cluster, each of shape (n,)."""
        hanging = _hanging(self.problem.bodies, self.problem.body_count)
        return [hanging == name for name in np.unique(hanging)]

    @property
    def start(self) -> Start:
        """The state that they were in."""
        return Start(self.impulse, self.rigid_velocity)

    def _only(self, contacts: IntArray, bodies: IntArray) -> Part:
        """The part of some bodies and all their contacts, by their numbers in this one, ascending."""
        whole = self.problem
        number = np.full(whole.body_count + 1, -1)  # the last is no body
        number[bodies] = np.arange(len(bodies))
        sides = number[whole.bodies[contacts]]
        maps = np.take(whole.rigid_map, contacts, axis=0)
        maps[sides < 0] = 0.0
        problem = replace(
            whole.only(contacts),
            bodies=sides,
            rigid_map=maps,
            rigid_mass=whole.rigid_mass[bodies],
            rigid_impulse=whole.rigid_impulse[bodies],
            rigid_velocity=whole.rigid_velocity[bodies],
            structure=Structure(),
        )
        return Part(
            problem,
            self.contacts[contacts],
            self.bodies[bodies],
            self.sides[contacts],
            self.impulse[contacts],
            self.rigid_velocity[bodies],
        )


def _hanging(sides: IntArray, count: int) -> IntArray:
    """A name of what each body hangs together with by contacts, shape (count,).

    Parameters
    ----------
    sides : Bodies on both sides of each contact, −1 for none, shape (k, 2). count : Of bodies.
    """
    pairs = sides[(sides >= 0).all(axis=1)]
    graph = sparse.coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(count, count))
    _, names = connected_components(graph, directed=False)
    return names.astype(np.int64)


def _grouped(number: IntArray, count: int) -> list[IntArray]:
    """Items by their number, each group ascending.

    Parameters
    ----------
    number : Of each item, from 0 on, shape (n,). count : Of groups.
    """
    order = np.argsort(number, kind="stable")
    return np.split(order, np.cumsum(np.bincount(number, minlength=count))[:-1])


def touched(problem: ContactProblem, chosen: Mask) -> Mask:
    """Contacts of some bodies, shape (c,).

    Parameters
    ----------
    problem : The contact problem. chosen : Bodies, shape (b,).
    """
    found: Mask = np.append(chosen, False)[problem.bodies].any(axis=1)  # supports are numbered -1
    return found


def unsettled(problem: ContactProblem, residual: FloatArray, least: float) -> Mask:
    """The fewest bodies without whose contacts the residual is at most ``least``, and those around them.

    Parameters
    ----------
    problem : The contact problem.
    residual : At each contact, shape (c, d).
    least : Its norm at the contacts of all others.
    """
    square = (residual**2).sum(axis=1)
    first, second = (np.bincount(side + 1, square, problem.body_count + 1) for side in problem.bodies.T)
    of_bodies = (first + second)[1:]  # supports are numbered -1
    order = np.argsort(of_bodies, kind="stable")
    chosen = np.zeros(problem.body_count + 1, dtype=bool)
    chosen[order[int(np.searchsorted(np.cumsum(of_bodies[order]), least**2, side="right")) :]] = True
    for _ in range(AROUND):
        chosen[problem.bodies[touched(problem, chosen[:-1])]] = True
    return chosen[:-1]
