"""Elastic blocks: all blocks of one mesh, material and clamping, stepped together as arrays.

    (bricks,) = elastic_groups(assembly, {block: stone for block in blocks})
    state = bricks.rest()
    free = bricks.free(state, state, bricks.acceleration_force(gravity), Scheme(step=1e-3))
    state = bricks.advance(state, free, free.rigid_velocity + free.rigid_impulse, nodal, scheme)

Kinematics are small: blocks keep their reference rotations. Clamped dofs follow their prescribed
motion u_c, and act on the others through the off-diagonal blocks of M̂:

    u_el,free = u_el + (M̂⁻¹)_el [h F − h C u − h K q − h²θ K u − M̂_fc (u_c⁺ − u_c)]

In statics (inertia 0) the velocities before the step, M and C are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from masonry_fem.bodies.base import (
    Actions,
    FloatArray,
    Free,
    IntArray,
    Scheme,
    Sides,
    StepEnergy,
    StressError,
    StressField,
)
from masonry_fem.bodies.rotation import moment
from masonry_fem.bodies.support import Motion
from masonry_fem.errors import GeometryError
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.attachment import ElasticAttachment
from masonry_fem.fem.balance import Balance, dot
from masonry_fem.fem.clamp import Clamping, Faces, Holds
from masonry_fem.fem.condense import Compliance, coefficients
from masonry_fem.fem.error_estimate import ErrorEstimate
from masonry_fem.fem.meshed import ElasticState, Meshed
from masonry_fem.fem.modes import rigid_modes
from masonry_fem.fem.stress import StressRecovery
from masonry_fem.solid.pose import Pose

KEPT_FACTORS = 3  # a march alternates between few schemes


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
    """

    kind = "elastic"
    prescribed = False
    turns = False
    deforms = True

    def __init__(
        self,
        blocks: IntArray,
        names: Sequence[str],
        poses: Sequence[Pose],
        operators: ShapeOperators,
        clamps: Faces = (),
        motions: Sequence[Sequence[Motion | None]] | None = None,
        faces: Sequence[str] = (),
    ) -> None:
        rotation = np.array([pose.rotation for pose in poses])
        translation = np.array([pose.translation for pose in poses])
        mesh = operators.mesh
        self.clamping = Clamping(mesh, clamps, motions, rotation, translation, names[0])
        self.holds: Holds = self.clamping.holds
        modes = rigid_modes(mesh.points, operators.mass, self.holds.free)
        super().__init__(blocks, names, poses, operators, modes)
        self.balance = Balance(operators, modes, self.holds)
        self._face_names = [
            faces[face] if face < len(faces) and faces[face] else str(face) for face, _ in clamps
        ]
        # Φᵀ M at held dofs: how their motion pushes the rigid modes
        self._pull: FloatArray = modes.momentum[self.holds.dofs]
        self._factors: dict[tuple[float, float], Compliance] = {}
        self.factorisations = 0

    @cached_property
    def _recovery(self) -> StressRecovery:
        own = self.operators
        return StressRecovery.of(own.mesh, own.material, own.plane)

    @cached_property
    def _estimate(self) -> ErrorEstimate:
        return ErrorEstimate.of(self.operators.mesh, self.operators.material)

    def share(self, other: ElasticGroup) -> None:
        """Take over factors, and what stresses are read by, of a group with the same matrices and clamps."""
        if other.operators is not self.operators or not np.array_equal(other.holds.free, self.holds.free):
            return
        self._factors = other._factors
        for name in ("_recovery", "_estimate"):
            if name in other.__dict__:
                self.__dict__[name] = other.__dict__[name]

    def attach(self, sides: Sides) -> ElasticAttachment:
        """The blocks seen through contact sides."""
        return ElasticAttachment.of(self, sides)

    def factor(self, scheme: Scheme) -> Compliance:
        """(M̂⁻¹)_el for a scheme; the last few are kept."""
        key = coefficients(self.operators, scheme)
        if key not in self._factors:
            while len(self._factors) >= KEPT_FACTORS:
                del self._factors[next(iter(self._factors))]
            self._factors[key] = self._factorised(scheme)
            self.factorisations += 1
        return self._factors[key]

    def _factorised(self, scheme: Scheme) -> Compliance:
        try:
            return Compliance(self.operators, self.modes, self.holds.free, scheme)
        except np.linalg.LinAlgError as error:
            size = np.ptp(self.mesh.points, axis=0)
            raise GeometryError(
                f"block '{self.names[0]}': its stiffness is singular to rounding, with sides of "
                f"{', '.join(f'{side:.2g}' for side in size)} m, ν = {self.operators.material.poisson:.17g}; "
                "expected a block at most some 1e7 times as long as thick, and ν not so near 1/2; change "
                "them, or make the block rigid"
            ) from error

    # --- states -----------------------------------------------------------------------------------

    def rest(self) -> ElasticState:
        """Undeformed, in place, at rest; clamps that move have their first velocity."""
        b, m = self.count, self.modes.modes.shape[1]
        velocity = self.no_force()
        velocity[:, self.holds.dofs] = self.clamping.first_velocity()
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

    # --- the step ---------------------------------------------------------------------------------

    def free(self, state: ElasticState, guess: ElasticState, force: FloatArray, scheme: Scheme) -> Free:
        """The step without contact impulses, in rigid and elastic part."""
        h, theta, inertia = scheme.step, scheme.theta, scheme.inertia
        operators, material, held = self.operators, self.operators.material, self.holds.dofs
        alpha, beta = material.mass_damping, material.stiffness_damping
        start = state.velocity if inertia else np.zeros_like(state.velocity)
        c_m, c_k = coefficients(operators, scheme)
        before = state.displacement[:, held], start[:, held]
        change = self.clamping.velocity(state.time, *before, scheme) - start[:, held]
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
        mass[:, self.modes.count :] = 1.0  # modes that clamps forbid are placeholders that stay at rest
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

    # --- measures of the step -----------------------------------------------------------------------

    def nodal_residual(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """M (u⁺ − u) + h C u_θ + h K q_θ − h F_θ − Gᵀ p of all nodes, shape (b, n) [N s].

        Zero at free dofs in a sound step; at held ones the impulse that the clamps give.
        """
        residual = self.balance.residual(state, after, force, scheme)
        return residual if nodal is None else residual - nodal

    def imbalance(
        self, state: ElasticState, guess: ElasticState, after: ElasticState, force: FloatArray,
        impulse: FloatArray, nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step, rigid and nodal [N s], shape (b,)."""
        return self.balance.imbalance(self.balance.residual(state, after, force, scheme), impulse, nodal)

    def clamp_reactions(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> dict[str, FloatArray]:  # fmt: skip
        """Mean force over the step, and moment about the origin, of each clamped face, ``block/face``."""
        if not self._face_names:
            return {}
        given = self.nodal_residual(state, after, force, nodal, scheme) / scheme.step
        reactions: dict[str, FloatArray] = {}
        for index, face in enumerate(self._face_names):
            own = np.zeros_like(given)
            mine = self.holds.dofs[self.holds.owner == index]
            own[:, mine] = given[:, mine]
            for name, wrench in zip(self.names, self.resultant(own), strict=True):
                key = f"{name}/{face}"  # one face may be clamped twice, a component at a time
                reactions[key] = reactions.get(key, 0.0) + wrench
        return reactions

    def actions(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> Actions:  # fmt: skip
        """Loads, clamps and inertia, in the reference: small kinematics balances there."""
        clamps = np.zeros_like(force)
        if self.holds.dofs.size:
            held = self.holds.dofs
            given = self.nodal_residual(state, after, force, nodal, scheme)
            clamps[:, held] = given[:, held] / scheme.step
        taken = self.balance.inertia(state, after, scheme) / scheme.step if scheme.inertia else clamps * 0.0
        load, d = self.resultant(force), self.dimension
        acting = np.einsum("bij,bnj->bni", self.rotation, (force + clamps).reshape(self.count, -1, d))
        moved = moment(self.positions(after).reshape(acting.shape), acting).sum(axis=1)
        centre = self.rotation @ self.modes.centroid + self.translation
        return Actions(load, self.resultant(clamps), self.resultant(taken), centre, moved)

    def step_energy(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Work of F_θ and of moving clamps, and what damping and the θ-scheme took, exactly."""
        given = None
        if self.clamping.moving:
            given = self.nodal_residual(state, after, force, nodal, scheme)
        return self.balance.energy(state, after, force, given, scheme)

    def kinetic_energy(self, state: ElasticState) -> FloatArray:
        """½ uᵀ M u, shape (b,) [J]."""
        return 0.5 * self.balance.mass_square(state.rigid_velocity, state.velocity)

    def strain_energy(self, state: ElasticState) -> FloatArray:
        """½ qᵀ K q, shape (b,) [J]."""
        return 0.5 * dot(state.displacement @ self.operators.stiffness, state.displacement)

    def stress(self, state: ElasticState) -> StressField:
        """Stresses of all blocks at Gauss points and nodes, world axes."""
        return self._recovery.field(state.displacement, self.rotation)

    def stress_error(self, state: ElasticState) -> StressError:
        """Zienkiewicz and Zhu's estimate of the error of these stresses."""
        squares = self._estimate.squares(self._recovery.gauss_stress(state.displacement))
        return StressError(squares, 2.0 * self.strain_energy(state), self._estimate.volume.sum(axis=1))
