"""Attachment: elastic blocks as the contact solver sees them.

The velocity of a contact point is interpolated from its facet's nodes, v = G u. Blocks of one shape whose
points have the same places in it share one W_el = G (M̂⁻¹)_el Gᵀ, which is computed once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np
from scipy import sparse

from masonry_fem.bodies.base import FloatArray, IntArray, Scheme, Sides
from masonry_fem.contact.interfaces import numbered
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.condense import DENSE_LIMIT, Compliance, coefficients
from masonry_fem.fem.locate import on_facets
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.modes import RigidModes
from masonry_fem.fem.reduction import ReducedCompliance
from masonry_fem.solid.mesh import Mesh

if TYPE_CHECKING:
    from masonry_fem.fem.deformable import Deformable, Deformed

AT_ONCE = 200  # contacts of a block that are condensed together
# Free dofs of a shape from which another process may make what it gives way by: 71 stones of 360 take two
# ranks 0.15 s for 0.21, of 630 0.41 s for 0.67, of 144 as long.
LEAST = 300
ALIKE = 1e-11  # equal weights and frames differ by this much, as poses have rounding errors


@dataclass(frozen=True, slots=True)
class _Known:
    """For the last scheme used: (M̂⁻¹)_el on the dofs that carry contacts, or W_el of each pattern."""

    key: tuple[float, float]
    surface: FloatArray | None = None
    patterns: tuple[FloatArray, ...] = ()


@dataclass(frozen=True, slots=True)
class Surface:
    """(M̂⁻¹)_el of a shape where contacts are, to be made by any process.

    Attributes
    ----------
    operators, modes, free, scheme : As for ``Compliance``. dofs : Those that carry contacts.
    """

    operators: ShapeOperators
    modes: RigidModes
    free: IntArray
    scheme: Scheme
    dofs: IntArray

    @property
    def cost(self) -> float:
        """Multiplications of a dense factor."""
        return float(len(self.free)) ** 2 * len(self.dofs)

    @property
    def numbers(self) -> int:
        """Those of what is made."""
        return len(self.dofs) ** 2 + min(len(self.free), DENSE_LIMIT) ** 2

    def made(self, *, here: bool) -> tuple[FloatArray, Compliance | None]:
        """The block of these dofs, and the factor unless it is a sparse one of another process."""
        factor = Compliance(self.operators, self.modes, self.free, self.scheme)
        return factor.block(self.dofs), factor if factor.dense or here else None


@dataclass(slots=True)
class ElasticAttachment[S: Deformed](ABC):
    """Elastic blocks seen through k contact sides.

    Attributes
    ----------
    group : The blocks. sides : Which contacts touch them, and where.
    carried : Weight of each node of the mesh in the motion of each contact, shape (k, nodes).
    carriers : All nodes that carry contacts, of any block, ascending.
    arms : The points from the centroids, shape axes, shape (k, d) [m].
    bodies : Blocks that have sides, shape (t,).
    order : Sides by block, shape (k,). start : First of those of each of these blocks, and k, shape (t + 1,).
    pattern : Number of the pattern of points that each of them has.
    """

    group: Deformable[S]
    sides: Sides
    carried: sparse.csr_array
    carriers: IntArray
    arms: FloatArray
    bodies: IntArray
    order: IntArray
    start: IntArray
    pattern: IntArray
    _interpolation: sparse.csr_array
    _known: _Known | None = field(default=None, repr=False)
    _shapes: FloatArray | None = field(default=None, repr=False)

    @classmethod
    def of(cls, group: Deformable[S], sides: Sides) -> Self:
        """Attach a group to sides."""
        count = len(sides.body)
        local = group.to_shape(sides.body, sides.point)
        carried = _carried(group.mesh, sides, local)
        order = np.argsort(sides.body, kind="stable")
        bodies, start = np.unique(sides.body[order], return_index=True)
        total = len(group.mesh.points)
        columns = carried.indices + np.repeat(sides.body * total, np.diff(carried.indptr))
        interpolation = sparse.csr_array(
            (carried.data, columns, carried.indptr), shape=(count, group.count * total)
        )
        return cls(
            group,
            sides,
            carried,
            np.unique(carried.indices).astype(np.int64),
            local - group.modes.centroid,
            bodies,
            order,
            np.append(start, count),
            _patterns(carried[order], np.append(start, count)),
            interpolation,
        )

    @abstractmethod
    def displacements(self, state: S) -> FloatArray:
        """How far the material points have gone, shape (k, d) [m]."""

    @abstractmethod
    def rotations(self, state: S) -> FloatArray:
        """How the blocks have turned since the reference configuration, shape (k, d, d)."""

    @abstractmethod
    def rigid_map(self, state: S, points: FloatArray, frames: FloatArray) -> FloatArray:
        """Velocity, in the frames, of the rigid part at ``points`` for unit U, shape (k, d, m)."""

    def elastic_velocity(self, elastic: FloatArray, seen: FloatArray) -> FloatArray:
        """Velocity, in the frames, that a nodal field (b, n) has at the points, shape (k, d)."""
        from masonry_fem.bodies.motions import by_block  # noqa: PLC0415 - Numba is slow to import

        world = by_block(self.group.rotation, self.sides.body, self._at_points(elastic))
        local: FloatArray = np.einsum("kij,kj->ki", seen, world)
        return local

    def spread(self, impulses: FloatArray, seen: FloatArray) -> FloatArray:
        """Nodal impulses Gᵀ p of signed side impulses (k, d) in the frames, shape (b, n) [N s]."""
        from masonry_fem.bodies.motions import by_block  # noqa: PLC0415 - Numba is slow to import

        world = np.einsum("kij,ki->kj", seen, impulses)
        back = np.ascontiguousarray(np.swapaxes(self.group.rotation, 1, 2))
        own = by_block(back, self.sides.body, world)
        nodal: FloatArray = (self._interpolation.T @ own).reshape(self.group.count, -1)
        return nodal

    def compliance(
        self, scheme: Scheme, seen: FloatArray, guess: S | None = None
    ) -> Sequence[tuple[IntArray, FloatArray]]:
        """W_el of each block that has sides; blocks that are alike share one (read-only) matrix."""
        if not len(self.bodies):
            return ()
        own = self._own_surfaces(scheme, guess)
        surface, local = self._surface_block(scheme), self._local(seen)
        digits = _digits(local)
        known: dict[tuple[int, bytes], FloatArray] = {}
        result = []
        for at, (body, pattern) in enumerate(zip(self.bodies.tolist(), self.pattern, strict=True)):
            rows = self._sides_of(at)
            if body in own:
                result.append((rows, self._condensed(rows, local[rows], own[body])))
                continue
            key = (int(pattern), digits[rows].tobytes())
            if key not in known:
                known[key] = self._condensed(rows, local[rows], surface)
            result.append((rows, known[key]))
        return result

    def kinds(
        self, scheme: Scheme, seen: FloatArray, guess: S | None = None
    ) -> Sequence[tuple[IntArray, FloatArray, FloatArray]]:
        """W_el by kinds of blocks that share a matrix: those of one pattern, and each that yields."""
        own = self._own_surfaces(scheme, guess)
        local, result = self._local(seen), []
        yields = np.isin(self.bodies, list(own))
        known = () if yields.all() else self._by_pattern(scheme)
        for pattern in np.unique(self.pattern[~yields]).tolist():
            alike = np.flatnonzero(~yields & (self.pattern == pattern))
            first, last = self.start[alike], self.start[alike[0] + 1]
            rows = self.order[first[:, None] + np.arange(last - first[0])]
            result.append((rows, local[rows], known[pattern]))
        for at in np.flatnonzero(yields).tolist():
            rows = self._sides_of(at)
            block = self._condensed(rows, self._unturned(rows), own[self.bodies[at]])
            result.append((rows[None], local[rows[None]], block))
        return result

    def making(self, scheme: Scheme) -> Surface | None:
        """(M̂⁻¹)_el where contacts are, for a scheme; None where it is known, or too cheap to be sent."""
        group, known = self.group, self._known
        if known is not None and known.key == coefficients(group.operators, scheme):
            return None
        small = len(group.free_dofs) < LEAST
        if small or group.modal or group.factored(scheme) or not len(self.bodies):
            return None
        return Surface(group.operators, group.modes, group.free_dofs, scheme, self._dofs)

    def take(self, scheme: Scheme, made: tuple[FloatArray, Compliance | None]) -> None:
        """Have what ``Surface`` has made."""
        surface, factor = made
        self._known = _Known(coefficients(self.group.operators, scheme), surface)
        if factor is not None:
            self.group.keep(scheme, factor)

    def unit_motions(self, scheme: Scheme, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Velocities, in the frames, of unit motions of reduced blocks, (k, d, K), and their mass, (b, K)."""
        factor = self.group.factor(scheme)
        assert isinstance(factor, ReducedCompliance)
        if self._shapes is None:
            d, count = self.group.dimension, len(factor.mass)
            of_nodes = factor.basis.modes.reshape(-1, d * count)
            self._shapes = np.asarray(self.carried @ of_nodes).reshape(-1, d, count)
        return self._local(seen) @ self._shapes, np.tile(factor.mass, (self.group.count, 1))

    # --- private ----------------------------------------------------------------------------------

    def _sides_of(self, at: int) -> IntArray:
        """Numbers of the sides of a block of ``bodies``."""
        return self.order[self.start[at] : self.start[at + 1]]

    def _local(self, frames: FloatArray) -> FloatArray:
        """Frames seen from the shape axes, shape (k, d, d)."""
        from masonry_fem.bodies.motions import turned_frames  # noqa: PLC0415 - Numba is slow to import

        turned: FloatArray = turned_frames(frames, self.group.rotation, self.sides.body)
        return turned

    def _unturned(self, rows: IntArray) -> FloatArray:
        """Frames that are the shape axes, for some sides."""
        return np.tile(np.eye(self.group.dimension), (len(rows), 1, 1))

    def _by_pattern(self, scheme: Scheme) -> tuple[FloatArray, ...]:
        """W_el in the shape axes of the blocks with each pattern; the surface's block is let go."""
        key = coefficients(self.group.operators, scheme)
        if self._known is None or self._known.key != key or not self._known.patterns:
            surface, first = self._surface_block(scheme), np.unique(self.pattern, return_index=True)[1]
            rows = map(self._sides_of, first.tolist())
            made = tuple(self._condensed(own, self._unturned(own), surface) for own in rows)
            self._known = _Known(key, patterns=made)
        return self._known.patterns

    def _at_points(self, nodal: FloatArray) -> FloatArray:
        """A nodal field (b, n) at the points, shape axes, shape (k, d)."""
        value: FloatArray = self._interpolation @ nodal.reshape(-1, self.group.dimension)
        return value

    def _own_surfaces(self, scheme: Scheme, guess: S | None) -> Mapping[int, FloatArray]:
        """(M̂_t⁻¹)_el on the dofs that carry contacts, of the blocks that yield in ``guess``."""
        tangents, touched = self.group.tangents(guess, scheme), set(self.bodies.tolist())
        return {body: one.block(self._dofs) for body, one in tangents.items() if body in touched}

    @property
    def _dofs(self) -> IntArray:
        """Those that carry contacts."""
        d = self.group.dimension
        return (self.carriers[:, None] * d + np.arange(d)).ravel()

    def _surface_block(self, scheme: Scheme) -> FloatArray:
        """(M̂⁻¹)_el on all dofs of the nodes that carry contacts, dense."""
        key = coefficients(self.group.operators, scheme)
        known = self._known
        if known is None or known.key != key or known.surface is None:
            self._known = None  # another one would take twice the memory
            known = self._known = _Known(key, self.group.factor(scheme).block(self._dofs))
        assert known.surface is not None
        return known.surface

    def _condensed(self, rows: IntArray, local: FloatArray, surface: FloatArray) -> FloatArray:
        """G C Gᵀ of one block's sides, C being the surface block; to rounding as symmetric as that."""
        d, count = self.group.dimension, len(rows)
        own = self.carried[rows]
        place = np.searchsorted(self.carriers, own.indices)
        blocks = own.data[:, None, None] * np.repeat(local, np.diff(own.indptr), axis=0)
        G = sparse.bsr_array((blocks, place, own.indptr), shape=(count * d, len(surface)))
        matrix = np.empty((count * d, count * d))
        for first in range(0, count, AT_ONCE):  # G C as a whole would be as large as the others
            last = min(first + AT_ONCE, count)
            some = slice(own.indptr[first], own.indptr[last])
            starts = own.indptr[first : last + 1] - own.indptr[first]
            part = sparse.bsr_array(
                (blocks[some], place[some], starts), shape=((last - first) * d, len(surface))
            )
            matrix[first * d : last * d] = (G @ (part @ surface).T).T
        matrix.flags.writeable = False
        return matrix


