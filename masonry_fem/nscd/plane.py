"""PlaneForm: rigid blocks that move in one plane only, as a problem in that plane.

A wall under loads along its face is a plane problem, whatever it is drawn in. Contacts that lie one
behind the other move alike; where equal impulses of theirs turn no block out of the plane, one contact
stands for them, and a solution in the plane is one in space.

    form = plane_form(problem)              # None: it moves in space
    flat = form.problem                     # d = 2, m = 3
    solution = iterate(problem, InPlane(InteriorPoint(), form), settings)
    p = form.impulse(flat_impulse); flat_p = form.flat_impulse(p)

Nothing but the problem is asked: the plane is what all normals and all loads lie in, a block's spin in it
what none of its points leaves the plane by.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.iterate import Iterate, Method, Run
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.scaling import free_speed
from masonry_fem.nscd.settings import SolverSettings, Start

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# What is zero beside the largest of its kind, at most; as a square where directions are sought.
ZERO = 1e-9
SQUARE = 1e-14
# Share of a solver's tolerance that the part out of the plane may have.
HIDDEN = 0.01


@dataclass(frozen=True, slots=True)
class PlaneForm:
    """A problem's form in its plane.

    Attributes
    ----------
    problem : The plane problem: k contacts, b bodies of two translations and a spin.
    member : Plane contact of each contact, shape (c,).
    share : What of its plane contact's impulse a contact bears, shape (c,).
    along : In-plane tangent in each contact's two tangents, shape (c, 2).
    modes : Orthonormal motions of each body in the plane, shape (b, 6, 3).
    """

    problem: ContactProblem
    member: IntArray
    share: FloatArray
    along: FloatArray
    modes: FloatArray

    def impulse(self, flat: FloatArray) -> FloatArray:
        """Impulses in space of impulses in the plane (k, 2), shape (c, 3)."""
        own = self.share[:, None] * flat[self.member]
        return np.concatenate([own[:, :1], own[:, 1:] * self.along], axis=1)

    def flat_impulse(self, impulse: FloatArray) -> FloatArray:
        """What impulses (c, 3) amount to in the plane, shape (k, 2)."""
        total = np.zeros((self.problem.count, 2))
        tangent = (impulse[:, 1:] * self.along).sum(axis=1)
        np.add.at(total, self.member, np.stack([impulse[:, 0], tangent], axis=1))
        return total

    def velocity(self, flat: FloatArray) -> FloatArray:
        """Rigid velocities in space of those in the plane (b, 3), shape (b, 6)."""
        velocity: FloatArray = np.einsum("bmj,bj->bm", self.modes, flat)
        return velocity

    def flat_velocity(self, velocity: FloatArray) -> FloatArray:
        """The part in the plane of rigid velocities (b, 6), shape (b, 3)."""
        flat: FloatArray = np.einsum("bmj,bm->bj", self.modes, velocity)
        return flat


def plane_form(problem: ContactProblem, tolerance: float = 1e-10) -> PlaneForm | None:
    """The problem's form in its plane; None where it has none.

    Only problems of rigid blocks with inertia in 3D, without cohesion, have one.

    Parameters
    ----------
    problem : The contact problem.
    tolerance : Error that the problem is to be solved to, in which what is left out must not show.
    """
    zero = min(ZERO, HIDDEN * tolerance)
    frames = _frames(problem) if _eligible(problem) else None
    if frames is None or not _stays(problem, frames, zero):
        return None
    along = frames.along
    rows = np.stack([problem.rigid_map[:, :, 0], _along(problem, along)], axis=2)
    flat, off = _by(problem, rows, frames.inside), _by(problem, rows, frames.outside)
    free = np.stack([problem.free_velocity[:, 0], (problem.free_velocity[:, 1:] * along).sum(axis=1)], axis=1)
    first, member = _alike(problem, flat, free, 10 * zero)
    share = 1.0 / np.bincount(member)[member]
    lost = np.zeros((len(first), *off.shape[1:]))  # what equal impulses give out of the plane
    np.add.at(lost, member, share[:, None, None, None] * off)
    if np.abs(lost).max() > zero * np.abs(flat).max():
        return None
    k = len(first)
    reduced = ContactProblem(
        friction=problem.friction[first],
        free_velocity=free[first],
        compliance=sparse.bsr_array((2 * k, 2 * k), blocksize=(2, 2)),
        bodies=problem.bodies[first],
        rigid_map=np.ascontiguousarray(flat[first]),
        rigid_mass=np.ascontiguousarray(problem.rigid_mass[:, :3]),
        rigid_impulse=np.einsum("bm,bmj->bj", problem.rigid_impulse, frames.inside),
        rigid_velocity=np.einsum("bm,bmj->bj", problem.rigid_velocity, frames.inside),
    )
    return PlaneForm(reduced, member, share, along, frames.inside)


@dataclass(frozen=True, slots=True)
class _Frames:
    """Directions in and out of the plane: contacts' tangents (c, 2), bodies' motions (b, 6, 3)."""

    along: FloatArray
    across: FloatArray
    inside: FloatArray
    outside: FloatArray


def _eligible(problem: ContactProblem) -> bool:
    """True for dry contacts of rigid blocks, each of which resists all motions alike."""
    if problem.dimension != 3 or not problem.count or not problem.rigid or problem.cohesive:
        return False
    mass = problem.rigid_mass
    touched = (problem.bodies >= 0).any(axis=1).all()
    return bool(touched and (mass > 0).all() and np.ptp(mass, axis=1).max() <= ZERO * mass.max())


def _frames(problem: ContactProblem) -> _Frames | None:
    axis = _axis(problem)
    tangents = None if axis is None else _tangents(problem, axis)
    if axis is None or tangents is None:
        return None
    along, across = tangents
    spin = _spins(problem, across)
    return None if spin is None else _Frames(along, across, *_modes(axis, spin))


def _axis(problem: ContactProblem) -> FloatArray | None:
    """The direction that no normal and no load has a part in, shape (3,)."""
    contact, side = np.nonzero(problem.bodies >= 0)
    normals = problem.rigid_map[contact, side, 0, :3]
    length = np.linalg.norm(normals, axis=1)
    if not (length > 0).all():
        return None
    normals = normals / length[:, None]
    loads = (problem.rigid_impulse + problem.rigid_mass * problem.rigid_velocity)[:, :3]
    size = np.linalg.norm(loads, axis=1).max(initial=0.0)
    loads = loads / size if size > 0 else loads
    values, vectors = np.linalg.eigh(normals.T @ normals / len(normals) + loads.T @ loads / len(loads))
    if values[0] > SQUARE * values[2] or values[1] <= SQUARE * values[2]:
        return None
    axis: FloatArray = vectors[:, 0]
    return axis


def _tangents(problem: ContactProblem, axis: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Tangents in and out of the plane, in each contact's own two, shape (c, 2) each."""
    side = np.argmax(problem.bodies >= 0, axis=1)
    own = problem.rigid_map[np.arange(problem.count), side][:, :, :3]
    across = own[:, 1:] @ axis
    length = np.linalg.norm(across, axis=1)
    if not (length > ZERO * np.abs(own).max()).all():
        return None
    across = across / length[:, None]
    along = np.stack([across[:, 1], -across[:, 0]], axis=1)
    # the same sense for all contacts of a normal: along axis × n
    sense = ((along[:, None] @ own[:, 1:])[:, 0] * np.cross(axis, own[:, 0])).sum(axis=1)
    return np.where(sense < 0, -1.0, 1.0)[:, None] * along, across


