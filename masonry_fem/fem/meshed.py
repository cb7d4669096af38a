"""Meshed: blocks that share one mesh, each in its own pose: loads, fields, places, as arrays.

A nodal array (b, n) holds vectors of b blocks in their shapes' axes, dof = node · d + component;
world and shape axes differ by the poses' rotations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.bodies.rotation import moment, resultants, turned
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.constitution import Memory
from masonry_fem.fem.locate import in_cells
from masonry_fem.fem.modes import RigidModes
from masonry_fem.fem.traction import face_weights, submerged_weights
from masonry_fem.solid.pose import Poses
from masonry_fem.solid.submerged import Submerged


@dataclass(frozen=True, slots=True)
class ElasticState:
    """How b blocks have moved and move, split in rigid and elastic part: u = Φ U + u_el.

    The split keeps the digits of the elastic part however far and fast a block moves.

    Attributes
    ----------
    time : Time [s] (load factor in statics), for clamps that move.
    rigid_displacement : Amplitudes of the rigid modes, shape (b, m) [kg^½ m].
    displacement : Elastic part, with what clamps prescribe, shape axes, shape (b, n) [m].
    rigid_velocity : U, shape (b, m) [kg^½ m/s].
    velocity : u_el, shape axes, shape (b, n) [m/s]. After a step of statics U and u_el are the
        displacements of that step over h; no momentum belongs to them.
    memory : Of the material; None where it has none.
    pushed : Forces of contacts on the nodes in the step that led here, of reduced blocks, shape (b, n) [N].
    """

    time: float
    rigid_displacement: FloatArray
    displacement: FloatArray
    rigid_velocity: FloatArray
    velocity: FloatArray
    memory: Memory | None = None
    pushed: FloatArray | None = None


class Meshed[S](ABC):
    """b blocks over one mesh, their states of a class S.

    Parameters
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    names : Their names.
    poses : Where the mesh stands for each.
    operators : Mesh, stiffness and mass.
    modes : Rigid modes of the mesh.
    """

    def __init__(
        self,
        blocks: IntArray,
        names: Sequence[str],
        poses: Poses,
        operators: ShapeOperators,
        modes: RigidModes,
    ) -> None:
        self.blocks = blocks
        self.names = tuple(names)
        self.rotation, self.translation = poses
        self.operators, self.modes = operators, modes
        self.mesh = operators.mesh
        self.dimension = operators.mesh.dimension
        self.cell = operators.mesh.cell
        unit = np.tile(np.eye(self.dimension), (len(self.mesh.points), 1))
        self._inertia: FloatArray = operators.mass @ unit  # force of unit accelerations, (n, d)
        self.mass: FloatArray = np.full(len(blocks), self._inertia[:: self.dimension, 0].sum())
        self._located: dict[tuple[int, bytes], tuple[NDArray[np.int64], FloatArray]] = {}
        self._faces: dict[int, FloatArray] = {}

    @property
    def count(self) -> int:
        """Number of blocks b."""
        return len(self.blocks)

    @property
    def unknowns(self) -> int:
        """Displacements that a step solves for: nodal and rigid ones of all blocks."""
        nodal, rigid = self.modes.modes.shape
        return int(self.count * (nodal + rigid))

    def to_shape(self, bodies: IntArray, points: FloatArray) -> FloatArray:
        """Shape coordinates of world points (k, d), each of its own block."""
        local: FloatArray = np.einsum("kij,ki->kj", self.rotation[bodies], points - self.translation[bodies])
        return local

    def no_force(self) -> FloatArray:
        """Nothing on any node, shape (b, n)."""
        return np.zeros((self.count, self.mesh.points.size))

    # --- loads ------------------------------------------------------------------------------------

    def acceleration_force(self, acceleration: FloatArray) -> FloatArray:
        """Body force of a uniform acceleration (d,) [m/s²], nodal (b, n) [N]."""
        local = np.einsum("bij,i->bj", self.rotation, np.asarray(acceleration, dtype=float))
        force: FloatArray = local @ self._inertia.T
        return force

    def traction_force(
        self, body: int, face: int, traction: FloatArray, factor: Submerged | None = None
    ) -> FloatArray:
        """Traction on a polytope face of one block, nodal (b, n) [N].

        Parameters
        ----------
        body, face : The block and its face. traction : World axes, shape (d,) [Pa].
        factor : What it is multiplied by at each point of the reference; None: it is uniform.
        """
        if factor is not None:
            places = self.mesh.points @ self.rotation[body].T + self.translation[body]
            weights = submerged_weights(self.mesh, face, self.names[body], places, factor)
        else:
            if face not in self._faces:
                self._faces[face] = face_weights(self.mesh, face, self.names[body])
            weights = self._faces[face]
        force = self.no_force()
        local = self.rotation[body].T @ np.asarray(traction, dtype=float)
        force[body] = np.outer(weights, local).ravel()
        return force

    def following(self, force: FloatArray, state: S) -> FloatArray:
        """The array itself: where kinematics are small directions stay those of the reference."""
        return force

    def point_force(self, body: int, point: FloatArray | None, force: FloatArray) -> FloatArray:
        """Force (d,) [N] at a world point of the reference (None: centroid), nodal (b, n) [N]."""
        centre = self.rotation[body] @ self.modes.centroid + self.translation[body]
        nodes, weights = self._located_at(body, centre if point is None else point)
        total = self.no_force()
        local = self.rotation[body].T @ np.asarray(force, dtype=float)
        total[body].reshape(-1, self.dimension)[nodes] = np.outer(weights, local)
        return total

    def resultant(self, force: FloatArray, state: S | None = None) -> FloatArray:
        """Force and moment about the world origin in the reference, whatever the state, (b, m) [N, N m]."""
        nodal = force.reshape(len(force), -1, self.dimension)
        given, own = resultants(self.mesh.points, nodal)
        total = np.einsum("bij,bj->bi", self.rotation, given)
        turned = own if self.dimension == 2 else np.einsum("bij,bj->bi", self.rotation, own)
        return np.concatenate([total, turned + moment(self.translation, total)], axis=1)

    # --- fields -----------------------------------------------------------------------------------

    def _weights(self, body: int, point: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
        """Nodes and weights of a world point of one block; kept, since probes ask at every step."""
        key = (body, np.asarray(point, dtype=float).tobytes())
        if key not in self._located:
            self._located[key] = self._located_at(body, point)
        return self._located[key]

    def _located_at(self, body: int, point: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
        """Nodes and weights of a world point of one block."""
        local = self.rotation[body].T @ (np.asarray(point, dtype=float) - self.translation[body])
        return in_cells(self.mesh, local, f"block '{self.names[body]}', point {point}")

    def _world(self, nodal: FloatArray, body: int) -> FloatArray:
        """Nodal vectors (n,) of one block in world axes, shape (nodes, d)."""
        turned: FloatArray = nodal.reshape(-1, self.dimension) @ self.rotation[body].T
        return turned

    @abstractmethod
    def _moved(self, state: S) -> FloatArray:
        """How far the nodes have gone, shape axes, shape (b, nodes, d) [m]."""

    @abstractmethod
    def _moving(self, state: S, place: S) -> FloatArray:
        """Velocity of the nodes with the blocks as in ``place``, shape axes, shape (b, nodes, d) [m/s]."""

    def displacement(self, state: S, body: int, point: FloatArray) -> FloatArray:
        """Displacement of a material point given in world coordinates of reference, (d,) [m]."""
        nodes, weights = self._weights(body, point)
        moved: FloatArray = weights @ self._world(self._moved(state)[body], body)[nodes]
        return moved

    def cells(self, body: int) -> IntArray:
        """Cells of the mesh, shape (m, k)."""
        return self.mesh.cells

    @property
    def alike(self) -> IntArray:
        """0 for each block: they share their mesh, shape (b,)."""
        return np.zeros(self.count, dtype=np.int64)

    @property
    def first(self) -> IntArray:
        """First node of each block, and the number of all, shape (b + 1,)."""
        return np.arange(self.count + 1) * len(self.mesh.points)

    def nodes(self, body: int) -> FloatArray:
        """Nodes of one block in the reference configuration, world axes, shape (nodes, d) [m]."""
        placed: FloatArray = self._world(self.mesh.points.ravel(), body) + self.translation[body]
        return placed

    @property
    def places(self) -> FloatArray:
        """Nodes of all blocks in the reference, block after block, world axes, shape (b · nodes, d) [m]."""
        placed = turned(self.rotation, self.mesh.points)
        places: FloatArray = (placed + self.translation[:, None]).reshape(-1, self.dimension)
        return places

    def positions(self, state: S) -> FloatArray:
        """Where the nodes of all blocks are, block after block, world axes, shape (b · nodes, d) [m]."""
        world = self._turned(self.mesh.points + self._moved(state)) + self.translation[:, None]
        return world.reshape(-1, self.dimension)

    def displacements(self, state: S) -> FloatArray:
        """How far the nodes of all blocks have gone, world axes, shape (b · nodes, d) [m]."""
        return self._turned(self._moved(state)).reshape(-1, self.dimension)

    def velocities(self, state: S, place: S | None = None) -> FloatArray:
        """Velocity of the nodes, with the blocks as in ``place``, world axes, shape (b · nodes, d) [m/s]."""
        moving = self._moving(state, state if place is None else place)
        return self._turned(moving).reshape(-1, self.dimension)

    def _turned(self, local: FloatArray) -> FloatArray:
        """Vectors (b, nodes, d) from shape axes to world axes."""
        return turned(self.rotation, local)
