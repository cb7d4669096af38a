"""LimitProblem: rigid blocks on the contact points of a model, with constant and growing loads.

    problem = limit_problem(model, live=["points.*"])
    problem.equilibrium @ force + problem.dead + factor * problem.live      # 0: balanced
    mechanism_of(problem, velocity).sentence()    # "7 blocks move in 3 parts; 4 hinges: ..."

Forces are divided by the mean load of a block and lengths by the model's typical size, so that results do not
depend on units. All blocks are taken as rigid, whatever their fidelity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.rotation import lever, moment, spin_count
from masonry_fem.limit.strength import Strength, strength_of
from masonry_fem.march.coupling import SIGN, Placement, connect
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.motion import BlockMotion, PointMotion
from masonry_fem.march.recognition import recognise

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

OPEN = 1e-3  # of the typical size: a contact point with a larger gap bears nothing

AT_REST = 1e-6  # of the speed of the fastest corner: slower blocks are at rest


@dataclass(frozen=True, slots=True)
class Hold:
    """A point of a block that is held along one axis: a clamped face has some.

    Attributes
    ----------
    block : Its number. point : Where, shape (d,) [m]. axis : World axis. name : Of the support.
    """

    block: int
    point: FloatArray
    axis: int
    name: str


@dataclass(frozen=True, slots=True)
class LimitProblem:
    """A problem of limit analysis: b free blocks of m velocities each, c contact points, h holds.

    m is 3 in 2D and 6 in 3D. Forces and lengths are relative to ``force`` and ``length``.

    Attributes
    ----------
    model : The model that it was made of.
    blocks : Numbers of the free blocks, shape (b,).
    centre : Points about which their moments are taken, shape (b, d) [m].
    points : Contact points, shape (c, d) [m].
    frame : Their local frames, rows (n, t1[, t2]), shape (c, d, d).
    active : False where a contact point stands open, shape (c,).
    equilibrium : Forces on the free blocks, the moments over ``length``, of unit contact forces
        (component by component in the local frames) and unit holds, shape (b m, c d + h).
    dead, live : Loads that stay and loads that grow, over ``force``, shape (b m,).
    strength : Strengths of the contact points, over ``force``.
    holds : Points of free blocks that are held.
    force : Unit of forces [N].
    length : Unit of lengths [m].
    """

    model: Model
    blocks: IntArray
    centre: FloatArray
    points: FloatArray
    frame: FloatArray
    active: NDArray[np.bool_]
    equilibrium: sparse.csr_array
    dead: FloatArray
    live: FloatArray
    strength: Strength
    holds: tuple[Hold, ...]
    force: float
    length: float

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.points.shape[1])

    def load(self, factor: float) -> FloatArray:
        """Dead and ``factor`` times live load, over ``force``, shape (b m,)."""
        return self.dead + factor * self.live

    def reaction(self, force: FloatArray) -> FloatArray:
        """Contact forces of a solution in the local frames, shape (c, d) [N]."""
        count = self.points.size
        return self.force * force[:count].reshape(self.points.shape)


def limit_problem(
    model: Model,
    dead: Sequence[FloatArray] | None = None,
    live: Sequence[FloatArray] | None = None,
    *,
    bodies: Sequence[Any] | None = None,
    holds: Sequence[Hold] = (),
) -> LimitProblem:
    """The problem of limit analysis of a model, for ``admissible``, ``collapse_multiplier`` and ``interval``.

    Parameters
    ----------
    model : Blocks and contacts, such as ``result.built.model``.
    dead, live : Loads that stay and loads that grow, as one force array for each body group (None: no load);
        ``masonry_fem.limit.group_forces`` makes them from a model's loads.
    bodies : States of the groups; None: the undeformed structure.
    holds : Points of free blocks that are held along an axis.

    Raises
    ------
    LawError : A joint has no constant strength.
    """
    states = tuple(group.rest() for group in model.groups) if bodies is None else tuple(bodies)
    here = connect(model).placement(states)
    free = [group for group in model.groups if not group.prescribed]
    blocks = np.concatenate([group.blocks for group in free]) if free else np.zeros(0, np.int64)
    centre = _centres(model, here, blocks)
    wrenches = [_wrench(model, states, centre, blocks, forces) for forces in (dead, live)]
    d = here.points.shape[1]
    size = [float(np.linalg.norm(wrench[:, :d], axis=1).sum()) for wrench in wrenches]
    force = (max(size) or 1.0) / max(1, len(blocks))
    length = model.length
    scale = np.full(wrenches[0].shape[1], force)
    scale[d:] *= length
    active = here.gap <= OPEN * length
    strength = strength_of(model)
    return LimitProblem(
        model=model,
        blocks=blocks,
        centre=centre,
        points=here.points,
        frame=here.frame,
        active=active,
        equilibrium=_equilibrium(model, here, blocks, centre, active, tuple(holds), length),
        dead=(wrenches[0] / scale).ravel(),
        live=(wrenches[1] / scale).ravel(),
        strength=strength.scaled(force),
        holds=tuple(holds),
        force=force,
        length=length,
    )


def group_forces(model: Model, factors: Mapping[str, float]) -> list[FloatArray]:
    """Sum of some loads of a model, by body group.

    Parameters
    ----------
    model : Blocks and loads.
    factors : Factor of each load by name; loads that are not named are left out.
    """
    total = [group.acceleration_force(np.zeros(model.assembly.dimension)) for group in model.groups]
    for load in model.loads:
        for index, pattern in enumerate(load.forces):
            if pattern is not None and factors.get(load.name, 0.0):
                total[index] = total[index] + factors[load.name] * pattern
    return total


def _centres(model: Model, here: Placement, blocks: IntArray) -> FloatArray:
    """Mean of the contact points of each block, (b, d) [m]: near enough for moments to be well scaled."""
    every = len(model.assembly.blocks)
    total, count = np.zeros((every, here.points.shape[1])), np.zeros(every)
    for side in (0, 1):
        np.add.at(total, model.contacts.blocks[:, side], here.points)
        np.add.at(count, model.contacts.blocks[:, side], 1.0)
    centre: FloatArray = (total / np.maximum(count, 1.0)[:, None])[blocks]
    return centre


def _wrench(
    model: Model,
    states: tuple[Any, ...],
    centre: FloatArray,
    blocks: IntArray,
    forces: Sequence[FloatArray] | None,
) -> FloatArray:
    """Force and moment about the centres of the free blocks, shape (b, m) [N, N m]."""
    d = model.assembly.dimension
    if forces is None or not len(blocks):
        return np.zeros((len(blocks), 3 if d == 2 else 6))
    total = np.concatenate(
        [
            group.resultant(force, state)
            for group, state, force in zip(model.groups, states, forces, strict=True)
            if not group.prescribed
        ]
    )
    total[:, d:] -= moment(centre, total[:, :d])
    return total


def _equilibrium(
    model: Model,
    here: Placement,
    blocks: IntArray,
    centre: FloatArray,
    active: NDArray[np.bool_],
    holds: tuple[Hold, ...],
    length: float,
) -> sparse.csr_array:
    """Forces and moments on the free blocks of unit contact forces and holds, (b m, c d + h)."""
    c, d = here.points.shape
    m = 3 if d == 2 else 6
    row_of = np.full(len(model.assembly.blocks), -1)
    row_of[blocks] = np.arange(len(blocks))
    body = row_of[model.contacts.blocks]
    contact, side = np.nonzero((body >= 0) & active[:, None])
    own = body[contact, side]
    local = _unit_wrenches(here.points[contact] - centre[own], here.frame[contact], length)
    local *= SIGN[side, None, None]
    rows = np.broadcast_to((own[:, None] * m + np.arange(m))[:, None, :], local.shape)
    columns = np.broadcast_to((contact[:, None] * d + np.arange(d))[:, :, None], local.shape)
    parts = [(local.ravel(), rows.ravel(), columns.ravel())]
    for number, hold in enumerate(holds):
        at = row_of[hold.block]
        unit = np.eye(d)[None, hold.axis : hold.axis + 1]
        wrench = _unit_wrenches((hold.point - centre[at])[None], unit, length).ravel()
        parts.append((wrench, at * m + np.arange(m), np.full(m, c * d + number)))
    values, row, column = (np.concatenate(part) for part in zip(*parts, strict=True))
    matrix = sparse.csr_array((values, (row, column)), shape=(len(blocks) * m, c * d + len(holds)))
    matrix.sum_duplicates()
    return matrix


def _unit_wrenches(arms: FloatArray, directions: FloatArray, length: float) -> FloatArray:
    """Force and moment over ``length`` of unit forces along directions (k, r, d) at arms, (k, r, m)."""
    # lever(arm) takes a spin to the velocity at the arm: its transpose takes a force to its moment
    moments = directions @ lever(arms) / length
    return np.concatenate([directions, moments], axis=2)


def mechanism_of(problem: LimitProblem, velocity: FloatArray) -> Mechanism:
    """The mechanism that the dual velocities of a program describe.

    Parameters
    ----------
    problem : Blocks and contact points.
    velocity : Velocities and spins block by block, in the problem's units; what follows them is ignored.
    """
    d, assembly = problem.dimension, problem.model.assembly
    free = velocity[: len(problem.blocks) * (3 if d == 2 else 6)].reshape(len(problem.blocks), -1)
    count = len(assembly.blocks)
    motion = BlockMotion(
        centre=np.stack([assembly.solid(block).vertices.mean(axis=0) for block in range(count)]),
        velocity=np.zeros((count, d)),
        spin=np.zeros((count, spin_count(d))),
        held=~np.isin(np.arange(count), problem.blocks),
        corners=tuple(assembly.solid(block).vertices for block in range(count)),
    )
    motion.centre[problem.blocks] = problem.centre
    motion.velocity[problem.blocks] = free[:, :d]
    motion.spin[problem.blocks] = free[:, d:] / problem.length
    faces = problem.active & ~problem.model.contacts.tied
    points = PointMotion(problem.points, problem.frame, faces)
    return recognise(problem.model, motion, points, rest=AT_REST, friction=problem.strength.friction)
