"""Elastic blocks: all blocks of one mesh, material and clamping, stepped together as arrays.

    (bricks,) = elastic_groups(assembly, {block: stone for block in blocks})
    state = bricks.rest()
    free = bricks.free(state, state, bricks.acceleration_force(gravity), Scheme(step=1e-3))
    state = bricks.advance(state, free, free.rigid_velocity + free.rigid_impulse, nodal, scheme)

Kinematics are small: blocks keep their reference rotations. Clamped dofs follow their prescribed
motion u_c, and act on the others through the off-diagonal blocks of M̂ (formulation 3):

    u_el,free = u_el + (M̂⁻¹)_el [h F − h C u − h K q − h²θ K u − M̂_fc (u_c⁺ − u_c)]

In statics (inertia 0) the velocities before the step, M and C are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free, IntArray, Scheme, Sides, StepEnergy, StressField
from masonry_fem.bodies.support import Motion
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.attachment import ElasticAttachment
from masonry_fem.fem.clamp import Holds, holds, moved
from masonry_fem.fem.condense import Compliance, coefficients
from masonry_fem.fem.meshed import ElasticState, Meshed
from masonry_fem.fem.modes import rigid_modes
from masonry_fem.fem.stress import StressRecovery
from masonry_fem.solid.pose import Pose

KEPT_FACTORS = 3  # a march alternates between few schemes
# Time over which a clamp's motion is differentiated where no step is known yet [s].
FIRST_DERIVATIVE_STEP = 1e-6


class ElasticGroup(Meshed):
    """All blocks of one mesh, material and clamping.

    Parameters
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    names : Their names.
    poses : Where the mesh stands for each.
    operators : Mesh, stiffness and mass.
    clamps : Held faces as (face, components in shape axes), alike for all blocks.
    motions : For each block one motion a clamp (None: held); None: all are held.
    faces : Names of the polytope's faces, for reports.

    Notes
    -----
    A motion is followed exactly in displacement for θ > ½; for θ = ½ that would leave an undamped
    zigzag in the velocity after each kink, so there the velocity is the central difference of the
    motion and the displacement follows it to O(h²).
    """

    prescribed = False

    def __init__(
        self,
        blocks: IntArray,
        names: Sequence[str],
        poses: Sequence[Pose],
        operators: ShapeOperators,
        clamps: tuple[tuple[int, tuple[int, ...]], ...] = (),
        motions: Sequence[Sequence[Motion | None]] | None = None,
        faces: Sequence[str] = (),
    ) -> None:
        self.holds: Holds = holds(operators.mesh, clamps, names[0])
        modes = rigid_modes(operators.mesh.points, operators.mass, self.holds.free)
        super().__init__(blocks, names, poses, operators, modes)
        self._clamps = clamps
        self._motions = motions if motions is not None else [[None] * len(clamps)] * len(blocks)
        self._face_names = [
            faces[face] if face < len(faces) and faces[face] else str(face) for face, _ in clamps
        ]
        self._moving = [
            (row, index, motion)
            for row, own in enumerate(self._motions)
            for index, motion in enumerate(own)
            if motion is not None
        ]
        # Φᵀ M at held dofs: how their motion pushes the rigid modes
        self._pull: FloatArray = modes.momentum[self.holds.dofs]
        self._factors: dict[tuple[float, float], Compliance] = {}

    @cached_property
    def _recovery(self) -> StressRecovery:
        own = self.operators
        return StressRecovery.of(own.mesh, own.material, own.plane)

    def attach(self, sides: Sides) -> ElasticAttachment:
        """The blocks seen through contact sides."""
        return ElasticAttachment.of(self, sides)

    def factor(self, scheme: Scheme) -> Compliance:
        """(M̂⁻¹)_el for a scheme; the last few are kept."""
        key = coefficients(self.operators, scheme)
        if key not in self._factors:
            while len(self._factors) >= KEPT_FACTORS:
                del self._factors[next(iter(self._factors))]
            self._factors[key] = Compliance(self.operators, self.modes, self.holds.free, scheme)
        return self._factors[key]

    # --- states -----------------------------------------------------------------------------------

    def rest(self) -> ElasticState:
        """Undeformed, in place, at rest; clamps that move have their first velocity."""
        b, m = self.count, self.modes.modes.shape[1]
        velocity = self.no_force()
        if self._moving:
            near = self._clamp_displacement(FIRST_DERIVATIVE_STEP) - self._clamp_displacement(0.0)
            velocity[:, self.holds.dofs] = near / FIRST_DERIVATIVE_STEP
        return ElasticState(0.0, np.zeros((b, m)), self.no_force(), np.zeros((b, m)), velocity)

    def scale_velocity(self, state: ElasticState, factor: float) -> ElasticState:
        """The state with its velocities multiplied by ``factor``."""
        return replace(state, rigid_velocity=factor * state.rigid_velocity, velocity=factor * state.velocity)

    def velocity_parts(self, state: ElasticState) -> tuple[FloatArray, FloatArray]:
        """The state's velocity as U (b, m) and u_el (b, n)."""
        return state.rigid_velocity, state.velocity

    def with_velocity(
        self, state: ElasticState, body: int, velocity: FloatArray, spin: FloatArray
    ) -> ElasticState:
        """One block's centroid set moving at (d,) [m/s], turning at (1 or 3,) [rad/s], as clamps allow."""
        turn = self.rotation[body].T
        own_spin = np.atleast_1d(np.asarray(spin, dtype=float))
        motion = np.concatenate([turn @ velocity, own_spin if self.dimension == 2 else turn @ own_spin])
        rigid, elastic = state.rigid_velocity.copy(), state.velocity.copy()
        rigid[body] = self.modes.from_motion @ motion
        elastic[body, self.holds.free] = 0.0
        return replace(state, rigid_velocity=rigid, velocity=elastic)

    def _clamp_displacement(self, time: float) -> FloatArray:
        """Prescribed displacement of the held dofs, shape axes, shape (b, c) [m]."""
        d, dofs = self.dimension, self.holds.dofs
        given = np.zeros((self.count, len(dofs)))
        for row, index, motion in self._moving:
            mine = np.flatnonzero(self.holds.owner == index)
            nodes, inverse = np.unique(dofs[mine] // d, return_inverse=True)
            points = self.mesh.points[nodes] @ self.rotation[row].T + self.translation[row]
            local = moved(motion, points, time) @ self.rotation[row]
            given[row, mine] = local[inverse, dofs[mine] % d]
        return given

    def _clamp_velocity(self, state: ElasticState, scheme: Scheme) -> FloatArray:
        """Velocity of the held dofs at the end of the step, shape (b, c) [m/s]."""
        h, theta, held = scheme.step, scheme.theta, self.holds.dofs
        if not self._moving:
            return np.zeros((self.count, len(held)))
        if theta == 0.5:
            ahead = self._clamp_displacement(state.time + 2 * h)
            return (ahead - self._clamp_displacement(state.time)) / (2 * h)
        reached = self._clamp_displacement(state.time + h)
        mean = (reached - state.displacement[:, held]) / h
        return (mean - (1 - theta) * state.velocity[:, held]) / theta

    # --- the step ---------------------------------------------------------------------------------

    def free(self, state: ElasticState, guess: ElasticState, force: FloatArray, scheme: Scheme) -> Free:
        """The step without contact impulses (formulation 3), in rigid and elastic part."""
        h, theta, inertia = scheme.step, scheme.theta, scheme.inertia
        operators, material, held = self.operators, self.operators.material, self.holds.dofs
        alpha, beta = material.mass_damping, material.stiffness_damping
        start = state.velocity if inertia else np.zeros_like(state.velocity)
        c_m, c_k = coefficients(operators, scheme)
        change = self._clamp_velocity(state, scheme) - start[:, held]
        right = h * force - h * (
            (state.displacement + (h * theta + inertia * beta) * start) @ operators.stiffness
        )
        if inertia and alpha:
            right -= inertia * h * alpha * (start @ operators.mass)
        if change.any():
            lifted = np.zeros_like(start)
            lifted[:, held] = change
            right -= c_m * (lifted @ operators.mass) + c_k * (lifted @ operators.stiffness)
        elastic = start + self.factor(scheme).apply(right)
        elastic[:, held] = start[:, held] + change
        momentum = state.rigid_velocity + start[:, held] @ self._pull
        impulse = (
            h * (force @ self.modes.modes) - inertia * h * alpha * momentum - c_m * (change @ self._pull)
        )
        mass = np.full_like(state.rigid_velocity, c_m)
        mass[:, self.modes.count :] = 1.0  # modes that clamps forbid: dummies at rest
        return Free(state.rigid_velocity, impulse, mass, elastic)

    def advance(
        self,
        state: ElasticState,
        free: Free,
        rigid_velocity: FloatArray,
        nodal: FloatArray | None,
        scheme: Scheme,
    ) -> ElasticState:
        """The state at the end of the step: u⁺ = Φ U⁺ + u_el,free + (M̂⁻¹)_el Gᵀ p, q⁺ by the θ rule."""
        assert free.elastic is not None
        h, theta = scheme.step, scheme.theta
        velocity = free.elastic
        if nodal is not None:
            velocity = velocity + self.factor(scheme).apply(nodal)
        return ElasticState(
            state.time + h,
            state.rigid_displacement + h * ((1 - theta) * state.rigid_velocity + theta * rigid_velocity),
            state.displacement + h * ((1 - theta) * state.velocity + theta * velocity),
            rigid_velocity,
            velocity,
        )

    def nodal_residual(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """M (u⁺ − u) + h C u_θ + h K q_θ − h F_θ − Gᵀ p of all nodes, shape (b, n) [N s].

        Zero at free dofs in a sound step; at held ones the impulse that the clamps give.
        """
        h, theta, inertia, own = scheme.step, scheme.theta, scheme.inertia, self.operators
        mean_displacement = (1 - theta) * state.displacement + theta * after.displacement
        total = -h * force if nodal is None else -h * force - nodal
        if inertia:
            alpha, beta = own.material.mass_damping, own.material.stiffness_damping
            mean_displacement = mean_displacement + beta * (
                (1 - theta) * state.velocity + theta * after.velocity
            )
            rigid = after.rigid_velocity - state.rigid_velocity
            elastic = after.velocity - state.velocity
            rigid = rigid + h * alpha * ((1 - theta) * state.rigid_velocity + theta * after.rigid_velocity)
            elastic = elastic + h * alpha * ((1 - theta) * state.velocity + theta * after.velocity)
            total = total + inertia * ((rigid @ self.modes.modes.T + elastic) @ own.mass)
        return total + h * (mean_displacement @ own.stiffness)

    def imbalance(
        self, state: ElasticState, after: ElasticState, force: FloatArray, impulse: FloatArray,
        nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step [N s], shape (b,).

        The rigid part, √m times a residual in U, and the nodal residual that is left, in one norm.
        """
        modes, momentum = self.modes.modes, self.modes.momentum.copy()
        momentum[self.holds.dofs] = 0.0
        unpushed = self.nodal_residual(state, after, force, None, scheme)
        unpushed[:, self.holds.dofs] = 0.0
        rigid = unpushed @ modes - impulse
        elastic = unpushed if nodal is None else unpushed - nodal
        elastic = elastic - (elastic @ modes) @ momentum.T
        elastic[:, self.holds.dofs] = 0.0
        size: FloatArray = np.hypot(
            np.sqrt(self.mass) * np.linalg.norm(rigid, axis=1), np.linalg.norm(elastic, axis=1)
        )
        return size

    def clamp_reactions(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> dict[str, FloatArray]:  # fmt: skip
        """Mean force over the step, and moment about the origin, of each clamped face, ``block/face``."""
        if not self._clamps:
            return {}
        given = self.nodal_residual(state, after, force, nodal, scheme) / scheme.step
        reactions: dict[str, FloatArray] = {}
        for index, face in enumerate(self._face_names):
            own = np.zeros_like(given)
            mine = self.holds.dofs[self.holds.owner == index]
            own[:, mine] = given[:, mine]
            for name, wrench in zip(self.names, self.resultant(own), strict=True):
                reactions[f"{name}/{face}"] = wrench
        return reactions

    # --- energies ---------------------------------------------------------------------------------

    def kinetic_energy(self, state: ElasticState) -> FloatArray:
        """½ uᵀ M u, shape (b,) [J]."""
        return 0.5 * self._mass_square(state.rigid_velocity, state.velocity)

    def strain_energy(self, state: ElasticState) -> FloatArray:
        """½ qᵀ K q, shape (b,) [J]."""
        return 0.5 * _dot(state.displacement @ self.operators.stiffness, state.displacement)

    def _mass_square(self, rigid: FloatArray, elastic: FloatArray) -> FloatArray:
        """uᵀ M u of u = Φ U + u_el, shape (b,)."""
        crossed = _dot(rigid, elastic[:, self.holds.dofs] @ self._pull)
        return _dot(rigid, rigid) + 2 * crossed + _dot(elastic @ self.operators.mass, elastic)

    def step_energy(
        self, state: ElasticState, after: ElasticState, force: FloatArray, scheme: Scheme
    ) -> StepEnergy:
        """Work of F_θ and of moving clamps, and what damping and the θ-scheme took, exactly.

        A contact on a node of a moving clamp would count twice: its impulse is not known here.
        """
        h, theta, inertia, own = scheme.step, scheme.theta, scheme.inertia, self.operators
        rigid = (1 - theta) * state.rigid_velocity + theta * after.rigid_velocity
        elastic = (1 - theta) * state.velocity + theta * after.velocity
        external = h * (_dot(force @ self.modes.modes, rigid) + _dot(force, elastic))
        if self._moving:
            held = self.holds.dofs
            push = self.nodal_residual(state, after, force, None, scheme)[:, held]
            external = external + _dot(push, elastic[:, held])
        stretch = after.displacement - state.displacement
        numerical = _dot(stretch @ own.stiffness, stretch)
        damping = np.zeros(self.count)
        if inertia:
            change = after.rigid_velocity - state.rigid_velocity
            numerical = numerical + inertia * self._mass_square(change, after.velocity - state.velocity)
            damping = own.material.mass_damping * self._mass_square(rigid, elastic)
            damping += own.material.stiffness_damping * _dot(elastic @ own.stiffness, elastic)
        return StepEnergy(external, inertia * h * damping, (theta - 0.5) * numerical)

    def stress(self, state: ElasticState) -> StressField:
        """Stresses of all blocks at Gauss points and nodes, world axes."""
        return self._recovery.field(state.displacement, self.rotation)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products block by block, shape (b,)."""
    product: FloatArray = np.einsum("bn,bn->b", a, b)
    return product
