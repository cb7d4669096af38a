"""InteriorPoint: a primal-dual interior-point method on the friction cones, sliding included.

With x = (μ p_N, p_T) and z = (v̂_N/μ, v̂_T) both in the second-order cone, Coulomb's and Signorini's
laws are x ∘ z = 0, and a step goes for x ∘ z = σ τ (1, 0) with the mean τ of x · z falling to 0
(Nesterov–Todd scaling, Mehrotra's predictor and corrector).

The friction term s = ‖v_T‖ in v̂ = v + μ s n makes the problem non-convex. It is neither frozen, whose
outer iteration cycles where joints slide, nor merely updated: each step linearises it, as

    s = √(‖v_T‖² + ε²) − ε,    ε in proportion to τ,    ŝ' = J v',  J = I + μ n ⊗ v_T/√(‖v_T‖² + ε²)

so that sliding contacts converge as fast as sticking ones. The term is left out altogether until
friction works at more than some times τ: a wall that sticks is a convex problem, and ends quadratically.

With H the scaling in impulses, a step is dp = −H (J dv + …), and where blocks are rigid it is solved
in the bodies' velocities, with the matrix M + Bᵀ H J B. H grows as 1/τ, and is never multiplied out
where it meets a velocity: H = R Rᵀ, and R Rᵀ dv keeps the digits that H dv loses.

In 3D the angle between friction and sliding is off by √τ after every such step. If blocks are elastic and no
other method improves the result, every other one of the last steps keeps τ and corrects the angle.

If cohesion has a stiffness S, x is made of p̃ = p + S v. Impulses p then are unknowns of their own, and
p + S v − p̃ a residual that falls with the others.

If contacts touch without force, or stick on the edge of their cone, the error falls only as √τ, and rounding
stops it at some 1e-7: proximal Newton continues from there in a few steps.

    solution = iterate(problem, InteriorPoint(), settings)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import lengths, project_cone, tangential_norm
from masonry_fem.nscd.iterate import Iterate
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied, multiplied
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.scaling import contact_scale, free_speed
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers import cones
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Frictionless contacts get the least μ: their cone would have no inside. It ends the error at 1e-5 to 1e-7
# (docs/solvers.md). The wider a cone, the more digits of the tangential impulses are lost; nothing real needs
# p_T > 1000 p_N.
LEAST_FRICTION = 1e-6
MOST_FRICTION = 1e3
# Share of elastic contacts above which their impulses and speeds are those of the problem.
MOSTLY = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class InteriorPoint:
    """Settings of the interior-point method.

    Attributes
    ----------
    sliding : The friction term is left out until the mean work of friction is so many times τ.
    align : Error below which steps that only align friction with sliding may come between the others,
        among elastic blocks; 0 where Newton will polish, which is quicker.
    to_boundary : Share of the way to the cones' boundary that a step goes where contacts slide.
    iterations : Steps in all.
    library : Linear factor, see ``linear``.
    """

    sliding: float = 2.0
    align: float = 1e-2
    to_boundary: float = 0.99
    iterations: int = 80
    library: Library = "auto"

    @property
    def name(self) -> str:
        """Its name in settings and reports."""
        return "interior_point"

    def init(self, problem: ContactProblem, start: Start | None) -> InteriorPointRun:
        """A run on a problem. A first guess is only looked at: the way starts deep inside the cones."""
        return InteriorPointRun(problem, self, start)


method = InteriorPoint  # of ``[solver]``


@dataclass(frozen=True, slots=True)
class _Residuals:
    """What a state misses: v̂ against v, the bodies' balance, p + S v against p̃; the derivative J of v̂."""

    velocity: FloatArray
    balance: FloatArray
    pressed: FloatArray | None  # None where joints are dry
    augment: FloatArray
    sliding: bool


@dataclass(frozen=True, slots=True)
class _Direction:
    """Changes of x, z, p and U, and how far they may be gone."""

    x: FloatArray
    z: FloatArray
    impulse: FloatArray
    rigid_velocity: FloatArray
    length: float


