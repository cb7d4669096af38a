"""Quality: how far a pair (p, U) is from solving a contact problem, whoever made it.

    quality = assess(problem, impulse, rigid_velocity)
    quality.error <= tolerance

The velocities are made anew from the problem, and no solver's word is taken for anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale, diagonal_blocks, free_speed

FloatArray = NDArray[np.float64]

DROWNED = 1e-6  # of the speeds that matter: what may at most be lost in the rounding of large impulses
LARGE = 1e4  # times the speeds that matter: what an impulse would give to a contact alone, and seldom does
BOUNDLESS = 1e6  # times what is asked of all bodies: what no wedge makes of it
COHESIVE = 1e-2  # least share of the contact parts that errors are measured by
ROUNDING = 4 * np.finfo(float).eps  # of a body's momentum, in its balance, of S v in p̃, and of v_T
ROUGH = 10.0  # friction from which μ‖v_T‖ makes something of the rounding of v_T


@dataclass(frozen=True, slots=True)
class Quality:
    """Error measures of a candidate solution; p̃ is the contact part of p, p itself where joints are dry.

    Attributes
    ----------
    natural_map : ‖p̃ − P_K(p̃ − v̂/w)‖ / ‖p‖ with the scale w of each contact; unit-free.
    natural_map_velocity : The same in velocities: the largest w_i‖p̃_i − P_K(…)‖ relative to the
        largest velocity that matters; unit-free. That is the largest elastic velocity ‖W_el p‖_i
        (elastic displacement over step), and where nothing is elastic the largest free velocity.
    block_balance : Largest residual of a body in Bᵀp + f_r − M_r(U − U_0) = 0, relative to the
        largest impulse on a body's modes; unit-free.
    max_penetration : Worst −v_N ≥ 0, gap term included [m/s].
    min_normal : Least p̃_N, at most 0 [N s].
    cone_violation : Worst ‖p̃_T‖ − μ p̃_N ≥ 0 [N s].
    complementarity : Worst |p̃ · v̂| [J].

    Notes
    -----
    Without any impulse the first two are the largest penetration relative to the largest velocity:
    a load-free problem is judged by its velocities, free of units too. Cohesion far above the loads
    would leave its rounding: ‖p‖ is not taken for less than ``COHESIVE`` ‖p̃‖. Cohesion far stiffer than
    the blocks makes p̃ = p + S v of a v that is nearly rounding: a contact's residual no larger than S
    times the rounding of what v is summed from counts as none. Balance and velocities then bound p.
    Where contacts are very rough, a v_T that is rounding has no share in μ‖v_T‖.
    """

    natural_map: float
    natural_map_velocity: float
    block_balance: float
    max_penetration: float
    min_normal: float
    cone_violation: float
    complementarity: float

    @property
    def error(self) -> float:
        """What the tolerance bounds: the worst of the unit-free measures (inf where not finite)."""
        worst = max(self.natural_map, self.natural_map_velocity, self.block_balance)
        return (
            worst
            if np.isfinite(self.natural_map + self.natural_map_velocity + self.block_balance)
            else np.inf
        )


def assess(
    problem: ContactProblem,
    impulse: FloatArray,
    rigid_velocity: FloatArray,
    scale: FloatArray | None = None,
    least_impulse: float = 0.0,
) -> Quality:
    """Error measures of a candidate solution.

    Parameters
    ----------
    problem : What it is to solve.
    impulse : p, shape (c, d) [N s].
    rigid_velocity : U, shape (b, m).
    scale : ``contact_scale(problem)`` where the caller keeps it, shape (c,) [1/kg].
    least_impulse : Stands for ‖p‖ where that is less [N s]: where a load vanishes, what is left of p is
        rounding of what it was.
    """
    w = contact_scale(problem) if scale is None else scale
    elastic = problem.elastic_velocity(impulse)
    v = elastic + problem.free_velocity + problem.contact_velocity(rigid_velocity)
    mu = problem.friction
    pressed = problem.contact_part(impulse, v)
    size = float(np.linalg.norm(impulse))
    reference = max(size, least_impulse)
    if problem.cohesive:
        reference = max(reference, COHESIVE * float(np.linalg.norm(pressed)))
    speed = _largest(w) * reference
    if size > 0:
        speed = _velocity_scale(problem, impulse, elastic, w) * (reference / size)
    augmented = graphs.augmented_velocity(v, mu)
    if mu.max(initial=0.0) > ROUGH:
        parts = np.maximum(np.minimum(w * reference, speed), _parts(problem, elastic, rigid_velocity))
        augmented[:, 0] -= _rounding_of_slip(v, mu, parts)
    residual = pressed - graphs.project_cone(pressed - augmented / w[:, None], mu)
    absolute = np.maximum(graphs.lengths(residual), _swallowed(problem, pressed, v, w))
    absolute = np.maximum(absolute, _drowned(problem, pressed, augmented, w, speed))
    stiffness = problem.cohesion_stiffness
    if stiffness is not None:
        absolute[absolute <= _pressed_rounding(problem, stiffness, elastic, rigid_velocity)] = 0.0
    by_impulse = by_velocity = _ratio(_largest(w * absolute), _largest(graphs.lengths(v)))
    if reference > 0:
        by_impulse = float(np.linalg.norm(absolute)) / reference
        by_velocity = _ratio(_largest(w * absolute), speed)
    return Quality(
        natural_map=by_impulse,
        natural_map_velocity=by_velocity,
        block_balance=_block_balance(problem, impulse, rigid_velocity),
        max_penetration=_largest(-v[:, 0]),
        min_normal=-_largest(-pressed[:, 0]),
        cone_violation=_largest(graphs.tangential_norm(pressed) - mu * pressed[:, 0]),
        complementarity=_largest(np.abs((pressed * augmented).sum(axis=1))),
    )


def rounding(
    problem: ContactProblem,
    impulse: FloatArray,
    rigid_velocity: FloatArray,
    scale: FloatArray,
    least_impulse: float = 0.0,
) -> float:
    """Error that rounding of W_el p + q + B U alone may make, where that cancels; unit-free.

    Slender blocks bend far under single impulses and hardly at all under all of them together. The parameters
    are those of ``assess``.

    Parameters
    ----------
    problem : What was solved.
    impulse : p, shape (c, d) [N s].
    rigid_velocity : U, shape (b, m).
    scale : ``contact_scale(problem)``, shape (c,).
    least_impulse : Stands for ‖p‖ where that is less [N s].
    """
    size = float(np.linalg.norm(impulse))
    reference = max(size, least_impulse)
    if problem.rigid or size == 0:
        return 0.0
    compliance = problem.compliance.copy()
    compliance.data = np.abs(compliance.data)
    bent = (compliance @ np.abs(impulse).ravel()).reshape(impulse.shape)
    lost = np.finfo(float).eps * _parts(problem, bent, rigid_velocity)
    elastic = problem.elastic_velocity(impulse)
    speed = _velocity_scale(problem, impulse, elastic, scale) * (reference / size)
    return max(float(np.linalg.norm(lost / scale)) / reference, _ratio(_largest(lost), speed))


def _rounding_of_slip(velocity: FloatArray, friction: FloatArray, parts: FloatArray) -> FloatArray:
    """What rounding of v_T has made of μ‖v_T‖ at very rough contacts, (c,) [m/s].

    ``parts`` are what v is summed from, or what errors are relative to [m/s]: no arithmetic brings v_T
    below 1e-16 of them, and with μ = 1e6 that would count as 1e-10.
    """
    slip = graphs.tangential_norm(velocity)
    return np.where((friction > ROUGH) & (slip <= ROUNDING * parts), friction * slip, 0.0)


def _swallowed(
    problem: ContactProblem, impulse: FloatArray, velocity: FloatArray, w: FloatArray
) -> FloatArray:
    """What of the natural map p − P_K(p − v/w) rounding hides where nothing can close a contact, (c,) [N s].

    No velocity tells of the size of such an impulse, and where it is 1e23 N s, less v/w it is 1e23 still.
    """
    opening = np.maximum(velocity[:, 0], 0.0) / w
    rows = np.flatnonzero((opening > 0) & (opening <= ROUNDING * impulse[:, 0]))
    rows = rows[~problem.rigid_map[rows, :, 0].any(axis=(1, 2))]
    hidden = np.zeros(problem.count)
    if len(rows):
        own = diagonal_blocks(problem.compliance, problem.count, problem.dimension)[rows, 0, 0]
        hidden[rows[own == 0]] = opening[rows[own == 0]]
    return hidden


def _drowned(
    problem: ContactProblem, impulse: FloatArray, augmented: FloatArray, w: FloatArray, speed: float
) -> FloatArray:
    """What of pressed contacts' natural map vanishes beside p, and is no rounding, (c,) [N s].

    Rigid blocks that are asked to be where they cannot get impulses without bounds, beside which v/w is lost.
    So v counts in full where it is no small speed, and where p is beyond all that loads and motions ask for.
    """
    size = graphs.lengths(impulse)
    hidden = np.zeros(len(size))
    if not (w * size > LARGE * speed).any():
        return hidden
    moves = graphs.lengths(augmented)
    seen = (moves > DROWNED * speed) & (moves <= ROUNDING * w * size)
    if problem.body_count:  # a plain problem does not tell what bodies' loads ask for
        seen |= size > BOUNDLESS * _asked(problem, w)
    rows = seen & (impulse[:, 0] > 0)
    hidden[rows] = moves[rows] / w[rows]
    return hidden


def _asked(problem: ContactProblem, w: FloatArray) -> float:
    """Impulse [N s] that stops all bodies and gives each contact the velocity asked of it."""
    reach = np.zeros(problem.body_count)  # of a body's modes, the largest motion: 1/√m
    contact, side = np.nonzero(problem.bodies >= 0)
    own = np.abs(problem.rigid_map[contact, side]).max(axis=(1, 2))
    np.maximum.at(reach, problem.bodies[contact, side], own)
    gained = graphs.lengths(problem.rigid_impulse) + graphs.lengths(
        problem.rigid_mass * problem.rigid_velocity
    )
    touched = reach > 0
    given = _largest(graphs.lengths(problem.free_velocity) / w)
    return float((gained[touched] / reach[touched]).sum()) + given


def _velocity_scale(
    problem: ContactProblem, impulse: FloatArray, elastic: FloatArray, w: FloatArray
) -> float:
    # w‖p‖ would not do: with a heavy block on a light one it exceeds all velocities by the ratio
    # of their masses, and hides a p that is wrong by as much
    return _largest(graphs.lengths(elastic)) or free_speed(problem) or _largest(w * graphs.lengths(impulse))


def _pressed_rounding(
    problem: ContactProblem, stiffness: FloatArray, elastic: FloatArray, rigid_velocity: FloatArray
) -> FloatArray:
    """How exactly S v is known: v by its parts, which cancel where stiff cohesion bonds, (c,) [N s]."""
    parts = _parts(problem, elastic, rigid_velocity)
    rounding: FloatArray = ROUNDING * np.linalg.norm(stiffness, axis=(1, 2)) * parts
    return rounding


def _parts(problem: ContactProblem, elastic: FloatArray, rigid_velocity: FloatArray) -> FloatArray:
    """Sum of the sizes of what v is summed from, (c,) [m/s]."""
    still = np.zeros((1, rigid_velocity.shape[1]))  # supports are numbered -1
    sides = problem.rigid_map @ np.concatenate([rigid_velocity, still])[problem.bodies][..., None]
    parts: FloatArray = graphs.lengths(elastic) + graphs.lengths(problem.free_velocity)
    parts += np.linalg.norm(sides[..., 0], axis=2).sum(axis=1)
    return parts


def _block_balance(problem: ContactProblem, impulse: FloatArray, rigid_velocity: FloatArray) -> float:
    if not problem.body_count:
        return 0.0
    sides = problem.side_impulse(impulse)
    given = problem.body_impulse(impulse)
    gained = problem.rigid_mass * (rigid_velocity - problem.rigid_velocity)
    residual = graphs.lengths(given + problem.rigid_impulse - gained)
    momentum = problem.rigid_mass * np.maximum(np.abs(rigid_velocity), np.abs(problem.rigid_velocity))
    residual[residual <= ROUNDING * graphs.lengths(momentum)] = 0.0
    # one contact's impulse counts too: a wedged block has large ones that cancel
    parts = (given, problem.rigid_impulse, gained, sides.reshape(-1, sides.shape[2]))
    return _ratio(_largest(residual), max(_largest(graphs.lengths(part)) for part in parts))


def _largest(values: FloatArray) -> float:
    """Largest value, at least 0; nan where one is."""
    return float(values.max(initial=0.0))


def _ratio(part: float, whole: float) -> float:
    if part == 0:
        return 0.0
    return part / whole if whole > 0 else np.inf
