"""Families of small contact problems, and changes of description that leave their mechanics alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import linalg, sparse

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.methods import make_method, names
from masonry_fem.nscd.problem import ContactProblem
from tests.nscd.plain_form import condensed
from tests.nscd.plane import plane_wall
from tests.nscd.walls import rigid_wall


def blocks(matrix, d):
    return sparse.bsr_array(sparse.csr_array(matrix), blocksize=(d, d))


def full_rank(rng, d):
    """A dense W of full rank between up to four contacts."""
    c = int(rng.integers(1, 5))
    root = rng.normal(size=(c * d, c * d))
    W = root @ root.T + 0.5 * c * d * np.eye(c * d)
    return ContactProblem.plain(W, rng.normal(size=(c, d)), rng.uniform(0, 0.8, c))


def low_rank(rng, friction, prescribed=False):
    """W of low rank in a plane, velocities that impulses can stop, and open gaps where ``prescribed``."""
    c = int(rng.integers(1, 12))
    root = rng.normal(size=(2 * c, int(rng.integers(1, 2 * c + 1))))
    q = (root @ rng.normal(size=root.shape[1])).reshape(c, 2)
    if prescribed:
        q[:, 0] += np.abs(rng.normal(size=c))
    return ContactProblem.plain(root @ root.T, q, friction)


def rigid(rng, d, mass):
    """A running-bond wall of five rigid blocks that stands."""
    pull = rng.uniform(0.0, 0.1)
    if d == 2:
        return plane_wall(2, 2, horizontal=pull, mass=mass)
    return rigid_wall(2, 2, horizontal=pull, inertia=mass, step=0.01)


def elastic(rng, d, mass):
    """The same wall, all contacts soft."""
    problem = rigid(rng, d, mass)
    n = problem.count * d
    root = rng.normal(size=(n, n)) / np.sqrt(n)
    size = 1e-6 * np.abs(problem.rigid_map).max() ** 2
    return replace(problem, compliance=blocks(size * (root @ root.T + 0.1 * np.eye(n)), d))


FAMILIES = {
    "plain": full_rank,
    "hyperstatic": lambda rng, d: condensed(rigid(rng, d, 1.0)),
    "rigid dynamics": lambda rng, d: rigid(rng, d, 1.0),
    "rigid statics": lambda rng, d: rigid(rng, d, 0.0),
    "elastic dynamics": lambda rng, d: elastic(rng, d, 1.0),
    "elastic statics": lambda rng, d: elastic(rng, d, 0.0),
}


def takes(method, problem):
    """Whether a method solves problems of this kind: some want inertia, one a plane."""
    try:
        make_method(method).init(problem, None)
    except ProblemError:
        return False
    return True


CASES = [
    (family, method, d)
    for family, made in FAMILIES.items()
    for method in (*names(), "auto")
    for d in (2, 3)
    if method == "auto" or takes(method, made(np.random.default_rng(0), d))
]


def rotation(rng, n):
    """A random orthogonal matrix (n, n)."""
    return np.linalg.qr(rng.normal(size=(n, n)))[0]


def turned(problem, rng):
    """Tangents turned in each contact's own frame, and the axes of all bodies: the problem, the frames."""
    d, c, m = problem.dimension, problem.count, problem.rigid_mass.shape[1]
    frames = np.zeros((c, d, d))
    frames[:, 0, 0] = 1.0
    for frame in frames:
        frame[1:, 1:] = rotation(rng, d - 1) if d == 3 else rng.choice([-1.0, 1.0])
    axes = rotation(rng, m)
    turn = linalg.block_diag(*frames)
    other = replace(
        problem,
        free_velocity=np.einsum("cij,cj->ci", frames, problem.free_velocity),
        compliance=blocks(turn @ problem.compliance.toarray() @ turn.T, d),
        rigid_map=frames[:, None] @ problem.rigid_map @ axes,
        rigid_impulse=problem.rigid_impulse @ axes,
        rigid_velocity=problem.rigid_velocity @ axes,
    )
    return other, frames


def in_units(problem, speed, mass):
    """Numbers of velocities times ``speed``, of masses times ``mass``; rigid modes stay mass-orthonormal."""
    motion = speed * np.sqrt(mass)
    return replace(
        problem,
        free_velocity=problem.free_velocity * speed,
        compliance=blocks(problem.compliance.toarray() / mass, problem.dimension),
        rigid_map=problem.rigid_map / np.sqrt(mass),
        rigid_impulse=problem.rigid_impulse * motion,
        rigid_velocity=problem.rigid_velocity * motion,
    )


def chosen(problem, contacts):
    """The contacts of a list, in its order; those listed twice touch twice."""
    d = problem.dimension
    rows = (np.asarray(contacts)[:, None] * d + np.arange(d)).ravel()
    return replace(
        problem,
        friction=problem.friction[contacts],
        free_velocity=problem.free_velocity[contacts],
        compliance=blocks(problem.compliance.toarray()[np.ix_(rows, rows)], d),
        bodies=problem.bodies[contacts],
        rigid_map=problem.rigid_map[contacts],
    )


def renumbered(problem, order):
    """Body ``order[k]`` becomes body k."""
    place = np.append(np.argsort(order), -1).astype(int)
    return replace(
        problem,
        bodies=place[problem.bodies],
        rigid_mass=problem.rigid_mass[order],
        rigid_impulse=problem.rigid_impulse[order],
        rigid_velocity=problem.rigid_velocity[order],
    )


def beside(one, other):
    """Two problems that do not touch, as one."""
    shifted = np.where(other.bodies >= 0, other.bodies + one.body_count, -1)
    names = ("friction", "free_velocity", "rigid_map", "rigid_mass", "rigid_impulse", "rigid_velocity")
    return ContactProblem(
        compliance=blocks(sparse.block_diag((one.compliance, other.compliance), format="csr"), one.dimension),
        bodies=np.concatenate([one.bodies, shifted]),
        **{name: np.concatenate([getattr(one, name), getattr(other, name)]) for name in names},
    )
