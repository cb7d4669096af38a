"""Questions of limit analysis: can the loads be carried, how far may they grow, how large is the thrust.

    carried = admissible(problem)               # .holds: reactions, or the mechanism that proves it not
    collapse = collapse_multiplier(problem)     # .multiplier, .mechanism
    low, high = interval(problem, support_resultant(problem, block, axis=0))

The flow rule is associated: a joint that slides also opens, at the angle of friction. Loads that cannot be
carried in this model cannot be carried with Coulomb friction either; loads that can be carried may still
make a structure collapse by sliding (Drucker). Blocks do not deform and have not moved.

Every question is asked as a ``Program`` that has a solution and a bounded value: whether a load may grow
without limit is asked first, with the growing part alone. So no answer depends on how a solver reports
infinity.

References
----------
Drucker, Coulomb friction, plasticity, and limit loads, J. Appl. Mech. 21 (1954).
Heyman, The stone skeleton, Int. J. Solids Structures 2 (1966).
Livesley, Limit analysis of structures formed from rigid blocks, Int. J. Numer. Meth. Engng 12 (1978).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from masonry_fem.errors import ProblemError
from masonry_fem.limit.conic import maximise_cones
from masonry_fem.limit.linear import maximise_plane
from masonry_fem.limit.problem import FloatArray, LimitProblem, mechanism_of
from masonry_fem.limit.program import AT_BOUND, Optimum, Program
from masonry_fem.limit.simplest import simplest
from masonry_fem.march.mechanism import Mechanism

EXACT = (
    1e-4  # largest relative error of equilibrium, mechanism or bound in an answer; mostly it is below 1e-9
)


@dataclass(frozen=True, slots=True)
class Admissible:
    """Whether the loads can be carried.

    Attributes
    ----------
    holds : True if contact forces within the joints' strength balance the loads.
    share : Share of the loads that can be carried, 0 to 1; without cohesion or holds it is 0 or 1.
    reaction : Such contact forces, local frames, shape (c, d) [N]; below a share of 1 those of the share.
    unbalanced : Imbalance that they leave, relative to the largest load.
    mechanism : Motion in which the loads come down if they cannot be carried; None if they can.
    closing : How far that motion makes blocks penetrate, relative: its error as a proof.
    """

    holds: bool
    share: float
    reaction: FloatArray
    unbalanced: float
    mechanism: Mechanism | None
    closing: float


@dataclass(frozen=True, slots=True)
class Collapse:
    """Answer of ``collapse_multiplier``.

    Attributes
    ----------
    multiplier : Greatest factor of the live load that can be carried; inf: any; nan: none, not even 0.
    least : Smallest such factor ≥ 0; above 0 where the dead load needs the live one; nan: there is none.
    reaction : Contact forces at the multiplier, shape (c, d) [N].
    mechanism : Motion of the collapse; None if the multiplier is not finite.
    unbalanced, closing : Errors of reactions and mechanism, as for ``Admissible``.
    gap : Relative difference between the lower bound, proved by the reactions, and the upper bound, proved by
        the mechanism.
    """

    multiplier: float
    least: float
    reaction: FloatArray
    mechanism: Mechanism | None
    unbalanced: float = 0.0
    closing: float = 0.0
    gap: float = 0.0


@dataclass(frozen=True, slots=True)
class Interval:
    """Smallest and largest value of a resultant over all contact forces that carry the loads.

    Attributes
    ----------
    low, high : [N]; infinite where nothing bounds them, nan where the loads cannot be carried, or where the
        program was not solved.
    gap : Difference of the bounds that forces and motions prove, and their errors, relative to the loads.
    error : The same as a force: how far an end may be off [N]; inf where one was not found.
    """

    low: float
    high: float
    gap: float = 0.0
    error: float = 0.0

    @property
    def exact(self) -> bool:
        """False if the error of an end is larger than other answers may have."""
        return self.gap <= EXACT


# --- questions --------------------------------------------------------------------------------


def admissible(problem: LimitProblem, factor: float = 0.0) -> Admissible:
    """Whether the dead load and ``factor`` times the live load can be carried.

    Parameters
    ----------
    problem : Blocks, contact points and loads, from ``limit_problem``.
    factor : Factor of the live load.

    Raises
    ------
    ProblemError : The answer is not accurate enough.
    """
    load = problem.load(factor)
    if not load.any():
        return Admissible(True, 1.0, np.zeros_like(problem.points), 0.0, None, 0.0)
    program = _program(problem, np.zeros_like(load), load, 1.0)
    found = _solved(program)
    share = min(max(found.value, 0.0), 1.0)
    reaction = _reaction(problem, found)
    if share >= 1.0 - AT_BOUND:
        trust("whether the loads can be carried", found.unbalanced)
        return Admissible(True, 1.0, reaction, found.unbalanced, None, 0.0)
    trust("whether the loads can be carried", found.closing)
    motion = mechanism_of(problem, simplest(program, found))
    return Admissible(False, share, reaction, found.unbalanced, motion, found.closing)


def collapse_multiplier(problem: LimitProblem) -> Collapse:
    """The largest factor of the live load that can be carried together with the dead load.

    Raises
    ------
    ProblemError : No load grows, or the answer is not accurate enough.
    """
    dead, live, nothing = problem.dead, problem.live, np.zeros_like(problem.points)
    if not live.any():
        raise ProblemError(
            "no load grows, so that there is no collapse multiplier; give the scene a load besides gravity, "
            "or tilt it"
        )
    least = 0.0
    if not admissible(problem).holds:
        lowest = maximum(_program(problem, dead, -live, 0.0))
        if lowest is None:
            return Collapse(np.nan, np.nan, nothing, None)
        least = -lowest.value
    if _carried_alone(problem, live):
        return Collapse(np.inf, least, nothing, None)
    program = _program(problem, dead, live, np.inf)
    found = _solved(program)
    trust("the collapse multiplier", found.unbalanced, found.closing, found.gap)
    return Collapse(
        multiplier=found.value + 0.0,  # -0 becomes 0
        least=least,
        reaction=_reaction(problem, found),
        mechanism=mechanism_of(problem, simplest(program, found)),
        unbalanced=found.unbalanced,
        closing=found.closing,
        gap=found.gap,
    )


def interval(
    problem: LimitProblem, resultant: FloatArray, factor: float = 0.0, carried: bool | None = None
) -> Interval:
    """Smallest and largest value of a resultant under the dead load and ``factor`` times the live load.

    An end that is not accurate is returned with its error, not refused.

    Parameters
    ----------
    problem : Blocks, contact points and loads, from ``limit_problem``.
    resultant : Coefficient of each contact force component and each hold, shape (c d + h,), such as from
        ``support_resultant``.
    factor : Factor of the live load.
    carried : Whether the loads can be carried; None: it is found out.
    """
    if not (admissible(problem, factor).holds if carried is None else carried):
        return Interval(np.nan, np.nan, np.nan)
    low, below = _extreme(problem, -resultant, factor)
    high, above = _extreme(problem, resultant, factor)
    gap = max(below, above)
    return Interval(
        0.0 - low, high + 0.0, gap, gap * float(np.abs(resultant).max(initial=0.0)) * problem.force
    )


def _extreme(problem: LimitProblem, resultant: FloatArray, factor: float) -> tuple[float, float]:
    """Greatest value of a resultant [N], its error relative to the unit of forces; nan, inf: not found."""
    size = float(np.abs(resultant).max(initial=0.0))
    if size == 0:
        return 0.0, 0.0
    row = sparse.csr_array(resultant[None] / size)
    matrix = sparse.csr_array(sparse.vstack([problem.equilibrium, row]))
    load = np.append(problem.load(factor), 0.0)
    value = np.zeros_like(load)
    value[-1] = -1.0
    base = _program(problem, load, value, np.inf)
    base = replace(base, matrix=matrix)
    friction = base.strength.without_cohesion()
    loose = replace(base, fixed=np.zeros_like(load), strength=friction, upper=1.0)
    try:
        if _solved(loose).value >= 1.0 - AT_BOUND:
            return np.inf, 0.0
        found = _solved(base)
    except ProblemError:
        return np.nan, np.inf
    gap = found.gap * max(abs(found.value), 1e-3)
    return found.value * size * problem.force, max(gap, found.unbalanced, found.closing)


# --- resultants -------------------------------------------------------------------------------


def support_resultant(problem: LimitProblem, block: int, axis: int) -> FloatArray:
    """Coefficients of the force that a support exerts along a world axis, shape (c d + h,), for ``interval``.

    Parameters
    ----------
    problem : Blocks and contact points.
    block : Number of the support.
    axis : 0 for x, 1 for y, 2 for z.
    """
    blocks = problem.model.contacts.blocks
    sign = np.where(blocks[:, 0] == block, -1.0, 0.0) + np.where(blocks[:, 1] == block, 1.0, 0.0)
    return _contacts(problem, sign, axis)


def interface_resultant(problem: LimitProblem, interface: int, axis: int) -> FloatArray:
    """Coefficients of the force on the candidate of an interface along a world axis, shape (c d + h,).

    The candidate is the first of ``Interface.blocks``.

    Parameters
    ----------
    problem : Blocks and contact points.
    interface : Number of the interface.
    axis : 0 for x, 1 for y, 2 for z.
    """
    model = problem.model
    own = model.contacts.interface == interface
    candidate = model.interfaces[interface].blocks[0] if own.any() else -1
    sign = np.where(model.contacts.blocks[:, 0] == candidate, 1.0, -1.0)
    return _contacts(problem, np.where(own, sign, 0.0), axis)


def hold_resultant(problem: LimitProblem, name: str, axis: int) -> FloatArray:
    """Coefficients of the force that held faces exert along a world axis, shape (c d + h,).

    Parameters
    ----------
    problem : Blocks and contact points.
    name : Name of the support that holds the faces.
    axis : 0 for x, 1 for y, 2 for z.
    """
    resultant = np.zeros(problem.equilibrium.shape[1])
    for number, hold in enumerate(problem.holds, start=problem.points.size):
        resultant[number] = float(hold.name == name and hold.axis == axis)
    return resultant


def _contacts(problem: LimitProblem, sign: FloatArray, axis: int) -> FloatArray:
    rows = np.where(problem.active, sign, 0.0)[:, None] * problem.frame[:, :, axis]
    resultant = np.zeros(problem.equilibrium.shape[1])
    resultant[: rows.size] = rows.ravel()
    return resultant


# --- programs ---------------------------------------------------------------------------------


def _program(problem: LimitProblem, fixed: FloatArray, growing: FloatArray, upper: float) -> Program:
    return Program(problem.equilibrium, fixed, growing, problem.strength, problem.dimension, upper)


def _carried_alone(problem: LimitProblem, load: FloatArray) -> bool:
    """Whether friction carries a load beside which all others vanish: it may then grow without limit."""
    program = _program(problem, np.zeros_like(load), load, 1.0)
    found = _solved(replace(program, strength=program.strength.without_cohesion()))
    return found.value >= 1.0 - AT_BOUND and found.unbalanced <= EXACT


def maximum(program: Program) -> Optimum | None:
    """The optimum of a program; None where its equations have no solution."""
    return maximise_plane(program) if program.dimension == 2 else maximise_cones(program)


def _solved(program: Program) -> Optimum:
    found = maximum(program)
    if found is None:
        raise ProblemError(
            "limit analysis: no reactions balance the loads, although some were found before; the structure "
            "is at the very limit: change the loads by a little"
        )
    return found


def _reaction(problem: LimitProblem, found: Optimum) -> FloatArray:
    reaction: FloatArray = np.where(problem.active[:, None], problem.reaction(found.force), 0.0)
    return reaction


def trust(what: str, *errors: float) -> None:
    """Refuse an answer whose own proof does not hold.

    Raises
    ------
    ProblemError : It does not.
    """
    worst = max((error for error in errors if np.isfinite(error)), default=0.0)
    if worst > EXACT:
        raise ProblemError(
            f"limit analysis: {what} is found to {worst:.1e} only, expected {EXACT:.0e}; the structure may "
            "be at the very limit: change loads or friction by a little"
        )