class InteriorPointRun:
    """Working memory of the method on one problem."""

    def __init__(self, problem: ContactProblem, settings: InteriorPoint, start: Start | None) -> None:
        self.problem, self.settings, self.start = problem, settings, start
        self.scale = scale = contact_scale(problem)
        self.system = NewtonSystem(problem, scale, settings.library)
        self.friction = np.clip(problem.friction, LEAST_FRICTION, MOST_FRICTION)
        self.shape = np.ones_like(problem.free_velocity)  # x = shape · p, z = v̂ / shape
        self.shape[:, 0] = self.friction
        self.unit, speed = _typical(problem, scale)
        self.x, self.z = np.zeros_like(self.shape), np.zeros_like(self.shape)
        # p_N and v̂_N of the problem's size whatever μ; where μ < 1 their sum with the tangential part
        ratio = np.maximum(self.friction, 1.0)
        slow = speed / ratio
        self.rigid_velocity = problem.rigid_velocity.copy()
        # contacts that part by themselves begin at that speed, with less impulse: steps that are to make
        # far larger speeds are cut to nothing
        parting = problem.velocity(np.zeros_like(self.x), self.rigid_velocity)[:, 0]
        self.z[:, 0] = slow + np.maximum(parting, 0.0) / self.friction
        self.x[:, 0] = self.unit * ratio * slow / self.z[:, 0]
        # p, where it is not p̃
        self.impulse = None if problem.cohesion_stiffness is None else self.x / self.shape
        # blocks that springs hold, as joints cohere, move far beyond the first speeds
        self.delay = 1 if problem.cohesion_stiffness is None else 2
        self.factors = 0  # made since the last offer
        self.centred = False  # the last step kept τ
        self.refines = bool(self.system.elastic.any())  # its directions, see ``_left``
        self.track: list[FloatArray] = []  # error, τ and missing velocity of each state

    def guess(self) -> Iterate:
        """The first guess that was given, or where it starts."""
        if self.start is not None and self.start.impulse is not None:
            given = self.start.impulse
            return Iterate(given, self.problem.balanced_velocity(given), iterations=0)
        return Iterate(self.x / self.shape, self.rigid_velocity, iterations=0)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """One predictor-corrector step."""
        tau = float((self.x * self.z).sum(axis=1).mean())
        missing = self._residuals(tau)
        missed = float(np.linalg.norm(missing.velocity))
        self.track.append(np.array([quality.error, tau, missed]))
        if self._stalled():
            return self._offer(Outcome.STALLED)
        try:
            with np.errstate(all="ignore"):  # a breakdown is seen in the numbers below
                moved = self._advance(tau, missing)
        except np.linalg.LinAlgError:
            moved = False
        return self._offer(None if moved else Outcome.STALLED)

    def _stalled(self) -> bool:
        """True where nothing falls any more."""
        # the error alone would not do: τ rises first, to meet the laws of motion; and a gap of 1e-4
        # of the speeds keeps the error where it is until τ is the square of that
        now, patience = self.track[-1], _PATIENCE * self.delay
        hopeless = _HOPELESS * self.delay
        if now[0] > _DIGITS:
            patience *= 3
        errors = [float(state[0]) for state in self.track[1:]]  # its own: the first may be a given state's
        since = len(errors) - 1 - int(np.argmin(errors or [now[0]]))
        if since >= hopeless:
            return True  # as where loads can just be balanced, and nothing lies inside the cones
        least = min(float(state[2]) for state in self.track)
        if since >= _OLD and now[0] < _NEAR and now[2] > _ROUNDED * least:
            return True
        before = self.track[:-1][-patience:]
        if len(before) < patience or not np.isfinite(now).all():
            return False
        return bool((now > _SLOW * before[0]).all())

    def _offer(self, verdict: Outcome | None) -> Iterate:
        impulse = self.x / self.shape
        # inside the cones no impulse is ever zero: those of contacts that part are taken for it
        ahead = impulse - self.z * self.shape / self.scale[:, None]
        impulse[project_cone(ahead, self.friction)[:, 0] == 0] = 0.0
        # what is rounding of others, too: where a bar alone is elastic, errors are relative to its velocity,
        # however little it pulls
        impulse[impulse[:, 0] < np.finfo(float).eps * impulse[:, 0].max()] = 0.0
        if self.impulse is not None:
            impulse = impulse - self._springs(self.problem.velocity(self.impulse, self.rigid_velocity))
        made = Iterate(
            impulse,
            self.rigid_velocity,
            iterations=min(self.factors, 1),
            linear_solves=self.factors,
            verdict=verdict,
        )
        self.factors = 0
        return made

    def _advance(self, tau: float, missing: _Residuals) -> bool:
        """Move to the next state; False where numbers broke down (the state is kept)."""
        self.centred = not self.centred and self._askew(tau, missing)
        chosen = self._direction(tau, missing, 1.0 if self.centred else None)
        if missing.sliding:
            chosen = self._past_obstacle(tau, missing, chosen)
        for share in _SHARES if self.refines else _SHARES[:1]:
            length = share * chosen.length
            x, z = self.x + length * chosen.x, self.z + length * chosen.z
            velocity = self.rigid_velocity + length * chosen.rigid_velocity
            inside = (cones.determinant(x) > 0).all() and (cones.determinant(z) > 0).all()
            if inside and np.isfinite(velocity).all() and length >= _LEAST_STEP:
                break
        else:
            return False
        self.x, self.z, self.rigid_velocity = x, z, velocity
        if self.impulse is not None:
            self.impulse = self.impulse + length * chosen.impulse
        return True

    def _springs(self, velocity: FloatArray) -> FloatArray:
        """S v, (c, d)."""
        return self.problem.contact_part(np.zeros_like(velocity), velocity)

    def _past_obstacle(self, tau: float, missing: _Residuals, full: _Direction) -> _Direction:
        """A direction that can be followed further than one that hits the cones at once.

        The linearised friction term is not monotone. Where its matrix is nearly singular, at a fold of the
        path, a handful of bodies are to move far and hold up all others: with half of the term at their
        contacts, the direction is nearly that of a convex problem there, and exact elsewhere.
        """
        best, softer = full, missing
        for _ in range(_SOFTENINGS):
            if best.length >= _LONG:
                return best
            short = np.minimum(cones.longest_steps(self.x, best.x), cones.longest_steps(self.z, best.z))
            held = self._neighbours(short < min(_HELD, max(3 * best.length, _SHORT)))
            if held.mean() > _FEW:
                break
            augment = softer.augment.copy()
            augment[held] = 0.5 * (self._identity()[held] + augment[held])
            softer = replace(missing, augment=augment)
            tried = self._direction(tau, softer)
            if tried.length < 1.2 * best.length:
                break
            best = tried
        if best.length < _SHORT:
            half = 0.5 * (self._identity() + missing.augment)
            tried = self._direction(tau, replace(missing, augment=half), _CENTRING)
            best = tried if tried.length > best.length else best
        return best

    def _neighbours(self, chosen: Mask) -> Mask:
        """Contacts of the bodies that some contacts touch."""
        touched = np.zeros(self.problem.body_count + 1, dtype=bool)
        touched[self.problem.bodies[chosen]] = True
        touched[-1] = False  # supports are numbered -1
        neighbours: Mask = touched[self.problem.bodies].any(axis=1) | chosen
        return neighbours

    def _askew(self, tau: float, missing: _Residuals) -> bool:
        """True where friction and sliding are not parallel, and nothing else is left to mend.

        The error in their angle falls as √τ while τ falls, and as its own square while τ is kept.
        Among rigid blocks rounding ends it earlier, and more steps would be for nothing.
        """
        if not (missing.sliding and self.system.elastic.any() and self.track[-1][0] < self.settings.align):
            return False
        x, z = self.x, self.z
        across = x[:, :1] * z[:, 1:] + z[:, :1] * x[:, 1:]
        square = lengths(across) ** 2 / (x[:, 0] * z[:, 0] * tau)
        return bool(square.max() > _PARALLEL**2)

    def _direction(self, tau: float, missing: _Residuals, centring: float | None = None) -> _Direction:
        """Mehrotra's direction; with a given ``centring`` without his second-order term."""
        x, z = self.x, self.z
        forth, back = cones.scaling(x, z)
        factor = self._factor(forth, back, missing.augment)
        second, second_z = np.zeros_like(x), np.zeros_like(x)
        if centring is None:
            ahead_x, ahead_z, *_ = self._solve(factor, back, missing, -x, -z)
            length = min(1.0, cones.longest_step(x, ahead_x), cones.longest_step(z, ahead_z))
            left = float(((x + length * ahead_x) * (z + length * ahead_z)).sum(axis=1).mean())
            centring = min(max(left / tau, 0.0) ** 3, 1.0)
            scaled = applied(forth, z)
            second = cones.product(applied(back, ahead_x), applied(forth, ahead_z))
            second = cones.quotient(scaled, second)
            second, second_z = applied(forth, second), applied(back, second)
        rounding = np.finfo(float).eps * float((np.abs(x) * np.abs(z)).sum(axis=1).mean())
        centring = max(centring, _ROUNDINGS * rounding / tau)
        target = centring * tau * cones.inverse(z) - x - second
        target_z = centring * tau * cones.inverse(x) - z - second_z
        change_x, change_z, change, motion = self._solve(factor, back, missing, target, target_z)
        reach = min(cones.longest_step(x, change_x), cones.longest_step(z, change_z))
        # where the problem is convex there is no need to keep off the cones' surface
        share = self.settings.to_boundary if missing.sliding else _CONVEX
        length = min(1.0, share * reach)
        return _Direction(change_x, change_z, change, motion, length if np.isfinite(length) else 0.0)

    def _residuals(self, tau: float) -> _Residuals:
        problem = self.problem
        pressed = self.x / self.shape
        impulse = pressed if self.impulse is None else self.impulse
        velocity = problem.velocity(impulse, self.rigid_velocity)
        apart = None if self.impulse is None else impulse + self._springs(velocity) - pressed
        speed = tangential_norm(velocity)
        missing = self.z * self.shape - velocity
        augment = self._identity()
        sliding = float((self.x[:, 0] * speed).mean()) > self.settings.sliding * tau
        if sliding:
            smallest = _SMOOTHING * tau / self.unit
            rounded = np.hypot(speed, smallest)
            missing[:, 0] -= self.friction * (rounded - smallest)
            augment[:, 0, 1:] = self.friction[:, None] * velocity[:, 1:] / rounded[:, None]
        balance = problem.body_impulse(impulse) + problem.rigid_impulse
        balance -= problem.rigid_mass * (self.rigid_velocity - problem.rigid_velocity)
        return _Residuals(missing, balance, apart, augment, sliding)

    def _identity(self) -> FloatArray:
        c, d = self.shape.shape
        return np.tile(np.eye(d), (c, 1, 1))

    def _factor(self, forth: FloatArray, back: FloatArray, augment: FloatArray) -> NewtonFactor:
        """H⁻¹ (dp + S dv) + J dv = … with dv = W_el dp + B dU, factorised."""
        self.factors += 1
        every = np.ones(self.problem.count, dtype=bool)
        own = np.zeros_like(forth)
        kept = self.system.elastic  # others need R only
        outer = self.shape[kept][:, :, None] * self.shape[kept][:, None, :]
        own[kept] = multiplied(back[kept], back[kept]) * outer
        return self.system.factor(
            own,
            augment,
            every,
            ~every,
            self.problem.rigid_mass,
            root=forth / self.shape[:, :, None],
            stiffness=self.problem.cohesion_stiffness,
        )

    def _solve(
        self,
        factor: NewtonFactor,
        back: FloatArray,
        missing: _Residuals,
        target: FloatArray,
        target_z: FloatArray,
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Changes of x, z, p and U with dx + W² dz = target and all residuals gone.

        ``target_z`` = W⁻² target: its product with W⁻², whose eigenvalues are τ⁻² apart, would be rounding.
        """
        # dv̂ = J dv − missing, and dp̃ = −H dv̂ + target / shape
        elastic = self.system.elastic[:, None]
        force = -missing.velocity - np.where(elastic, self.shape * target_z, 0.0)
        given = np.where(elastic, 0.0, target / self.shape)
        if missing.pressed is not None:
            given = given - missing.pressed
        change, motion = factor.solve(force, missing.balance, given)
        if self.refines:
            left = self._left(back, missing, force, given, change, motion)
            more, further = factor.solve(*left)
            change, motion = change + more, motion + further
        velocity = self.problem.elastic_velocity(change) + self.problem.contact_velocity(motion)
        # not from the scaling: on the cones' edges it would blow up the rounding of dx
        change_z = (applied(missing.augment, velocity) - missing.velocity) / self.shape
        pressed = change
        if missing.pressed is not None:
            pressed = change + self._springs(velocity) + missing.pressed
        return self.shape * pressed, change_z, change, motion

    def _left(
        self,
        back: FloatArray,
        missing: _Residuals,
        force: FloatArray,
        given: FloatArray,
        change: FloatArray,
        motion: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """What a solution leaves of the equations of elastic contacts and of the bodies' balance.

        H⁻¹ = shape · W⁻² · shape has eigenvalues τ⁻² apart, and the rounding of its entries outweighs the
        compliance that the matrix adds to them. Applied as two products to a solution it is exact enough
        for one step of iterative refinement to bring the digits back.
        """
        velocity = self.problem.elastic_velocity(change) + self.problem.contact_velocity(motion)
        scaled = self.shape * (change + self._springs(velocity) - given)
        resisting = self.shape * applied(back, applied(back, scaled))
        left = force + resisting + applied(missing.augment, velocity)
        left[~self.system.elastic] = 0.0
        balance = missing.balance + self.problem.body_impulse(change) - self.problem.rigid_mass * motion
        return left, balance


def _typical(problem: ContactProblem, scale: FloatArray) -> tuple[float, float]:
    """An impulse and a speed of the problem's size, to start from."""
    middle = float(np.median(scale))
    if problem.body_count and problem.operator.elastic().mean() > MOSTLY:
        # elastic speeds lie far below free ones: by the loads; not where a few bars alone give way
        per_load = float(np.abs(problem.rigid_map).max(initial=0.0)) or 1.0
        unit = float(np.abs(problem.rigid_impulse).max()) / per_load
        if unit > 0:
            return unit, unit * middle
    speed = free_speed(problem) or 1.0
    return speed / middle, speed


# ε of the friction term, relative to τ over the first impulse
_SMOOTHING = 3.0
# It is stalled where so many steps left more than this share of the error, of τ and of what v̂ misses; three
# times as many at errors above the third, where the active set is still sought; twice as many where joints
# cohere: with fewer, whether such problems are solved depends on the kernel of BLAS
_PATIENCE, _SLOW, _DIGITS = 5, 0.7, 1e-3
# Steps are rounding, and end, at errors below the first, where the best state is so many steps old and v̂
# misses so many times more than it did: sweeps and the polish do the rest. A wall of 64×64 rigid stones that
# slides ends after 43 steps for 47. If two steps were enough, it would end at an error of 7e-7 for 4e-7 with
# another kernel of BLAS
_NEAR, _OLD, _ROUNDED = 1e-6, 4, 100.0
# Least τ that is aimed at, over the rounding of x · z. Without it the kernel of BLAS decides whether single
# contacts that slide are solved to 1e-12; with any factor from 4 to 256 sixteen of them are
_ROUNDINGS = 16
# Angle between friction and sliding, over √τ, that asks for a step that mends it
_PARALLEL = 0.03
# Share of the way to the boundary while the friction term is left out
_CONVEX = 0.9999
# Steps without a new least error after which it is hopeless: rigid stones with bars take up to 34
_HOPELESS = 45
_LEAST_STEP = 1e-6
# Shares of a step that are tried: refined directions are exact, and only rounding leads out of the cones
_SHARES = (1.0, 0.9)
# Steps shorter than the first ask for a softer direction where they are held up: so many times, at contacts
# that allow less than the second, where these are less than the third of all
_LONG = 0.3
_SOFTENINGS = 2
_HELD = 0.5
_FEW = 0.2
# Steps still shorter than this ask for a direction softer everywhere, which aims at this share of τ
_SHORT = 0.1
_CENTRING = 0.3
