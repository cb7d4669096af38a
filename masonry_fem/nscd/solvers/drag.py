"""Drag: bodies without inertia, held back a little wherever they go.

Static problems may have no solution, which no iteration proves. With a drag δ on the bodies

    v + ε w p ∈ contact laws,    Bᵀ p + f_r − δ M (U − U_0) = 0

there always is one: large drags hold everything nearly where it is, and the state changes little from one
drag to the next. So where Newton's steps do not lead to a drag at once, they go there by way of larger
ones, in strides that are as long as they hold. What the drag bears tells what the limit δ → 0 is like
(``unstressed``).

Where steps cycle all the same, one way must end, in the plane: contacts are driven apart, v + t d, until all
are open, and t falls to zero. That is Lemke's path. As drag and compliance make a positive definite matrix it
cannot lead away. It is followed kink by kink (``kinks``), with new factors underway: rounding does not add
up as it does in a tableau.

    dragged = Drag(problem)
    if dragged.towards(1e-6):
        dragged.impulse, dragged.motion, dragged.lacking()

ε w_i is the compliance of the contacts themselves: all that rigid blocks have, and next to nothing beside
that of elastic ones, where it determines the impulses that a coarse mesh leaves open.
"""

from __future__ import annotations

from dataclasses import replace
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.scaling import contact_scale, newton_scale
from masonry_fem.nscd.solvers.kinks import Walk
from masonry_fem.nscd.solvers.linearisation import Linearisation, bonded_contacts, linearise
from masonry_fem.nscd.solvers.newton_system import NewtonSystem
from masonry_fem.nscd.solvers.normal_map import NormalMap

FloatArray = NDArray[np.float64]
State = tuple[FloatArray, FloatArray]  # impulses and rigid velocities

FIRST = 1.0  # drag over what the contacts resist a body's motion by: all but sticks
OWN = 1e-5  # compliance of elastic blocks' contacts themselves, over that of the blocks
# ρ over 1/w. Of 22 elastic walls that tip and slide 15 are told with 0.5, 18 with 0.1, 20 with this.
RHO = 0.01
STRIDE = 0.1  # from one drag to the next; its root after a stride that does not hold
SHORTEST = 0.95
TOLERANCE = 1e-6
STEPS = 40  # Newton steps to a drag
# Walks of so many kinks each, with a factor; walls of 240 contacts take 800 to 10 000 kinks.
KINKS, WALKS = 30, 400
NARROW = 1e-2  # ρ there over this one: sliding speeds lie by 1/δ above elastic ones
SHAKE, SEED = 0.05, 1  # of the motion that drives contacts apart, that no two change at once
FULL = 6  # steps without line search: the active set settles in few of them


