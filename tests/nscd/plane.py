"""Plane problems in split form: rigid walls, and blocks with a made-up compliance."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from masonry_fem.nscd.problem import ContactProblem
from tests.nscd import walls


def plane_problem(points, normals, owners, friction, load, *, mass=0.0, velocity=None, centres=None):
    """Rigid blocks in the plane, their velocities about ``centres`` (default: the origin), unit mass.

    ``owners`` are (candidate, antagonist) of each contact, −1 fixed; the tangent is the normal turned
    by −90°.
    """
    points, normals = np.asarray(points, float), np.asarray(normals, float)
    owners, load = np.asarray(owners), np.asarray(load, float)
    c, b = len(points), len(load)
    centres = np.zeros((b, 2)) if centres is None else np.asarray(centres, float)
    frames = np.stack([normals, np.stack([normals[:, 1], -normals[:, 0]], 1)], 1)
    maps = np.zeros((c, 2, 2, 3))
    for side, sign in enumerate((1.0, -1.0)):
        has = owners[:, side] >= 0
        arm = points[has] - centres[owners[has, side]]
        turn = np.stack([-arm[:, 1], arm[:, 0]], 1)
        maps[has, side] = sign * np.concatenate([frames[has], frames[has] @ turn[:, :, None]], axis=2)
    return ContactProblem(
        friction=np.broadcast_to(np.asarray(friction, float), (c,)).copy(),
        free_velocity=np.zeros((c, 2)),
        compliance=sparse.bsr_array(sparse.csr_array((2 * c, 2 * c)).tobsr((2, 2))),
        bodies=owners,
        rigid_map=maps,
        rigid_mass=np.full((b, 3), float(mass)),
        rigid_impulse=load,
        rigid_velocity=np.zeros((b, 3)) if velocity is None else np.asarray(velocity, float),
    )


def plane_wall(bricks=3, courses=3, *, friction=0.6, horizontal=0.1, mass=1.0):
    """Running-bond wall of rigid bricks 2 x 1, two points a joint, under its weight and a pull."""
    boxes = walls.running_bond(courses, 2.0 * bricks, (2.0, 1.0, 1.0))
    low = np.array([box[0] for box in boxes])[:, [0, 2]]
    size = np.array([box[1] for box in boxes])[:, [0, 2]]
    points, normals, owners = [], [], []
    for i, j, direction in walls.touching(boxes):
        axis = 1 if direction == 2 else 0
        other, k = 1 - axis, j if j >= 0 else i
        start = max(low[i, other], low[k, other])
        stop = min(low[i, other] + size[i, other], low[k, other] + size[k, other])
        for at in (start, stop):
            point = np.empty(2)
            point[axis], point[other] = low[i, axis], at
            points.append(point)
            normals.append(np.eye(2)[axis])
            owners.append((i, j))
    weight = size.prod(axis=1)
    load = np.stack([horizontal * weight, -weight, 0 * weight], axis=1)
    centres = low + size / 2
    return plane_problem(points, normals, owners, friction, load, mass=mass, centres=centres)


def soft(problem, seed=0, size=1e-6):
    """The same with a random compliance between all contacts."""
    generator = np.random.default_rng(seed)
    n = 2 * problem.count
    root = generator.normal(size=(n, n)) / np.sqrt(n)
    return ContactProblem(
        problem.friction,
        problem.free_velocity,
        sparse.bsr_array(size * (root @ root.T + 0.1 * np.eye(n)), blocksize=(2, 2)),
        problem.bodies,
        problem.rigid_map,
        problem.rigid_mass,
        problem.rigid_impulse,
        problem.rigid_velocity,
    )
