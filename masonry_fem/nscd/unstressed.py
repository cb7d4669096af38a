"""Unstressed: whether a static state is reached from a start without stress, or only thinkable.

    told = from_no_stress(problem)
    told.reached            # False: what carries the loads is a thrust that nothing has put there

Rigid blocks at rest are held by any impulses within the cones that balance the loads, and so by pairs of
thrusts that balance each other: a beam between two walls that nobody has pushed together stands. Give
each contact a compliance, and impulses come from motion alone (formulation 7b). Where nothing is stressed
at the start and what is closed touches without gap, the problem with the compliance ε w_i I has the same
impulses for every ε, and motions in proportion to it: its limit ε → 0 is that of ε = 1.

That problem may have no solution, which no iteration proves. With a little drag δ on the bodies it always
has one. What the drag bears is the share of its loads that a body lacks. It falls in proportion to δ where
blocks come to rest. Where they do not, they run off as 1/δ, and the share stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.linearisation import Linearisation, bonded_contacts, linearise
from masonry_fem.nscd.solvers.newton_system import NewtonSystem
from masonry_fem.nscd.threads import one_thread

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

# The drag over what the contacts resist a body's motion by. A stack of n blocks, or a wedge of the angle
# 1/n, lacks some n² times it; what n = 1e4 lacks of the last is a hundredth. Angles of 1e-7, the rounding
# of surveyed shapes, hold nothing at the last.
DRAGS = (1e-6, 1e-8, 1e-10)
FALLS = 0.2  # from one drag to the next: the share then vanishes with the drag, which falls by 0.01
STAYS = 0.95  # the share does not vanish at all
TOLERANCE = 1e-6
STEPS = 40  # Newton steps before another method is asked
FULL = 6  # steps without line search: the active set settles in few of them


@dataclass(frozen=True, slots=True)
class Unstressed:
    """What the loads do to blocks that nothing stresses beforehand.

    Attributes
    ----------
    reached : True where they come to rest, False where they run off; None where neither could be told.
    impulse : p at the last drag, shape (c, d) [N s].
    motion : Rigid velocities there, at which what is not held runs off, shape (b, m).
    lacking : Largest share of its loads that a body lacks, by drag.
    """

    reached: bool | None
    impulse: FloatArray
    motion: FloatArray
    lacking: tuple[float, ...]


def from_no_stress(problem: ContactProblem, closed: Mask | None = None) -> Unstressed:
    """Whether bodies without inertia come to rest under their loads, from a start without stress.

    Parameters
    ----------
    problem : Dry contacts. Where no body is elastic, each contact gets a compliance of its own scale, and
        the free velocity is left out: blocks start where they are.
    closed : Contacts that touch, (c,); the others take no part. None: all do.
    """
    mask = np.ones(problem.count, dtype=bool) if closed is None else closed
    part = _touching(problem, np.flatnonzero(mask))
    with one_thread():
        told = _rigid(part) if problem.rigid else _elastic(part)
    impulse = np.zeros_like(problem.free_velocity)
    impulse[mask] = told.impulse
    return replace(told, impulse=impulse)


def _rigid(problem: ContactProblem) -> Unstressed:
    solver = _Soft(problem)
    start: Start | None = None
    shares: list[float] = []
    for drag in DRAGS:
        found = solver.solve(drag, start)
        if found is None:
            break
        start, share = found
        shares.append(share)
        if _vanishes(shares):
            break
    return _told(problem, start, shares)


def _elastic(problem: ContactProblem) -> Unstressed:
    """Elastic bodies have a compliance of their own."""
    start: Start | None = None
    shares: list[float] = []
    resistance = _resistance(problem, contact_scale(problem))
    for drag in DRAGS:
        found = _solved(replace(problem, rigid_mass=drag * resistance), start)
        if found is None:
            break
        start = found
        assert start.impulse is not None
        assert start.rigid_velocity is not None
        held = drag * resistance * (start.rigid_velocity - problem.rigid_velocity)
        shares.append(_lacking(problem, start.impulse, held))
        if _vanishes(shares):
            break
    return _told(problem, start, shares)


def _told(problem: ContactProblem, start: Start | None, shares: list[float]) -> Unstressed:
    impulse, motion = np.zeros_like(problem.free_velocity), np.zeros_like(problem.rigid_velocity)
    if start is not None and start.impulse is not None and start.rigid_velocity is not None:
        impulse, motion = start.impulse, start.rigid_velocity
    reached: bool | None = None
    if _vanishes(shares):
        reached = True
    elif len(shares) == len(DRAGS) and shares[-1] > STAYS * shares[-2]:
        reached = False
    return Unstressed(reached, impulse, motion, tuple(shares))


def _vanishes(shares: list[float]) -> bool:
    return bool(shares) and (shares[-1] == 0 or (len(shares) > 1 and shares[-1] <= FALLS * shares[-2]))


def _lacking(problem: ContactProblem, impulse: FloatArray, held: FloatArray) -> float:
    """Largest of the bodies' ``held`` impulses (b, m) over what acts on the body."""
    acting = np.linalg.norm(problem.rigid_impulse, axis=1)
    pressed = np.linalg.norm(problem.side_impulse(impulse), axis=2)
    for side in (0, 1):
        own = problem.bodies[:, side] >= 0
        np.maximum.at(acting, problem.bodies[own, side], pressed[own, side])
    lack = np.linalg.norm(held, axis=1)
    return float(np.divide(lack, acting, out=np.zeros_like(lack), where=acting > 0).max(initial=0.0))


