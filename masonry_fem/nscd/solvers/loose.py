"""Loose: bodies without inertia that only sliding contacts hold, and how far they go in a Newton step.

Bodies that stick to each other, directly or through others, are one *cluster*. One that neither sticks to
the ground nor has inertia is loose: along its sliding contacts the Newton matrix has nothing against its
motion, so that a step takes it anywhere, though in the end one of its points may stick.

Its sliding contacts are given a share of the secant of friction here: their slope in the direction of slip,
which is zero, becomes that of p_T = −(μ p_N/‖v_T‖) v_T. The step is then short, and again and again the same,
as the force that is missing does not fall. What the slope has kept it from is the step's *drift*, and each
cluster goes along that until friction, as it is, takes no more power from it than the loads give.

    loose = loose_clusters(problem, line, pressed, velocity)     # None: there are none
    loose.line                                                   # for the step's factor
    force = loose.withheld(change, slip)                         # the drift is what takes that away
    lengths = loose.lengths(...)

References
----------
S. Hüeber, G. Stadler and B. I. Wohlmuth, "A primal-dual active set algorithm for three-dimensional contact
problems with Coulomb friction", SIAM Journal on Scientific Computing 30 (2008), change the same derivative.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.nscd import graphs
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.linearisation import Linearisation

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SECANT = 0.03  # share of the secant; with a tenth and more each step takes as many iterations again
FARTHEST = 6  # doublings of the drift; it is made of the step's own model
HALVINGS = 40
BALANCED = 1e-6  # share of the power at the start that counts as none


@dataclass(frozen=True, slots=True)
class Loose:
    """The loose clusters of one step.

    Attributes
    ----------
    problem : The contact problem.
    line : The linearisation with the share of the secant.
    cluster : That of each body, −1 where it is not loose, shape (b,).
    count : How many there are.
    contacts : Those on loose bodies, shape (k,).
    sides : Their bodies' clusters, −1 where not loose, shape (k, 2).
    softened : Contacts that have been given the secant, shape (s,). secant : By how much, (s, d − 1, d − 1).
    """

    problem: ContactProblem
    line: Linearisation
    cluster: IntArray
    count: int
    contacts: IntArray
    sides: IntArray
    softened: IntArray
    secant: FloatArray

    def withheld(self, change: FloatArray, slip: FloatArray) -> FloatArray:
        """What the secant adds to the contact function along a step (dp, dv), shape (c, d), over ρ.

        Parameters
        ----------
        change, slip : dp and dv, shape (c, d).
        """
        line, at = self.line, self.softened
        force = np.zeros_like(change)
        trial = change[at, 1:] / line.rho[at, None] - slip[at, 1:]
        force[at, 1:] = (self.secant @ trial[:, :, None])[:, :, 0]
        return force

    def along(self, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lengths by contact (c,) and by body (b,) of those by cluster, zero where nothing is loose."""
        given = np.append(lengths, 0.0)
        of_contacts = np.zeros(self.problem.count)
        of_contacts[self.contacts] = given[self._owner]
        return of_contacts, given[self.cluster]

    @property
    def _owner(self) -> IntArray:
        """The cluster that each of the contacts goes with."""
        return np.where(self.sides[:, 0] >= 0, self.sides[:, 0], self.sides[:, 1])

    def lengths(
        self,
        impulse: FloatArray,
        velocity: FloatArray,
        load: FloatArray,
        drag: FloatArray,
        drift: tuple[FloatArray, FloatArray, FloatArray],
    ) -> FloatArray:
        """How far each cluster goes along the drift, in its lengths.

        Parameters
        ----------
        impulse, velocity : p and v at the end of the step, shape (c, d).
        load : Impulse on bodies that does not come from contacts, shape (b, m).
        drag : Impulse per velocity that holds bodies back, shape (b, m).
        drift : Its dp, dv, shape (c, d), and dU, shape (b, m).
        """
        problem, rows, owner = self.problem, self.contacts, self._owner
        change, slip, motion = drift
        bodies = problem.bodies[rows]
        # velocities of the contacts by the motion of either body
        seen = (problem.rigid_map[rows] @ motion[bodies][:, :, :, None])[:, :, :, 0]
        rho, friction = self.line.rho[rows], problem.friction[rows]
        bearing = impulse[rows, 0] - rho * velocity[rows, 0]
        more = change[rows, 0] - rho * slip[rows, 0]
        given = self._sum((load * motion).sum(axis=1))
        held = self._sum((drag * motion**2).sum(axis=1))
        number, loose = self.count, self.sides >= 0
        of = self.sides[loose]

        def power(length: FloatArray) -> FloatArray:
            far = length[owner]
            moved = velocity[rows] + far[:, None] * slip[rows]
            force = np.empty_like(moved)
            force[:, 0] = np.maximum(bearing + far * more, 0.0)
            speed = graphs.tangential_norm(moved)
            force[:, 1:] = -(friction * force[:, 0] / np.where(speed > 0, speed, 1.0))[:, None] * moved[:, 1:]
            taken = (force[:, None, :] * seen).sum(axis=2)[loose]
            return np.bincount(of, taken, number) + given - length * held

        first = power(np.zeros(number))
        goes, enough = first > 0, BALANCED * np.abs(first)
        low, high = np.zeros(number), np.where(goes, 1.0, 0.0)
        on = goes & (power(high) > enough)
        for _ in range(FARTHEST):
            low, high = np.where(on, high, low), np.where(on, 2 * high, high)
            on &= power(high) > enough
        low = np.where(on, high, low)  # those go as far as they may
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            still = power(middle) > enough
            low, high = np.where(still, middle, low), np.where(still, high, middle)
        return high

    def _sum(self, values: FloatArray) -> FloatArray:
        """Sums over the bodies of each cluster."""
        of = self.cluster >= 0
        return np.bincount(self.cluster[of], values[of], self.count)


