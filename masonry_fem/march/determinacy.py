"""ForceDeterminacy: which forces in a structure are facts, and which a choice among many.

    told = determine(model, march.last)
    told.determined[k], told.resultant[k]     # of interface k: normal, tangents, moments
    told.state                                # the same state with the reactions of least norm

Resultants are taken in an interface's own frame, at the mean of its points; those of supports in
world axes about the origin. ``nscd.determinacy`` says what determined means.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import FloatArray
from masonry_fem.march.acting import contact_wrenches
from masonry_fem.march.conditions import contact_status
from masonry_fem.march.measure import support_resultants
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.march.ties import taut_sticks
from masonry_fem.nscd.determinacy import determined_resultants, least_norm_reaction
from masonry_fem.nscd.solution_set import SolutionSet, solution_set

Mask = NDArray[np.bool_]

COMPONENTS = {
    2: ("normal", "tangent", "moment"),
    3: ("normal", "tangent_1", "tangent_2", "moment_normal", "moment_tangent_1", "moment_tangent_2"),
}


@dataclass(frozen=True, slots=True)
class ForceDeterminacy:
    """What is known of the forces in a state of i interfaces; r = 3 components in 2D, 6 in 3D.

    Attributes
    ----------
    state : The state with the reactions of least norm.
    resultant : Force on the candidate [N] and moment [N m] of each interface, ``COMPONENTS``, (i, r).
    determined : True where every solution has the same, (i, r).
    unique : Contacts whose reaction is the same in every solution, (c,).
    supports : By name: force and moment about the origin that a support gives to the blocks, (r,).
    supports_determined : The same for them, by name, (r,).
    error : Of the least-norm reactions, ``Quality.error``.
    least_norm : False where the way to them broke off, and the reactions are those of the solver.
    """

    state: SystemState
    resultant: FloatArray
    determined: Mask
    unique: Mask
    supports: dict[str, FloatArray]
    supports_determined: dict[str, Mask]
    error: float
    least_norm: bool


def determine(model: Model, made: Increment) -> ForceDeterminacy:
    """What the last step of a march determines.

    Parameters
    ----------
    model : The structure, as ``made`` was made with it.
    made : A step whose contact problem was solved, with what acts on the blocks in its state.
    """
    problem, solution, active = made.problem, made.solution, made.contacts
    found = solution_set(problem, solution)
    least = least_norm_reaction(problem, solution, solutions=found)
    reaction = np.zeros_like(made.after.reaction)
    reaction[active] = least.impulse / made.scheme.step
    friction = np.zeros(len(reaction))
    friction[active] = problem.friction
    status = taut_sticks(model, contact_status(made.scheme.step * reaction, friction))
    state = replace(made.after, reaction=reaction, status=status)
    rows, number = _interface_rows(model, made), model.contacts.interface
    known = determined_resultants(problem, solution, number[active], rows[active], solutions=found)
    determined = np.ones((len(model.interfaces), rows.shape[1]), dtype=bool)
    determined[known.interface] = known.determined
    unique = np.ones(len(reaction), dtype=bool)
    unique[active] = known.unique
    resultant = np.zeros(determined.shape)
    np.add.at(resultant, number, (rows @ reaction[:, :, None])[:, :, 0])
    assert state.acting is not None
    contact = contact_wrenches(model.contacts.blocks, state.acting.arms, state.force, len(state.acting.size))
    supports = support_resultants(model, made, contact)
    return ForceDeterminacy(
        state,
        resultant,
        determined,
        unique,
        supports,
        _supports_determined(model, made, found, tuple(supports)),
        least.quality.error,
        least.attained,
    )


def _supports_determined(
    model: Model, made: Increment, found: SolutionSet, names: tuple[str, ...]
) -> dict[str, Mask]:
    """By support: which components of force and moment about the origin are determined.

    What clamps inside an elastic block give follows from its deformation, so it is.
    """
    r = len(COMPONENTS[model.assembly.dimension])
    known = {name: np.ones(r, dtype=bool) for name in names}
    held = np.zeros(len(model.assembly.blocks), dtype=bool)
    for group in model.groups:
        held[group.blocks] = group.prescribed
    blocks = model.contacts.blocks[made.contacts]
    side = held[blocks].argmax(axis=1)
    support = np.where(held[blocks].any(axis=1), blocks[np.arange(len(blocks)), side], -1)
    sign = np.where(side == 0, -1.0, 1.0)
    rows = sign[:, None, None] * _world_rows(made)[made.contacts]
    told = determined_resultants(made.problem, made.solution, support, rows, solutions=found)
    for block, determined in zip(told.interface.tolist(), told.determined, strict=True):
        if block >= 0:
            known[model.assembly.blocks.names[block]] = determined
    return known


def _interface_rows(model: Model, made: Increment) -> FloatArray:
    """Rows that make each contact's share of its interface's resultant, (c, r, d)."""
    frame, points = made.here.frame, made.here.points
    number = model.contacts.interface
    count = len(model.interfaces)
    many = np.maximum(np.bincount(number, minlength=count), 1)
    centre = np.zeros((count, points.shape[1]))
    np.add.at(centre, number, points)
    centre /= many[:, None]
    first = np.zeros(count, dtype=np.int64)
    first[number[::-1]] = np.arange(len(number))[::-1]
    axes = frame[first][number]  # of the interface, that of its first point
    world = frame.transpose(0, 2, 1)
    force = axes @ world
    arm = points - centre[number]
    turned = _moments(arm, world)
    moment = turned if points.shape[1] == 2 else axes @ turned
    return np.concatenate([force, moment], axis=1)


def _world_rows(made: Increment) -> FloatArray:
    """The same in world axes about the origin, (c, r, d)."""
    world = made.here.frame.transpose(0, 2, 1)
    return np.concatenate([world, _moments(made.here.points, world)], axis=1)


def _moments(arm: FloatArray, forces: FloatArray) -> FloatArray:
    """Moments of forces that are columns (c, d, k) at arms (c, d), shape (c, 1 | 3, k)."""
    if arm.shape[1] == 2:
        return arm[:, :1, None] * forces[:, 1:2] - arm[:, 1:, None] * forces[:, :1]
    return np.cross(arm[:, :, None], forces, axis=1)
