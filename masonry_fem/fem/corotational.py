"""Corotational blocks: blocks that turn without bound and are strained little.

Each block has a frame: its centroid in the reference has gone by ``shift``, its axes have turned by R, and

    x = c + R (X + u),        Φᵀ M u = 0

where u is small and M-orthogonal to the rigid modes of the reference. Internal forces are R K u, or R ∫Bᵀσ(u)
where stones yield: K, M and all elastic factors are constant in the frame, and material laws see strains that
no turn has changed. Nothing else is needed for balance in the deformed place: the frame
is that of least squares with M as weight, whose derivative adds M Φ λ to K u, with λ what makes the forces on
the deformed block balance. That is what ``Compliance`` solves.

U has velocities of the centroid along the axes of the shape, which do not turn, and spins along those of the
frame, mass-orthonormal as in small kinematics.

References
----------
C. A. Felippa, B. Haugen, "A unified formulation of small-strain corotational finite elements", Computer
Methods in Applied Mechanics and Engineering 194 (2005). There each element has a frame; here each block has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_fem.bodies.base import (
    Actions,
    FloatArray,
    Free,
    IntArray,
    Scheme,
    Sides,
    StepEnergy,
    StressField,
)
from masonry_fem.bodies.rotation import (
    between,
    chained,
    change,
    exponential,
    first_order,
    lever,
    moment,
    resultants,
    settled_spin,
    summed,
    turned,
    turned_by,
)
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.attachment import ElasticAttachment
from masonry_fem.fem.balance import products
from masonry_fem.fem.condense import coefficients
from masonry_fem.fem.constitution import Constitution, LinearElasticity, Memory, dot, times
from masonry_fem.fem.deformable import Deformable
from masonry_fem.fem.modes import RigidModes, rigid_modes
from masonry_fem.solid.pose import Poses


@dataclass(frozen=True, slots=True)
class TurningState:
    """Where b blocks are and how they move.

    Attributes
    ----------
    time : Time [s] (load factor in statics).
    shift : How far the centroids' places have gone, shape axes, shape (b, d) [m].
    turned : R − 1, shape axes, shape (b, d, d): small turns keep their digits.
    displacement : u, axes of the frame, shape (b, n) [m].
    rigid_velocity : U, shape (b, m) [kg^½ m/s].
    velocity : u̇, axes of the frame, shape (b, n) [m/s]. After a step of statics U and u̇ are the motion of
        that step over h; no momentum belongs to them.
    memory : Of the material, axes of the frame; None where it has none.
    pushed : Forces of contacts on the nodes in the step that led here, of reduced blocks, shape (b, n) [N].
    """

    time: float
    shift: FloatArray
    turned: FloatArray
    displacement: FloatArray
    rigid_velocity: FloatArray
    velocity: FloatArray
    memory: Memory | None = None
    pushed: FloatArray | None = None

    @property
    def rotation(self) -> FloatArray:
        """R, shape axes, shape (b, d, d)."""
        turned: FloatArray = np.eye(self.turned.shape[1]) + self.turned
        return turned


class CorotationalGroup(Deformable[TurningState]):
    """Blocks of one mesh and material that nothing clamps, each with its frame.

    Parameters
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    names : Their names.
    poses : Where the mesh stands for each.
    operators : Mesh, stiffness and mass.
    constitution : Their stresses; None: linear elasticity.
    kind : Name of their fidelity.

    Notes
    -----
    Loads are dead, and impulses act as on rigid blocks (``RigidGroup``): statics balances where it ends, a
    step with inertia where it begins. Strain does not change the moments of inertia, and spin strains
    nothing: a strain of ρ ω² ℓ²/E is left out.
    """

    turns = True

    def __init__(
        self, blocks: IntArray, names: Sequence[str], poses: Poses, operators: ShapeOperators,
        constitution: Constitution | None = None, kind: str = "elastic",
    ) -> None:  # fmt: skip
        mesh = operators.mesh
        free = np.arange(mesh.points.size)
        modes = rigid_modes(mesh.points, operators.mass, free)
        own = LinearElasticity(operators) if constitution is None else constitution
        super().__init__(blocks, names, poses, operators, modes, free, own, kind)
        self.per_unit = _per_unit(modes)

    def clamp_reactions(
        self, state: TurningState, after: TurningState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> dict[str, FloatArray]:  # fmt: skip
        """None: nothing clamps these blocks."""
        return {}

    def set_down(
        self, state: TurningState, rows: IntArray, rotation: FloatArray, shift: FloatArray
    ) -> TurningState:
        """Blocks ``rows`` (k,) at rest at x = R X + t without strain: R (k, d, d), t (k, d) [m]."""
        poses, rest = self.rotation[rows], self.rest()
        centres = poses @ self.modes.centroid + self.translation[rows]
        turn = rotation - np.eye(self.dimension)
        away = shift + np.einsum("kij,kj->ki", turn, centres)
        gone, turned = state.shift.copy(), state.turned.copy()
        gone[rows] = np.einsum("kji,kj->ki", poses, away)
        turned[rows] = poses.swapaxes(1, 2) @ turn @ poses
        bent, rigid, velocity = (
            own.copy() for own in (state.displacement, state.rigid_velocity, state.velocity)
        )
        bent[rows], rigid[rows], velocity[rows] = (
            own[rows] for own in (rest.displacement, rest.rigid_velocity, rest.velocity)
        )
        return replace(
            state, shift=gone, turned=turned, displacement=bent, rigid_velocity=rigid, velocity=velocity
        )

    def nodal_motion(self, state: TurningState) -> tuple[FloatArray, FloatArray]:
        """Displacements [m] and velocities [m/s] of all nodes, turns to first order, shape axes, (b, n)."""
        rigid = np.concatenate([state.shift, first_order(state.turned)], axis=1) @ self.modes.from_motion.T
        modes = self.modes.modes.T
        return rigid @ modes + state.displacement, state.rigid_velocity @ modes + state.velocity

    def moved_by(
        self, state: TurningState, rows: IntArray, displacement: FloatArray, velocity: FloatArray
    ) -> TurningState:
        """The state with blocks ``rows`` (k,) moved as ``nodal_motion`` tells, displacements (k, n)."""
        d, (amplitudes, bent) = self.dimension, self.modes.split(displacement)
        motion = np.linalg.solve(self.modes.from_motion, amplitudes.T).T
        speed, bending = self.modes.split(velocity)
        changes: dict[str, Any] = {
            "shift": motion[:, :d], "turned": change(motion[:, d:]), "displacement": bent,
            "rigid_velocity": speed, "velocity": bending,
        }  # fmt: skip
        for name, own in changes.items():
            changes[name] = getattr(state, name).copy()
            changes[name][rows] = own
        return replace(state, **changes)

    def following(self, force: FloatArray, state: TurningState) -> FloatArray:
        """Nodal forces (b, n) of the reference with their directions turned with the frames."""
        nodal = force.reshape(self.count, -1, self.dimension)
        return turned(state.rotation, nodal).reshape(force.shape)

    def rest(self) -> TurningState:
        """Undeformed, in place, at rest."""
        b, m, d = self.count, self.modes.modes.shape[1], self.dimension
        nothing, memory = np.zeros((b, m)), self.constitution.fresh(b)
        return TurningState(
            0.0, np.zeros((b, d)), np.zeros((b, d, d)), self.no_force(), nothing, self.no_force(), memory
        )

    def attach(self, sides: Sides) -> TurningAttachment:
        """The blocks seen through contact sides."""
        return TurningAttachment.of(self, sides)

    def _own(self, state: TurningState, world: FloatArray) -> FloatArray:
        """Nodal vectors (b, n) along the shape's axes seen from the frames."""
        nodal = world.reshape(self.count, -1, self.dimension)
        return turned(state.rotation.swapaxes(1, 2), nodal).reshape(world.shape)

    def _arms(self, state: TurningState) -> FloatArray:
        """Nodes from the centre of the frame, its axes, shape (b, nodes, d) [m]."""
        bent = state.displacement.reshape(self.count, -1, self.dimension)
        return self.mesh.points - self.modes.centroid + bent

    def with_velocity(
        self, state: TurningState, body: int, velocity: FloatArray, spin: FloatArray
    ) -> TurningState:
        """One block's centroid set moving at (d,) [m/s], turning at (1 or 3,) [rad/s]."""
        back, d = self.rotation[body].T, self.dimension
        own_spin = np.atleast_1d(np.asarray(spin, dtype=float))
        if d == 3:
            own_spin = state.rotation[body].T @ back @ own_spin
        rigid, elastic = state.rigid_velocity.copy(), state.velocity.copy()
        rigid[body] = self.modes.from_motion @ np.concatenate([back @ velocity, own_spin])
        elastic[body] = 0.0
        return replace(state, rigid_velocity=rigid, velocity=elastic)

    # --- the step ---------------------------------------------------------------------------------

    def free(
        self, state: TurningState, at: TurningState, force: FloatArray, scheme: Scheme,
        guess: TurningState | None = None,
    ) -> Free:  # fmt: skip
        """The step without contact impulses; loads act along the axes and at the arms of ``at``.

        With inertia those of ``state``.
        """
        at = state if scheme.inertia else at
        h, theta, inertia = scheme.step, scheme.theta, scheme.inertia
        alpha, beta = self.operators.material.mass_damping, self.operators.material.stiffness_damping
        if guess is not None:
            left = self._elastic_residual(state, guess, self._own(at, force), scheme)
            # a first guess is as warm as the step begins
            ahead = state.time + h - guess.time
            left -= h * theta * self.constitution.expanding(guess, ahead, tangent=True)
            elastic = guess.velocity - self.compliant(left, guess, scheme)
        else:
            start = state.velocity if inertia else np.zeros_like(state.velocity)
            rate = (h * theta + inertia * beta) * start
            right = h * self._own(at, force)
            right -= h * self.constitution.forces(state, state, theta, rate)
            right += h * theta * self.constitution.expanding(state, h)
            if inertia and alpha:
                right -= inertia * h * alpha * times(start, self.operators.mass)
            elastic = start + self.factor(scheme).apply(right)
        return replace(
            self._rigid(state, at, force, scheme),
            elastic=elastic, origin=None if at is state else at, guess=guess,
        )  # fmt: skip

    def _rigid(self, state: TurningState, at: TurningState, force: FloatArray, scheme: Scheme) -> Free:
        """The rigid part of ``free``."""
        coasting = self._coasting(state, scheme)
        damping = scheme.inertia * scheme.step * self.operators.material.mass_damping
        mass = np.full_like(coasting, coefficients(self.operators, scheme)[0])
        impulse = scheme.step * self.generalised(at, force) - damping * coasting
        return Free(coasting, impulse, mass, None)

    def generalised(self, at: TurningState, force: FloatArray) -> FloatArray:
        """Work of nodal forces (b, n) by unit U, with the blocks as in ``at``, shape (b, m)."""
        shifts, spins = self.per_unit
        nodal = force.reshape(self.count, -1, self.dimension)
        moments = summed(moment(self._arms(at), turned(at.rotation.swapaxes(1, 2), nodal)))
        return np.concatenate([shifts * summed(nodal), moments @ spins], axis=1)

    def _coasting(self, state: TurningState, scheme: Scheme) -> FloatArray:
        """U at the end of a step in which nothing acts: angular momentum stays, the frames turn, (b, m)."""
        d = self.dimension
        if d == 2 or scheme.inertia == 0:
            return state.rigid_velocity
        spins = self.per_unit[1]
        before = state.rigid_velocity[:, d:]
        momentum = np.linalg.solve(spins.T, before.T).T

        def following(after: FloatArray) -> FloatArray:
            mean = (1 - scheme.theta) * before + scheme.theta * after
            turn = exponential(scheme.step * mean @ spins.T)
            updated: FloatArray = np.einsum("bji,bj->bi", turn, momentum) @ spins
            return updated

        return np.concatenate([state.rigid_velocity[:, :d], settled_spin(before, following)], axis=1)

    def _reached(
        self,
        state: TurningState,
        origin: TurningState | None,
        rigid_velocity: FloatArray,
        velocity: FloatArray,
        scheme: Scheme,
    ) -> TurningState:
        # u by the θ rule in the frame, the frame by the exponential
        h, theta, d = scheme.step, scheme.theta, self.dimension
        bent = state.displacement + h * ((1 - theta) * state.velocity + theta * velocity)
        time, (shifts, spins) = state.time + h, self.per_unit
        memory = self.constitution.followed(state, bent, time)
        if origin is None:
            move = h * ((1 - theta) * state.rigid_velocity + theta * rigid_velocity)
            shift = state.shift + shifts * move[:, :d]
            turned = _turned_on(state.turned, move[:, d:] @ spins.T)
            return TurningState(time, shift, turned, bent, rigid_velocity, velocity, memory)
        # on from the state that the step was linearised at, with the U that leads there at once
        move = h * (rigid_velocity - origin.rigid_velocity)
        shift = origin.shift + shifts * move[:, :d]
        turned = _turned_on(origin.turned, move[:, d:] @ spins.T)
        way = turned_by(between(state.turned, turned))
        if d == 3:
            way = np.einsum("bji,bj->bi", state.rotation, way)
        whole = np.concatenate([(shift - state.shift) / shifts, np.linalg.solve(spins, way.T).T], axis=1) / h
        return TurningState(time, shift, turned, bent, whole, velocity, memory)

    # --- measures of the step -----------------------------------------------------------------------

    def resultant(self, force: FloatArray, state: TurningState | None = None) -> FloatArray:
        """Force and moment about the world origin, where blocks are; None: reference, (b, m) [N, N m]."""
        if state is None:
            return super().resultant(force)
        acting = self._turned(force.reshape(self.count, -1, self.dimension))
        return np.concatenate(resultants(self.positions(state).reshape(acting.shape), acting), axis=1)

    def imbalance(
        self, state: TurningState, at: TurningState, after: TurningState, force: FloatArray,
        impulse: FloatArray, nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step, rigid and nodal [N s], shape (b,)."""
        at = state if scheme.inertia else at
        rigid = self._rigid(state, at, force, scheme)
        left = (
            rigid.rigid_mass * (after.rigid_velocity - rigid.rigid_velocity) - impulse - rigid.rigid_impulse
        )
        nodal_left = self._elastic_residual(state, after, self._own(at, force), scheme)
        nodal_left = nodal_left if nodal is None else nodal_left - nodal
        nodal_left = nodal_left - (nodal_left @ self.modes.modes) @ self.modes.momentum.T
        size: FloatArray = np.hypot(
            np.sqrt(self.mass) * np.linalg.norm(left, axis=1), self.unbalanced(nodal_left)
        )
        return size

    def _elastic_residual(
        self, state: TurningState, after: TurningState, force: FloatArray, scheme: Scheme
    ) -> FloatArray:
        """M Δu̇ + h C u̇_θ + h ∫Bᵀσ_θ − h F_θ in the frame, but for rigid modes, shape (b, n) [N s]."""
        h, theta, inertia, own = scheme.step, scheme.theta, scheme.inertia, self.operators
        mean = (1 - theta) * state.velocity + theta * after.velocity
        rate = inertia * own.material.stiffness_damping * mean if inertia else None
        left: FloatArray = h * self.constitution.forces(state, after, theta, rate) - h * force
        if inertia:
            moved = after.velocity - state.velocity + h * own.material.mass_damping * mean
            left += inertia * times(moved, own.mass)
        return left

    def actions(
        self, state: TurningState, after: TurningState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> Actions:  # fmt: skip
        """Loads and inertia, at the end of a step of statics, at the start of one of dynamics."""
        d, there = self.dimension, state if scheme.inertia else after
        load = self.resultant(force, there)
        centre = self._centres(there)
        taken = self._momentum_change(state, after, scheme)
        taken[:, d:] += moment(centre, taken[:, :d])
        return Actions(load, np.zeros_like(load), np.zeros(self.count), taken, centre, load[:, d:])

    def _centres(self, state: TurningState) -> FloatArray:
        """Centres of the frames, world axes, shape (b, d) [m]."""
        own = self.modes.centroid + state.shift
        world: FloatArray = np.einsum("bij,bj->bi", self.rotation, own) + self.translation
        return world

    def _momentum(self, state: TurningState) -> FloatArray:
        """Momentum, and angular momentum about the centroid, world axes, shape (b, m)."""
        d, (shifts, spins) = self.dimension, self.per_unit
        linear = np.einsum("bij,bj->bi", self.rotation, state.rigid_velocity[:, :d] / shifts)
        angular = np.linalg.solve(spins.T, state.rigid_velocity[:, d:].T).T
        if d == 3:
            angular = np.einsum("bij,bjk,bk->bi", self.rotation, state.rotation, angular)
        return np.concatenate([linear, angular], axis=1)

    def _momentum_change(self, state: TurningState, after: TurningState, scheme: Scheme) -> FloatArray:
        before, now = self._momentum(state), self._momentum(after)
        mean = (1 - scheme.theta) * before + scheme.theta * now
        damped = self.operators.material.mass_damping * mean
        taken: FloatArray = scheme.inertia * ((now - before) / scheme.step + damped)
        return taken

    def step_energy(
        self, state: TurningState, after: TurningState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Work of F_θ on the way of its nodes; what damping, yielding, the θ-scheme and finite turns took.

        Impulses and loads of a step work along velocities, nodes that turn go on arcs: as with rigid blocks
        what the discretisation gives or takes there is numerical.
        """
        h, theta, inertia, own = scheme.step, scheme.theta, scheme.inertia, self.operators
        coasting, at = self._coasting(state, scheme), state if inertia else after
        rigid = (1 - theta) * state.rigid_velocity + theta * after.rigid_velocity
        bending = (1 - theta) * state.velocity + theta * after.velocity
        generalised, ends = self.generalised(at, force), (self._moved(state), self._moved(after))
        straight = h * (dot(generalised, rigid) + dot(self._own(at, force), bending))
        external = dot(force, (ends[1] - ends[0]).reshape(force.shape))
        numerical, lost = self.constitution.lost(state, after, theta)
        damping = np.zeros(self.count)
        if inertia:
            turned, bent = after.rigid_velocity - state.rigid_velocity, after.velocity - state.velocity
            numerical += inertia * (theta - 0.5) * (dot(turned, turned) + dot(times(bent, own.mass), bent))
            numerical -= inertia * dot(rigid, coasting - state.rigid_velocity)
            damped = (1 - theta) * coasting + theta * after.rigid_velocity
            alpha, beta = own.material.mass_damping, own.material.stiffness_damping
            if alpha:
                damping += alpha * (dot(rigid, damped) + dot(times(bending, own.mass), bending))
            if beta:
                damping += beta * dot(times(bending, own.stiffness), bending)
        support, heat = np.zeros(self.count), self.constitution.heat(state, after, theta)
        gone = (abs(ends[0]) + abs(ends[1])).reshape(force.shape)
        loaded = dot(abs(force), gone)
        loaded += h * (dot(abs(generalised), abs(rigid)) + dot(abs(force), abs(bending)))
        summed = loaded + products(own, self.constitution, state, after, inertia)
        return StepEnergy(
            external, support, inertia * h * damping, numerical + external - straight, lost, heat, summed
        )

    def kinetic_energy(self, state: TurningState) -> FloatArray:
        """½ U·U + ½ u̇ᵀ M u̇, shape (b,) [J]."""
        rigid = dot(state.rigid_velocity, state.rigid_velocity)
        return 0.5 * (rigid + dot(times(state.velocity, self.operators.mass), state.velocity))

    # --- fields -----------------------------------------------------------------------------------

    def _moved(self, state: TurningState) -> FloatArray:
        """Displacements of the nodes along the shape's axes, shape (b, nodes, d) [m]."""
        arms = self.mesh.points - self.modes.centroid
        gone = turned(state.turned, arms)
        bent = state.displacement.reshape(gone.shape)
        moved: FloatArray = state.shift[:, None] + gone + turned(state.rotation, bent)
        return moved

    def _moving(self, state: TurningState, place: TurningState) -> FloatArray:
        """Velocity of the nodes with the blocks as in ``place``, shape axes, shape (b, nodes, d) [m/s]."""
        d, (shifts, spins) = self.dimension, self.per_unit
        spin = state.rigid_velocity[:, d:] @ spins.T
        rates = np.einsum("bnij,bj->bni", lever(self._arms(place)), spin)
        rates += state.velocity.reshape(rates.shape)
        moving: FloatArray = shifts * state.rigid_velocity[:, None, :d]
        moving = moving + turned(place.rotation, rates)
        return moving

    def motion(self, state: TurningState) -> tuple[FloatArray, FloatArray]:
        """The motions x = R X + t of the frames, (b, d, d) and (b, d) [m]."""
        turn = self.rotation @ state.rotation @ np.swapaxes(self.rotation, 1, 2)
        start = np.einsum("bij,j->bi", self.rotation, self.modes.centroid) + self.translation
        return turn, self._centres(state) - np.einsum("bij,bj->bi", turn, start)

    def stress(self, state: TurningState) -> StressField:
        """Stresses of all blocks at Gauss points and nodes, world axes."""
        return self._field(state, self.rotation @ state.rotation)


class TurningAttachment(ElasticAttachment[TurningState]):
    """Corotational blocks seen through k contact sides."""

    __slots__ = ()

    def displacements(self, state: TurningState) -> FloatArray:
        """How far the material points have gone, shape (k, d) [m]."""
        from masonry_fem.bodies.motions import by_block, carried  # noqa: PLC0415 - Numba is slow to import

        body = self.sides.body
        moved = carried(state.turned, state.shift, self.arms, body)
        moved += by_block(state.rotation, body, self._at_points(state.displacement))
        world: FloatArray = by_block(self.group.rotation, body, moved)
        return world

    def rotations(self, state: TurningState) -> FloatArray:
        """How the frames have turned since the reference configuration, world axes, shape (k, d, d)."""
        turn = self.group.rotation
        turned: FloatArray = turn @ state.rotation @ np.swapaxes(turn, 1, 2)
        return turned[self.sides.body]

    def rigid_map(self, state: TurningState, points: FloatArray, frames: FloatArray) -> FloatArray:
        """Velocity, in the frames, of the frame of the block at ``points`` for unit U, shape (k, d, m)."""
        from masonry_fem.bodies.motions import side_maps  # noqa: PLC0415 - Numba is slow to import

        body, d = self.sides.body, self.group.dimension
        shifts, spins = _per_unit(self.group.modes)
        arms = self.group.to_shape(body, points) - self.group.modes.centroid - state.shift[body]
        if d == 2:
            axes, of_spins = np.zeros((0, 3, 3)), 1.0 / spins[0]
        else:
            axes, of_spins = state.rotation @ spins, np.ones(3)
        scale = np.tile(np.append(np.full(d, 1.0 / shifts), of_spins), (self.group.count, 1))
        seen: FloatArray = side_maps(self._local(frames), arms, axes, scale, body)
        return seen


def _per_unit(modes: RigidModes) -> tuple[float, FloatArray]:
    """Velocities of the centroid by those of U, and spins by those of U, shape (1 or 3, 1 or 3) [kg^−½]."""
    d = len(modes.centroid)
    return 1.0 / float(modes.from_motion[0, 0]), np.linalg.inv(modes.from_motion[d:, d:])


def _turned_on(turned: FloatArray, vectors: FloatArray) -> FloatArray:
    """R − 1 after frames have turned by rotation vectors along their own axes."""
    return chained(change(vectors), turned)
