"""Quality: how far a pair (p, U) is from solving a contact problem, whoever made it.

    quality = assess(problem, impulse, rigid_velocity)
    quality.error <= tolerance

The velocities are made anew from the problem, and no solver's word is taken for anything.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.problem import ContactProblem, Products
from masonry_fem.nscd.scaling import contact_scale, free_speed

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Quality:
    """Error measures of a candidate solution; p̃ is the contact part of p, p itself where joints are dry.

    Attributes
    ----------
    natural_map : ‖p̃ − P_K(p̃ − v̂/w)‖ / ‖p‖ with the scale w of each contact; unit-free.
    natural_map_velocity : The same in velocities: the largest w_i‖p̃_i − P_K(…)‖ relative to the
        largest velocity that matters; unit-free. That is the largest elastic velocity ‖W_el p‖_i
        (elastic displacement over step), and where nothing is elastic the largest free velocity.
    block_balance : Largest residual of a body in Bᵀp + f_r − M_r (U − U_0) = 0, relative to the
        largest impulse on a body's modes; unit-free.
    max_penetration : Worst −v_N ≥ 0, gap term included [m/s].
    min_normal : Least p̃_N, at most 0 [N s].
    cone_violation : Worst ‖p̃_T‖ − μ p̃_N ≥ 0 [N s].
    complementarity : Worst ``|p̃ · v̂|`` [J].

    Notes
    -----
    Nothing is subtracted from these measures; ``rounding`` gives what rounding alone may make of each.
    Without any impulse the first two are the largest penetration relative to the largest velocity.
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
        return max(self._measures) if math.isfinite(sum(self._measures)) else math.inf

    @property
    def _measures(self) -> tuple[float, float, float]:
        return self.natural_map, self.natural_map_velocity, self.block_balance

    def bounded_by(self, bounds: Quality, tolerance: float) -> bool:
        """True where each of these measures is within the tolerance, or within its own bound.

        Parameters
        ----------
        bounds : A bound of each measure. tolerance : What is near enough.
        """
        pairs = zip(self._measures, bounds._measures, strict=True)
        return all(measure <= max(bound, tolerance) for measure, bound in pairs)


def assess(
    problem: ContactProblem,
    impulse: FloatArray,
    rigid_velocity: FloatArray,
    scale: FloatArray | None = None,
    least_impulse: float = 0.0,
    products: Products | None = None,
) -> Quality:
    """Error measures of a candidate solution, computed from it and the problem alone.

    Parameters
    ----------
    problem : The contact problem.
    impulse : Impulses p, shape (c, d) [N s].
    rigid_velocity : Rigid velocities U, shape (b, m).
    scale : Scale w of each contact, shape (c,) [1/kg]; None: ``contact_scale(problem)``.
    least_impulse : Impulse to which errors are relative if ‖p‖ is smaller [N s], as after a load has gone,
        when only rounding is left of p.
    products : Those of the problem, if they are of these p and U; None: they are not known.
    """
    from masonry_fem.nscd.contact_measures import measured  # noqa: PLC0415 - Numba is slow to import

    at = _State(problem, impulse, rigid_velocity, scale, least_impulse, products)
    natural, penetration, tension, violation, work = measured(
        np.ascontiguousarray(at.pressed), np.ascontiguousarray(at.velocity), problem.friction, at.scale
    )
    unbalanced = _longest(at.given + problem.rigid_impulse - at.gained)
    return Quality(
        *at.relative(natural, unbalanced, penetration),
        max_penetration=penetration,
        min_normal=-tension,
        cone_violation=violation,
        complementarity=work,
    )


def rounding(
    problem: ContactProblem,
    impulse: FloatArray,
    rigid_velocity: FloatArray,
    scale: FloatArray | None = None,
    least_impulse: float = 0.0,
) -> Quality:
    """What rounding alone may make of each measure: no state of these sizes can be told to be better.

    With the unit roundoff u, a sum of n terms a_k is computed to within γ Σ|a_k|, γ = √n u: not always,
    but errors of one sign only are very unlikely in long sums [1]_. So (|·| takes the absolute value of
    each entry)

        v = W_el p + q + B U                is known to    δv = γ (|W_el| |p| + |q| + |B| |U|),
        p̃ = p + a + S v                     to             δp̃ = γ (|p| + |a|) + |S| δv,
        Bᵀ p + f_r − M_r (U − U_0)          to             γ (|B|ᵀ |p| + |f_r| + M_r (|U| + |U_0|)),
        v̂ = v + μ‖v_T‖ n                    to             δv̂ = (1 + μ) δv.

    Neither P_K nor 1 − P_K brings two points farther apart, so p̃ − P_K(p̃ − v̂/w) is known to δp̃ + δv̂/w.

    Parameters
    ----------
    problem, impulse, rigid_velocity, scale, least_impulse : Those of ``assess``.

    Returns
    -------
    A bound of each measure, in its unit, all at least 0 (``min_normal`` at most 0).

    References
    ----------
    .. [1] N. J. Higham and T. Mary, "A new approach to probabilistic rounding error analysis", SIAM Journal
       on Scientific Computing 41 (2019), with λ = 1. Bounds that hold always have n u instead of √n u: N. J.
       Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed., SIAM 2002, chapter 3.
    """
    at = _State(problem, impulse, rigid_velocity, scale, least_impulse)
    sizes, p, moved = _sizes(problem), np.abs(impulse), np.abs(rigid_velocity)
    d, m = problem.dimension, rigid_velocity.shape[1]
    summed = d * problem.operator.terms() + 2 * m + 1
    of_velocity = gamma(summed)[:, None] * sizes.velocity(p, moved)
    of_part = gamma(2) * sizes.contact_part(p, np.zeros_like(p))
    if sizes.cohesion_stiffness is not None:
        of_part += (sizes.cohesion_stiffness @ of_velocity[..., None])[..., 0]
    part = graphs.lengths(of_part)
    augmented = (1.0 + problem.friction) * graphs.lengths(of_velocity)
    return Quality(
        *at.relative(part + augmented / at.scale, _largest(_of_balance(sizes, p, moved))),
        max_penetration=_largest(of_velocity[:, 0]),
        min_normal=-_largest(of_part[:, 0]),
        cone_violation=_largest((1.0 + problem.friction) * part),
        complementarity=_largest(
            part * graphs.lengths(graphs.augmented_velocity(at.velocity, problem.friction))
            + graphs.lengths(at.pressed) * augmented
        ),
    )


