"""Admissible impulses: whether any impulses within the friction cones balance the loads.

    found = admissible_impulses(problem)
    found.stands            # there are some
    found.falls             # there are none, whatever the motion: found.motion proves it
    at_limit(problem)       # true: with a little less friction there are none

min ½‖Bᵀp + f_r‖² over the cones is convex. Where the minimum is zero the loads can be carried, by p;
where it is not, the unbalanced impulse is the rigid motion of a mechanism (Farkas), and no state of
sticking and sliding can be an equilibrium. It is the static theorem of limit analysis, and the
judge of a verdict that the nonlinear solution gave.

Cohesion that is constant counts as a load. That of springs gives whatever they are stretched for: to the
cone of their contact come all impulses in the directions of their stiffness.

It is also what one step of rigid blocks of unit mass does whose joints dilate as they slide: a contact
problem without the friction term, for which the interior-point method is made.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd import graphs
from masonry_fem.nscd.cohesion import onto_cones, sprung_directions, without_offset
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import assess
from masonry_fem.nscd.scaling import free_speed, rigid_diagonal
from masonry_fem.nscd.settings import SolverSettings

FloatArray = NDArray[np.float64]

# Unbalanced part of the loads below which they can be carried.
BALANCED = 1e-5
# Unbalanced part that a convex problem does not end at for want of accuracy. Springs that are far firmer than
# all else leave no exact mechanism.
FAR = 1e-2
# Share of friction without which a structure at its limit cannot carry its loads; they then lack some
# tenth of it, well above what counts as balanced.
MARGIN = 1e-3
ITERATIONS = 60
# The least that is proven to be missing over what a balance lacks: enough for a proof; for one motion only.
TWICE, UNIQUE = 0.5, 1 - 1e-6
# Ratio of the bodies' largest motions by a unit impulse from which they are brought to one scale.
UNEVEN = 100.0
# Of the speed that the loads give: what gaps of rounding size, closed in a step, come to.
CLOSED = 1e-12
# Stiffness that springs get, over that by which a unit mass resists: they then give way by its inverse.
FIRM = 1e8


@dataclass(frozen=True, slots=True)
class Admissible:
    """The best balance found.

    Attributes
    ----------
    impulse : p, the contact part within the cones [N s], shape (c, d).
    unbalanced : ‖Bᵀp + f_r‖ / ‖f_r‖ on the modes without inertia; 0 without loads.
    motion : Rigid velocities of a mechanism that proves that nothing balances the loads, shape (b, m) [m/s
        for blocks of unit mass]; None: there is no such proof.
    """

    impulse: FloatArray
    unbalanced: float
    motion: FloatArray | None = None

    @property
    def stands(self) -> bool:
        """True where the impulses balance the loads."""
        return self.unbalanced <= BALANCED

    @property
    def falls(self) -> bool:
        """True where a mechanism proves that none do, or much is left; where neither holds, nobody knows."""
        proven = self.motion is not None
        return (proven and not self.stands) or self.unbalanced > FAR


def admissible_impulses(
    problem: ContactProblem, tolerance: float = 1e-6, iterations: int = ITERATIONS, near: float = TWICE
) -> Admissible:
    """Impulses within the cones that balance the loads on static modes as well as they can.

    Parameters
    ----------
    problem : The contact problem.
    tolerance : Unbalanced share of the loads at which the search stops. It also stops where the best
        balance is proven to leave more than that, and ``near`` of what the one found does.
    iterations : Most steps of the interior-point method.
    near : The share, below 1.
    """
    if problem.cohesion_offset is not None:
        made = admissible_impulses(without_offset(problem), tolerance, iterations, near)
        return replace(made, impulse=made.impulse - problem.cohesion_offset)
    scale = _evening(problem)
    if scale is not None:
        made = admissible_impulses(_evened(problem, scale), tolerance, iterations, near)
        return made if made.motion is None else replace(made, motion=scale * made.motion)
    best = Admissible(np.zeros_like(problem.free_velocity), 1.0)
    rigid_map, load = static_part(problem)
    size = float(np.linalg.norm(load))
    if size == 0 or rigid_map.nnz == 0:
        return replace(best, unbalanced=float(size > 0))
    # larger impulses leave more than the tolerance as rounding of their products with B
    largest = tolerance / np.finfo(float).eps * size / float(abs(rigid_map).max())
    twin, transposed = _twin(problem), rigid_map.T.tocsr()
    run, settings = InteriorPoint(sliding=np.inf).init(twin, None), SolverSettings(tolerance=1e-15)
    offer, static = run.guess(), problem.rigid_mass <= 0
    for _ in range(iterations):
        offer = run.step(assess(twin, offer.impulse, offer.rigid_velocity), settings)
        velocity = twin.contact_velocity(offer.rigid_velocity)
        impulse = onto_cones(twin, offer.impulse, velocity)
        unbalanced = float(np.linalg.norm(transposed @ impulse.ravel() + load)) / size
        if unbalanced < best.unbalanced:
            best = Admissible(impulse, unbalanced)
        motion = offer.rigid_velocity[static]
        least = _least_unbalanced(problem, rigid_map, load, motion, largest) / size
        proven = least >= max(tolerance, near * best.unbalanced)
        if proven:
            return replace(best, motion=np.where(static, offer.rigid_velocity, 0.0))
        if offer.verdict is not None or best.unbalanced <= tolerance:
            break
    return best


def _evening(problem: ContactProblem) -> FloatArray | None:
    """By what to multiply the static modes of bodies to bring them to one scale, (b, m); None: they have one.

    Modes are of unit mass, and a block 1e-8 as heavy as its neighbours moves 1e4 times as far by the same
    impulse: its balance then is rounding of theirs. Without inertia the scale of a mode is free to choose.
    """
    static = problem.rigid_mass <= 0
    largest = np.zeros(problem.body_count)
    contact, side = np.nonzero(problem.bodies >= 0)
    body = problem.bodies[contact, side]
    own = np.abs(problem.rigid_map[contact, side] * static[body][:, None]).max(axis=(1, 2))
    np.maximum.at(largest, body, own)
    touched = largest > 0
    if not touched.any() or largest[touched].max() <= UNEVEN * largest[touched].min():
        return None
    by_body = np.ones(problem.body_count)
    by_body[touched] = np.exp(np.log(largest[touched]).mean()) / largest[touched]
    scale: FloatArray = np.where(static, by_body[:, None], 1.0)
    return scale


def _evened(problem: ContactProblem, scale: FloatArray) -> ContactProblem:
    """The problem with its modes multiplied by ``scale`` (b, m)."""
    sides = np.concatenate([scale, np.ones((1, scale.shape[1]))])[problem.bodies]
    return replace(
        problem,
        rigid_impulse=scale * problem.rigid_impulse,
        rigid_map=problem.rigid_map * sides[:, :, None, :],
    )


def at_limit(problem: ContactProblem) -> bool:
    """True where no impulses balance the loads once friction is lower by ``MARGIN``.

    Elastic blocks that slide at the very limit find no rest: as they bulge, friction turns away from the
    direction it is needed in, the less the farther they slide, and balance is reached at infinity only.
    """
    return weakened(problem, TWICE).falls


def weakened(problem: ContactProblem, near: float = UNIQUE) -> Admissible:
    """What impulses within the cones of friction that is lower by ``MARGIN`` balance.

    Parameters
    ----------
    problem : The contact problem.
    near : See ``admissible_impulses``. What no impulses balance is unique, and so is the motion that it is
        of: by default it is found to the square root of 2 (1 − ``UNIQUE``).
    """
    return admissible_impulses(replace(problem, friction=(1 - MARGIN) * problem.friction), near=near)


def falling(problem: ContactProblem, impulse: FloatArray) -> FloatArray | None:
    """A mechanism of the contacts that close within the step, where they carry no loads, shape (b, m).

    A contact counts whose gap is at most as large as the motions that supports, free blocks and the impulses
    make at any contact: what lies farther off, only a fall can reach.

    Parameters
    ----------
    problem : The contact problem.
    impulse : Contact impulses p, shape (c, d) [N s].
    """
    asked = np.maximum(-problem.free_velocity[:, 0], graphs.tangential_norm(problem.free_velocity))
    reach = max(asked.max(initial=0.0), graphs.lengths(problem.elastic_velocity(impulse)).max(initial=0.0))
    reach = max(float(reach), CLOSED * free_speed(problem))
    near = problem.free_velocity[:, 0] <= reach
    if problem.cohesion_stiffness is not None:  # springs pull across any gap
        near |= problem.cohesion_stiffness.any(axis=(1, 2))
    found = admissible_impulses(problem.without_compliance().only(np.flatnonzero(near)))
    return found.motion if found.falls else None


def _twin(problem: ContactProblem) -> ContactProblem:
    """Rigid blocks of unit mass at rest, of which only the static modes move."""
    static = problem.rigid_mass <= 0
    moves = np.concatenate([static, np.zeros((1, static.shape[1]), dtype=bool)])[problem.bodies]
    return replace(
        problem.without_compliance(),
        free_velocity=np.zeros_like(problem.free_velocity),
        rigid_map=problem.rigid_map * moves[:, :, None, :],
        rigid_mass=np.ones_like(problem.rigid_mass),
        rigid_velocity=np.zeros_like(problem.rigid_velocity),
        rigid_impulse=np.where(static, problem.rigid_impulse, 0.0),
        cohesion_stiffness=_firm(problem),
    )


def _firm(problem: ContactProblem) -> FloatArray | None:
    """Stiffness that all but keeps the springs' directions from moving, (c, d, d)."""
    directions = sprung_directions(problem)
    if directions is None:
        return None
    return FIRM / float(rigid_diagonal(problem).max()) * directions


