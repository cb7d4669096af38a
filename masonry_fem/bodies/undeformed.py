"""Undeformed blocks: what rigid blocks and supports have in common, as arrays.

A block that keeps its shape is a *centre* (the point about which it turns: centroid or pivot)
and a rotation. A material point X of the reference configuration is at

    x = X + shift + (rotation − 1) (X − centre)

Shifts and what rotations differ from 1 by are kept, and not places: beside an elastic stone a rigid one may
move by 1e-9 of its size, and coordinates would keep seven digits of that.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from masonry_fem.bodies.base import (
    Actions,
    FloatArray,
    IntArray,
    Scheme,
    Sides,
    StressError,
    StressField,
)
from masonry_fem.bodies.rotation import moment, spin_count
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.tiled import tiled


class Placed(Protocol):
    """State of b undeformed blocks: where their centres are, how they have turned, how they move."""

    @property
    def shift(self) -> FloatArray:
        """How far the centres have gone, shape (b, d) [m]."""
        ...

    @property
    def turned(self) -> FloatArray:
        """R − 1 of the rotations since the reference configuration, shape (b, d, d)."""
        ...

    @property
    def rotation(self) -> FloatArray:
        """R, shape (b, d, d)."""
        ...

    @property
    def velocity(self) -> FloatArray:
        """Generalised velocities U in the group's own scaling, shape (b, m)."""
        ...


