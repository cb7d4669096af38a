"""Part: some bodies of a contact problem as a problem of their own, while all others stay as they are.

    part = Part.of(problem, chosen, impulse, rigid_velocity)
    solution = iterate(part.problem, method, settings, part.start)
    impulse, rigid_velocity = part.put(solution.impulse, solution.rigid_velocity)

Its contacts are those of its bodies. What the other contacts push, and how the other bodies move, become
loads and motions of its own.
"""

from __future__ import annotations

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


@dataclass(frozen=True, slots=True)
class Part:
    """Some bodies of a contact problem and their k contacts.

    Attributes
    ----------
    problem : Theirs alone.
    contacts, bodies : Their numbers in the whole, ascending, shapes (k,) and (n,).
    impulse, rigid_velocity : State of the whole that it was taken from, shapes (c, d) and (b, m).
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
        contacts, bodies = np.flatnonzero(inside), np.flatnonzero(chosen)
        outer = np.where(inside[:, None], 0.0, impulse)
        velocity = whole.velocity(outer, np.where(chosen[:, None], 0.0, rigid_velocity))
        number = np.full(whole.body_count + 1, -1)  # the last is no body
        number[bodies] = np.arange(len(bodies))
        sides = number[whole.bodies[contacts]]
        cohesion = {name: getattr(whole, name) for name in COHESION}
        problem = replace(
            whole,
            friction=whole.friction[contacts],
            free_velocity=velocity[contacts],
            compliance=only(whole.compliance, contacts),
            bodies=sides,
            rigid_map=np.where((sides >= 0)[:, :, None, None], whole.rigid_map[contacts], 0.0),
            rigid_mass=whole.rigid_mass[bodies],
            rigid_impulse=(whole.rigid_impulse + whole.body_impulse(outer))[bodies],
            rigid_velocity=whole.rigid_velocity[bodies],
            structure=Structure(alone=True),
            **{name: None if values is None else values[contacts] for name, values in cohesion.items()},
        )
        return cls(problem, contacts, bodies, impulse, rigid_velocity)

    @property
    def start(self) -> Start:
        """The state that it was taken from."""
        return Start(self.impulse[self.contacts], self.rigid_velocity[self.bodies])

    def put(self, impulse: FloatArray, rigid_velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Impulses (c, d) and U (b, m) of the whole with those of the part in their places.

        Parameters
        ----------
        impulse, rigid_velocity : Of the part, shapes (k, d) and (n, m).
        """
        whole, motion = self.impulse.copy(), self.rigid_velocity.copy()
        whole[self.contacts], motion[self.bodies] = impulse, rigid_velocity
        return whole, motion


def touched(problem: ContactProblem, chosen: Mask) -> Mask:
    """Contacts of some bodies, shape (c,).

    Parameters
    ----------
    problem : The contact problem. chosen : Bodies, shape (b,).
    """
    found: Mask = np.append(chosen, False)[problem.bodies].any(axis=1)  # supports are numbered -1
    return found


def unsettled(problem: ContactProblem, residual: FloatArray, least: float) -> Mask:
    """The fewest bodies without whose contacts the residual is at most ``least``, and their neighbours.

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
    chosen[problem.bodies[touched(problem, chosen[:-1])]] = True
    return chosen[:-1]


def clusters(problem: ContactProblem) -> list[Mask]:
    """Bodies that hang together by contacts, cluster by cluster, each of shape (b,).

    Parameters
    ----------
    problem : The contact problem.
    """
    pairs = problem.bodies[(problem.bodies >= 0).all(axis=1)]
    graph = sparse.coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(problem.body_count,) * 2)
    count, number = connected_components(graph, directed=False)
    return [number == cluster for cluster in range(count)]