class Drag:
    """A static problem's bodies, held back by less and less.

    Attributes
    ----------
    until : Monotonic clock after which no way is looked for [s]; None: no limit.
    reached : Drag that the state is at; inf before the first.
    impulse, motion : The state there: p (c, d) and U (b, m).
    solves : Linear systems factorised.
    """

    def __init__(self, problem: ContactProblem, until: float | None = None) -> None:
        self.problem, self.until = problem, until
        scale = newton_scale(problem)
        self.own = scale if problem.rigid else OWN * scale
        self.rho = RHO / scale
        self.resistance = _resistance(problem, scale)
        self.system = NewtonSystem(problem, scale)
        self.load = float(np.linalg.norm(problem.rigid_impulse))
        # impulses that count as none: what is pressed by less flies
        rigid = contact_scale(problem.without_compliance())
        self.least = self.load * float(np.sqrt(RHO * (1.0 / rigid).mean())) if len(rigid) else 1.0
        self.reached, self.solves = np.inf, 0
        self.impulse, self.motion = np.zeros_like(problem.free_velocity), problem.rigid_velocity.copy()

    @property
    def late(self) -> bool:
        """Whether there is no time left."""
        return self.until is not None and monotonic() > self.until

    def towards(self, drag: float) -> bool:
        """Go to a drag that is less than any before; False where no way was found."""
        return self.at_once(drag) or self.by_strides(drag)

    def by_strides(self, drag: float) -> bool:
        """Go there by way of larger drags, or kink by kink; False where no way was found."""
        stride = STRIDE if self.reached <= FIRST or self.at_once(FIRST) else 1.0
        while self.reached > drag and stride <= SHORTEST and not self.late:
            went = self.at_once(max(stride * self.reached, drag))
            stride = max(stride**1.5, STRIDE) if went else stride**0.5
        return self.reached <= drag or self.kink_by_kink(drag)

    def at_once(self, drag: float) -> bool:
        """Go there by Newton's steps from where it is; False where they lead nowhere."""
        made = self._solved(drag)
        if made is not None:
            self.reached, (self.impulse, self.motion) = drag, made
        return made is not None

    def kink_by_kink(self, drag: float) -> bool:
        """Go to a drag on Lemke's path; False in space, and where there are too many kinks."""
        if self.problem.dimension != 2:
            return False
        equation = NormalMap(replace(self.problem, rigid_mass=drag * self.resistance))
        equation.rho, equation.pull = NARROW * self.rho, self.own
        open_ = np.zeros_like(self.impulse)
        free = self.problem.velocity(open_, equation.problem.balanced_velocity(open_))
        shake = SHAKE * np.random.default_rng(SEED).standard_normal(open_.shape)
        apart = equation.scale[:, None] * (shake - [1.0, 0.0])
        target = 1.1 * max(float((free[:, 0] / apart[:, 0]).max()), 0.0) * apart
        x, t, sense = equation.rho[:, None] * (target - free), 1.0, 0
        for _ in range(WALKS):
            piece = equation.at(x)
            piece = equation.at(x + piece.change(piece.residual - t * target))
            sense = sense or piece.sign
            walk = Walk(piece, target, t, forwards=piece.sign == sense)
            for _ in range(KINKS):
                walk.cross()
                if walk.endless or walk.unsure or walk.t == 0 or self.late:
                    break
            if walk.endless or walk.t == 0 or self.late:
                break
            walk.step_inside()
            x, t = walk.x, walk.t
        self.solves += equation.factors
        if walk.t > 0:
            return False
        impulse = equation.at(walk.x).impulse
        self.reached, self.impulse, self.motion = drag, impulse, equation.problem.balanced_velocity(impulse)
        return self.at_once(drag)

    def _solved(self, drag: float) -> State | None:
        """Newton's steps from the state there is to that at a drag; None where they lead nowhere."""
        impulse, motion, bonded = self.impulse, self.motion, self.reached > FIRST
        mass = drag * self.resistance
        residuals: list[float] = []
        with np.errstate(all="ignore"):  # a breakdown is seen in the numbers
            for count in range(STEPS):
                line = self._line(impulse, motion, bonded=bonded and count == 0)
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

    def lacking(self) -> float:
        """Largest share of what acts on a body that the drag bears."""
        problem = self.problem
        acting = np.linalg.norm(problem.rigid_impulse, axis=1)
        pressed = np.linalg.norm(problem.side_impulse(self.impulse), axis=2)
        for side in (0, 1):
            own = problem.bodies[:, side] >= 0
            np.maximum.at(acting, problem.bodies[own, side], pressed[own, side])
        held = self.reached * self.resistance * (self.motion - problem.rigid_velocity)
        lack = np.linalg.norm(held, axis=1)
        return float(np.divide(lack, acting, out=np.zeros_like(lack), where=acting > 0).max(initial=0.0))

    def _line(self, impulse: FloatArray, motion: FloatArray, *, bonded: bool = False) -> Linearisation:
        velocity = self.problem.velocity(impulse, motion) + self.own[:, None] * impulse
        if bonded:
            return bonded_contacts(velocity, self.rho)
        return linearise(impulse, velocity, self.problem.friction, self.rho)

    def _left(self, impulse: FloatArray, motion: FloatArray, mass: FloatArray) -> FloatArray:
        """What is left of the bodies' balance, (b, m)."""
        problem = self.problem
        balance: FloatArray = problem.body_impulse(impulse) + problem.rigid_impulse
        return balance - mass * (motion - problem.rigid_velocity)

    def _size(self, line: Linearisation, left: FloatArray, impulse: FloatArray) -> float:
        """The larger of both residuals, relative."""
        missing = float(np.linalg.norm(line.residual))
        balance = float(np.linalg.norm(left)) / (self.load or 1.0)
        return max(missing / (float(np.linalg.norm(impulse)) + self.least or 1.0), balance)

    def _step(
        self, line: Linearisation, left: FloatArray, impulse: FloatArray, mass: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Newton's change (dp, dU)."""
        problem = self.problem
        step = np.where(line.open[:, None], -impulse, 0.0)
        shift = applied(line.by_velocity, problem.elastic_velocity(step))
        own = line.by_impulse / line.rho[:, None, None]
        own = own + self.own[:, None, None] * line.by_velocity
        self.solves += 1
        factor = self.system.factor(own, line.by_velocity, ~line.open, line.plain, mass)
        force = line.residual / line.rho[:, None] + shift
        change, turn = factor.solve(force, left + problem.body_impulse(step))
        return step + change, turn


def _resistance(problem: ContactProblem, scale: FloatArray) -> FloatArray:
    """What contacts resist a body's motion by, Bᵀ w⁻¹ B in the mean, shape (b, m) [kg].

    The same for all: what nothing holds then falls together.
    """
    sides = np.where(problem.bodies >= 0, 1.0, 0.0)[:, :, None, None] * problem.rigid_map**2
    total = float((sides.sum(axis=(1, 2, 3)) / scale).sum())
    mean = total / max(problem.rigid_mass.size, 1)
    return np.full_like(problem.rigid_mass, mean if mean > 0 else 1.0)