def _least_unbalanced(
    problem: ContactProblem,
    rigid_map: sparse.csr_array,
    load: FloatArray,
    motion: FloatArray,
    largest: float,
) -> float:
    """What impulses in the cones with ‖p‖ ≤ ``largest`` leave unbalanced at least, by Farkas' lemma.

    ‖Bᵀp + f‖ ‖U‖ ≥ U·f + p·BU for any motion U, best the unbalanced impulse itself. In the cones
    p·BU ≥ −‖p‖ dist(BU, K*), and that distance is the length of −BU projected on K (Moreau). At the
    minimum it is zero and the bound the minimum itself.
    """
    opened = (rigid_map @ motion).reshape(problem.free_velocity.shape)
    closing = float(np.linalg.norm(graphs.project_cone(-opened, problem.friction)))
    directions = sprung_directions(problem)
    if directions is not None:
        closing += float(np.linalg.norm(directions @ opened[:, :, None]))
    speed = float(np.linalg.norm(motion))
    return float(motion @ load - largest * closing) / speed if speed > 0 else 0.0


def static_part(problem: ContactProblem) -> tuple[sparse.csr_array, FloatArray]:
    """B and f_r of the modes without inertia: (c d, k) and (k,)."""
    c, d = problem.free_velocity.shape
    bodies, m = problem.rigid_mass.shape
    contact, side = np.nonzero(problem.bodies >= 0)
    body, local = problem.bodies[contact, side], problem.rigid_map[contact, side]
    rows = np.broadcast_to((contact[:, None] * d + np.arange(d))[:, :, None], local.shape)
    columns = np.broadcast_to((body[:, None] * m + np.arange(m))[:, None, :], local.shape)
    where = (rows.ravel(), columns.ravel())
    whole = sparse.csr_array((local.ravel(), where), shape=(c * d, bodies * m))
    static = np.flatnonzero(problem.rigid_mass.ravel() <= 0)
    return sparse.csr_array(whole[:, static]), problem.rigid_impulse.ravel()[static]
