"""Prestress: the least that joints must be pressed beforehand for the loads to be carried.

    found = least_prestress(problem, joints=[(3,), (4, 5)], pressed=normal)
    found.thrust            # N: with less in every one of these joints no reactions balance the loads

Of all reactions within the cones that balance the loads, those for which the greatest thrust that a joint
bears on top of what presses it already is least. One program, like every question of limit analysis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from masonry_fem.limit.problem import FloatArray, IntArray, LimitProblem
from masonry_fem.limit.program import Program
from masonry_fem.limit.questions import maximum, trust
from masonry_fem.limit.strength import Strength


@dataclass(frozen=True, slots=True)
class Prestress:
    """The answer.

    Attributes
    ----------
    thrust : Greatest thrust on top of what is there in a joint, as small as it can be [N].
    rises : Of each joint, summed over the points that are pressed more than before, shape (j,) [N].
    unbalanced : What the reactions leave of the loads, relative to the largest.
    """

    thrust: float
    rises: FloatArray
    unbalanced: float


def least_prestress(
    problem: LimitProblem, joints: Sequence[Sequence[int]], pressed: FloatArray
) -> Prestress | None:
    """The least thrust on top with which the dead loads are carried; None where nothing carries them.

    Parameters
    ----------
    problem : Its dead loads count.
    joints : Those that may be pressed, each as the numbers of its facets among the model's interfaces, (j,).
    pressed : Normal force that is there already at each contact point, shape (c,) [N].

    Raises
    ------
    ProblemError : The program was not solved well enough to tell.
    """
    c, d = problem.points.shape
    rank = np.full(len(problem.model.interfaces), -1)
    for number, facets in enumerate(joints):
        rank[list(facets)] = number
    joint = rank[problem.model.contacts.interface]
    own = np.flatnonzero((joint >= 0) & problem.active)
    k, j = len(own), len(joints)
    # r_N = present force + rise − fall at each point; the rises of a joint and a slack sum up to the thrust.
    # Rises, falls and slacks are non-negative, so they enter as normal forces of contacts without friction.
    point = np.arange(k)
    normal = _ones(point, d * own, (k, c * d))
    above = _ones(point, d * point, (k, k * d))
    sums = _ones(joint[own], d * point, (j, k * d))
    lacks = _ones(np.arange(j), d * np.arange(j), (j, j * d))
    balance, held = problem.equilibrium[:, : c * d], problem.equilibrium[:, c * d :]
    matrix = sparse.block_array(
        [
            [balance, None, None, None, held],
            [normal, -above, above, None, None],
            [None, sums, None, lacks, None],
        ],
        format="csr",
    )
    strength, others = problem.strength, np.zeros(2 * k + j)
    given = (
        (strength.friction, others),
        (strength.apex, others),
        (strength.tension, others),
        (strength.most, np.full(len(others), np.inf)),
    )
    program = Program(
        matrix=sparse.csr_array(matrix),
        fixed=np.concatenate([problem.dead, -pressed[own] / problem.force, np.zeros(j)]),
        growing=np.concatenate([np.zeros(len(problem.dead) + k), np.ones(j)]),
        strength=Strength(*(np.concatenate(pair) for pair in given)),
        dimension=d,
        upper=0.0,
    )
    found = maximum(program)
    if found is None:
        return None
    trust("the least pre-stress", found.unbalanced)
    rises = problem.force * (sums @ found.force[c * d : (c + k) * d])
    return Prestress(max(-found.value, 0.0) * problem.force, rises, found.unbalanced)


def _ones(rows: IntArray, columns: IntArray, shape: tuple[int, int]) -> sparse.csr_array:
    """The matrix that has a one at each of some places."""
    return sparse.csr_array((np.ones(len(rows)), (rows, columns)), shape=shape)