@dataclass(slots=True)
class SmallAttachment(ElasticAttachment[ElasticState]):
    """Blocks of small kinematics: rotations are frozen.

    Attributes
    ----------
    modes : Rigid modes at the points, shape axes, shape (k, d, m).
    """

    modes: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        modes, d = self.group.modes.modes, self.group.dimension
        of_nodes = modes.reshape(-1, d * modes.shape[1])
        self.modes = (self.carried @ of_nodes).reshape(-1, d, modes.shape[1])

    def displacements(self, state: ElasticState) -> FloatArray:
        """How far the material points have gone, shape (k, d) [m]."""
        rigid = np.einsum("kdm,km->kd", self.modes, state.rigid_displacement[self.sides.body])
        moved = rigid + self._at_points(state.displacement)
        world: FloatArray = np.einsum("kij,kj->ki", self.group.rotation[self.sides.body], moved)
        return world

    def rotations(self, state: ElasticState) -> FloatArray:
        """None, shape (k, d, d)."""
        d = self.group.dimension
        return np.tile(np.eye(d), (len(self.sides.body), 1, 1))

    def rigid_map(self, state: ElasticState, points: FloatArray, frames: FloatArray) -> FloatArray:
        """B = G Φ at the material points, shape (k, d, m); ``points`` makes no difference here."""
        turned: FloatArray = self._local(frames) @ self.modes
        return turned