def _along(problem: ContactProblem, tangent: FloatArray) -> FloatArray:
    """Rows of the rigid map along given tangents, shape (c, 2, m)."""
    rows: FloatArray = np.einsum("cj,csjm->csm", tangent, problem.rigid_map[:, :, 1:])
    return rows


def _spins(problem: ContactProblem, across: FloatArray) -> FloatArray | None:
    """The spin of each body that moves no contact point of its out of the plane, shape (b, 3)."""
    contact, side = np.nonzero(problem.bodies >= 0)
    out = _along(problem, across)[contact, side, 3:]
    square = np.zeros((problem.body_count, 3, 3))
    np.add.at(square, problem.bodies[contact, side], out[:, :, None] * out[:, None, :])
    values, vectors = np.linalg.eigh(square)
    touched = values[:, 2] > 0
    if (values[touched, 0] > SQUARE * values[touched, 2]).any():
        return None
    if (values[touched, 1] <= SQUARE * values[touched, 2]).any():
        return None  # all its points in one line through its centre
    spins: FloatArray = vectors[:, :, 0]
    return spins


def _modes(axis: FloatArray, spin: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Orthonormal motions of each body in the plane, and out of it, shape (b, 6, 3) each."""
    smallest = np.eye(3)[np.argmin(np.abs(axis))]
    one = np.cross(axis, smallest)
    one /= np.linalg.norm(one)
    frames = np.linalg.svd(spin[:, None, :])[2]  # its first row is ± the spin
    inside, outside = np.zeros((len(spin), 6, 3)), np.zeros((len(spin), 6, 3))
    inside[:, :3, 0], inside[:, :3, 1], inside[:, 3:, 2] = one, np.cross(axis, one), spin
    outside[:, :3, 0], outside[:, 3:, 1:] = axis, frames[:, 1:].transpose(0, 2, 1)
    return inside, outside


def _by(problem: ContactProblem, rows: FloatArray, modes: FloatArray) -> FloatArray:
    """Rows (c, 2, r, m) of the rigid map by given motions of the bodies, zero at supports, (c, 2, r, j)."""
    padded = np.concatenate([modes, np.zeros((1, *modes.shape[1:]))])  # supports are numbered -1
    product: FloatArray = rows @ padded[problem.bodies]
    return product


def _stays(problem: ContactProblem, frames: _Frames, zero: float) -> bool:
    """True where no load, velocity or prescribed motion leads out of the plane."""
    gained, kept = problem.rigid_impulse, problem.rigid_mass * problem.rigid_velocity
    size = max(np.abs(gained).max(), np.abs(kept).max())
    for given in (gained, kept):
        if np.abs(np.einsum("bm,bmj->bj", given, frames.outside)).max() > zero * size:
            return False
    across = (problem.free_velocity[:, 1:] * frames.across).sum(axis=1)
    return bool(np.abs(across).max() <= zero * free_speed(problem))


def _alike(
    problem: ContactProblem, flat: FloatArray, free: FloatArray, near: float
) -> tuple[IntArray, IntArray]:
    """First contact of each set that moves alike in the plane, and each contact's set."""
    c = problem.count
    parts = [problem.bodies.astype(float)]
    for values, size in (
        (flat.reshape(c, -1), np.abs(flat).max()),
        (free, free_speed(problem)),
        (problem.friction[:, None], problem.friction.max()),
    ):
        # + 0.0 as -0.0 is another number to a sort
        parts.append(np.round(values / (near * size)) + 0.0 if size > 0 else values)
    _, first, member = np.unique(
        np.concatenate(parts, axis=1), axis=0, return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[member.ravel()]


@dataclass(frozen=True, slots=True)
class InPlane:
    """A method that solves a problem in space in its plane.

    Attributes
    ----------
    inner : The method in the plane.
    form : The problem's form there.
    """

    inner: Method
    form: PlaneForm

    @property
    def name(self) -> str:
        """The inner method's."""
        return self.inner.name

    @property
    def iterations(self) -> int:
        """The inner method's own limit."""
        return self.inner.iterations

    def init(self, problem: ContactProblem, start: Start | None) -> InPlaneRun:
        """A run on the problem that the form was made of."""
        if start is not None:
            given, velocity = start.impulse, start.rigid_velocity
            start = Start(
                None if given is None else self.form.flat_impulse(given),
                None if velocity is None else self.form.flat_velocity(velocity),
            )
        return InPlaneRun(self.inner.init(self.form.problem, start), self.form)


class InPlaneRun:
    """A run in the plane, its offers those in space."""

    def __init__(self, run: Run, form: PlaneForm) -> None:
        self._run, self._form = run, form

    def guess(self) -> Iterate:
        """Where it starts."""
        return self._in_space(self._run.guess())

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """The inner run's next offer; ``quality`` is in space."""
        return self._in_space(self._run.step(quality, settings))

    def _in_space(self, offer: Iterate) -> Iterate:
        impulse, velocity = self._form.impulse(offer.impulse), self._form.velocity(offer.rigid_velocity)
        return replace(offer, impulse=impulse, rigid_velocity=velocity)
