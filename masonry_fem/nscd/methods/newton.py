"""ProximalNewton: semismooth Newton on the Alart–Curnier function, with a proximal weight.

The method for statics, large steps and tight tolerances. A *round* solves, by
Newton steps, the problem regularised about a centre (p_k, U_k)

    v + α w (p − p_k) instead of v,        M_r (U − U_0) + ε (U − U_k) instead of M_r (U − U_0)

and moves the centre there, with a smaller α. The second term acts only where M_r = 0. It keeps the
matrix regular whatever the active set, and it shows when no equilibrium exists: then the
unbalanced impulse stays from round to round, whatever ε, and U grows along the mechanism.

If the line search makes a step of many elastic contacts in statics very short, slip is damped, too, by
F_T + κ ρ (v_T − v_T,k) at contacts that slide; κ falls with each round that converges, and rises if one does
not. After each such step the bodies with the largest residuals are solved for separately, as a smaller
contact problem (``part``); in large problems also after each step that goes on from a first guess. A large
part has such parts, too, where its rounds bring it on slowly.

The first step of a cold start is the *bonded* one: all contacts stick, with gaps closed or across them.

    solution = iterate(problem, ProximalNewton(), settings)
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.iterate import Iterate, Run
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.modal import ModalRun, modal_form, modal_start
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import ContactProblem, Products
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.scaling import SLENDER, SLENDER_OF_MANY, method_scales, proximal_scale
from masonry_fem.nscd.settings import TARGET, SolverSettings, Start
from masonry_fem.nscd.solvers.centre import inside
from masonry_fem.nscd.solvers.elastic_krylov import CONTACTS, FACTORED
from masonry_fem.nscd.solvers.elastic_ranks import on_ranks
from masonry_fem.nscd.solvers.escape import Escape
from masonry_fem.nscd.solvers.flips import Flips
from masonry_fem.nscd.solvers.linearisation import (
    Linearisation,
    bonded_contacts,
    held_back,
    linearise,
    parted_contacts,
    slipping,
)
from masonry_fem.nscd.solvers.modal_system import ModalSystem
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem
from masonry_fem.nscd.solvers.resting import Resting
from masonry_fem.nscd.solvers.settling import Settles, Settling

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class ProximalNewton:
    """Settings of the proximal Newton method.

    Attributes
    ----------
    weight : First α, relative to each contact's scale (``proximal_scale``); None: by the kind of problem,
        and the least where many elastic contacts go on from a first guess in statics.
    decrease : Factor on α after each round; None: by the kind of problem.
    adaptive : α follows what rounds cost instead: lower after few steps, higher after many. For states
        near a solution at the limit of friction everywhere, where a fixed path of α cycles.
    accuracy : A round ends at ‖F‖ ≤ accuracy · e ‖p‖, e the natural map at its centre. Loose: where
        joints slide, each new weight changes hundreds of statuses, and exact rounds are wasted.
    full_steps : Newton steps of a round without line search: the active set settles in few full
        steps, through larger residuals. None: 5; 0 for many elastic contacts in statics, which never settle
        so.
    round_steps : Newton steps after which a round is given up.
    patience : Rounds without progress after which it is stalled; sooner where elastic blocks in dynamics are
        near enough to the solution.
    grip : κ of slip that is held from the start, as in a part of a problem; 0: it is held where a step comes
        out too short, and what is far from settled then comes to rest by itself after each step.
    moving : Contacts are scaled by all of W, as befits blocks that fly, fall and hinge: scaled by W_el alone,
        what their masses decide changes from step to step. Where blocks press on each other it takes longer.
    iterations : Newton steps in all.
    systems : Linear systems after which no further step begins, those of parts included.
    library : Linear factor, see ``linear``.
    """

    weight: float | None = None
    decrease: float | None = None
    adaptive: bool = False
    accuracy: float = 0.5
    full_steps: int | None = None
    round_steps: int = 40
    patience: int = 20
    grip: float = 0.0
    moving: bool = False
    iterations: int = 400
    systems: float = np.inf
    library: Library = "auto"

    @property
    def name(self) -> str:
        """Its name in settings and reports."""
        return "newton"

    def init(self, problem: ContactProblem, start: Start | None) -> Run:
        """A run on a problem, from a first guess (bonded where there is none)."""
        form = modal_form(problem)
        if form is None:
            return on_ranks(problem, self, start) or NewtonRun(problem, self, start)
        return ModalRun(NewtonRun(form, self, modal_start(form, start)), problem.rigid_mass.shape[1])


method = ProximalNewton  # of ``[solver]``


@dataclass(slots=True)
class _Round:
    """One proximal problem: where it began, its centre, its weights, and how it went so far."""

    impulse: FloatArray
    centre: FloatArray  # of impulses, inside the cones where contacts stick
    rigid_velocity: FloatArray
    mass: FloatArray  # ε, zero where M_r > 0, shape (b, m)
    alpha: float
    slip: FloatArray | None = None  # v at the centre where slip is held, shape (c, d)
    came: tuple[FloatArray, FloatArray, FloatArray] | None = None  # how far p, U, v came in the round before
    steps: int = 0
    residuals: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Point:
    """A state seen by the round's problem."""

    impulse: FloatArray
    rigid_velocity: FloatArray
    moved: FloatArray  # v
    velocity: FloatArray  # with the proximal term
    pressed: FloatArray  # the contact part of the impulse, at this velocity
    line: Linearisation
    balance: FloatArray
    residual: float  # ‖F‖ / ‖p‖


