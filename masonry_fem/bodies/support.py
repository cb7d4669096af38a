"""Supports: blocks whose motion is given (ground, springings, settlements, rotating floors).

    ground = SupportGroup(assembly, [0])
    floor = SupportGroup(assembly, [0], [Motion(displacement=lambda t: np.array([0.0, 0.0, -0.01 * t]))])

A support's velocities U = (v of its pivot [m/s], ω [rad/s], world axes) are given to the solver,
not solved for; they are plain, not mass-orthonormal, since a support has no mass.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free, IntArray, Scheme, StepEnergy
from masonry_fem.bodies.rotation import IDENTITY, between, chained, change, spin_count, turned_by
from masonry_fem.bodies.undeformed import Placed, Undeformed
from masonry_fem.errors import SceneError
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.submerged import Submerged

# Time over which the motion is differentiated, relative to the step; the second-order formula has
# an error of its square and rounding of about 1e-16 divided by it.
DERIVATIVE_STEP = 1e-4


@dataclass(frozen=True, slots=True)
class Motion:
    """Rigid motion of one support as a function of time, from its reference position.

    Attributes
    ----------
    displacement : Time [s] → displacement of the pivot, shape (d,) [m]; None: none.
    rotation : Time [s] → rotation vector about the pivot, shape (3,), or angle in 2D [rad]; None: none.
    pivot : Point about which it turns, reference configuration, (d,) [m]; None: the vertices' mean.
    """

    displacement: Callable[[float], FloatArray] | None = None
    rotation: Callable[[float], FloatArray | float] | None = None
    pivot: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class Clamp:
    """A held face of a block that deforms.

    Attributes
    ----------
    face : Polytope face.
    components : Held world axes; None: all.
    motion : How it moves (about the mean of the face's nodes unless it has a pivot); None: not.
    """

    face: int
    components: tuple[int, ...] | None = None
    motion: Motion | None = None


@dataclass(frozen=True, slots=True)
class SupportState:
    """Where b supports are at ``time`` and how they move.

    Attributes
    ----------
    time : Time [s] (load factor in statics).
    shift : How far the pivots have gone, shape (b, d) [m].
    turned : R − 1 of the rotations since the reference configuration, shape (b, d, d).
    velocity : Velocities of the pivots and spins, world axes, shape (b, m) [m/s, rad/s].
    """

    time: float
    shift: FloatArray
    turned: FloatArray
    velocity: FloatArray

    @property
    def rotation(self) -> FloatArray:
        """R, shape (b, d, d)."""
        rotation: FloatArray = IDENTITY[self.turned.shape[1]] + self.turned
        return rotation


class SupportGroup(Undeformed):
    """All supports of a model.

    Parameters
    ----------
    assembly : Where the blocks come from.
    blocks : Their numbers in it, shape (b,).
    motions : One a block (None: held); None holds them all.

    Attributes
    ----------
    mass : Zero, shape (b,): loads on a support go to the ground and never enter a balance.

    Raises
    ------
    SceneError
        If motions and blocks differ in number, or a motion's vector has the wrong length.
    """

    kind = "support"
    prescribed = True
    unknowns = 0

    def __init__(
        self,
        assembly: Assembly,
        blocks: Sequence[int] | IntArray,
        motions: Sequence[Motion | None] | None = None,
    ) -> None:
        numbers = np.asarray(blocks, dtype=np.int64)
        given = (None,) * len(numbers) if motions is None else motions
        if len(given) != len(numbers):
            raise SceneError(
                f"supports: {len(given)} motions for {len(numbers)} blocks, expected one each; "
                "give None for the blocks that are held"
            )
        self.motions = tuple(motion or Motion() for motion in given)
        pivots = [
            assembly.solid(int(block)).vertices.mean(axis=0) if motion.pivot is None else motion.pivot
            for block, motion in zip(numbers, self.motions, strict=True)
        ]
        super().__init__(assembly, numbers, np.array(pivots, float).reshape(-1, assembly.dimension))
        self._moving = [
            row for row, motion in enumerate(self.motions) if motion.displacement or motion.rotation
        ]
        self.mass: FloatArray = np.zeros(self.count)
        d = self.dimension
        self._begin = np.zeros((self.count, d)), np.zeros((self.count, d, d))
        self._pose(0.0)  # wrong lengths are found here, not in the middle of a march

    def starting_at(self, shift: FloatArray, turned: FloatArray) -> SupportGroup:
        """The same supports with motions that go on from another place than the reference.

        Parameters
        ----------
        shift : How far the pivots are from it, shape (b, d) [m].
        turned : R − 1 of the turns since it, shape (b, d, d).
        """
        motions = [
            _going_on(motion, *begin) for motion, *begin in zip(self.motions, shift, turned, strict=True)
        ]
        group = SupportGroup(self.assembly, self.blocks, motions)
        group._begin = shift, turned
        return group

    def rest(self) -> SupportState:
        """The reference, or where motions begin: in place at time 0, even where these start with a jump."""
        velocity = self._forward_velocity(0.0, DERIVATIVE_STEP)
        return SupportState(0.0, *self._begin, velocity)

    def spin_axes(self, state: Placed) -> tuple[FloatArray, FloatArray]:
        """The world axes: velocities of a support are plain."""
        return self._plain

    @cached_property
    def _plain(self) -> tuple[FloatArray, FloatArray]:
        return np.tile(np.eye(3), (self.count, 1, 1)), np.ones((self.count, self.freedoms))

    # --- the given motion -------------------------------------------------------------------------

    def _pose(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Shifts of the pivots (b, d) and R − 1 (b, d, d) that the motions give for an instant."""
        spins = spin_count(self.dimension)
        shift, turn = np.zeros((self.count, self.dimension)), np.zeros((self.count, spins))
        for row in self._moving:
            motion = self.motions[row]
            if motion.displacement is not None:
                shift[row] = self._vector(row, "displacement", motion.displacement(time), self.dimension)
            if motion.rotation is not None:
                turn[row] = self._vector(row, "rotation", motion.rotation(time), spins)
        return shift, change(turn)

    def _vector(self, row: int, name: str, value: FloatArray | float, length: int) -> FloatArray:
        vector = np.atleast_1d(np.asarray(value, dtype=float))
        if vector.shape != (length,):
            block = self.assembly.blocks.names[self.blocks[row]]
            raise SceneError(
                f"support '{block}': {name} has shape {vector.shape}, expected ({length},); "
                f"give {length} component(s) in {self.dimension}D"
            )
        return vector

    def _mean_velocity(
        self, shift: FloatArray, turned: FloatArray, pose: tuple[FloatArray, FloatArray], step: float
    ) -> FloatArray:
        """Constant U that carries a pose into another within a step, shape (b, m)."""
        if not any(part.any() for part in (shift, turned, *pose)):  # held where it was
            return np.zeros((self.count, self.freedoms))
        turn = turned_by(between(turned, pose[1]))
        mean: FloatArray = np.concatenate([pose[0] - shift, turn], axis=1) / step
        return mean

    def _forward_velocity(self, time: float, step: float) -> FloatArray:
        """U just after an instant, by a one-sided difference of second order, shape (b, m)."""
        if not self._moving:
            return np.zeros((self.count, self.freedoms))
        start = self._pose(time)
        near = self._mean_velocity(*start, self._pose(time + step), step)
        far = self._mean_velocity(*start, self._pose(time + 2 * step), 2 * step)
        return 2 * near - far

    # --- the step ---------------------------------------------------------------------------------

    def free(
        self, state: SupportState, at: SupportState, force: FloatArray, scheme: Scheme,
        guess: SupportState | None = None,
    ) -> Free:  # fmt: skip
        """The velocity at the end of the step, given by the motion.

        It is the u⁺ for which q + h[(1−θ) u + θ u⁺] is exactly the prescribed position at the end,
        u being the state's velocity: gaps computed by the θ rule are then exact too (translations;
        a turn by hω bends the path of a point at distance r by r (hω)²/2, which no velocity has).
        """
        pose = self._pose(state.time + scheme.step)
        mean = self._mean_velocity(state.shift, state.turned, pose, scheme.step)
        velocity = (mean - (1 - scheme.theta) * state.velocity) / scheme.theta
        return Free(velocity, self.generalised(state, force), np.zeros_like(velocity), None)

    def generalised(self, state: SupportState, force: FloatArray) -> FloatArray:
        """Nothing, shape (b, m): the motion is given, whatever acts."""
        return np.zeros_like(state.velocity)

    def advance(
        self,
        state: SupportState,
        free: Free,
        rigid_velocity: FloatArray,
        nodal: FloatArray | None,
        scheme: Scheme,
    ) -> SupportState:
        """The prescribed pose at the end of the step, with the velocity that it goes on with.

        Where θ < 1 that velocity enters the next step, and is taken from the motion itself: at a
        kink of the motion u⁺ would carry an alternating error from step to step.
        """
        h, time = scheme.step, state.time + scheme.step
        velocity = rigid_velocity if scheme.theta == 1 else self._forward_velocity(time, DERIVATIVE_STEP * h)
        return SupportState(time, *self._pose(time), velocity)

    def imbalance(
        self, state: SupportState, at: SupportState, after: SupportState, force: FloatArray,
        impulse: FloatArray, nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Nothing: a support takes whatever it is given, shape (b,) [N s]."""
        return np.zeros(self.count)

    def momentum_change(self, state: Placed, after: Placed, scheme: Scheme) -> FloatArray:
        """Nothing: no mass, shape (b, m)."""
        return np.zeros((self.count, self.freedoms))

    # --- loads and energies -----------------------------------------------------------------------

    def acceleration_force(self, acceleration: FloatArray) -> FloatArray:
        """No force: a support has no mass."""
        return self.no_force()

    def set_down(
        self, state: SupportState, rows: IntArray, rotation: FloatArray, shift: FloatArray
    ) -> SupportState:
        """The state itself: the motion is given."""
        return state

    def following(self, force: FloatArray, state: SupportState) -> FloatArray:
        """The array itself: what acts on a support goes to the ground."""
        return force

    def traction_force(
        self, body: int, face: int, traction: FloatArray, factor: Submerged | None = None
    ) -> FloatArray:
        """No force: what acts on a support goes to the ground."""
        return self.no_force()

    def point_force(self, body: int, point: FloatArray | None, force: FloatArray) -> FloatArray:
        """No force: what acts on a support goes to the ground."""
        return self.no_force()

    def scale_velocity(self, state: SupportState, factor: float) -> SupportState:
        """The state with its velocities multiplied by ``factor``; the motion goes on as given."""
        return replace(state, velocity=factor * state.velocity)

    def going_on(self, state: SupportState, end: SupportState) -> SupportState:
        """The state itself: the motion is given."""
        return state

    def kinetic_energy(self, state: SupportState) -> FloatArray:
        """Nothing: no mass, shape (b,) [J]."""
        return np.zeros(self.count)

    def step_energy(
        self, state: SupportState, after: SupportState, force: FloatArray, nodal: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Nothing: no mass, no loads, each of shape (b,) [J]; its work is that of its contacts."""
        nothing = np.zeros(self.count)
        return StepEnergy(nothing, nothing, nothing, nothing)

    def with_velocity(
        self, state: SupportState, body: int, velocity: FloatArray, spin: FloatArray
    ) -> SupportState:
        """Refused: a support moves as its motion says."""
        name = self.assembly.blocks.names[self.blocks[body]]
        raise SceneError(
            f"support '{name}': initial velocity is {np.asarray(velocity)}, expected none, since its "
            "motion is prescribed; give the support a motion instead"
        )


def _going_on(motion: Motion, shift: FloatArray, turned: FloatArray) -> Motion:
    """A motion that begins where a support is: ``shift`` (d,) [m] and R − 1 (d, d) off the reference."""
    if not (shift.any() or turned.any()):
        return motion
    way, turn = motion.displacement, motion.rotation

    def displacement(time: float) -> FloatArray:
        return shift if way is None else shift + way(time)

    def rotation(time: float) -> FloatArray:
        if turn is None:
            return turned_by(turned)
        return turned_by(chained(turned, change(np.atleast_1d(np.asarray(turn(time), dtype=float)))))

    return Motion(displacement, rotation if turned.any() or turn is not None else None, motion.pivot)