def _resistance(problem: ContactProblem, scale: FloatArray) -> FloatArray:
    """What contacts resist a body's motion by, Bᵀ w⁻¹ B in the mean, shape (b, m) [kg].

    The same for all: what nothing holds then falls together.
    """
    sides = np.where(problem.bodies >= 0, 1.0, 0.0)[:, :, None, None] * problem.rigid_map**2
    total = float((sides.sum(axis=(1, 2, 3)) / scale).sum())
    mean = total / max(problem.rigid_mass.size, 1)
    return np.full_like(problem.rigid_mass, mean if mean > 0 else 1.0)


def _touching(problem: ContactProblem, contacts: NDArray[np.int64]) -> ContactProblem:
    """The problem of some contacts and bodies without inertia, at rest where they are rigid."""
    d = problem.dimension
    dofs = (contacts[:, None] * d + np.arange(d)).ravel()
    compliance = sparse.bsr_array((len(dofs), len(dofs)), blocksize=(d, d) if len(dofs) else (1, 1))
    if not problem.rigid:
        compliance = sparse.bsr_array(problem.compliance.tocsr()[dofs][:, dofs], blocksize=(d, d))
    rest = 0.0 if problem.rigid else 1.0
    return replace(
        problem,
        friction=problem.friction[contacts],
        free_velocity=rest * problem.free_velocity[contacts],
        compliance=compliance,
        bodies=problem.bodies[contacts],
        rigid_map=problem.rigid_map[contacts],
        rigid_mass=np.zeros_like(problem.rigid_mass),
        rigid_velocity=rest * problem.rigid_velocity,
    )


def _solved(problem: ContactProblem, start: Start | None) -> Start | None:
    """A solution by the usual methods; None where none of them finds one."""
    from masonry_fem.nscd.solve import solve  # noqa: PLC0415 - which asks this module for a verdict

    made = solve(problem, SolverSettings(tolerance=TOLERANCE), start)
    return Start(made.impulse, made.rigid_velocity) if made.converged else None


