"""CentralPath: an interior-point way through the impulses that leave all velocities as they are.

    min ½ u Σ ω_i‖p_i‖²    over    p_i in its face,    Bᵀ p = Bᵀ p̃,    W_el p = W_el p̃

with p̃ one such p. On the way, at a fixed distance τ from the end, p lies as far inside the faces as
the equations let it: what is at an edge there is at the edge in *every* solution. At its end p is the
solution of least norm.

Faces are second-order cones (``Faces.maps``); steps are Nesterov–Todd's, solved by ``NewtonSystem``.
W_el p = W_el p̃ is held by the method of multipliers, one update a step, as W_el is singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.faces import Faces
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied, multiplied
from masonry_fem.nscd.solvers import cones
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]

# Weight of the norm over the elastic compliance: how fast the multipliers' method goes.
SOFT = 1e-7
# It goes there in so many stages of at most so many steps, each to such a stationarity.
HARDER, HARDENING, NEARLY = 9, 6, 1e-2
# Distance x · z at which p is well inside the faces, relative to u ‖p‖² of a mean contact.
INSIDE = 0.1
# Relative to the equations' own, what keeps the bodies' matrix regular.
REGULAR = 1e-14
TO_BOUNDARY = 0.99
SHORTEST = 1e-9
# Stages to the end, and how much lower x · z is in each.
STAGES, LOWER = 7, 0.1
# It is stuck where so many steps left more than this share of what was missing.
PATIENCE, SLOW = 8, 0.5


@dataclass(frozen=True, slots=True)
class Misses:
    """What a point of the path misses: equations [rel.], stationarity [rel.] and x · z [rel.]."""

    equations: float
    stationarity: float
    gap: float


class CentralPath:
    """A point of the path that moves along it.

    Parameters
    ----------
    problem : The contact problem. faces : Where impulses may lie.
    member : p̃ in the faces, shape (c, d). balance : What Bᵀp must be, Bᵀp̃ but for errors, (b, m).
    weight : ω > 0, shape (c,).
    scale : Scale of each contact, shape (c,) [1/kg].
    """

    def __init__(
        self,
        problem: ContactProblem,
        faces: Faces,
        member: FloatArray,
        balance: FloatArray,
        weight: FloatArray,
        scale: FloatArray,
    ) -> None:
        self.problem, self.faces, self.member, self.weight = problem, faces, member, weight
        self.closed = faces.closed
        self.unit = _unit(problem, scale)  # u
        self.system = NewtonSystem(problem, np.full(problem.count, self.unit), "direct")
        self.started = problem.rigid
        self.size = float(np.linalg.norm(member[self.closed], axis=1).mean()) if self.closed.any() else 0.0
        self.size = self.size or 1.0
        self.T, self.inverse = faces.maps()
        self.x, self.z = np.zeros_like(member), np.zeros_like(member)
        self.x[:, 0] = self.z[:, 0] = 1.0  # where there is no face they stay so
        wide = np.where(self.inverse[:, 0, 0] > 0, self.inverse[:, 0, 0], 1.0)[self.closed]
        self.x[self.closed, 0] = self.size * wide
        self.z[self.closed, 0] = self.unit * self.size / wide
        self.motion = np.zeros_like(problem.rigid_mass)  # multipliers of the bodies' balance
        self.pull = np.zeros_like(member)  # W_el times the multipliers of the elastic velocities
        self.given = balance
        self.force = max(
            float(np.abs(problem.side_impulse(member)).max(initial=0.0)),
            float(np.abs(self.given).max(initial=0.0)),
        )
        self.bent = float(np.abs(problem.elastic_velocity(member)).max(initial=0.0))

    @property
    def impulse(self) -> FloatArray:
        """The p of the point, within the faces, shape (c, d)."""
        product: FloatArray = applied(self.T, np.where(self.closed[:, None], self.x, 0.0))
        return product

    @property
    def typical_gap(self) -> float:
        """What x · z is measured by: u ‖p‖² of a mean contact."""
        return self.unit * self.size**2

    def follow(self, gap: float | None, tolerance: float, steps: int) -> Misses:
        """Move to a fixed gap x · z [rel.], or to its end where ``gap`` is None."""
        if not self.started:
            self._start(INSIDE if gap is None else gap)
        misses = self._misses(0.0 if gap is None else gap)
        track: list[float] = []
        for _ in range(steps):
            left = max(misses.equations, 1e-3 * misses.stationarity, misses.gap if gap is None else 0.0)
            track.append(left)
            stuck = len(track) > PATIENCE and left > SLOW * track[-1 - PATIENCE]
            if left <= tolerance or stuck or not np.isfinite(left):
                break
            if not self._moved(gap, pull=misses.stationarity < NEARLY):
                break
            misses = self._misses(0.0 if gap is None else gap)
        return misses

    def _moved(self, gap: float | None, *, pull: bool) -> bool:
        """Make one step; False where its equations have no solution."""
        try:
            with np.errstate(all="ignore"):
                moved = self._step(None if gap is None else gap * self.typical_gap)
                if pull:
                    self._pull_back()
        except np.linalg.LinAlgError:
            return False
        return moved

    def finish(self, tolerance: float, steps: int) -> None:
        """Move to the end, in stages where multipliers of elastic velocities must follow."""
        if not self.problem.rigid:
            for stage in range(1, STAGES):
                self.follow(INSIDE * LOWER**stage, tolerance, steps)
        self.follow(None, tolerance, steps)

    def gradient(self, impulse: FloatArray) -> FloatArray:
        """What is stationary: u ω p + multipliers, in velocities, shape (c, d)."""
        away = self.problem.elastic_velocity(impulse - self.member)
        turned = self.problem.contact_velocity(self.motion)
        return self.unit * self.weight[:, None] * impulse + self.pull + away + turned

    def equations(self, impulse: FloatArray) -> float:
        """Largest miss of Bᵀp and of W_el p, relative to the largest entry of either."""
        balance = np.abs(self.problem.body_impulse(impulse) - self.given).max(initial=0.0)
        bent = np.abs(self.problem.elastic_velocity(impulse - self.member)).max(initial=0.0)
        return float(np.maximum(balance / (self.force or 1.0), bent / (self.bent or 1.0)))  # nan stays

    def _misses(self, gap: float) -> Misses:
        missing = self.z - self._slack(self.gradient(self.impulse))
        products = (self.x * self.z).sum(axis=1)[self.closed] / self.typical_gap
        # z of a contact that is forced to an edge grows beyond all bounds: each by its own
        own = np.abs(missing) / (np.abs(self.z).max(axis=1) + self.unit * self.size)[:, None]
        return Misses(
            self.equations(self.impulse),
            float(own[self.closed].max(initial=0.0)),
            float(products.mean()) if len(products) and gap == 0 else 0.0,
        )

    def _slack(self, gradient: FloatArray) -> FloatArray:
        slack: FloatArray = applied(self.T.transpose(0, 2, 1), gradient)
        return slack

    def _step(self, gap: float | None) -> bool:
        """One step towards a gap (an absolute one), or a predictor-corrector step to the end."""
        x, z = self.x, self.z
        forth, back = cones.scaling(x, z)
        bend = multiplied(back, back)
        missing = z - self._slack(self.gradient(self.impulse))
        own = bend + self.unit * self.weight[:, None, None] * multiplied(self.T.transpose(0, 2, 1), self.T)
        own_inverse = np.linalg.inv(own)
        factor = self._factor(own_inverse)
        solve = (factor, own_inverse, bend, missing)
        if gap is not None:
            chosen = self._direction(*solve, gap * cones.inverse(z) - x)
        else:
            ahead_x, ahead_z, _ = self._direction(*solve, -x)
            length = min(1.0, self._reach(ahead_x, ahead_z))
            now = (x * z).sum(axis=1)[self.closed].mean()
            left = ((x + length * ahead_x) * (z + length * ahead_z)).sum(axis=1)[self.closed].mean()
            second = cones.product(applied(back, ahead_x), applied(forth, ahead_z))
            scaled = applied(forth, z)
            second = applied(forth, cones.quotient(scaled, second))
            aim = min(max(left / now, 0.0) ** 3, 1.0) * now
            chosen = self._direction(*solve, aim * cones.inverse(z) - x - second)
        change_x, change_z, motion = chosen
        length = min(1.0, TO_BOUNDARY * self._reach(change_x, change_z))
        x, z = x + length * change_x, z + length * change_z
        inside = (cones.determinant(x) > 0).all() and (cones.determinant(z) > 0).all()
        if not inside or not np.isfinite(motion).all() or length < SHORTEST:
            return False
        self.x, self.z, self.motion = x, z, self.motion + length * motion
        return True

    def _pull_back(self) -> None:
        """Bring the multipliers of the elastic velocities up to date."""
        self.pull = self.pull + self.problem.elastic_velocity(self.impulse - self.member)

    def _start(self, gap: float) -> None:
        """Let W_el take over from the norm by and by: at once, it would throw p to the edges."""
        self.started = True
        for _ in range(HARDER):
            for _ in range(HARDENING):
                with np.errstate(all="ignore"):
                    moved = self._step(gap * self.typical_gap)
                if not moved or self._misses(gap).stationarity < NEARLY:
                    break
            ratio = SOFT ** (1.0 / HARDER)
            self.unit *= ratio
            self.z[self.closed] *= ratio
            self.motion, self.pull = self.motion * ratio, self.pull * ratio

    def _reach(self, change_x: FloatArray, change_z: FloatArray) -> float:
        reach = min(cones.longest_step(self.x, change_x), cones.longest_step(self.z, change_z))
        return reach if not np.isnan(reach) else 0.0

    def _factor(self, own_inverse: FloatArray) -> NewtonFactor:
        c, d, _ = own_inverse.shape
        inverse = multiplied(multiplied(self.T, own_inverse), self.T.transpose(0, 2, 1))
        own = np.tile(np.eye(d), (c, 1, 1))
        if not self.problem.rigid:
            # across a ray nothing may move
            across = np.eye(d) - self.faces.spans()
            most = np.abs(inverse).max(axis=(1, 2))
            stiff = np.where(most > 0, most, 1.0)[:, None, None]
            own = np.linalg.inv(inverse + 1e-10 * stiff * across)
        identity = np.broadcast_to(np.eye(d), own.shape)
        mass = REGULAR * self.system.column**2 / self.unit
        plain = np.ones(c, dtype=bool)
        return self.system.factor(own, identity, self.closed, plain, mass, own_inverse=inverse)

    def _direction(
        self,
        factor: NewtonFactor,
        own_inverse: FloatArray,
        bend: FloatArray,
        missing: FloatArray,
        target: FloatArray,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Changes of x, z and the bodies' multipliers with dx + H⁻¹ dz = target."""
        problem = self.problem
        wanted = applied(own_inverse, missing + applied(bend, target))
        given = applied(self.T, wanted)
        balance = problem.body_impulse(self.impulse) - self.given
        change, motion = factor.solve(np.zeros_like(given), balance, given)
        change_x = applied(self.inverse, change)
        change = applied(self.T, change_x)
        moved = self.unit * self.weight[:, None] * change + problem.contact_velocity(motion)
        change_z = self._slack(moved + problem.elastic_velocity(change)) - missing
        closed = self.closed[:, None]
        return np.where(closed, change_x, 0.0), np.where(closed, change_z, 0.0), motion


def _unit(problem: ContactProblem, scale: FloatArray) -> float:
    """Mean scale of the contacts that have compliance, if any: rigid ones lie far above."""
    elastic = problem.operator.elastic()
    return float(scale[elastic].mean() if elastic.any() else scale.mean())