def _carried(mesh: Mesh, sides: Sides, local: FloatArray) -> sparse.csr_array:
    """Weights of the mesh nodes in the motion of points at ``local`` (k, d) or of means, (k, nodes)."""
    many = np.zeros(len(local), dtype=bool) if sides.means is None else np.diff(sides.means.indptr) > 0
    nodes, weights = on_facets(mesh, sides.facet[~many], local[~many])
    shape = (len(local), len(mesh.points))
    pointers = np.append(0, np.cumsum(np.where(many, 0, nodes.shape[1])))
    points = sparse.csr_array((weights.ravel(), nodes.ravel(), pointers), shape=shape)
    if sides.means is None:
        return points
    return points + sparse.csr_array((sides.means.data, sides.means.indices, sides.means.indptr), shape=shape)


def _patterns(carried: sparse.csr_array, start: IntArray) -> IntArray:
    """Numbers of equal runs of rows, as they first come; ``start`` is where b runs begin, and the end.

    Returns
    -------
    Shape (b,).
    """
    digits = _digits(carried.data)
    begin = carried.indptr[start].astype(np.int64)
    sizes, of_size = np.unique(np.column_stack([np.diff(start), np.diff(begin)]), axis=0, return_inverse=True)
    found, total = np.empty(len(of_size), dtype=np.int64), 0
    for size, (rows, entries) in enumerate(sizes.tolist()):
        own = np.flatnonzero(of_size == size)
        at = begin[own][:, None] + np.arange(entries)
        ends = carried.indptr[start[own][:, None] + np.arange(rows + 1)] - begin[own][:, None]
        key = np.ascontiguousarray(np.hstack([ends, carried.indices[at], digits[at]]), dtype=np.int64)
        _, number = np.unique(key.view(np.dtype((np.void, key[0].nbytes))).ravel(), return_inverse=True)
        found[own] = number + total
        total = int(found[own].max()) + 1
    return numbered(found[:, None])[0]


def _digits(values: FloatArray) -> IntArray:
    """Values as whole numbers of ``ALIKE``: equal where they differ by rounding, −0 being 0."""
    return np.rint(values / ALIKE).astype(np.int64)
