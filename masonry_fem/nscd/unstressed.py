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

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.graphs import lengths
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.settings import MethodName, SolverSettings, Start
from masonry_fem.nscd.solvers.linearisation import Linearisation, bonded_contacts, linearise
from masonry_fem.nscd.solvers.newton_system import NewtonSystem
from masonry_fem.nscd.threads import one_thread

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]
State = tuple[FloatArray, FloatArray]  # impulses and rigid velocities
Solve = Callable[[float, State | None], tuple[State, float] | None]  # at a drag: the share that is lacking

# The drag over what the contacts resist a body's motion by. A stack of n blocks lacks some n² times it.
DRAGS = (1e-6, 1e-8, 1e-10)
# Times what the impulses give a contact: what slides farther is held by faces that close in by their rounding
# as coordinates (1e-7 in files of single precision), and by less friction than that not at all.
FAR = 1e6
FIRM = 1e-2  # a drag with which such faces carry nothing
FALLS = 0.2  # from one drag to the next: the share then vanishes with the drag, which falls by 0.01
STAYS = 0.95  # the share does not vanish at all
EASIER = tuple(10.0**power for power in range(6, -1, -1))  # times a drag too small to begin with
TOLERANCE = 1e-6
USABLE = 1e-5  # error of a state that shows the share: a fifth or all of it is left
METHODS: tuple[MethodName, ...] = ("interior_point", "auto")
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
        told = _asked(part, _Soft(part).solve if problem.rigid else _elastic(part))
    impulse = np.zeros_like(problem.free_velocity)
    impulse[mask] = told.impulse
    return replace(told, impulse=impulse)


def _asked(problem: ContactProblem, solve: Solve) -> Unstressed:
    """What states at falling drags tell."""
    state: State | None = None
    shares: list[float] = []
    for drag in DRAGS:
        found = solve(drag, state)
        if found is None:
            break
        state, share = found
        shares.append(share)
        if _vanishes(shares):
            break
    reached: bool | None = None
    if state is not None and _vanishes(shares):
        reached = _slide(problem, *state) <= FAR
        if not reached:  # what the loads press without the faces' rounding
            firm = solve(FIRM, None)
            state = state if firm is None else (firm[0][0], state[1])
    elif len(shares) == len(DRAGS) and shares[-1] > STAYS * shares[-2]:
        reached = False
    if state is None:
        state = np.zeros_like(problem.free_velocity), np.zeros_like(problem.rigid_velocity)
    return Unstressed(reached, *state, tuple(shares))


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


def _usual(problem: ContactProblem, drag: FloatArray, state: State | None) -> State | None:
    """The state with a drag (b, m) by the usual methods; None where none of them finds one."""
    from masonry_fem.nscd.solve import solve  # noqa: PLC0415 - which asks this module for a verdict

    held, start = replace(problem, rigid_mass=drag), None if state is None else Start(*state)
    for method in METHODS:
        made = solve(held, SolverSettings(method=method, tolerance=TOLERANCE), start)
        if made.quality.error <= USABLE:
            return made.impulse, made.rigid_velocity
    return None


def _elastic(problem: ContactProblem) -> Solve:
    """How bodies that are elastic are solved for: these have a compliance of their own."""
    resistance = _resistance(problem, contact_scale(problem))

    def solve(drag: float, state: State | None) -> tuple[State, float] | None:
        found = _usual(problem, drag * resistance, state)
        if found is None:
            return None
        held = drag * resistance * (found[1] - problem.rigid_velocity)
        return found, _lacking(problem, found[0], held)

    return solve


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

    def solve(self, drag: float, state: State | None) -> tuple[State, float] | None:
        """Impulses and motion at a drag, and the largest share of its loads that a body lacks."""
        mass = drag * self.resistance
        found = self._newton(mass, state) or self._stepwise(mass) or self._other(mass)
        if found is None:
            return None
        return found, _lacking(self.problem, found[0], mass * found[1])

    def _stepwise(self, mass: FloatArray) -> State | None:
        """From more drag to less: the first states stick and are near to each other."""
        state: State | None = None
        for factor in EASIER:
            state = self._newton(factor * mass, state)
            if state is None:
                return None
        return state

    def _other(self, mass: FloatArray) -> State | None:
        """By the usual methods, which take the compliance for that of elastic blocks."""
        c, d = self.problem.free_velocity.shape
        blocks = self.scale[:, None, None] * np.eye(d)
        compliance = sparse.bsr_array(
            (blocks, np.arange(c), np.arange(c + 1)), shape=(c * d, c * d), blocksize=(d, d)
        )
        return _usual(replace(self.problem, compliance=compliance), mass, None)

    def _newton(self, mass: FloatArray, state: State | None) -> State | None:
        problem = self.problem
        impulse, motion = np.zeros_like(problem.free_velocity), np.zeros_like(problem.rigid_velocity)
        if state is not None:
            impulse, motion = state
        residuals: list[float] = []
        with np.errstate(all="ignore"):
            for count in range(STEPS):
                line = self._line(impulse, motion, bonded=state is None and count == 0)
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
