"""Part: some bodies of a contact problem as a problem of their own, while all others stay as they are.

    part = Part.of(problem, chosen, impulse, rigid_velocity)
    for cluster in part.clusters():
        solution = iterate(cluster.problem, method, settings, cluster.start)
        impulse[cluster.contacts], rigid_velocity[cluster.bodies] = solution.impulse, solution.rigid_velocity

Its contacts are those of its bodies. What the other contacts push, and how the other bodies move, become
loads and motions of its own. Bodies that do not hang together by contacts are clusters, each a part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.nscd.compliance import only
from masonry_fem.nscd.problem import COHESION, ContactProblem
from masonry_fem.nscd.settings import Start
from masonry_fem.nscd.structure import Structure

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Layers of bodies around those that are far from settled: what these give to bodies beside the part, which
# stay, is unbalanced there. With one a part at rest may leave the whole with a greater error than before.
AROUND = 2


@dataclass(frozen=True, slots=True)
class Part:
    """Some bodies of a contact problem and their k contacts.

    Attributes
    ----------
    problem : Theirs alone.
    contacts, bodies : Their numbers in the whole, ascending, shapes (k,) and (n,).
    impulse, rigid_velocity : State that they were in, shapes (k, d) and (n, m).
    """

    problem: ContactProblem
    contacts: IntArray
    bodies: IntArray
    impulse: FloatArray
    rigid_velocity: FloatArray

    @classmethod
    def of(cls, whole: ContactProblem, chosen: Mask, impulse: FloatArray, rigid_velocity: FloatArray) -> Part:
        """The part that some bodies make.

        Parameters
        ----------
        whole : The contact problem.
        chosen : Bodies, shape (b,).
        impulse, rigid_velocity : State in which the others stay, shapes (c, d) and (b, m).
        """
        inside = touched(whole, chosen)
        outer = np.where(inside[:, None], 0.0, impulse)
        velocity = whole.velocity(outer, np.where(chosen[:, None], 0.0, rigid_velocity))
        pushed = whole.rigid_impulse + whole.body_impulse(outer)
        beside = replace(whole, free_velocity=velocity, rigid_impulse=pushed, structure=Structure(alone=True))
        every = cls(beside, np.arange(whole.count), np.arange(whole.body_count), impulse, rigid_velocity)
        return every._only(np.flatnonzero(inside), np.flatnonzero(chosen))

    def clusters(self) -> Iterator[Part]:
        """Bodies that hang together by contacts, each cluster a part of the same whole."""
        problem, count = self.problem, self.problem.body_count
        pairs = problem.bodies[(problem.bodies >= 0).all(axis=1)]
        graph = sparse.coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(count, count))
        clusters, found = connected_components(graph, directed=False)
        number = found.astype(np.int64)
        contacts, bodies = number[problem.bodies.max(axis=1)], number
        ends = np.arange(1, clusters)
        return (
            self._only(*own) for own in zip(_grouped(contacts, ends), _grouped(bodies, ends), strict=True)
        )

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
        cohesion = {name: getattr(whole, name) for name in COHESION}
        problem = replace(
            whole,
            friction=whole.friction[contacts],
            free_velocity=whole.free_velocity[contacts],
            compliance=only(whole.compliance, contacts),
            bodies=sides,
            rigid_map=np.where((sides >= 0)[:, :, None, None], whole.rigid_map[contacts], 0.0),
            rigid_mass=whole.rigid_mass[bodies],
            rigid_impulse=whole.rigid_impulse[bodies],
            rigid_velocity=whole.rigid_velocity[bodies],
            structure=Structure(alone=True),
            **{name: None if values is None else values[contacts] for name, values in cohesion.items()},
        )
        return Part(
            problem,
            self.contacts[contacts],
            self.bodies[bodies],
            self.impulse[contacts],
            self.rigid_velocity[bodies],
        )


def _grouped(number: IntArray, ends: IntArray) -> list[IntArray]:
    """Items by their number from 0 on, each group ascending.

    Parameters
    ----------
    number : Of each item, shape (n,). ends : Numbers at which a group begins but the first, ascending.
    """
    order = np.argsort(number, kind="stable")
    return np.split(order, np.searchsorted(number[order], ends))


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
    of_bodies = np.zeros(problem.body_count + 1)  # the last is no body
    np.add.at(of_bodies, problem.bodies, square[:, None])
    order = np.argsort(of_bodies[:-1], kind="stable")
    chosen = np.zeros(problem.body_count + 1, dtype=bool)
    chosen[order[int(np.searchsorted(np.cumsum(of_bodies[order]), least**2, side="right")) :]] = True
    for _ in range(AROUND):
        chosen[problem.bodies[touched(problem, chosen[:-1])]] = True
    return chosen[:-1]
