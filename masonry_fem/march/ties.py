"""Ties: which contacts are ties, what they bear, and a structure without them.

told = tie_forces(model, state)                 # names, forces, elongations
model, state = without_ties(model, state)       # for what is said of faces
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.update import chosen
from masonry_fem.joints.assignment import Assignment
from masonry_fem.joints.law import Pull
from masonry_fem.joints.state import JointState
from masonry_fem.march.model import FloatArray, Model
from masonry_fem.march.state import SLIP, STICK, SystemState


@dataclass(frozen=True, slots=True)
class TieForces:
    """What the k straight parts of ties bear in a state.

    Attributes
    ----------
    contacts : Their numbers among the contacts, shape (k,).
    names : Of the parts.
    ends : Where they begin and end, shape (k, 2, d) [m].
    force : T ≥ 0, shape (k,) [N].
    stress : T/A, shape (k,) [Pa].
    elongation : L − L_0 from the length without force; less than 0 where it is slack, shape (k,) [m].
    strain : The same over L_0, shape (k,).
    plastic : Part of it that stays without force, shape (k,).
    utilisation : T over the force at which it yields further; 0 where it never does, shape (k,).
    yields : Whether it may, shape (k,).
    snapped : Whether it has, shape (k,).
    """

    contacts: NDArray[np.int64]
    names: tuple[str, ...]
    ends: FloatArray
    force: FloatArray
    stress: FloatArray
    elongation: FloatArray
    strain: FloatArray
    plastic: FloatArray
    utilisation: FloatArray
    yields: NDArray[np.bool_]
    snapped: NDArray[np.bool_]


def _parts(laws: Assignment) -> Iterator[tuple[Pull, NDArray[np.int64]]]:
    """Laws of ties and their contacts."""
    for law, points in laws.parts:
        if law.pull is not None:
            yield law.pull, points


def snapped_ties(model: Model, joints: JointState) -> NDArray[np.bool_]:
    """Contacts that were ties, which have snapped, shape (c,).

    Parameters
    ----------
    model : The structure of c contacts. joints : State of their laws.
    """
    gone = np.zeros(model.contacts.count, dtype=bool)
    for law, points in _parts(model.laws):
        gone[points] = law.snapped(joints.take(points))
    return gone


def taut_sticks(model: Model, status: NDArray[np.int8]) -> NDArray[np.int8]:
    """Status of contacts with ties that are taut as sticking: they have no friction to slide against, (c,).

    Parameters
    ----------
    model : The structure of c contacts. status : As friction has it, shape (c,).
    """
    return np.where(model.contacts.tied & (status == SLIP), np.int8(STICK), status)


def tie_forces(model: Model, state: SystemState) -> TieForces | None:
    """What the ties of a model bear in a state; None where it has none.

    Parameters
    ----------
    model : The structure. state : Where it is.
    """
    found = next(_parts(model.laws), None)
    if found is None:
        return None
    law, points = found
    area, own = model.contacts.area[points], state.joints.take(points)
    force, capacity = np.maximum(state.reaction[points, 0], 0.0), law.capacity(own, area)
    elongation = -state.gap[points]
    first = state.points[points]
    reach = (law.length + elongation)[:, None] * state.frame[points, 0]
    return TieForces(
        contacts=points,
        names=tuple(model.interfaces[k].label for k in model.contacts.interface[points].tolist()),
        ends=np.stack([first, first + reach], axis=1),
        force=force,
        stress=force / area,
        elongation=elongation,
        strain=elongation / law.length,
        plastic=(0.0 - own.crushed) / law.length,
        utilisation=force / capacity,
        yields=np.isfinite(capacity),
        snapped=law.snapped(own),
    )


def yield_on_the_way(model: Model, before: JointState, after: JointState) -> FloatArray:
    """What ties that begin to yield within a step lacked at its start, times their flow, ≤ 0, shape (c,) [J].

    Parameters
    ----------
    model : The structure of c contacts. before, after : States of their laws at both ends of the step.
    """
    energy = np.zeros(model.contacts.count)
    for law, points in _parts(model.laws):
        area, start = model.contacts.area[points], before.take(points)
        flow = start.crushed - after.crushed[points]
        flows = (flow > 0) & ~law.snapped(after.take(points))
        lacked = law.force(start, area)[flows] - law.capacity(start, area)[flows]
        energy[points[flows]] = lacked * flow[flows]
    return energy


def without_ties(model: Model, state: SystemState) -> tuple[Model, SystemState]:
    """A structure and its state with the contacts of faces alone.

    Parameters
    ----------
    model : The structure. state : Where it is.
    """
    tied = model.contacts.ties
    if tied is None:
        return model, state
    keep = ~model.interfaces.tie
    interfaces, contacts = chosen(model.interfaces, model.contacts, keep)
    rows = np.flatnonzero(~tied)
    number = np.cumsum(~tied) - 1
    parts = tuple((law, number[points]) for law, points in model.laws.parts if law.pull is None)
    faces = replace(
        model,
        interfaces=interfaces,
        contacts=replace(contacts, ties=None),
        laws=Assignment(parts),
        scatter={name: values[rows] for name, values in model.scatter.items()},
        joint_records=tuple(one for one, stays in zip(model.joint_records, keep, strict=False) if stays),
    )
    return faces, replace(
        state,
        reaction=state.reaction[rows],
        velocity=state.velocity[rows],
        gap=state.gap[rows],
        status=state.status[rows],
        frame=state.frame[rows],
        points=state.points[rows],
        reaction_frame=state.reaction_frame[rows],
        jump=state.jump[rows],
        joints=state.joints.take(rows),
    )