class _Soft:
    """Rigid bodies with drag on contacts of which each gives way by its own scale w_i I.

    Newton steps on v = w p + B U eliminate every contact, as those of rigid blocks do.
    """

    def __init__(self, problem: ContactProblem, library: Library = "auto") -> None:
        self.problem = problem
        self.scale = contact_scale(problem)
        self.rho = 0.5 / self.scale
        self.resistance = _resistance(problem, self.scale)
        self.system = NewtonSystem(problem, self.scale, library)

    def solve(self, drag: float, start: Start | None) -> tuple[Start, float] | None:
        """Impulses and motion at a drag, and the largest share of its loads that a body lacks."""
        mass = drag * self.resistance
        found = self._newton(mass, start) or self._other(mass)
        if found is None:
            return None
        impulse, motion = found
        return Start(impulse, motion), _lacking(self.problem, impulse, mass * motion)

    def _other(self, mass: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """By the usual methods, which take the compliance for that of elastic blocks."""
        c, d = self.problem.free_velocity.shape
        blocks = self.scale[:, None, None] * np.eye(d)
        compliance = sparse.bsr_array(
            (blocks, np.arange(c), np.arange(c + 1)), shape=(c * d, c * d), blocksize=(d, d)
        )
        found = _solved(replace(self.problem, compliance=compliance, rigid_mass=mass), None)
        if found is None or found.impulse is None or found.rigid_velocity is None:
            return None
        return found.impulse, found.rigid_velocity

    def _newton(self, mass: FloatArray, start: Start | None) -> tuple[FloatArray, FloatArray] | None:
        problem = self.problem
        impulse, motion = np.zeros_like(problem.free_velocity), np.zeros_like(problem.rigid_velocity)
        if start is not None and start.impulse is not None and start.rigid_velocity is not None:
            impulse, motion = start.impulse, start.rigid_velocity
        residuals: list[float] = []
        with np.errstate(all="ignore"):
            for count in range(STEPS):
                line = self._line(impulse, motion, bonded=start is None and count == 0)
                left = self._left(impulse, motion, mass)
                residual = self._size(line, left, impulse)
                if not np.isfinite(residual):
                    return None
                if count and residual <= TOLERANCE:
                    return impulse, motion
                change, turn = self._step(line, left, impulse, mass)
                length = 1.0
                residuals.append(residual)
                while count >= FULL and length > 1e-3:
                    trial = impulse + length * change, motion + length * turn
                    after = self._size(self._line(*trial), self._left(*trial, mass), trial[0])
                    if after <= (1 - 1e-4 * length) * max(residuals[-4:]):
                        break
                    length *= 0.5
                impulse, motion = impulse + length * change, motion + length * turn
        return None

    def _line(self, impulse: FloatArray, motion: FloatArray, *, bonded: bool = False) -> Linearisation:
        velocity = self.scale[:, None] * impulse + self.problem.contact_velocity(motion)
        if bonded:
            return bonded_contacts(velocity, self.rho)
        return linearise(impulse, velocity, self.problem.friction, self.rho)

    def _left(self, impulse: FloatArray, motion: FloatArray, mass: FloatArray) -> FloatArray:
        """What is left of the bodies' balance, (b, m)."""
        balance: FloatArray = self.problem.body_impulse(impulse) + self.problem.rigid_impulse - mass * motion
        return balance

    def _size(self, line: Linearisation, left: FloatArray, impulse: FloatArray) -> float:
        """The larger of both residuals, relative."""
        pressed = float(np.linalg.norm(impulse))
        load = float(np.linalg.norm(self.problem.rigid_impulse))
        missing = float(np.linalg.norm(line.residual))
        balance = float(np.linalg.norm(left)) / (load or 1.0)
        return max(missing / (pressed + load * float(np.sqrt(self.rho.mean())) or 1.0), balance)

    def _step(
        self, line: Linearisation, left: FloatArray, impulse: FloatArray, mass: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Newton's change (dp, dU)."""
        step = np.where(line.open[:, None], -impulse, 0.0)
        own = line.by_impulse / line.rho[:, None, None]
        own = own + self.scale[:, None, None] * line.by_velocity
        factor = self.system.factor(own, line.by_velocity, ~line.open, line.plain, mass)
        force = line.residual / line.rho[:, None]
        change, turn = factor.solve(force, left + self.problem.body_impulse(step))
        return step + change, turn
