"""Renewal: a march goes on with contacts found anew, and what the old ones knew.

coupling, state = renewed(coupling, state, scheme)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.bodies.base import FloatArray, Scheme
from masonry_fem.contact.update import partners
from masonry_fem.joints.state import JointState
from masonry_fem.march.coupling import Coupling, Placement, connect
from masonry_fem.march.model import Model
from masonry_fem.march.place import relative_velocity
from masonry_fem.march.state import STICK, SystemState

NEAR = 0.25  # of the model's length: how far a contact goes on from an old one of the same blocks


def renewed(coupling: Coupling, state: SystemState, scheme: Scheme) -> tuple[Coupling, SystemState]:
    """Coupling and state with the contacts that ``model.update`` finds; both unchanged where none is due.

    Parameters
    ----------
    coupling : Body groups at the contacts so far.
    state : The state reached.
    scheme : Of the next step.
    """
    model = coupling.model
    if model.update is None or state.index % model.update.every:
        return coupling, state
    found = model.update(model, state.bodies, state.time, scheme, ~state.joints.broken)
    anew = connect(found)
    here = anew.placement(state.bodies)
    old = partners(model.contacts, state.points, found.contacts, here.points, NEAR * model.length)
    return anew, carried(model, found, anew, here, state, old)


def carried(
    model: Model,
    found: Model,
    coupling: Coupling,
    here: Placement,
    state: SystemState,
    old: np.ndarray,
) -> SystemState:
    """The state at new contacts, with what the old ones knew.

    Parameters
    ----------
    model, found : The structure with the old and with the new contacts.
    coupling : Body groups at the c new contacts.
    here : Contact geometry there.
    state : The state at the old contacts.
    old : Old contact that each new one goes on from, −1 where it begins without a history, shape (c,).
    """
    known = old >= 0
    exchanged = np.zeros(len(old), dtype=bool)
    exchanged[known] = found.contacts.blocks[known, 0] != model.contacts.blocks[old[known], 0]
    sign = np.where(exchanged, -1.0, 1.0)

    def turned(values: FloatArray) -> FloatArray:
        result = np.zeros_like(here.points)
        world = np.einsum("cij,ci->cj", state.frame, values)
        result[known] = np.einsum("cij,cj->ci", here.frame[known], world[old[known]])
        return sign[:, None] * result

    trend = state.trend
    status = np.full(len(old), STICK, dtype=np.int8)
    status[known] = state.status[old[known]]
    return replace(
        state,
        reaction=turned(state.reaction),
        velocity=relative_velocity(
            found, coupling, state.bodies, here, coupling.rigid_map(state.bodies, here)
        ),
        gap=here.gap,
        status=status,
        frame=here.frame,
        points=here.points,
        reaction_frame=here.frame,
        jump=turned(state.jump),
        joints=_joints(found, state, old),
        trend=None if trend is None else replace(trend, growth=turned(trend.growth)),
    )


def _joints(found: Model, state: SystemState, old: np.ndarray) -> JointState:
    """What the laws remember: of new contacts nothing, and no cohesion binds them."""
    count, d = found.contacts.count, found.contacts.dimension
    fresh = found.laws.initial(count, d)
    fresh = replace(fresh, adhesion=np.zeros(count), broken=np.ones(count, dtype=bool))
    width = max(fresh.own.shape[1], state.joints.own.shape[1])
    fresh = replace(fresh, own=np.pad(fresh.own, ((0, 0), (0, width - fresh.own.shape[1]))))
    known = np.flatnonzero(old >= 0)
    return fresh.put(known, state.joints.take(old[known]))
