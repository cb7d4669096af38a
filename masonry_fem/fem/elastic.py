"""Elastic blocks: all blocks of one mesh, material and clamping, stepped together as arrays.

    (bricks,) = elastic_groups(assembly, {block: stone for block in blocks})
    state = bricks.rest()
    free = bricks.free(state, state, bricks.acceleration_force(gravity), Scheme(step=1e-3))
    state = bricks.advance(state, free, free.rigid_velocity + free.rigid_impulse, nodal, scheme)

Kinematics are small: blocks keep their reference rotations (``corotational`` has those that turn). Clamped
dofs follow their prescribed motion u_c, and act on the others through the off-diagonal blocks of M̂:

    u_el,free = u_el + (M̂⁻¹)_el [h F − h C u − h K q − h²θ K u − M̂_fc (u_c⁺ − u_c)]

In statics (inertia 0) the velocities before the step, M and C are left out. Stones that yield (``inelastic``)
are linearised at a guess of the end of the step instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import Self

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
from masonry_fem.bodies.rotation import first_order, resultants
from masonry_fem.bodies.support import Motion
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.attachment import SmallAttachment
from masonry_fem.fem.balance import Balance
from masonry_fem.fem.clamp import Clamping, Faces, Holds
from masonry_fem.fem.condense import coefficients
from masonry_fem.fem.constitution import Constitution, LinearElasticity, times
from masonry_fem.fem.deformable import Deformable
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.modes import rigid_modes
from masonry_fem.solid.pose import Poses

# Of the forces that would hold what heated stones grow by: where these cancel 1e-12 of them is rounding,
# and what is written is to balance to 1e-6 of this share.
CANCELLED = 1e-6


class ElasticGroup(Deformable[ElasticState]):
    """All blocks of one mesh, material and clamping, with small kinematics.

    Parameters
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    names : Their names.
    poses : Where the mesh stands for each.
    operators : Mesh, stiffness and mass.
    clamps : Held faces as (face, components in shape axes), alike for all blocks.
    motions : For each block one motion a clamp (None: held); None: all are held.
    faces : Names of the polytope's faces, for reports.
    constitution : Their stresses; None: linear elasticity.
    kind : Name of their fidelity.
    """

    turns = False

    def __init__(
        self,
        blocks: IntArray,
        names: Sequence[str],
        poses: Poses,
        operators: ShapeOperators,
        clamps: Faces = (),
        motions: Sequence[Sequence[Motion | None]] | None = None,
        faces: Sequence[str] = (),
        constitution: Constitution | None = None,
        kind: str = "elastic",
    ) -> None:
        mesh = operators.mesh
        self.clamping = Clamping(mesh, clamps, motions, *poses, names[0])
        self.holds: Holds = self.clamping.holds
        modes = rigid_modes(mesh.points, operators.mass, self.holds.free)
        own = LinearElasticity(operators) if constitution is None else constitution
        super().__init__(blocks, names, poses, operators, modes, self.holds.free, own, kind)
        self.balance = Balance(operators, own, modes, self.holds)
        self._face_names = [
            faces[face] if face < len(faces) and faces[face] else str(face) for face, _ in clamps
        ]
        # Φᵀ M at held dofs: how their motion pushes the rigid modes
        self._pull: FloatArray = modes.momentum[self.holds.dofs]

    def set_down(
        self, state: ElasticState, rows: IntArray, rotation: FloatArray, shift: FloatArray
    ) -> ElasticState:
        """Blocks ``rows`` (k,) at rest at x = R X + t without strain: R (k, d, d), t (k, d) [m].

        With small kinematics turns are taken to first order. Blocks with clamped faces stay as they are.
        """
        if self.modes.count < len(self.modes.from_motion):
            return state
        poses = self.rotation[rows]
        centres = poses @ self.modes.centroid + self.translation[rows]
        turn = rotation - np.eye(self.dimension)
        away = np.einsum("kji,kj->ki", poses, shift + np.einsum("kij,kj->ki", turn, centres))
        own = poses.swapaxes(1, 2) @ turn @ poses
        spin = first_order(own)
        rigid = state.rigid_displacement.copy()
        rigid[rows] = np.concatenate([away, spin], axis=1) @ self.modes.from_motion.T
        return replace(state, rigid_displacement=rigid)

    def nodal_motion(self, state: ElasticState) -> tuple[FloatArray, FloatArray]:
        """Displacements [m] and velocities [m/s] of all nodes, shape axes, (b, n)."""
        modes = self.modes.modes.T
        return (
            state.rigid_displacement @ modes + state.displacement,
            state.rigid_velocity @ modes + state.velocity,
        )

    def moved_by(
        self, state: ElasticState, rows: IntArray, displacement: FloatArray, velocity: FloatArray
    ) -> ElasticState:
        """The state with blocks ``rows`` (k,) moved as ``nodal_motion`` tells, displacements (k, n)."""
        changes = {}
        for rigid, elastic, given in (
            ("rigid_displacement", "displacement", displacement),
            ("rigid_velocity", "velocity", velocity),
        ):
            amplitudes, rest = self.modes.split(given)
            changes[rigid], changes[elastic] = getattr(state, rigid).copy(), getattr(state, elastic).copy()
            changes[rigid][rows], changes[elastic][rows] = amplitudes, rest
        return replace(state, **changes)

    def clamped_at(self, state: ElasticState) -> Self:
        """The same blocks with clamps whose motions go on from where a state has them."""
        group = copy(self)
        group.clamping = self.clamping.starting_at(state.displacement[:, self.holds.dofs])
        return group

    def clamped_as(self, other: Self) -> Self:
        """The same blocks with the clamps of another group of them, which may be of another material."""
        group = copy(self)
        group.clamping = other.clamping
        return group

    def clamp_forces(self, state: ElasticState, force: FloatArray, nodal: FloatArray) -> FloatArray:
        """What clamps give beside loads and contacts (b, n) in statics, zero at free dofs, (b, n) [N]."""
        given = self.nodal_residual(state, state, force, nodal, Scheme(1.0, 1.0, 0.0))
        given[:, self.holds.free] = 0.0
        return given

    def attach(self, sides: Sides) -> SmallAttachment:
        """The blocks seen through contact sides."""
        return SmallAttachment.of(self, sides)

    # --- states -----------------------------------------------------------------------------------

    def rest(self) -> ElasticState:
        """Undeformed, in place, at rest; clamps that move have their first velocity."""
        b, m = self.count, self.modes.modes.shape[1]
        velocity = self.no_force()
        velocity[:, self.holds.dofs] = self.clamping.first_velocity()
        memory = self.constitution.fresh(b)
        return ElasticState(0.0, np.zeros((b, m)), self.no_force(), np.zeros((b, m)), velocity, memory)

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

    def free(
        self, state: ElasticState, at: ElasticState, force: FloatArray, scheme: Scheme,
        guess: ElasticState | None = None,
    ) -> Free:  # fmt: skip
        """The step without contact impulses, in rigid and elastic part, wherever the blocks are."""
        h, theta, inertia = scheme.step, scheme.theta, scheme.inertia
        operators, material, held = self.operators, self.operators.material, self.holds.dofs
        alpha, beta = material.mass_damping, material.stiffness_damping
        start = state.velocity if inertia else np.zeros_like(state.velocity)
        c_m = coefficients(operators, scheme)[0]
        before = state.displacement[:, held], start[:, held]
        change = self.clamping.velocity(state.time, *before, scheme) - start[:, held]
        if guess is not None:
            left = self.balance.residual(state, guess, force, scheme)
            # a first guess is as warm as the step begins
            ahead = state.time + h - guess.time
            left -= h * theta * self.constitution.expanding(guess, ahead, tangent=True)
            missing = start[:, held] + change - guess.velocity[:, held]
            if missing.any():  # the guess is where the step begins
                left += self._pushed(missing, guess, scheme)
            elastic = guess.velocity - self.compliant(left, guess, scheme)
        else:
            rate = (h * theta + inertia * beta) * start
            right = h * force - h * self.constitution.forces(state, state, theta, rate)
            right += h * theta * self.constitution.expanding(state, h)
            if inertia and alpha:
                right -= inertia * h * alpha * times(start, operators.mass)
            if change.any():
                right -= self._pushed(change, None, scheme)
            elastic = start + self.factor(scheme).apply(right)
        elastic[:, held] = start[:, held] + change
        momentum = state.rigid_velocity + start[:, held] @ self._pull
        impulse = (
            h * self.generalised(at, force) - inertia * h * alpha * momentum - c_m * (change @ self._pull)
        )
        mass = np.full_like(state.rigid_velocity, c_m)
        mass[:, self.modes.count :] = 1.0  # modes that clamps forbid are placeholders that stay at rest
        return Free(state.rigid_velocity, impulse, mass, elastic, guess=guess)

    def generalised(self, state: ElasticState, force: FloatArray) -> FloatArray:
        """Φᵀ F, shape (b, m), wherever the blocks are."""
        work: FloatArray = force @ self.modes.modes
        return work

    def _pushed(self, change: FloatArray, guess: ElasticState | None, scheme: Scheme) -> FloatArray:
        """Impulses that held dofs give to all nodes as their velocities change by (b, held), shape (b, n)."""
        operators, (c_m, c_k) = self.operators, coefficients(self.operators, scheme)
        moved = self.no_force()
        moved[:, self.holds.dofs] = change
        inert, stiff = times(moved, operators.mass), times(moved, operators.stiffness)
        for body, factor in self.tangents(guess, scheme).items():
            stiff[body] = factor.stiffness @ moved[body]
        return c_m * inert + c_k * stiff

    def _reached(
        self,
        state: ElasticState,
        origin: ElasticState | None,
        rigid_velocity: FloatArray,
        velocity: FloatArray,
        scheme: Scheme,
    ) -> ElasticState:
        h, theta = scheme.step, scheme.theta
        displacement = state.displacement + h * ((1 - theta) * state.velocity + theta * velocity)
        return ElasticState(
            state.time + h,
            state.rigid_displacement + h * ((1 - theta) * state.rigid_velocity + theta * rigid_velocity),
            displacement,
            rigid_velocity,
            velocity,
            self.constitution.followed(state, displacement, state.time + h),
        )

    # --- measures of the step -----------------------------------------------------------------------

    def nodal_residual(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """M (u⁺ − u) + h C u_θ + h ∫Bᵀσ_θ − h F_θ − Gᵀ p of all nodes, shape (b, n) [N s].

        Zero at free dofs in a sound step; at held ones the impulse that the clamps give.
        """
        residual = self.balance.residual(state, after, force, scheme)
        return residual if nodal is None else residual - nodal

    def imbalance(
        self, state: ElasticState, at: ElasticState, after: ElasticState, force: FloatArray,
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
        acting = self._turned((force + clamps).reshape(self.count, -1, d))
        moved = resultants(self.positions(after).reshape(acting.shape), acting)[1]
        centre = self.rotation @ self.modes.centroid + self.translation
        sizes = np.linalg.norm(clamps.reshape(acting.shape), axis=2).sum(axis=1)
        # clamps of a stone that is free to expand give rounding of what would hold it
        sizes = np.maximum(sizes, CANCELLED * self.constitution.confined(state, after).force)
        summed: FloatArray | float = 0.0
        if self.holds.dofs.size:
            stretch = np.maximum(abs(state.displacement), abs(after.displacement))
            summed = stretch @ self.operators.row_sums
        return Actions(load, self.resultant(clamps), sizes, self.resultant(taken), centre, moved, summed)

    def step_energy(
        self, state: ElasticState, after: ElasticState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Work of F_θ and of moving clamps, and what damping, yielding and the θ-scheme took, exactly."""
        given = None
        if self.clamping.moving:
            given = self.nodal_residual(state, after, force, nodal, scheme)
        return self.balance.energy(state, after, force, given, scheme)

    def kinetic_energy(self, state: ElasticState) -> FloatArray:
        """½ uᵀ M u, shape (b,) [J]."""
        return 0.5 * self.balance.mass_square(state.rigid_velocity, state.velocity)

    # --- fields -----------------------------------------------------------------------------------

    def _moved(self, state: ElasticState) -> FloatArray:
        """How far the nodes have gone, shape axes, shape (b, nodes, d) [m]."""
        return self._nodal(state.rigid_displacement, state.displacement)

    def _moving(self, state: ElasticState, place: ElasticState) -> FloatArray:
        """Velocity of the nodes, wherever the blocks are, shape axes, shape (b, nodes, d) [m/s]."""
        return self._nodal(state.rigid_velocity, state.velocity)

    def _nodal(self, rigid: FloatArray, elastic: FloatArray) -> FloatArray:
        """Φ times rigid amplitudes (b, m) and a nodal field (b, n), shape axes, (b, nodes, d)."""
        return (rigid @ self.modes.modes.T + elastic).reshape(self.count, -1, self.dimension)

    def motion(self, state: ElasticState) -> tuple[FloatArray, FloatArray]:
        """The rigid motions x = R X + t nearest to those of the nodes, (b, d, d) and (b, d) [m]."""
        moved = self.displacements(state).reshape(self.count, -1, self.dimension)
        start = self.places.reshape(moved.shape)
        now, middle = start + moved, start.mean(axis=1)
        reached = now.mean(axis=1)
        spread = np.einsum("bni,bnj->bij", now - reached[:, None], start - middle[:, None])
        left, _, right = np.linalg.svd(spread)
        left[:, :, -1] *= np.sign(np.linalg.det(left @ right))[:, None]
        turn = left @ right
        return turn, reached - np.einsum("bij,bj->bi", turn, middle)

    def stress(self, state: ElasticState) -> StressField:
        """Stresses of all blocks at Gauss points and nodes, world axes."""
        return self._field(state, self.rotation)
