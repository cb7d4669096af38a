"""Small masonry problems in split form, built with NumPy alone: what the solvers are tested on.

``Structure`` holds hexahedral blocks (trilinear, 2 x 2 x 2 Gauss points) whose coinciding nodes
touch; ``wall``, ``cubes`` and ``arch`` make the references of validation A10, ``rigid_wall`` and
``slope`` structures of rigid bricks. Static by default (h = 1 s, so velocities are displacements).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise

import numpy as np
from scipy import linalg, sparse

from masonry_fem.nscd.problem import ContactProblem

GRAVITY = np.array([0.0, 0.0, -9.81])
DENSITY, YOUNG, POISSON = 2400.0, 10e9, 0.2
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


def elastic_matrix():
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = YOUNG / (2 * (1 + POISSON))
    C = np.diag([2 * shear] * 3 + [shear] * 3)
    C[:3, :3] += lame
    return C


@dataclass(frozen=True)
class Shape:
    """A meshed block in its own axes: dense K, M, rigid modes and elastic inverse."""

    nodes: np.ndarray
    cells: np.ndarray
    clamped: np.ndarray  # node mask
    K: np.ndarray = field(repr=False)
    M: np.ndarray = field(repr=False)
    modes: np.ndarray = field(repr=False)  # (3n, 6); (3n, 0) where clamped
    inverse: np.ndarray = field(repr=False)  # (M^-1)_el, (3n, 3n)


def grid(elements):
    nx, ny, nz = elements
    index = np.arange((nx + 1) * (ny + 1) * (nz + 1)).reshape(nx + 1, ny + 1, nz + 1)
    lattice = np.stack(np.meshgrid(*(np.linspace(0, 1, n + 1) for n in elements), indexing="ij"), -1)
    cells = np.stack([index[i : i + nx, j : j + ny, k : k + nz].ravel() for i, j, k in CORNERS], -1)
    return lattice.reshape(-1, 3), cells


def make_shape(nodes, cells, clamped=None, inertia=0.0):
    """Assemble K, M and invert M + K (inertia 1) or K (inertia 0) off the rigid modes."""
    n = len(nodes)
    clamped = np.zeros(n, bool) if clamped is None else clamped
    K, M = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, 3 * n))
    points = (np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T / np.sqrt(3) + 1) / 2
    dofs = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), -1)
    Ke = np.zeros((len(cells), 24, 24))
    Me = np.zeros((len(cells), 24, 24))
    for point in points:
        factor = np.where(CORNERS == 1, point, 1 - point)
        value = factor.prod(1)
        slope = np.stack(
            [np.where(CORNERS[:, a] == 1, 1, -1) * np.delete(factor, a, 1).prod(1) for a in range(3)], 1
        )
        J = np.einsum("ena,nb->eab", nodes[cells], slope)
        weight = np.linalg.det(J) / 8
        gradient = np.einsum("nb,eba->ena", slope, np.linalg.inv(J))
        B = np.zeros((len(cells), 6, 8, 3))
        for a in range(3):
            B[:, a, :, a] = gradient[:, :, a]
        for row, (a, b) in enumerate([(0, 1), (1, 2), (0, 2)], 3):
            B[:, row, :, a], B[:, row, :, b] = gradient[:, :, b], gradient[:, :, a]
        B = B.reshape(len(cells), 6, 24)
        Ke += np.einsum("e,eia,ij,ejb->eab", weight, B, elastic_matrix(), B, optimize=True)
        Me += DENSITY * weight[:, None, None] * np.kron(np.outer(value, value), np.eye(3))
    for element, ke, me in zip(dofs, Ke, Me, strict=True):
        K[np.ix_(element, element)] += ke
        M[np.ix_(element, element)] += me
    modes = np.zeros((3 * n, 0)) if clamped.any() else rigid_modes(nodes, M)
    effective = K + inertia * M
    free = ~np.repeat(clamped, 3)
    inverse = np.zeros_like(K)
    if clamped.any():
        inverse[np.ix_(free, free)] = linalg.inv(effective[np.ix_(free, free)], assume_a="pos")
    else:
        Mm = M @ modes
        inverse = linalg.inv(effective + np.trace(effective) / np.trace(M) * Mm @ Mm.T, assume_a="pos")
        inverse -= modes @ (Mm.T @ inverse)
        inverse -= (inverse @ Mm) @ modes.T
    return Shape(nodes, cells, clamped, K, M, modes, inverse)


def rigid_modes(nodes, M):
    """Mass-orthonormal translations and rotations of a mesh, (3n, 6)."""
    n = len(nodes)
    modes = np.zeros((n, 3, 6))
    centre = (M[::3, ::3].sum(0) @ nodes) / M[::3, ::3].sum()
    modes[:, :, :3] = np.eye(3)
    for a in range(3):
        modes[:, :, 3 + a] = np.cross(np.eye(3)[a], nodes - centre)
    modes = modes.reshape(3 * n, 6)
    return modes @ np.linalg.inv(np.linalg.cholesky(modes.T @ M @ modes)).T


@dataclass
class Structure:
    """Blocks (shape, rotation, translation) and the node pairs that touch."""

    blocks: list = field(default_factory=list)
    pairs: list = field(default_factory=list)  # (candidate, node, antagonist, node, frame); -1: floor
    forces: list = field(default_factory=list)  # nodal, block axes, (3n,)

    def add(self, shape, rotation=None, origin=(0.0, 0.0, 0.0)):
        R = np.eye(3) if rotation is None else rotation
        self.blocks.append((shape, R, np.asarray(origin, float)))
        acceleration = np.tile(R.T @ GRAVITY, len(shape.nodes))
        self.forces.append(shape.M @ acceleration)
        return len(self.blocks) - 1

    def positions(self, block):
        shape, R, origin = self.blocks[block]
        return shape.nodes @ R.T + origin

    def touch(self, candidate, antagonist, normal, origin):
        """Pair the coinciding nodes of two blocks (antagonist -1: the floor) on a plane."""
        normal = np.asarray(normal, float)
        first = (
            np.cross(normal, [0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else np.cross(normal, [1.0, 0.0, 0.0])
        )
        first /= np.linalg.norm(first)
        frame = np.stack([normal, first, np.cross(normal, first)])
        on = [self._on(block, normal, origin) for block in (candidate, antagonist)]
        if antagonist < 0:
            self.pairs += [(candidate, node, -1, -1, frame) for node in on[0]]
            return
        a, b = self.positions(candidate)[on[0]], self.positions(antagonist)[on[1]]
        near = np.linalg.norm(a[:, None] - b[None], axis=2) < 1e-7
        self.pairs += [
            (candidate, on[0][i], antagonist, on[1][j], frame) for i, j in zip(*np.nonzero(near), strict=True)
        ]

    def _on(self, block, normal, origin):
        if block < 0:
            return np.zeros(0, int)
        return np.nonzero(np.abs((self.positions(block) - origin) @ normal) < 1e-7)[0]

    def traction(self, block, area_weights, traction):
        """Add nodal forces: weights (n,) [m2] times a traction (3,) [Pa] in world axes."""
        _, R, _ = self.blocks[block]
        self.forces[block] = self.forces[block] + np.outer(area_weights, R.T @ np.asarray(traction)).ravel()

    def problem(self, friction=0.6, inertia=0.0, rigid=()):
        """The contact problem; blocks listed in ``rigid`` lose their compliance."""
        c = len(self.pairs)
        movable = [b for b, (shape, _, _) in enumerate(self.blocks) if shape.modes.shape[1]]
        number = {b: i for i, b in enumerate(movable)}
        bodies, rigid_map = np.full((c, 2), -1), np.zeros((c, 2, 3, 6))
        free, rows, columns, values = np.zeros((c, 3)), [], [], []
        sides = {}
        for contact, (a, na, b, nb, frame) in enumerate(self.pairs):
            for side, (block, node) in enumerate(((a, na), (b, nb))):
                if block >= 0:
                    sides.setdefault(block, []).append((contact, side, node, frame))
        for block, members in sides.items():
            shape, R, _ = self.blocks[block]
            contact = np.array([m[0] for m in members])
            side = np.array([m[1] for m in members])
            dofs = 3 * np.array([m[2] for m in members])[:, None] + np.arange(3)
            frames = np.stack([m[3] for m in members]) @ R * np.array([1.0, -1.0])[side][:, None, None]
            if block in number:
                bodies[contact, side] = number[block]
                rigid_map[contact, side] = np.einsum("kij,kjm->kim", frames, shape.modes[dofs])
            if block in rigid:
                continue
            field_ = (shape.inverse @ self.forces[block])[dofs]
            np.add.at(free, contact, np.einsum("kij,kj->ki", frames, field_))
            k = len(members)
            matrix = shape.inverse[np.ix_(dofs.ravel(), dofs.ravel())].reshape(k, 3, k, 3)
            matrix = np.einsum("aij,ajbl,bml->aibm", frames, matrix, frames, optimize=True)
            where = 3 * contact[:, None] + np.arange(3)
            rows.append(np.repeat(where.ravel(), 3 * k))
            columns.append(np.tile(where.ravel(), 3 * k))
            values.append((0.5 * (matrix + matrix.transpose(2, 3, 0, 1))).ravel())
        data = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))) if rows else None
        shape_ = (3 * c, 3 * c)
        compliance = sparse.coo_array(data, shape=shape_) if data else sparse.coo_array(shape_)
        return ContactProblem(
            friction=np.full(c, float(friction)),
            free_velocity=free,
            compliance=sparse.bsr_array(compliance.tocsr().tobsr((3, 3))),
            bodies=bodies,
            rigid_map=rigid_map,
            rigid_mass=np.full((len(movable), 6), float(inertia)),
            rigid_impulse=np.array([self.blocks[b][0].modes.T @ self.forces[b] for b in movable]).reshape(
                -1, 6
            ),
            rigid_velocity=np.zeros((len(movable), 6)),
        )

    def displacement(self, problem, impulse, rigid_velocity, block, point):
        """Displacement (world) of the node nearest to a point, from a solution."""
        shape, R, _ = self.blocks[block]
        force = self.forces[block].copy().reshape(-1, 3)
        for contact, (a, na, b, nb, frame) in enumerate(self.pairs):
            if a == block:
                force[na] += R.T @ frame.T @ impulse[contact]
            if b == block:
                force[nb] -= R.T @ frame.T @ impulse[contact]
        node = np.argmin(np.linalg.norm(self.positions(block) - point, axis=1))
        u = shape.inverse[3 * node : 3 * node + 3] @ force.ravel()
        if shape.modes.shape[1]:
            number = [b for b, (s, _, _) in enumerate(self.blocks) if s.modes.shape[1]].index(block)
            u = u + shape.modes[3 * node : 3 * node + 3] @ rigid_velocity[number]
        return R @ u


@cache
def _cube(divisions, inertia, *, clamped):
    lattice, cells = grid((divisions,) * 3)
    return make_shape(lattice, cells, clamped=lattice[:, 2] < 1e-9 if clamped else None, inertia=inertia)


def cubes(divisions=8, horizontal=0.3e6, vertical=1e6, *, inertia=0.0):
    """A10.1 to A10.3: a cube on a clamped cube, pressed and sheared on its top."""
    lattice, _ = grid((divisions,) * 3)
    structure = Structure()
    structure.add(_cube(divisions, inertia, clamped=True))
    structure.add(_cube(divisions, inertia, clamped=False), origin=(0, 0, 1.0))
    structure.touch(1, 0, (0, 0, 1.0), np.array([0, 0, 1.0]))
    line = np.ones(divisions + 1) / divisions
    line[[0, -1]] /= 2
    index = np.rint(lattice * divisions).astype(int)
    weights = np.where(lattice[:, 2] > 1 - 1e-9, line[index[:, 0]] * line[index[:, 1]], 0.0)
    structure.traction(1, weights, (horizontal, 0.0, -vertical))
    return structure


def running_bond(courses, length, brick):
    """Boxes (low corner, size) of a wall with half bricks at the ends of every other course."""
    L, T, H = brick
    boxes = []
    for course in range(courses):
        half = course % 2 == 1
        edges = np.arange(0, length + 1e-9, L) if not half else np.r_[0, np.arange(L / 2, length, L), length]
        boxes += [((a, 0.0, course * H), (b - a, T, H)) for a, b in pairwise(edges)]
    return boxes


def touching(boxes):
    """Pairs of boxes that share part of a face: (upper or right one, other or -1 for the floor, axis)."""
    low = np.array([b[0] for b in boxes])
    high = low + np.array([b[1] for b in boxes])
    found = []
    for axis, other in ((2, 0), (0, 2)):
        order = np.argsort(high[:, axis], kind="stable")
        first, last = (
            np.searchsorted(high[order, axis], low[:, axis] + gap, side)
            for gap, side in ((-1e-9, "left"), (1e-9, "right"))
        )
        counts = last - first
        upper = np.repeat(np.arange(len(boxes)), counts)
        lower = order[np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts - first, counts)]
        overlap = np.minimum(high[upper, other], high[lower, other]) - np.maximum(
            low[upper, other], low[lower, other]
        )
        keep = overlap > 1e-9
        found += [(int(i), int(j), axis) for i, j in zip(upper[keep], lower[keep], strict=True)]
    found += [(int(i), -1, 2) for i in np.flatnonzero(low[:, 2] < 1e-9)]
    last = len(boxes)
    return sorted(found, key=lambda pair: (pair[0], pair[1] if pair[1] >= 0 else last, -pair[2]))


def wall(courses=5, length=2.0, elements=(4, 2, 2), brick=(0.5, 0.25, 0.25), *, inertia=0.0):
    """A10.4: a running-bond wall of elastic bricks on a rigid floor."""
    structure, shapes = Structure(), {}
    boxes = running_bond(courses, length, brick)
    for corner, size in boxes:
        half = size[0] < brick[0] - 1e-9
        if half not in shapes:
            lattice, cells = grid((elements[0] // 2 if half else elements[0], *elements[1:]))
            shapes[half] = make_shape(lattice * np.array(size), cells, inertia=inertia)
        structure.add(shapes[half], origin=corner)
    for i, j, axis in touching(boxes):
        structure.touch(i, j, np.eye(3)[axis], np.array(boxes[i][0]))
    return structure


def arch(voussoirs=11, elements=(8, 8, 8), radius=5.0, thickness=0.75, width=0.75, *, inertia=0.0):
    """A semicircular arch of exact sectors whose springings rest on a rigid floor."""
    angle = np.pi / voussoirs
    lattice, cells = grid(elements)
    r = radius + thickness * (lattice[:, 0] - 0.5)
    turn = angle * (lattice[:, 2] - 0.5)
    nodes = np.stack([r * np.cos(turn), width * lattice[:, 1], r * np.sin(turn)], -1)
    shape = make_shape(nodes, cells, inertia=inertia)
    structure = Structure()
    for k in range(voussoirs):
        phi = angle * (k + 0.5)
        R = np.array([[np.cos(phi), 0, -np.sin(phi)], [0, 1, 0], [np.sin(phi), 0, np.cos(phi)]])
        structure.add(shape, R)
    for k in range(voussoirs + 1):
        phi = angle * k
        normal = np.array([-np.sin(phi), 0, np.cos(phi)])
        if k == voussoirs:
            structure.touch(k - 1, -1, -normal, np.zeros(3))
        else:
            structure.touch(k, k - 1, normal, np.zeros(3))
    return structure


def rigid_boxes(boxes, contacts, *, friction, acceleration, inertia=1.0, step=1.0, density=2000.0):
    """Problem of rigid boxes with 4 corner points on each common rectangle; floor antagonist -1."""
    low = np.array([b[0] for b in boxes])
    size = np.array([b[1] for b in boxes])
    mass = density * size.prod(1)
    square = size**2
    moments = mass[:, None] / 12 * (square.sum(1)[:, None] - square)
    i, j, axis = np.array(contacts).T
    other = np.where(j >= 0, j, i)
    high = low + size
    corners = np.stack([np.maximum(low[i], low[other]), np.minimum(high[i], high[other])])
    pair = np.arange(len(i))
    corners[:, pair, axis] = low[i, axis]
    # the four corners of the common rectangle: either end of both axes in its plane
    picks = np.array(list(np.ndindex(2, 2)))
    pick = np.zeros((len(i), 4, 3), dtype=int)
    for normal in range(3):
        tangents = [a for a in range(3) if a != normal]
        pick[axis == normal, :, tangents[0]], pick[axis == normal, :, tangents[1]] = picks.T
    points = corners[pick, pair[:, None, None], np.arange(3)].reshape(-1, 3)
    frames = np.repeat(np.eye(3)[(axis[:, None] + np.arange(3)) % 3], 4, axis=0)
    bodies = np.repeat(np.stack([i, j], axis=1), 4, axis=0)
    maps = np.zeros((len(points), 2, 3, 6))
    for side, sign in enumerate((1.0, -1.0)):
        has = bodies[:, side] >= 0
        block = bodies[has, side]
        arm = points[has] - low[block] - size[block] / 2
        turn = np.cross(np.eye(3)[None], arm[:, None]).transpose(0, 2, 1)
        maps[has, side, :, :3] = sign * frames[has] / np.sqrt(mass[block])[:, None, None]
        maps[has, side, :, 3:] = sign * frames[has] @ (turn / np.sqrt(moments[block])[:, None])
    c = len(bodies)
    impulse = np.zeros((len(boxes), 6))
    impulse[:, :3] = step * np.sqrt(mass)[:, None] * np.asarray(acceleration, float)
    return ContactProblem(
        friction=np.full(c, float(friction)),
        free_velocity=np.zeros((c, 3)),
        compliance=sparse.bsr_array(sparse.csr_array((3 * c, 3 * c)).tobsr((3, 3))),
        bodies=bodies,
        rigid_map=maps,
        rigid_mass=np.full((len(boxes), 6), float(inertia)),
        rigid_impulse=impulse,
        rigid_velocity=np.zeros((len(boxes), 6)),
    )


def rigid_wall(bricks=10, courses=8, *, friction=0.6, horizontal=0.1, inertia=1.0, step=1.0):
    """Running-bond wall of rigid bricks, .4 x .2 x .2, under gravity and ``horizontal`` g along x."""
    boxes = running_bond(courses, 0.4 * bricks, (0.4, 0.2, 0.2))
    pull = GRAVITY + np.array([9.81 * horizontal, 0, 0])
    return rigid_boxes(
        boxes, touching(boxes), friction=friction, acceleration=pull, inertia=inertia, step=step
    )