def balance_rounding(problem: ContactProblem, impulse: FloatArray, rigid_velocity: FloatArray) -> FloatArray:
    """What rounding alone may leave of the balance of each body, shape (b,); see ``rounding``.

    Parameters
    ----------
    problem, impulse, rigid_velocity : Those of ``assess``.
    """
    return _of_balance(_sizes(problem), np.abs(impulse), np.abs(rigid_velocity))


def _of_balance(sizes: ContactProblem, p: FloatArray, moved: FloatArray) -> FloatArray:
    """The same of absolute values."""
    touching = np.bincount(sizes.bodies[sizes.bodies >= 0], minlength=sizes.body_count)
    momentum = sizes.body_impulse(p) + sizes.rigid_impulse
    momentum += sizes.rigid_mass * (moved + sizes.rigid_velocity)
    bound: FloatArray = gamma(sizes.dimension * touching + 3) * graphs.lengths(momentum)
    return bound


class _State:
    """What the measures of a state have in common: its parts, and what its errors are relative to."""

    def __init__(
        self,
        problem: ContactProblem,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        scale: FloatArray | None,
        least_impulse: float,
        products: Products | None = None,
    ) -> None:
        self.problem, self.impulse, self.least_impulse = problem, impulse, least_impulse
        self.scale = contact_scale(problem) if scale is None else scale
        if products is None or not products.are_of(impulse, rigid_velocity):
            products = problem.products(impulse, rigid_velocity)
        self.elastic, self.velocity, self.given = products.elastic, products.velocity, products.given
        self.pressed = problem.contact_part(impulse, self.velocity)
        self.gained = problem.rigid_mass * (rigid_velocity - problem.rigid_velocity)

    def relative(
        self, natural: FloatArray, unbalanced: float, penetration: float = 0.0
    ) -> tuple[float, float, float]:
        """The unit-free measures of what remains at each contact, (c,) [N s], and of a body at most."""
        moved = _largest(self.scale * natural)
        if not self.impulse.any():
            # of blocks that go into each other the natural map shows 1/√(1 + μ²) where they slip, too
            moved = max(moved, penetration)
        impulse, speed = self._references()
        balance = _ratio(unbalanced, self._largest_momentum())
        if impulse == 0:
            longest = _longest(self.velocity)
            # squares of speeds below 1e-162 m/s are zero
            alone = 0.0 if longest == 0 else _ratio(moved, longest)
            return alone, alone, balance
        return float(np.linalg.norm(natural)) / impulse, _ratio(moved, speed), balance

    def _references(self) -> tuple[float, float]:
        """Impulse [N s] and velocity [m/s] that the natural map is divided by."""
        size = float(np.linalg.norm(self.impulse))
        reference = max(size, self.least_impulse)
        if size == 0:
            return reference, _largest(self.scale) * reference
        # w‖p‖ would not do: with a heavy block on a light one it exceeds all velocities by the ratio
        # of their masses, and hides a p that is wrong by as much
        speed = _longest(self.elastic) or free_speed(self.problem)
        speed = speed or _largest(self.scale * graphs.lengths(self.impulse))
        return reference, speed * (reference / size)

    def _largest_momentum(self) -> float:
        # one contact's impulse counts too: a wedged block has large ones that cancel
        if not self.problem.body_count:
            return 0.0
        from masonry_fem.nscd.transfer import largest_side  # noqa: PLC0415 - Numba is slow to import

        sides = float(largest_side(self.problem.rigid_map, np.ascontiguousarray(self.impulse)))
        return max(sides, *map(_longest, (self.given, self.problem.rigid_impulse, self.gained)))


def gamma(terms: FloatArray | IntArray | int) -> FloatArray:
    """γ of sums of so many terms, see ``rounding``."""
    share: FloatArray = np.sqrt(terms) * np.finfo(float).eps / 2
    return share


def _sizes(problem: ContactProblem) -> ContactProblem:
    """The problem with the absolute value of each entry that is multiplied or added."""
    offset, stiffness = problem.cohesion_offset, problem.cohesion_stiffness
    return replace(
        problem,
        compliance=problem.operator.magnitudes(),
        free_velocity=np.abs(problem.free_velocity),
        rigid_map=np.abs(problem.rigid_map),
        rigid_impulse=np.abs(problem.rigid_impulse),
        rigid_velocity=np.abs(problem.rigid_velocity),
        cohesion_offset=None if offset is None else np.abs(offset),
        cohesion_stiffness=None if stiffness is None else np.abs(stiffness),
    )


def _largest(values: FloatArray) -> float:
    """Largest value, at least 0; nan where one is."""
    return float(values.max(initial=0.0))


def _longest(rows: FloatArray) -> float:
    """Length of the longest row; nan where one is."""
    from masonry_fem.nscd.transfer import longest  # noqa: PLC0415 - Numba is slow to import

    return float(longest(np.ascontiguousarray(rows)))


def _ratio(part: float, whole: float) -> float:
    if part == 0:
        return 0.0
    return part / whole if whole > 0 else np.inf
