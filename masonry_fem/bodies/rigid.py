"""Rigid blocks: centre of mass, rotation and 3 (2D) or 6 (3D) mass-orthonormal velocities each.

    stones = RigidGroup(assembly, blocks=[1, 2, 3], density=2400.0)
    state = stones.rest()
    free = stones.free(state, state, stones.acceleration_force(gravity), Scheme(step=1e-3))
    state = stones.advance(state, free, free.rigid_velocity + free.rigid_impulse, None, scheme)

The velocities of a block are U = (√m v, √J₁ ω₁, √J₂ ω₂, √J₃ ω₃), v the velocity of the centroid
and ωᵢ the spin about its i-th principal axis, which turns with the block: Φᵀ M Φ = I whatever the
rotation. The kinetic energy is ½ U·U.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free, IntArray, Scheme, StepEnergy
from masonry_fem.bodies.inertia import inertia_of
from masonry_fem.bodies.rotation import (
    IDENTITY,
    SPIN_ITERATIONS,
    SPIN_TOLERANCE,
    between,
    chained,
    change,
    turned_by,
)
from masonry_fem.bodies.undeformed import Placed, Undeformed
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.submerged import Submerged, below


@dataclass(frozen=True, slots=True)
class RigidState:
    """Where b rigid blocks are and how they move.

    Attributes
    ----------
    shift : How far the centroids have gone, shape (b, d) [m].
    turned : R − 1 of the rotations since the reference configuration, shape (b, d, d).
    velocity : Mass-orthonormal velocities U, shape (b, m) [kg^½ m/s].
    """

    shift: FloatArray
    turned: FloatArray
    velocity: FloatArray

    @property
    def rotation(self) -> FloatArray:
        """R, shape (b, d, d)."""
        rotation: FloatArray = IDENTITY[self.turned.shape[1]] + self.turned
        return rotation


class RigidGroup(Undeformed):
    """All rigid blocks of a model.

    Parameters
    ----------
    assembly : Where the blocks come from.
    blocks : Their numbers in it, shape (b,).
    density : One for all, or one a block, shape (b,) [kg/m³].
    damping : Mass-proportional damping α, one for all, one a block, shape (b,), or one for each velocity of a
        block, translations before spins, shape (b, m); all spins of a block have the same [1/s].
    turns : False keeps axes and lever arms those of the reference, as small kinematics has it.

    Attributes
    ----------
    mass : Masses, shape (b,) [kg; kg per metre of depth in 2D].
    inertia : Principal moments of inertia about the centroid, shape (b, 1 or 3) [kg m²].
    axes : Principal axes in the reference configuration, as columns, shape (b, 3, 3); in 2D the
        one axis is normal to the plane, shape (b, 1, 1).

    Notes
    -----
    Loads are dead: a force keeps its direction and its material point, so that its lever arm turns
    with the block; a step with inertia takes the arm that it starts with. Impulses too act along the
    principal axes at its start, whereas U⁺ lies along those at its end: of a block that turns by φ in a
    step the direction of an angular impulse is known to φ. Nothing is lost where nothing acts. Statics
    takes arms and axes of the state that it is linearised at, and goes on until that is the end.

    Raises
    ------
    GeometryError
        If a shape has no volume (its faces are turned inside out), or a density is not positive.
    """

    kind = "rigid"
    prescribed = False

    def __init__(
        self,
        assembly: Assembly,
        blocks: Sequence[int] | IntArray,
        density: float | FloatArray,
        damping: float | FloatArray = 0.0,
        *,
        turns: bool = True,
    ) -> None:
        numbers = np.asarray(blocks, dtype=np.int64)
        inertia = inertia_of(assembly, numbers, density)
        super().__init__(assembly, numbers, inertia.centroid)
        self.mass: FloatArray = inertia.mass
        self.inertia: FloatArray = inertia.moments
        self.axes: FloatArray = inertia.axes
        each = np.asarray(damping, dtype=float)
        by_block = each[:, None] if each.ndim == 1 else each
        self.damping: FloatArray = np.broadcast_to(by_block, (len(numbers), self.freedoms))
        # √ of the diagonal of the mass matrix in (v, ω about principal axes), shape (b, m)
        mass_columns = np.repeat(self.mass[:, None], self.dimension, axis=1)
        self._scale: FloatArray = np.sqrt(np.concatenate([mass_columns, self.inertia], axis=1))
        self._radii: FloatArray = np.sqrt(self.inertia)
        self.turns = turns
        # the last answer of _coasting_velocity with what it is for: a step and its measures ask five times
        self._coasted: tuple[RigidState, Scheme, FloatArray] | None = None
        # and that of generalised
        self._pushed: tuple[RigidState, FloatArray, FloatArray] | None = None

    def rest(self) -> RigidState:
        """The state of reference: in place, at rest."""
        turned = np.zeros((self.count, self.dimension, self.dimension))
        return RigidState(np.zeros_like(self.centres), turned, np.zeros((self.count, self.freedoms)))

    def set_down(
        self, state: RigidState, rows: IntArray, rotation: FloatArray, shift: FloatArray
    ) -> RigidState:
        """Blocks ``rows`` (k,) at rest at x = R X + t: R (k, d, d), t (k, d) [m]."""
        gone, turned, velocity = state.shift.copy(), state.turned.copy(), state.velocity.copy()
        turned[rows] = rotation - np.eye(self.dimension)
        gone[rows] = shift + np.einsum("kij,kj->ki", turned[rows], self.centres[rows])
        velocity[rows] = 0.0
        return RigidState(gone, turned, velocity)

    def with_velocity(
        self, state: RigidState, body: int, velocity: FloatArray, spin: FloatArray
    ) -> RigidState:
        """The state with one block's centroid moving at (d,) [m/s], turning at (1 or 3,) [rad/s]."""
        principal = self._current_axes(state.rotation)[body].T @ np.atleast_1d(np.asarray(spin, dtype=float))
        changed = state.velocity.copy()
        changed[body] = self._scale[body] * np.concatenate([velocity, principal])
        return replace(state, velocity=changed)

    def _current_axes(self, rotation: FloatArray) -> FloatArray:
        """Principal axes now, as columns of world components, shape (b, 1 or 3, 1 or 3)."""
        return rotation @ self.axes if self.turns and self.dimension == 3 else self.axes

    def spin_axes(self, state: Placed) -> tuple[FloatArray, FloatArray]:
        """Principal axes now, and √ of the mass matrix in velocities and spins about them."""
        return self._current_axes(state.rotation), self._scale

    # --- loads ------------------------------------------------------------------------------------

    def following(self, force: FloatArray, state: RigidState) -> FloatArray:
        """A force array of the reference with its directions turned with the blocks."""
        if not self.turns:
            return force
        d = self.dimension
        rows = force.reshape(self.count, d + 1, d)  # the force, and by coordinate of the arm
        turned: FloatArray = np.einsum("bij,bkj->bki", state.rotation, rows).reshape(force.shape)
        return turned

    def acceleration_force(self, acceleration: FloatArray) -> FloatArray:
        """Body force of a uniform acceleration (d,) [m/s²], a force array."""
        force = self.no_force()
        force[:, : self.dimension] = self.mass[:, None] * np.asarray(acceleration, dtype=float)
        return force

    def traction_force(
        self, body: int, face: int, traction: FloatArray, factor: Submerged | None = None
    ) -> FloatArray:
        """Traction on a polytope face of one block, a force array.

        Parameters
        ----------
        body, face : The block and its face. traction : World axes, shape (d,) [Pa].
        factor : What it is multiplied by at each point; None: it is uniform.
        """
        corners = self.assembly.solid(int(self.blocks[body])).face_points(face)
        value = np.asarray(traction, dtype=float)
        if factor is None:
            area, centre = _area_and_centre(corners)
            return self.point_force(body, centre, area * value)
        points, weights = _submerged(corners, factor)
        total, d = self.no_force(), self.dimension
        total[body, :d] = weights.sum() * value
        total[body, d:] = np.outer(weights @ (points - self.centres[body]), value).ravel()
        return total

    def point_force(self, body: int, point: FloatArray | None, force: FloatArray) -> FloatArray:
        """Force (d,) [N] at a world point of the reference (None: centroid), a force array."""
        total, d = self.no_force(), self.dimension
        value = np.asarray(force, dtype=float)
        total[body, :d] = value
        if point is not None:
            arm = np.asarray(point, dtype=float) - self.centres[body]
            total[body, d:] = np.outer(arm, value).ravel()
        return total

    def generalised(self, state: RigidState, force: FloatArray) -> FloatArray:
        """Φᵀ F of a force array, shape (b, m)."""
        if self._pushed is not None and self._pushed[0] is state and self._pushed[1] is force:
            return self._pushed[2]
        d = self.dimension
        moments = self.moments(force, self.arms(state)[0])
        principal = np.einsum("bri,br->bi", self._current_axes(state.rotation), moments)
        pushed = np.concatenate([force[:, :d], principal], axis=1) / self._scale
        self._pushed = state, force, pushed
        return pushed

    # --- the step ---------------------------------------------------------------------------------

    def free(
        self, state: RigidState, at: RigidState, force: FloatArray, scheme: Scheme,
        guess: RigidState | None = None,
    ) -> Free:  # fmt: skip
        """The step without contact impulses; the gyroscopic term stands in U_0, the arms are of ``at``.

        ``rigid_velocity`` is the velocity with which the block would end the step if nothing acted
        on it: spatial angular momentum conserved, components along the axes that have turned.
        """
        velocity, h = self._coasting_velocity(state, scheme), scheme.step
        at = state if scheme.inertia else at
        damping = scheme.inertia * h * self.damping
        return Free(
            rigid_velocity=velocity,
            rigid_impulse=h * self.generalised(at, force) - damping * velocity,
            rigid_mass=scheme.inertia + scheme.theta * damping,
            elastic=None,
            origin=None if at is state else at,
        )

    def _coasting_velocity(self, state: RigidState, scheme: Scheme) -> FloatArray:
        """U at the end of a step in which nothing acts on the blocks, shape (b, m).

        L = E √J U_r is constant while the axes E turn with the θ-mean of the spin: an implicit
        equation, solved by fixed point. For θ = ½ the scheme is time-reversible, so that the
        energy of a tumbling block oscillates but does not drift.
        """
        d = self.dimension
        if d == 2 or scheme.inertia == 0:
            return state.velocity
        if self._coasted is not None and self._coasted[0] is state and self._coasted[1] == scheme:
            return self._coasted[2]
        from masonry_fem.bodies.motions import spun  # noqa: PLC0415 - Numba is slow to import

        axes = self._current_axes(state.rotation)
        start = np.ascontiguousarray(state.velocity[:, d:])
        h, theta = float(scheme.step), float(scheme.theta)
        spin = spun(axes, self._radii, start, h, theta, SPIN_ITERATIONS, SPIN_TOLERANCE)
        velocity = np.concatenate([state.velocity[:, :d], spin], axis=1)
        self._coasted = state, scheme, velocity
        return velocity

    def _turn(self, state: RigidState, axes: FloatArray, spin: FloatArray, scheme: Scheme) -> FloatArray:
        """Rotation vector of a step that ends with scaled spins U_r, world axes, (b, 1 or 3) [rad]."""
        d, h, theta = self.dimension, scheme.step, scheme.theta
        mean = (1 - theta) * state.velocity[:, d:] + theta * spin
        turned: FloatArray = h * np.einsum("bri,bi->br", axes, mean / self._scale[:, d:])
        return turned

    def advance(
        self,
        state: RigidState,
        free: Free,
        rigid_velocity: FloatArray,
        nodal: FloatArray | None,
        scheme: Scheme,
    ) -> RigidState:
        """The state at the end of the step: q⁺ = q + h[(1−θ) u + θ u⁺], rotations by exponential."""
        if free.origin is not None:
            return self._led_on(state, free.origin, rigid_velocity, scheme.step)
        d, h, theta = self.dimension, scheme.step, scheme.theta
        mean = (1 - theta) * state.velocity[:, :d] + theta * rigid_velocity[:, :d]
        axes = self._current_axes(state.rotation)
        turn = change(self._turn(state, axes, rigid_velocity[:, d:], scheme))
        return RigidState(
            shift=state.shift + h * mean / self._scale[:, :d],
            turned=chained(state.turned, turn),
            velocity=rigid_velocity,
        )

    def _led_on(self, state: RigidState, origin: RigidState, end: FloatArray, h: float) -> RigidState:
        """Where U − (the velocity of ``origin``) leads from there, with the U that leads there at once."""
        d, scale = self.dimension, self._scale
        move = h * (end - origin.velocity) / scale
        turn = change(np.einsum("bri,bi->br", self._current_axes(origin.rotation), move[:, d:]))
        shift, turned = origin.shift + move[:, :d], chained(origin.turned, turn)
        whole = turned_by(between(state.turned, turned))
        # the axis of a turn has the same components along the axes before and after it
        principal = np.einsum("bri,br->bi", self._current_axes(state.rotation), whole)
        mean = np.concatenate([shift - state.shift, principal], axis=1) / h
        return RigidState(shift, turned, scale * mean)

    def imbalance(
        self, state: RigidState, at: RigidState, after: RigidState, force: FloatArray, impulse: FloatArray,
        nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step [N s], shape (b,).

        The part about the principal axes counts by the momentum that it has at the radius of
        gyration, √(J/m): both parts are then √m times a residual in U.
        """
        free = self.free(state, at, force, scheme)
        residual = free.rigid_mass * (after.velocity - free.rigid_velocity) - impulse - free.rigid_impulse
        size: FloatArray = np.sqrt(self.mass) * np.linalg.norm(residual, axis=1)
        return size

    def momentum_change(self, state: Placed, after: Placed, scheme: Scheme) -> FloatArray:
        """Mean M (Δu/h + α u_θ) of the centroids and the same of spins about them, shape (b, m) [N, N m]."""
        d, theta = self.dimension, scheme.theta
        before, now = (
            np.concatenate([self._scale[:, :d] * own.velocity[:, :d], self.angular_momentum(own)], axis=1)
            for own in (state, after)
        )
        mean = (1 - theta) * before + theta * now
        change: FloatArray = scheme.inertia * ((now - before) / scheme.step + self.damping * mean)
        return change

    # --- energies and changes of state ------------------------------------------------------------

    def scale_velocity(self, state: RigidState, factor: float) -> RigidState:
        """The state with its velocities multiplied by ``factor``."""
        return replace(state, velocity=factor * state.velocity)

    def going_on(self, state: RigidState, end: RigidState) -> RigidState:
        """The state with the velocities of the end."""
        return replace(state, velocity=end.velocity)

    def step_energy(
        self, state: RigidState, after: RigidState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Work of F_θ on the way of its material points; what damping and finite steps took, exactly.

        The gyroscopic term does no work in nature, and the points of a block that turns go on arcs, whereas
        the step's impulses work along velocities: what the discretisation gives or takes there is numerical.
        """
        h, theta, inertia, d = scheme.step, scheme.theta, scheme.inertia, self.dimension
        coasting = self._coasting_velocity(state, scheme)
        mean = (1 - theta) * state.velocity + theta * after.velocity
        damped = (1 - theta) * coasting + theta * after.velocity
        change = after.velocity - state.velocity
        gyroscopic = _dot(mean, coasting - state.velocity)
        straight = h * _dot(self.generalised(state if inertia else after, force), mean)
        turned = np.einsum("bki,bik->b", after.turned - state.turned, force[:, d:].reshape(-1, d, d))
        external = _dot(force[:, :d], after.shift - state.shift) + turned
        moved, changed = abs(after.shift) + abs(state.shift), abs(after.turned) + abs(state.turned)
        summed = _dot(abs(force[:, :d]), moved)
        summed += np.einsum("bki,bik->b", changed, abs(force[:, d:]).reshape(-1, d, d))
        summed += h * _dot(abs(self.generalised(state if inertia else after, force)), abs(mean))
        summed += inertia * (_dot(after.velocity, after.velocity) + _dot(state.velocity, state.velocity))
        return StepEnergy(
            external=external,
            support=np.zeros(self.count),
            damping=inertia * h * _dot(self.damping * mean, damped),
            numerical=inertia * ((theta - 0.5) * _dot(change, change) - gyroscopic) + external - straight,
            summed=summed,
        )

    def kinetic_energy(self, state: RigidState) -> FloatArray:
        """½ uᵀ M u = ½ U·U, shape (b,) [J]."""
        return 0.5 * _dot(state.velocity, state.velocity)

    def angular_momentum(self, state: Placed) -> FloatArray:
        """Angular momentum about the centroid, world axes, shape (b, 1 or 3) [kg m²/s]."""
        principal = self._scale[:, self.dimension :] * state.velocity[:, self.dimension :]
        world: FloatArray = np.einsum("bri,bi->br", self._current_axes(state.rotation), principal)
        return world


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products block by block, shape (b,)."""
    product: FloatArray = np.einsum("bm,bm->b", a, b)
    return product


def _area_and_centre(points: FloatArray) -> tuple[float, FloatArray]:
    """Area [m²; length in 2D] and centroid (d,) [m] of a flat face with corners (k, d)."""
    if points.shape[1] == 2:
        return float(np.linalg.norm(points[1] - points[0])), points.mean(axis=0)
    spokes = points - points[0]
    vectors = 0.5 * np.cross(spokes[1:-1], spokes[2:])
    total = vectors.sum(axis=0)
    area = float(np.linalg.norm(total))
    signed = vectors @ (total / area)  # a fan of a non-convex face has negative triangles
    centres = points[0] + (spokes[1:-1] + spokes[2:]) / 3
    return area, (signed @ centres) / area


def _submerged(points: FloatArray, factor: Submerged) -> tuple[FloatArray, FloatArray]:
    """Points (p, d) [m] and weights (p,) [m²; m in 2D] of a flat face, exact for the factor times places.

    Parameters
    ----------
    points : Corners, shape (k, d) [m]. factor : By depth.
    """
    if points.shape[1] == 2:
        parts, extent = points[None], np.array([np.linalg.norm(points[1] - points[0])])
        rule = 0.5 + np.array([[1.0, -1.0], [-1.0, 1.0]]) / np.sqrt(12)  # of Gauss
    else:
        spokes = points - points[0]
        vectors = 0.5 * np.cross(spokes[1:-1], spokes[2:])
        total = vectors.sum(axis=0)
        extent = vectors @ (total / np.linalg.norm(total))  # of a non-convex face some are negative
        first = np.broadcast_to(points[0], (len(extent), 3))
        parts = np.stack([first, points[1:-1], points[2:]], axis=1)
        rule = 0.5 * (1 - np.eye(3))  # the middles of the edges
    shares = below(factor.depth(parts))
    at = np.einsum("qk,tskc,tcd->tsqd", rule, shares, parts)
    weights = extent[:, None] * np.abs(np.linalg.det(shares)) / len(rule)
    return at.reshape(-1, points.shape[1]), (weights[:, :, None] * factor(at)).ravel()
