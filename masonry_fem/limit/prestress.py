"""Prestress: the least that joints must be pressed beforehand for the loads to be carried.

    found = least_prestress(problem, joints=[3, 4], pressed=[0.0, 0.0])
    found.thrust            # N: with less in every one of these joints no reactions balance the loads

Of all reactions within the cones that balance the loads, those whose greatest rise of a joint's normal
force above what presses it already is least. One program, like every question of limit analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from masonry_fem.limit.problem import FloatArray, LimitProblem
from masonry_fem.limit.program import Program
from masonry_fem.limit.questions import maximum, trust
from masonry_fem.limit.strength import Strength


@dataclass(frozen=True, slots=True)
class Prestress:
    """The answer.

    Attributes
    ----------
    thrust : Greatest rise of a joint's normal force, as small as it can be [N].
    rises : Of each joint, shape (j,) [N].
    unbalanced : What the reactions leave of the loads, relative to the largest.
    """

    thrust: float
    rises: FloatArray
    unbalanced: float


def least_prestress(
    problem: LimitProblem, joints: Sequence[int], pressed: Sequence[float]
) -> Prestress | None:
    """The least rise of normal forces with which the dead loads are carried; None where nothing carries them.

    Parameters
    ----------
    problem : Its dead loads count.
    joints : Numbers of the model's interfaces that may be pressed, (j,).
    pressed : Normal force of each that is there already, (j,) [N].

    Raises
    ------
    ProblemError : The program was not solved well enough to tell.
    """
    d, count = problem.dimension, len(joints)
    contacts, number = len(problem.points), problem.model.contacts.interface
    normal = problem.equilibrium.shape[1] - d * contacts
    # a joint's normal force less what is there, and what it lacks of the thrust: a contact without friction
    rank = np.full(len(problem.model.interfaces), -1)
    rank[list(joints)] = np.arange(count)
    own = np.flatnonzero((rank[number] >= 0) & problem.active)
    sums = sparse.csr_array((np.ones(len(own)), (rank[number[own]], d * own)), shape=(count, d * contacts))
    slack = sparse.csr_array(
        (np.ones(count), (np.arange(count), d * np.arange(count))), shape=(count, d * count)
    )
    balance = problem.equilibrium[:, : d * contacts]
    rest = problem.equilibrium[:, d * contacts :]
    matrix = sparse.block_array(
        [[balance, None, rest], [sums, slack, sparse.csr_array((count, normal))]], format="csr"
    )
    strength = problem.strength
    nothing = np.zeros(count)
    found = maximum(
        Program(
            matrix=sparse.csr_array(matrix),
            fixed=np.concatenate([problem.dead, -np.asarray(pressed, float) / problem.force]),
            growing=np.concatenate([np.zeros_like(problem.dead), np.ones(count)]),
            strength=Strength(
                *(
                    np.concatenate([part, nothing])
                    for part in (strength.friction, strength.apex, strength.tension)
                )
            ),
            dimension=d,
            upper=0.0,
        )
    )
    if found is None:
        return None
    trust("the least pre-stress", found.unbalanced)
    rises = problem.force * (sums @ found.force[: d * contacts]) - np.asarray(pressed, float)
    return Prestress(max(-found.value, 0.0) * problem.force, rises, found.unbalanced)