@dataclass(frozen=True, slots=True)
class Means:
    """What the method works with on one problem.

    Attributes
    ----------
    scale : w of each contact. proximal : What α is relative to, both of shape (c,).
    system : Of its Newton steps. settling : Makes what brings parts of it to rest by another method.
    """

    scale: FloatArray
    proximal: FloatArray
    system: NewtonSystem
    settling: Callable[[ProximalNewton], Settles]

    @classmethod
    def of(cls, problem: ContactProblem, settings: ProximalNewton) -> Means:
        """Those of a problem all of whose contacts are here."""
        scale, unfolded = method_scales(problem, moving=settings.moving)
        modes = problem.rigid_mass.shape[1] > (3 if problem.dimension == 2 else 6)
        kind = ModalSystem if modes else NewtonSystem
        system: NewtonSystem = kind(problem, unfolded, settings.library)
        proximal = proximal_scale(problem, scale, SLENDER_OF_MANY if system.many else SLENDER)
        return cls(scale, proximal, system, partial(Settling, problem))


class NewtonRun:
    """Working memory of the method on one problem.

    Parameters
    ----------
    problem : The contact problem. settings : Of the method. start : First guess; None: there is none.
    means : What it works with; None: as befits a problem all of whose contacts are here.
    """

    def __init__(
        self,
        problem: ContactProblem,
        settings: ProximalNewton,
        start: Start | None,
        means: Means | None = None,
    ) -> None:
        self.problem, self.settings = problem, settings
        means = Means.of(problem, settings) if means is None else means
        self.scale, self.proximal, self.system = means.scale, means.proximal, means.system
        self.static = problem.rigid_mass <= 0
        weight, decrease, self.least_weight = _usual_weights(problem, self.system.many)
        self.decrease = decrease if settings.decrease is None else settings.decrease
        self.bonded_size = np.inf  # of U after the bonded step
        self.factors = 0
        self.flips = Flips(problem.friction, problem.any)
        self.weight = weight if settings.weight is None else settings.weight
        self.least_weight = min(self.least_weight, self.weight)  # a given one may be below the usual floor
        self.static_mass = _SOFT
        self.bonded = True
        self.impulse = np.zeros_like(problem.free_velocity)
        self.rigid_velocity = problem.rigid_velocity.copy()
        self.solved_before: FloatArray | None = None  # v that the first impulses belong to
        self.error = 1.0  # natural map at the last centre
        self.softens = True  # ε may fall again after it had to rise
        self.escape = Escape()
        self.slight = False  # whether some gaps are small beside what blocks give way by
        self.grip = settings.grip  # κ, which holds slip
        self.jammed = False  # this step was
        self.settles = False  # what is far from settled comes to rest by itself after each step
        held = ProximalNewton(
            weight=self.least_weight,
            grip=_GRIP,
            iterations=_PART_STEPS,
            patience=_PART_STEPS,
            library=settings.library,
        )
        self.settling = means.settling(held)
        self.large_part = bool(settings.grip) and self.system.many and problem.whole_count > FACTORED
        self.seen: tuple[_Round, _Point] | None = None  # the last point, and the round it was looked at in
        self.made: Products | None = None  # of the last p and U
        self.begun = time.monotonic()
        self.wanted = TARGET  # error at which it ends
        self.enough = TARGET  # error of the impulses at which it does
        self.until: float | None = None  # when it has to end
        moving = not self.static.any() and problem.whole_count >= CONTACTS and self._deformable()
        self.moves = moving and problem.any(problem.rigid_map)  # elastic blocks, not all of them clamped
        self.near = False  # they are as near to the solution as is asked for
        self.best, self.idle, self.crawling = np.inf, 0, 0
        self.rests = Resting(problem) if problem.peers is None else None  # else the leader sees to it
        if start is not None and start.impulse is not None:
            self._go_on(start.impulse, start)
        self.round = self._new_round()

    def _go_on(self, impulse: FloatArray, start: Start) -> None:
        """Begin at a first guess with these impulses."""
        self.bonded = False
        if self.system.many and self.settings.weight is None:  # what sticks is nearly known
            self.weight = self.least_weight
            # a step of fewer contacts costs less than what parts of it take
            self.settles = not self.settings.grip and self.problem.whole_count > FACTORED
        self.impulse = impulse.copy()
        self.rigid_velocity = self.problem.balanced_velocity(impulse)
        if start.rigid_velocity is not None:
            self.rigid_velocity = np.where(self.static, start.rigid_velocity, self.rigid_velocity)
        self.solved_before, self.made = start.velocity, start.products

    def guess(self) -> Iterate:
        """Where it starts."""
        return Iterate(self.impulse, self.rigid_velocity, iterations=0, products=self.made)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """One Newton step; a round that is solved moves the centre."""
        state = self.impulse, self.rigid_velocity
        if self.rests is not None and self.rests.at(quality, settings.tolerance, *state):
            return self._offer(Outcome.STALLED, solves=0)
        if self._solves() >= self.settings.systems:
            return self._offer(Outcome.MAX_ITERATIONS, solves=0)
        self.wanted, self.enough = settings.tolerance, 0.5 * _share(quality) * settings.tolerance
        if quality.error <= settings.acceptable:
            self.near = self.moves
        if settings.time_limit is not None:
            self.until = self.begun + settings.time_limit
        before = self._solves()
        try:
            with np.errstate(all="ignore"):  # a breakdown is seen in the numbers below
                point = self._advance()
        except np.linalg.LinAlgError:  # a contact's own block is exactly singular
            point = None
        if point is None or not np.isfinite(point.residual):
            return self._offer(None if self._restart() else Outcome.FAILED, self._solves() - before)
        self.impulse, self.rigid_velocity = point.impulse, point.rigid_velocity
        self.round.steps += 1
        verdict = self._next(point.residual)
        return self._offer(verdict, self._solves() - before)

    def _next(self, residual: float) -> Outcome | None:
        """What follows a step: the round goes on, or is closed, given up or begun again; why none can."""
        if self.jammed:
            self.jammed, self.settles, self.grip = False, True, _GRIP
            return self._watch_settling() if self._settle() else self._close_round()
        rebounds = self._rebounds(residual)
        if self.settles and self._settle(self.enough):
            self.grip = min(self.grip * _LOOSER, _GRIP)
            return self._watch_settling()
        if residual <= max(self.settings.accuracy * self.error, self.enough):
            self.grip *= _LOOSER
            slow = self.large_part and self._relative(self._natural_residual()) > _SLOW * self.error
            return self._watch_settling() if slow and self._settle() else self._close_round()
        if rebounds:
            return self._grip_harder()
        runs_off = np.linalg.norm(self.rigid_velocity) > 1e3 * self.bonded_size
        if runs_off and self._firmer():
            return None
        return self._give_up_round() if self.round.steps >= self.settings.round_steps else None

    def _solves(self) -> int:
        """Linear systems so far, those of parts included."""
        return self.factors + self.settling.linear_solves

    def _offer(self, verdict: Outcome | None, solves: int) -> Iterate:
        velocity = self.rigid_velocity
        if verdict is Outcome.NO_EQUILIBRIUM:
            velocity = self.escape.mechanism
        steps = min(solves, 1)  # partings come within one
        return Iterate(self.impulse, velocity, steps, solves, verdict, self.made)

    # one Newton step

    def _advance(self) -> _Point:
        here = self._look(*self._set_off(), bonded=self.bonded)
        if self.solved_before is not None:
            here, self.solved_before = self._led_on(here, self.solved_before), None
        here = self._unswung(here)
        factor = self._factor(here.line)
        change, motion = self._solve(factor, here, here.line.residual)
        full = self._look(here.impulse + change, here.rigid_velocity + motion)
        if self.bonded:
            return self._bond(factor, here, full)
        self.round.residuals.append(here.residual)
        if self.round.slip is not None:
            return full
        usual = 0 if self.system.many else _FULL
        if self.round.steps < (usual if self.settings.full_steps is None else self.settings.full_steps):
            return full
        return self._search(here, change, motion, full)

    def _set_off(self) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        """P, U and, if known, v to step from: of a round that holds slip ahead of its centre, as it goes."""
        now = self.round
        if now.came is None or now.slip is None or now.steps:
            return self.impulse, self.rigid_velocity, None
        impulse, rigid_velocity, velocity = (_AHEAD * way for way in now.came)
        return self.impulse + impulse, self.rigid_velocity + rigid_velocity, now.slip + velocity

    def _led_on(self, here: _Point, velocity: FloatArray) -> _Point:
        """The point linearised where the problem before was solved: its statuses, and what has changed."""
        problem = self.problem
        pressed = problem.contact_part(here.impulse, velocity)
        line = linearise(pressed, velocity, problem.friction, here.line.rho, problem.cohesion_stiffness)
        change = applied(line.by_velocity, here.velocity - velocity)
        line = replace(line, residual=line.residual + line.rho[:, None] * change)
        return replace(here, line=line, pressed=pressed)

    def _bond(self, factor: NewtonFactor, here: _Point, closed: _Point) -> _Point:
        """The bonded state with gaps closed; with a bond across them or open ones, if that is nearer."""
        gap, chosen = np.maximum(self.problem.free_velocity[:, 0], 0.0), closed
        if self.problem.any(gap > _NONE * self._reach(closed)):
            residual = here.line.residual.copy()
            residual[:, 0] -= here.line.rho * gap
            across = self._moved(factor, here, residual)
            if across.residual < _NEARER * closed.residual:
                chosen = across
            if (chosen is closed or self._closable(gap, across)) and self._felt(gap, across, closed):
                apart = self._parted(here, across, gap)
                chosen = apart if apart.residual < chosen.residual else chosen
            chosen = self._unclosed(here, chosen, gap)
        self.bonded = False
        if self.problem.cohesion_stiffness is None:  # which may give way farther than blocks do
            self.bonded_size = min(self.bonded_size, float(np.linalg.norm(chosen.rigid_velocity)))
        return chosen

    def _reach(self, point: _Point) -> FloatArray:
        """How far the greatest normal impulse brings blocks together at each contact, shape (c,)."""
        reach: FloatArray = self.scale * self.problem.largest(np.abs(point.impulse[:, 0]))
        return reach

    def _closable(self, gap: FloatArray, across: _Point) -> bool:
        """Whether blocks that deform may close some gaps: what all of them are too wide for is soon told."""
        reach = self._reach(across)
        return self.problem.any((gap > _ROUNDING * reach) & (gap < _WIDE * reach))

    def _felt(self, gap: FloatArray, across: _Point, closed: _Point) -> bool:
        """Whether gaps of blocks at rest make the closed state far worse than it would be without gaps."""
        problem = self.problem
        if not self.static.any() or problem.cohesion_stiffness is not None:
            return False
        touching = across.velocity.copy()
        touching[:, 0] -= gap
        line = linearise(across.pressed, touching, problem.friction, across.line.rho)
        without = problem.norm(line.residual)
        return closed.residual * problem.norm(across.impulse) > _FELT * without

    def _parted(self, here: _Point, across: _Point, gap: FloatArray) -> _Point:
        """The state with gaps open where closing them would pull, and all else bonded: an active set."""
        found, apart = across, np.zeros(len(gap), dtype=bool)
        for _ in range(_PARTINGS):
            before = apart
            apart = np.where(before, found.velocity[:, 0] > 0, (gap > 0) & (found.impulse[:, 0] < 0))
            if not self.problem.any(apart != before):
                break
            line = parted_contacts(here.line, here.impulse, apart)
            factor = self._factor(line)
            found = self._moved(factor, replace(here, line=line), line.residual)
        return found

    def _unclosed(self, here: _Point, chosen: _Point, gap: FloatArray) -> _Point:
        """The state with all gaps open, if some are small beside what blocks give way by, and no block falls.

        Impulses round a loop of joints, such as a head joint and the beds below it, move nothing but their
        proximal springs. In these a gap is closed that is smaller than they are compressed, and each round
        lets go of no more of such impulses than moves the springs by a gap. In the end springs are softened
        as the error falls.

        References
        ----------
        Regularised by as much as the error is, Newton's steps stay quadratic where solutions are not unique:
        J.-Y. Fan and Y.-X. Yuan, "On the quadratic convergence of the Levenberg-Marquardt method without
        nonsingularity assumption", Computing 74 (2005).
        """
        problem = self.problem
        if not self.static.any() or problem.cohesion_stiffness is not None or not self._deformable():
            return chosen
        reach = self._reach(chosen)
        apart = gap > _NONE * reach
        self.slight = problem.any(apart & (gap < _SLIGHT * reach))
        if not self.slight or self._lets_go(apart):
            return chosen
        line = parted_contacts(here.line, here.impulse, apart)
        found = self._moved(self._factor(line), replace(here, line=line), line.residual)
        falls = np.linalg.norm(found.rigid_velocity) > _FALLS * np.linalg.norm(chosen.rigid_velocity)
        return chosen if falls else found

    def _lets_go(self, apart: Mask) -> bool:
        """Whether all contacts of some body are apart."""
        problem = self.problem
        counts = [
            np.bincount(sides.ravel() + 1, minlength=problem.body_count + 1).astype(float)
            for sides in (problem.bodies, problem.bodies[~apart])
        ]
        touching, held = problem.summed(np.array(counts))[:, 1:]  # supports are numbered -1
        return bool(((touching > 0) & (held == 0)).any())

    def _deformable(self) -> bool:
        """Whether all contacts are those of blocks that deform."""
        return bool(self.problem.body_count) and not self.problem.any(~self.system.elastic)

    def _moved(self, factor: NewtonFactor, here: _Point, residual: FloatArray) -> _Point:
        """The point where a residual of the linearised problem is gone."""
        change, motion = self._solve(factor, here, residual)
        return self._look(here.impulse + change, here.rigid_velocity + motion)

    def _unswung(self, here: _Point) -> _Point:
        """The point with the contacts that swing between open and sticking taken for slipping."""
        problem = self.problem
        if self.round.slip is not None:
            return here
        swinging = self.flips.swinging(here.line, settled=self.round.steps >= _SETTLED)
        if not swinging.any():
            return here
        line = slipping(
            here.line, swinging, here.pressed, here.velocity, problem.friction, problem.cohesion_stiffness
        )
        return replace(here, line=line)

    def _factor(self, line: Linearisation) -> NewtonFactor:
        """The factor of a step."""
        self.factors += 1
        from masonry_fem.nscd.contact_measures import own_derivatives  # noqa: PLC0415 - Numba is slow to import

        weight = self.round.alpha * self.proximal
        own = own_derivatives(line.by_impulse, line.rho, weight, line.by_velocity)
        mass = self.problem.rigid_mass + self.round.mass
        return self.system.factor(own, line.by_velocity, ~line.open, line.plain, mass)

    def _solve(
        self, factor: NewtonFactor, here: _Point, residual: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Newton's change (dp, dU) that takes a residual away; open contacts lose their impulses exactly."""
        line, problem = here.line, self.problem
        force, balance = residual / line.rho[:, None], here.balance
        step = np.where(line.open[:, None], -here.impulse, 0.0)
        if problem.any(step):
            force += applied(line.by_velocity, problem.elastic_velocity(step))
            balance = balance + problem.body_impulse(step)
        change, motion = factor.solve(force, balance)
        return step + change, motion

    def _search(self, here: _Point, change: FloatArray, motion: FloatArray, full: _Point) -> _Point:
        """Backtrack until the residual is below the worst of the last four: it may rise, not cycle."""
        bound, length, point = max(self.round.residuals[-4:]), 1.0, full
        for _ in range(12):
            if point.residual <= (1 - 1e-4 * length) * bound:
                break
            length *= 0.5
            moved = here.moved + length * (full.moved - here.moved)  # which spares a product with W_el
            point = self._look(here.impulse + length * change, here.rigid_velocity + length * motion, moved)
        holds = self.error > min(_SLIPS, self.enough) and self.problem.cohesion_stiffness is None
        self.jammed = length < _JAMMED and self.system.many and holds
        return point

    def _look(
        self,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        moved: FloatArray | None = None,
        *,
        bonded: bool = False,
    ) -> _Point:
        """A state as the round sees it; ``moved`` is its v, where that is known."""
        from masonry_fem.nscd.contact_measures import held  # noqa: PLC0415 - Numba is slow to import

        problem, now = self.problem, self.round
        moved = self._velocity(impulse, rigid_velocity) if moved is None else moved
        if self.seen is not None and not bonded:
            where, point = self.seen
            if where is now and point.moved is moved:
                return point
        weight = now.alpha * self.proximal
        velocity, rho = held(moved, weight, impulse, now.centre), 1.0 / (self.scale + weight)
        pressed = problem.contact_part(impulse, velocity)
        line = (
            bonded_contacts(velocity, rho)
            if bonded
            else linearise(pressed, velocity, problem.friction, rho, problem.cohesion_stiffness)
        )
        if now.slip is not None:
            line = held_back(line, velocity - now.slip, self.grip)
        known = self._known(impulse, rigid_velocity)
        given = problem.body_impulse(impulse) if known is None else known.given
        balance = given + problem.rigid_impulse
        balance -= problem.rigid_mass * (rigid_velocity - problem.rigid_velocity)
        balance -= now.mass * (rigid_velocity - now.rigid_velocity)
        size, residual = problem.norm(impulse), problem.norm(line.residual)
        relative = residual / size if size > 0 else residual
        point = _Point(impulse, rigid_velocity, moved, velocity, pressed, line, balance, relative)
        self.seen = None if bonded else (now, point)
        return point

    def _velocity(self, impulse: FloatArray, rigid_velocity: FloatArray) -> FloatArray:
        """V of a state, shape (c, d); those of the last point and of the last state are known."""
        if self.seen is not None:
            point = self.seen[1]
            if point.impulse is impulse and point.rigid_velocity is rigid_velocity:
                return point.moved
        known = self._known(impulse, rigid_velocity)
        if known is None:
            known = self.made = self.problem.products(impulse, rigid_velocity)
        return known.velocity

    def _known(self, impulse: FloatArray, rigid_velocity: FloatArray) -> Products | None:
        """Products of a state, if they were the last that were made."""
        made = self.made
        if made is None or self.problem.any(np.array([not made.are_of(impulse, rigid_velocity)])):
            return None
        return made

    # parts

    def _settle(self, enough: float = 0.0) -> bool:
        """Bring what is far from settled to rest by itself; False where it cannot be done, or need not be."""
        residual = self._natural_residual()
        error = min(self._relative(residual), _REBOUND * self.best)
        if error <= enough:
            return False
        settled = self.settling.settle(
            residual,
            self.impulse,
            self.rigid_velocity,
            error,
            self.wanted,
            self.until,
            self.best,
            self._known(self.impulse, self.rigid_velocity),
        )
        if settled is None:
            return False
        self.impulse, self.rigid_velocity = settled
        self.error = self._relative(self._natural_residual())
        self.weight = max(_UNSETTLED * self.error, self.least_weight)
        self.round = self._new_round()
        return True

    def _watch_settling(self) -> Outcome | None:
        """Whether parts bring the whole on."""
        self._watch_returns()
        self.idle = 0 if self.error < 0.8 * self.best else self.idle + 1
        self.best = min(self.best, self.error)
        return Outcome.STALLED if self.idle >= self.settings.patience else None

    @property
    def _patience(self) -> int:
        """Rounds without progress after which it is stalled."""
        return _NEAR_ROUNDS if self.near else self.settings.patience

    def _watch_returns(self) -> None:
        """Let α fall where the error of the whole comes back to the best one again and again.

        An impulse that moves next to nothing is on its way then, as far in each round as α lets it.
        """
        if self.settings.grip or self.error >= (1 + _SAME) * self.best:
            return
        self.crawling = 0 if self.error < (1 - _SAME) * self.best else self.crawling + 1
        if self.crawling >= _CRAWL:
            self.least_weight, self.crawling = max(0.1 * self.least_weight, _LEAST), 0

    def _natural_residual(self) -> FloatArray:
        """P − P_K(p − v̂/w), shape (c, d)."""
        velocity = self._velocity(self.impulse, self.rigid_velocity)
        pressed = self.problem.contact_part(self.impulse, velocity)
        residual: FloatArray = graphs.natural_map(pressed, velocity, self.problem.friction, self.scale)
        return residual

    def _relative(self, residual: FloatArray) -> float:
        """Norm of a residual over that of the impulses."""
        size = self.problem.norm(self.impulse)
        return self.problem.norm(residual) / size if size > 0 else 1.0

    # rounds

    def _new_round(self) -> _Round:
        mass = np.where(self.static, self.static_mass * self.system.column**2 / self.system.unit, 0.0)
        slip = self._velocity(self.impulse, self.rigid_velocity) if self.grip else None
        centre = self.impulse
        if slip is not None and not self.settings.grip:
            # the margin falls with κ, too: in proportion to the error alone, it would keep the error alive
            error = self.error * self.grip / _GRIP
            centre = inside(self.problem, centre, slip, self.scale, error, self.weight)
        return _Round(self.impulse, centre, self.rigid_velocity, mass, self.weight, slip)

    def _close_round(self) -> Outcome | None:
        """Move the centre to a solved round's solution; tell whether that can go on."""
        before, last = self.round, self.error
        self.error = self._relative(self._natural_residual())
        self._watch_crawl(before, last)
        self.weight = self._next_weight(before.steps)
        progress = self.error
        if self.static.any():
            progress = max(progress, self._watch_equilibrium(before))
            if self.escape.sure:
                return Outcome.NO_EQUILIBRIUM
        self.round = self._new_round()
        if before.slip is not None:
            here = self._velocity(self.impulse, self.rigid_velocity)
            rigid = self.rigid_velocity - before.rigid_velocity
            self.round.came = self.impulse - before.impulse, rigid, here - before.slip
        self.idle = 0 if progress < 0.8 * self.best else self.idle + 1
        self.best = min(self.best, progress)
        stuck = self.idle >= self._patience and not self.escape.rounds
        return Outcome.STALLED if stuck else None

    def _watch_crawl(self, before: _Round, last: float) -> None:
        """Let α fall further where statuses are settled and what is left falls only as fast as α lets it.

        Where slip is held, it is κ that keeps rounds from coming far. ``last`` is the error a round earlier.
        """
        settled = before.slip is None and before.steps <= _CHEAP
        crawls = settled and self.weight <= self.least_weight
        self.crawling = self.crawling + 1 if crawls and self.error > _SLOW * last else 0
        if self.crawling >= _CRAWL:
            self.least_weight, self.crawling = max(0.1 * self.least_weight, _LEAST), 0

    def _next_weight(self, steps: int) -> float:
        """α of the round after one that took so many steps."""
        if not self.settings.adaptive:
            floor = self.least_weight
            if self.slight and self.error < _DECIDED:
                floor = min(floor, max(_SOFTER * self.error, _LEAST))
            return max(self.weight * self.decrease, floor)
        factor = 0.5 if steps <= _CHEAP else 1.0 if steps <= _DEAR else 2.0
        return min(max(factor * self.weight, _LEAST), 1.0)

    def _watch_equilibrium(self, before: _Round) -> float:
        """The unbalanced impulse ε (U − U_k) relative to the loads; counts the rounds it did not fall in."""
        from masonry_fem.nscd.transfer import side_size  # noqa: PLC0415 - Numba is slow to import

        travelled = self.rigid_velocity - before.rigid_velocity
        left = before.mass * travelled
        loads = max(
            float(np.linalg.norm(self.problem.rigid_impulse)),
            self.problem.norm_of(
                float(side_size(self.problem.rigid_map, np.ascontiguousarray(self.impulse)))
            ),
        )
        relative = float(np.linalg.norm(left)) / loads if loads > 0 else 0.0
        slow = relative > 0.1 * self.escape.last
        easy = before.steps <= _EASY and self.error < _CLOSE
        if self.escape.watch(relative, travelled):
            # firm rounds show a mechanism in few steps, weak ones tell it from slow progress
            self.static_mass *= 0.1
        # ε U is all that is left of balance; a long chain has modes far softer than the first ε
        elif slow and easy and self.softens:
            self.static_mass *= 0.1
        return relative

    def _give_up_round(self) -> Outcome | None:
        """A round that does not end: regularise more, and begin it again."""
        if self._firmer():
            return None
        self.weight = min(10.0 * self.weight, 1.0)
        self.impulse, self.rigid_velocity = self.round.impulse, self.round.rigid_velocity
        self.round = self._new_round()
        self.idle += 1
        return Outcome.STALLED if self.idle >= self._patience else None

    def _rebounds(self, residual: float) -> bool:
        """True where slip goes too far: its first step may raise the residual, the next ones lower it."""
        now = self.round
        if not self.grip:
            return False
        return now.steps >= _GRIPPED or (now.steps >= 2 and residual > now.residuals[-1])

    def _grip_harder(self) -> Outcome | None:
        """A round in which slip went too far: hold it more, and begin again."""
        self.grip *= _TIGHTER
        self.impulse, self.rigid_velocity = self.round.impulse, self.round.rigid_velocity
        self.round = self._new_round()
        return None if self.grip < 1.0 else Outcome.STALLED

    def _firmer(self) -> bool:
        """Start again with more ε where some bodies have no inertia; False where it is firm already."""
        return bool(self.static.any()) and self.static_mass < _FIRM and self._restart()

    def _restart(self) -> bool:
        """Start again from the last centre with more regularisation; False where that was tried."""
        self.softens = self.static_mass <= _SOFT  # once: it led here again
        if self.weight >= 1.0 and self.static_mass >= 1.0:
            return False
        self.weight = min(100.0 * self.weight, 1.0)
        self.static_mass = max(min(100.0 * self.static_mass, 1.0), 1e-2)
        self.impulse, self.rigid_velocity = self.round.impulse, self.round.rigid_velocity
        self.bonded = not self.problem.any(self.impulse)
        self.error = max(self.error, 0.1)
        self.round = self._new_round()
        return True


# Contraction of the error, in so many rounds of few steps, above which the floor of α gives way, and how
# far; in one round of a large part, that above which parts of it come to rest first. A floor that is too low
# lets the impulses wander that nothing determines.
_SLOW = 0.5
_CRAWL = 3
# Rounds without progress after which blocks that move stay where they are, if that is near enough: impulses
# that go round stones, and move next to nothing, change for a hundred steps.
_NEAR_ROUNDS = 3
_SAME = 0.05  # by how much an error may differ from the best one and be the same
_LEAST = 1e-9
# Newton steps, and the error reached, of a round after which a tenth of ε will do
_EASY = 4
_CLOSE = 1e-3
_CHEAP, _DEAR = 2, 4  # steps of a round up to which an adaptive α, or its floor, falls; above which it rises
_PART_STEPS = 80  # Newton steps in a part
_FULL = 5  # Newton steps of a round without line search
_NEARER = 0.5  # share of the residual, so that gaps of rounding decide nothing
_FELT = 10.0  # times the residual without gaps
_ROUNDING, _WIDE = 1e-6, 0.1  # gaps relative to what the greatest impulse closes at a contact
_NONE, _SLIGHT = 1e-9, 1e-3  # the same: gaps that are rounding, and those that proximal springs hide
# Beside slight gaps: error from which statuses are decided, and α over it, which keeps steps quadratic where
# impulses are not unique. From 1e-3 on a dome takes more than 26 steps for 11.
_DECIDED, _SOFTER = 1e-5, 1e-3
_FALLS = 10.0  # times the velocity before, of blocks that open gaps let go
_PARTINGS = 3  # after which Newton's steps settle the rest
_JAMMED = 0.1  # length of a step that is too short
# Error below which slip is not held, unless velocities are still too far off: what changes there bears next
# to nothing, and parts that rest of themselves take more than the whole. From 1e-8 on a tower takes four
# times as long.
_SLIPS = 1e-9
_GRIP = 3e-2  # first κ
_LOOSER, _TIGHTER = 0.5, 4.0  # factors on κ after a round that ends, and one that does not
_AHEAD = 0.5  # share of how far the last round came, at which the next one starts
_GRIPPED = 10  # steps in which it should
# Times the best error so far: a step that leaves more rebounds, and does not tell how exact parts need to be.
_REBOUND = 100.0
# α over the error that parts leave. With the least α at once the next step throws contacts of vaults that
# part and meet far off (errors of 2 for 0.1); with 0.1 pushed walls take a fifth fewer products, but errors
# of a vault of 1500 stones swing between 2e-3 and 0.1 for 24 steps, in place of 9 to 1e-3.
_UNSETTLED = 0.3
_SETTLED = 2  # steps of a round before its contacts' swinging means anything
_SOFT = 1e-6  # first ε, relative to the compliance that B sees
_FIRM = 1e-2  # ε from which a mechanism moves slowly enough to be followed


def _share(quality: Quality) -> float:
    """Natural map over the worse of it and the same in velocities: the tolerance bounds both."""
    worse = max(quality.natural_map, quality.natural_map_velocity)  # may lie a thousand times above
    return quality.natural_map / worse if 0 < worse < np.inf else 1.0


def _usual_weights(problem: ContactProblem, many: bool) -> tuple[float, float, float]:
    """First α, its factor and its floor, as measured on each kind of problem.

    Elastic impulses are nearly unique and bear a small α at once. The impulses of rigid blocks, and of a
    plain W that may be theirs, are not unique: a floor keeps those that no measure determines from wandering.
    They are known to the rounding of W p over α: with a hundredth of the floor that is 1e-11 of them, and
    contacts at the edges of their cones slip in one step and stick in the next.
    """
    if problem.rigid or not problem.body_count:
        return 1e-2, 0.3, 1e-5
    if many:
        return 1e-2, 0.1, 1e-5
    return (1e-4, 0.1, 1e-5) if problem.operator.elastic().all() else (1e-3, 0.3, 1e-5)