class Undeformed(ABC):
    """b blocks that keep their shape, about given centres.

    Parameters
    ----------
    assembly : Where the blocks come from.
    blocks : Their numbers in it, shape (b,).
    centres : Points about which they turn, reference configuration, shape (b, d) [m].
    """

    turns = True
    deforms = False
    modal = False
    nonlinear = False
    cell = None
    factorisations = 0

    def __init__(self, assembly: Assembly, blocks: IntArray, centres: FloatArray) -> None:
        self.assembly = assembly
        self.dimension = assembly.dimension
        self.blocks: IntArray = np.asarray(blocks, dtype=np.int64)
        self.centres = centres
        # the last answer of resultant about the reference, with what it is for: loads seldom change
        self._resulted: tuple[FloatArray, FloatArray] | None = None

    @property
    def count(self) -> int:
        """Number of blocks b."""
        return int(self.blocks.shape[0])

    @property
    def freedoms(self) -> int:
        """Number of rigid velocities of a block m: 3 in 2D, 6 in 3D."""
        return self.dimension + spin_count(self.dimension)

    def attach(self, sides: Sides) -> UndeformedAttachment:
        """The blocks seen through contact sides."""
        return UndeformedAttachment(self, sides, sides.point - self.centres[sides.body])

    @property
    def unknowns(self) -> int:
        """Displacements that a step solves for, those of all blocks."""
        return self.count * self.freedoms

    def motion(self, state: Placed) -> tuple[FloatArray, FloatArray]:
        """The motions x = R X + t of the blocks, shapes (b, d, d) and (b, d) [m]."""
        return state.rotation, state.shift - np.einsum("bij,bj->bi", state.turned, self.centres)

    def positions_of_centres(self, state: Placed) -> FloatArray:
        """Where the centres are, shape (b, d) [m]."""
        return self.centres + state.shift

    @abstractmethod
    def spin_axes(self, state: Placed) -> tuple[FloatArray, FloatArray]:
        """Axes of the spins in U, as columns, (b, 3, 3), and what velocities are multiplied by in U, (b, m).

        In 2D there is one axis, normal to the plane, and the first array is not used.
        """

    def velocity_map(self, state: Placed, bodies: IntArray, points: FloatArray) -> FloatArray:
        """Velocity at current points of ``bodies`` for unit U, world axes, shape (k, d, m)."""
        return self.local_map(state, bodies, points, np.tile(np.eye(self.dimension), (len(bodies), 1, 1)))

    def local_map(
        self, state: Placed, bodies: IntArray, points: FloatArray, frames: FloatArray
    ) -> FloatArray:
        """Velocity at current points of ``bodies`` for unit U, in frames, shape (k, d, m).

        Parameters
        ----------
        state : Where the blocks are.
        bodies : Block of each point, shape (k,).
        points : World coordinates, shape (k, d) [m].
        frames : Rows (n, t1[, t2]) at each of them, shape (k, d, d).
        """
        from masonry_fem.bodies.motions import side_maps  # noqa: PLC0415 - Numba is slow to import

        arms = points - self.positions_of_centres(state)[bodies]
        maps: FloatArray = side_maps(frames, arms, *self.spin_axes(state), bodies)
        return maps

    # --- loads ------------------------------------------------------------------------------------

    # A force array has, by block, the force F and the dyadic Σ r ⊗ f of arms from the centre in
    # the reference configuration: it adds and scales, and gives the moment in any rotation.

    def no_force(self) -> FloatArray:
        """No force on any block, shape (b, d + d²)."""
        return np.zeros((self.count, self.dimension * (1 + self.dimension)))

    def moments(self, force: FloatArray, rotation: FloatArray) -> FloatArray:
        """Moments of forces about the centres of blocks that have turned, shape (b, 1 or 3) [N m]."""
        from masonry_fem.bodies.motions import turned_moments  # noqa: PLC0415 - Numba is slow to import

        turned: FloatArray = turned_moments(force, rotation)
        return turned

    def arms(self, state: Placed | None) -> tuple[FloatArray, FloatArray]:
        """How lever arms have turned, (b, d, d), and where they begin, (b, d) [m]; None: in the reference."""
        if state is not None and self.turns:
            return state.rotation, self.positions_of_centres(state)
        return self._unturned, self.centres

    @cached_property
    def _unturned(self) -> FloatArray:
        """Rotations in the reference, shape (b, d, d)."""
        return np.tile(np.eye(self.dimension), (self.count, 1, 1))

    def resultant(self, force: FloatArray, state: Placed | None = None) -> FloatArray:
        """Force and moment about the world origin, arms as in ``state``, shape (b, m) [N, N m]."""
        if state is None and self._resulted is not None and self._resulted[0] is force:
            return self._resulted[1]
        d, (rotation, centre) = self.dimension, self.arms(state)
        about_origin = self.moments(force, rotation) + moment(centre, force[:, :d])
        total = np.concatenate([force[:, :d], about_origin], axis=1)
        if state is None:
            self._resulted = force, total
        return total

    def clamp_reactions(
        self, state: Placed, after: Placed, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> dict[str, FloatArray]:
        """None: only meshes have clamped faces."""
        return {}

    def actions(
        self, state: Placed, after: Placed, force: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> Actions:
        """Loads and inertia, at the end of a step of statics, at the start of one of dynamics."""
        d, there = self.dimension, state if scheme.inertia else after
        load, centre = self.resultant(force, there), self.arms(there)[1]
        taken = self.momentum_change(state, after, scheme)
        taken[:, d:] += moment(centre, taken[:, :d])
        return Actions(load, np.zeros_like(load), np.zeros(self.count), taken, centre, load[:, d:])

    @abstractmethod
    def momentum_change(self, state: Placed, after: Placed, scheme: Scheme) -> FloatArray:
        """Mean force and moment about the centres that inertia and mass damping take, shape (b, m)."""

    def velocity_parts(self, state: Placed) -> tuple[FloatArray, None]:
        """The state's velocity U, shape (b, m), and no elastic part."""
        return state.velocity, None

    def strain_energy(self, state: Placed) -> FloatArray:
        """Nothing: a block that keeps its shape stores none, shape (b,) [J]."""
        return np.zeros(self.count)

    def warmed(self, state: Placed) -> None:
        """A block that keeps its shape does not expand."""
        return

    # --- fields -----------------------------------------------------------------------------------

    def displacement(self, state: Placed, body: int, point: FloatArray) -> FloatArray:
        """Displacement of material points of one block, reference coordinates, (..., d) [m]."""
        point = np.asarray(point, dtype=float)
        arm = point - self.centres[body]
        moved: FloatArray = state.shift[body] + arm @ state.turned[body].T
        return moved

    def cells(self, body: int) -> Sequence[tuple[int, ...]]:
        """Face loops of one block's polytope over its vertices."""
        faces: Sequence[tuple[int, ...]] = self.assembly.shapes[int(self.alike[body])].solid.faces
        return faces

    @property
    def alike(self) -> IntArray:
        """Number of each block's shape, shape (b,)."""
        return self.assembly.blocks.shape[self.blocks]

    @cached_property
    def first(self) -> IntArray:
        """First vertex of each block, and the number of all, shape (b + 1,)."""
        vertices = np.array([len(shape.solid.vertices) for shape in self.assembly.shapes], dtype=np.int64)
        return np.append(0, np.cumsum(vertices[self.alike]))

    def nodes(self, body: int) -> FloatArray:
        """Vertices of one block in the reference configuration, shape (n, d) [m]."""
        return self.places[self.first[body] : self.first[body + 1]]

    def positions(self, state: Placed) -> FloatArray:
        """Where the vertices of all blocks are, block after block, shape (all vertices, d) [m]."""
        return self.places + self.displacements(state)

    @cached_property
    def _corners(self) -> tuple[IntArray, FloatArray]:
        """The body of each vertex, (v,), and its arm from the body's centre in the reference, (v, d) [m]."""
        owner = np.repeat(np.arange(self.count), np.diff(self.first))
        return owner, self.places - self.centres[owner]

    @cached_property
    def places(self) -> FloatArray:
        """Of the vertices in the reference, block after block, shape (v, d) [m]."""
        blocks = self.assembly.blocks
        vertices, owner = tiled([shape.solid.vertices for shape in self.assembly.shapes], self.alike)
        turned = np.einsum("vij,vj->vi", blocks.rotation[self.blocks][owner], vertices)
        places: FloatArray = turned + blocks.translation[self.blocks][owner]
        return places

    def displacements(self, state: Placed) -> FloatArray:
        """How far the vertices of all blocks have gone, shape (all vertices, d) [m]."""
        owner, arms = self._corners
        return _carried(state, arms, owner)

    def velocities(self, state: Placed, place: Placed | None = None) -> FloatArray:
        """Velocity of all vertices, with the blocks as in ``place``, shape (all vertices, d) [m/s]."""
        there, owner = state if place is None else place, self._corners[0]
        rates = self.velocity_map(there, owner, self.positions(there))
        field: FloatArray = np.einsum("vdm,vm->vd", rates, state.velocity[owner])
        return field

    def stress(self, state: Placed) -> StressField | None:
        """None: a block that keeps its shape has no stress field."""
        return None

    def material_state(self, state: Placed) -> Mapping[str, FloatArray]:
        """Nothing: what keeps its shape has no strains."""
        return {}

    def stress_error(self, state: Placed) -> StressError | None:
        """None, as ``stress``."""
        return None


@dataclass(frozen=True, slots=True)
class UndeformedAttachment:
    """Undeformed blocks seen through k contact sides.

    Attributes
    ----------
    group : The blocks.
    sides : Which contacts touch them, and where.
    arms : Material points measured from the blocks' centres, reference axes, shape (k, d) [m].
    """

    group: Undeformed
    sides: Sides
    arms: FloatArray

    def displacements(self, state: Placed) -> FloatArray:
        """How far the material points have gone, shape (k, d) [m]."""
        return _carried(state, self.arms, self.sides.body)

    def rotations(self, state: Placed) -> FloatArray:
        """How the blocks have turned since the reference configuration, shape (k, d, d)."""
        return state.rotation[self.sides.body]

    def rigid_map(self, state: Placed, points: FloatArray, frames: FloatArray) -> FloatArray:
        """Velocity, in the frames, at current points for unit U, shape (k, d, m)."""
        return self.group.local_map(state, self.sides.body, points, frames)

    def elastic_velocity(self, elastic: FloatArray, seen: FloatArray) -> FloatArray:
        """Nothing, shape (k, d)."""
        return np.zeros_like(self.arms)

    def compliance(
        self, scheme: Scheme, seen: FloatArray, guess: Placed | None = None
    ) -> Sequence[tuple[IntArray, FloatArray]]:
        """None: W_el = 0."""
        return ()

    def kinds(
        self, scheme: Scheme, seen: FloatArray, guess: Placed | None = None
    ) -> Sequence[tuple[IntArray, FloatArray, FloatArray]]:
        """None: W_el = 0."""
        return ()

    def unit_motions(self, scheme: Scheme, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
        """None."""
        return np.zeros((*seen.shape[:2], 0)), np.zeros((0, 0))

    def spread(self, impulses: FloatArray, seen: FloatArray) -> FloatArray | None:
        """None: no nodes to spread impulses to."""
        return None


def _carried(state: Placed, arms: FloatArray, body: IntArray) -> FloatArray:
    """How far material points have gone, shape (k, d) [m]."""
    from masonry_fem.bodies.motions import carried  # noqa: PLC0415 - Numba is slow to import

    moved: FloatArray = carried(state.turned, state.shift, arms, body)
    return moved