def loose_clusters(
    problem: ContactProblem, line: Linearisation, pressed: FloatArray, velocity: FloatArray
) -> Loose | None:
    """The loose clusters of a step; None: there are none.

    Parameters
    ----------
    problem : One without cohesion.
    line : Its contact function, linearised.
    pressed, velocity : Where, shape (c, d).
    """
    ground = problem.body_count
    sides = np.where(problem.bodies < 0, ground, problem.bodies)
    inert = np.flatnonzero((problem.rigid_mass > 0).any(axis=1))
    one = np.concatenate([sides[line.plain, 0], inert])
    other = np.concatenate([sides[line.plain, 1], np.full(len(inert), ground)])
    graph = sparse.coo_array((np.ones(len(one)), (one, other)), shape=(ground + 1, ground + 1))
    number, label = connected_components(graph, directed=False)
    if number == 1:
        return None
    cluster = label - (label > label[ground])
    cluster[label == label[ground]] = -1
    of_sides = cluster[sides]
    contacts = np.flatnonzero((of_sides >= 0).any(axis=1))
    softened = contacts[~line.open[contacts] & ~line.plain[contacts]]
    trial = pressed[softened] - line.rho[softened, None] * velocity[softened]
    size = graphs.tangential_norm(trial)
    size = np.where(size > 0, size, 1.0)  # a contact may be taken for sliding that does not
    direction = trial[:, 1:] / size[:, None]
    share = SECANT * problem.friction[softened] * np.maximum(trial[:, 0], 0.0) / size
    secant = share[:, None, None] * direction[:, :, None] * direction[:, None, :]
    by_impulse, by_velocity = line.by_impulse.copy(), line.by_velocity.copy()
    by_impulse[softened, 1:, 1:] -= secant
    by_velocity[softened, 1:, 1:] += secant
    return Loose(
        problem, replace(line, by_impulse=by_impulse, by_velocity=by_velocity), cluster[:-1], number - 1,
        contacts, of_sides[contacts], softened, secant,
    )  # fmt: skip
