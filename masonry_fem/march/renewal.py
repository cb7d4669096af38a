"""Renewal: a march goes on with contacts found anew, and what the old ones knew.

coupling, state = renewed(coupling, state, scheme, lookout)

All of them where ``model.update`` is due. Else, in time, those of blocks that have slid past the end of a
face: the common part of two faces is clipped where these are, and nothing bears beyond it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.bodies.base import FloatArray, Scheme
from masonry_fem.contact.update import partners, picked
from masonry_fem.joints.state import JointState
from masonry_fem.march.coupling import Coupling, Placement, connect
from masonry_fem.march.lookout import Lookout
from masonry_fem.march.model import Model
from masonry_fem.march.overhang import slid_off
from masonry_fem.march.place import relative_velocity
from masonry_fem.march.state import STICK, SystemState

NEAR = 0.25  # of the model's length: how far a contact goes on from an old one of the same blocks


def renewed(
    coupling: Coupling, state: SystemState, scheme: Scheme, lookout: Lookout
) -> tuple[Coupling, SystemState]:
    """Coupling and state with the contacts that are due to be found anew; both unchanged where none is.

    Parameters
    ----------
    coupling : Body groups at the contacts so far.
    state : The state reached.
    scheme : Of the next step.
    lookout : Knows where faces end.
    """
    model = coupling.model
    if model.update is None or state.index % model.update.every:
        return _let_go(coupling, state, scheme, lookout)
    found = model.update(model, state.bodies, state.time, scheme, ~state.joints.broken)
    anew = connect(found)
    here = anew.placement(state.bodies)
    old = partners(model.contacts, state.points, found.contacts, here.points, NEAR * model.length)
    return anew, carried(model, found, anew, here, state, old)


def _let_go(
    coupling: Coupling, state: SystemState, scheme: Scheme, lookout: Lookout
) -> tuple[Coupling, SystemState]:
    """With those of pairs found anew of which one has slid off the other, in dynamics."""
    model = coupling.model
    if model.meet is None or scheme.inertia == 0:
        return coupling, state
    held = ~state.joints.broken
    pairs = slid_off(model, coupling.placement(state.bodies), state.bodies, held, lookout.ends)
    if not len(pairs):
        return coupling, state
    found, kept = model.meet(model, state.bodies, state.bodies, pairs, held, slid=True)
    if found is model:
        return coupling, state
    anew = connect(found)
    here = anew.placement(state.bodies)
    return anew, carried(model, found, anew, here, state, continued(model, state, found, here, kept))


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
        velocity=relative_velocity(coupling, state.bodies, here, coupling.rigid_map(state.bodies, here)),
        gap=here.gap,
        status=status,
        frame=here.frame,
        points=here.points,
        reaction_frame=here.frame,
        jump=turned(state.jump),
        joints=_joints(found, state, old),
        trend=None if trend is None else replace(trend, growth=turned(trend.growth)),
    )


def continued(
    model: Model, state: SystemState, found: Model, here: Placement, kept: np.ndarray
) -> np.ndarray:
    """The old contact that each one goes on from: itself, or one of those that made way; −1: none, (c,).

    Parameters
    ----------
    model, found : The structure with the old and with the c new contacts.
    state : At the old ones.
    here : Where the new ones are.
    kept : Numbers of the old contacts that come first among the new ones, shape (k,).
    """
    lost = np.setdiff1d(np.arange(model.contacts.count), kept)
    fresh = np.arange(len(kept), found.contacts.count)
    gone, new = picked(model.contacts, lost), picked(found.contacts, fresh)
    near = partners(gone, state.points[lost], new, here.points[fresh], NEAR * model.length)
    return np.concatenate([kept, np.append(lost, -1)[near]])


def _joints(found: Model, state: SystemState, old: np.ndarray) -> JointState:
    """What the laws remember: of new contacts nothing, and no cohesion binds them."""
    count, d = found.contacts.count, found.contacts.dimension
    fresh = found.laws.initial(count, d)
    fresh = replace(fresh, adhesion=np.zeros(count), broken=np.ones(count, dtype=bool))
    width = max(fresh.own.shape[1], state.joints.own.shape[1])
    fresh = replace(fresh, own=np.pad(fresh.own, ((0, 0), (0, width - fresh.own.shape[1]))))
    known = np.flatnonzero(old >= 0)
    return fresh.put(known, state.joints.take(old[known]))
