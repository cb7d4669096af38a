"""Unstressed: whether a static state is reached from a start without stress, or only thinkable.

    told = from_no_stress(problem)
    told.reached            # False: what carries the loads is a thrust that nothing has put there

Rigid blocks at rest are held by any impulses within the cones that balance the loads, and so by pairs of
thrusts that balance each other: a beam between two walls that nobody has pushed together stands. Give
each contact a compliance, and impulses come from motion alone. Where nothing is stressed
at the start and what is closed touches without gap, the problem with the compliance ε w_i I has the same
impulses for every ε, and motions in proportion to it: its limit ε → 0 is that of ε = 1. Elastic blocks have
a compliance of their own.

That problem may have no solution, which no iteration proves. With a little drag δ on the bodies it always
has one (``drag``). What the drag bears is the share of its loads that a body lacks. It falls in proportion
to δ where blocks come to rest. Where they do not, they run off as 1/δ, and the share stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import lengths
from masonry_fem.nscd.outcome import Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.settings import SolverSettings, time_left
from masonry_fem.nscd.solvers.drag import Drag
from masonry_fem.nscd.threads import one_thread

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

# The drag over what the contacts resist a body's motion by. A stack of n blocks lacks some n² times it.
DRAGS = (1e-6, 1e-8, 1e-10)
# Times what the impulses give a contact: what slides farther is held by faces that close in by their rounding
# as coordinates (1e-7 in files of single precision), and by less friction than that not at all.
FAR = 1e6
FIRM = 1e-2  # a drag with which such faces carry nothing
FALLS = 0.2  # from one drag to the next: the share then vanishes with the drag, which falls by 0.01
STAYS = 0.95  # the share does not vanish at all
# What is asked where no strides lead to a drag, and the error of a state that shows the share.
METHODS: tuple[str, ...] = ("interior_point", "auto")
TOLERANCE = 1e-6
USABLE = 1e-5
BALANCED = 1e-8  # error of impulses that show balance


@dataclass(frozen=True, slots=True)
class Unstressed:
    """What the loads do to blocks that nothing stresses beforehand.

    Attributes
    ----------
    reached : True where they come to rest, False where they run off; None where neither could be told.
    impulse : p at the last drag, shape (c, d) [N s].
    motion : Rigid velocities there, at which what is not held runs off, shape (b, m).
    lacking : Largest share of its loads that a body lacks, by drag.
    solves : Linear systems factorised.
    """

    reached: bool | None
    impulse: FloatArray
    motion: FloatArray
    lacking: tuple[float, ...]
    solves: int


def from_no_stress(
    problem: ContactProblem, closed: Mask | None = None, until: float | None = None
) -> Unstressed:
    """Whether bodies without inertia come to rest under their loads, from a start without stress.

    Parameters
    ----------
    problem : Dry contacts. Where no body is elastic, each contact gets a compliance of its own scale, and
        the free velocity is left out: blocks start where they are.
    closed : Contacts that touch, (c,); the others take no part. None: all do.
    until : Monotonic clock after which nothing more is tried [s]; None: no limit.
    """
    mask = np.ones(problem.count, dtype=bool) if closed is None else closed
    with one_thread():
        told = _asked(_touching(problem, np.flatnonzero(mask)), until)
    impulse = np.zeros_like(problem.free_velocity)
    impulse[mask] = told.impulse
    return replace(told, impulse=impulse)


def _asked(problem: ContactProblem, until: float | None) -> Unstressed:
    """What states at falling drags tell."""
    dragged = Drag(problem, until)
    shares: list[float] = []
    if not dragged.at_once(DRAGS[0]) and problem.rigid:
        smooth = _frictionless(problem)
        dragged.solves += smooth.linear_solves
        if smooth.converged and lengths(smooth.impulse).max(initial=0.0) <= FAR * dragged.least:
            return Unstressed(True, smooth.impulse, np.zeros_like(dragged.motion), (0.0,), dragged.solves)
    for drag in DRAGS:
        there = dragged.reached <= drag or dragged.by_strides(drag)
        if not there and (problem.rigid or not _usual(dragged, drag)):
            break
        shares.append(dragged.lacking())
        if _vanishes(shares):
            break
    reached, impulse = _end(dragged, shares)
    return Unstressed(reached, impulse, dragged.motion, tuple(shares), dragged.solves)


def _end(dragged: Drag, shares: list[float]) -> tuple[bool | None, FloatArray]:
    """Whether bodies come to rest, by the shares that they lacked at falling drags, and the impulses then."""
    problem, impulse = dragged.problem, dragged.impulse
    if not _vanishes(shares):
        stays = len(shares) == len(DRAGS) and shares[-1] > STAYS * shares[-2]
        return False if stays else None, impulse
    if _slide(problem, impulse, dragged.motion) <= FAR:
        return True, impulse
    firm = Drag(problem, dragged.until)  # what the loads press without the faces' rounding
    return False, firm.impulse if firm.towards(FIRM) else impulse


def _frictionless(problem: ContactProblem) -> Solution:
    """Impulses p° without friction under which rigid blocks are balanced, if there are any.

    Then they stay: at a drag δ their velocities U give balance times Uᵀ

        fᵀ U = δ ‖U‖² − pᵀ v ≥ δ ‖U‖²    and    fᵀ U = −p°ᵀ v = −p°_n v_n ≤ 0

    since contact and friction give pᵀ v ≤ 0, and nothing enters anything, v_n ≥ 0. It costs a tenth of the
    way by strides in large walls. Impulses far above the loads come from faces that close in by rounding.
    """
    from masonry_fem.nscd.portfolio import solve  # noqa: PLC0415 - which asks this module for a verdict

    smooth = replace(problem, friction=np.zeros_like(problem.friction))
    return solve(smooth, SolverSettings(method="newton", tolerance=BALANCED))


def _usual(dragged: Drag, drag: float) -> bool:
    """Go to a drag of elastic blocks by the usual methods, which find no way where blocks are rigid."""
    from masonry_fem.nscd.portfolio import solve  # noqa: PLC0415 - which asks this module for a verdict

    held = replace(dragged.problem, rigid_mass=drag * dragged.resistance)
    for method in METHODS:
        if dragged.late:
            return False
        limit = time_left(dragged.until)
        made = solve(held, SolverSettings(method=method, tolerance=TOLERANCE, time_limit=limit))
        dragged.solves += made.linear_solves
        if made.quality.error <= USABLE:
            dragged.reached, dragged.impulse, dragged.motion = drag, made.impulse, made.rigid_velocity
            return True
    return False


def _vanishes(shares: list[float]) -> bool:
    return bool(shares) and (shares[-1] == 0 or (len(shares) > 1 and shares[-1] <= FALLS * shares[-2]))


def _touching(problem: ContactProblem, contacts: NDArray[np.int64]) -> ContactProblem:
    """The problem of some contacts and bodies without inertia, at rest where they are rigid."""
    rest = 0.0 if problem.rigid else 1.0
    part = problem.only(contacts)
    return replace(
        part,
        free_velocity=rest * part.free_velocity,
        rigid_mass=np.zeros_like(part.rigid_mass),
        rigid_velocity=rest * part.rigid_velocity,
    )


def _slide(problem: ContactProblem, impulse: FloatArray, motion: FloatArray) -> float:
    """Farthest slide of a contact over what the greatest impulse on its blocks gives it."""
    scale = contact_scale(problem)
    slip = lengths(problem.velocity(impulse, motion)[:, 1:])
    pressed = np.full(problem.body_count, 0.0)
    for side in (0, 1):
        own = problem.bodies[:, side] >= 0
        np.maximum.at(pressed, problem.bodies[own, side], impulse[own, 0])
    least = np.append(pressed, np.inf)[problem.bodies].min(axis=1)
    slides = (impulse[:, 0] > 0) & np.isfinite(least)
    return float((slip[slides] / (scale * least)[slides]).max(initial=0.0))
