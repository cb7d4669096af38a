"""Conditions: what a step asks of its contacts: gaps that stay, impacts, friction, and joints with laws."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.base import FloatArray, Free, Scheme
from masonry_fem.joints.fold import JointStep
from masonry_fem.joints.state import JointState
from masonry_fem.march.coupling import Coupling, Placement
from masonry_fem.march.model import Model
from masonry_fem.march.place import Place
from masonry_fem.march.state import BONDED, OPEN, SLIP, STICK, SystemState
from masonry_fem.march.ties import snapped_ties
from masonry_fem.nscd import ContactProblem, Start
from masonry_fem.nscd.compliance import Shared, only
from masonry_fem.nscd.graphs import lengths

ROUNDING = 1e-12  # of the model's length: a gap that is none
SLIGHT = 1e-6  # of the model's length: an overlap that is not driven apart
CREEP = 1e-9  # of the model's length: a gap of the gap form that is none where there is inertia
DRIFT = 1e-6  # of the model's length: how far a pressed contact may drift where there is inertia


def joint_step(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    free: tuple[Free, ...],
    start: Placement,
    place: Place,
    compliance: sparse.bsr_array | Shared,
    trial: JointState,
) -> JointStep:
    """What joint laws need of a step to make its contact problem, for the contacts that take part in it.

    Parameters
    ----------
    model : The structure, with its joint laws.
    coupling : Its body groups at c contacts.
    state : Where the step begins.
    scheme : Length and weights of the step.
    free : The step of each group without contact impulses.
    start : Contact geometry where the step begins.
    place : Where the step is linearised.
    compliance : W_el of all contacts, shape (c d, c d) [1/kg].
    trial : State of the joints that the laws begin with.
    """
    here, rigid_map = place.contact, place.rigid_map
    q = coupling.elastic_velocity(tuple(part.elastic for part in free), here)
    q += coupling.rigid_velocity(
        tuple(
            part.rigid_velocity if group.prescribed else np.zeros_like(part.rigid_velocity)
            for group, part in zip(model.groups, free, strict=True)
        ),
        rigid_map,
    )
    q += place.bend
    takes_part = ~model.laws.in_velocities | _closed(model, state, scheme, start)
    takes_part |= ~state.joints.broken  # cohesion acts across a gap, too
    takes_part &= ~snapped_ties(model, trial)
    active = np.flatnonzero(takes_part)
    bodies, maps = coupling.bodies, rigid_map
    if len(active) < len(q):
        compliance = only(compliance, active)
        bodies, maps = bodies[active], maps[active]
    problem = partial(
        ContactProblem,
        bodies=bodies,
        rigid_map=np.where(bodies[:, :, None, None] >= 0, maps, 0.0),
        rigid_mass=coupling.gather(free, "rigid_mass"),
        rigid_impulse=coupling.gather(free, "rigid_impulse"),
        rigid_velocity=coupling.gather(free, "rigid_velocity"),
        structure=coupling.structure,
    )
    return JointStep(
        active=active,
        problem=problem,
        free_velocity=q[active],
        compliance=compliance,
        jump=shifted_jump(state, scheme),
        area=model.contacts.area,
        trial=trial,
        gap_term=lambda closure: _gap_term(model, coupling.soft, state, scheme, start, closure),
        length=scheme.step,
    )


def _closed(model: Model, state: SystemState, scheme: Scheme, here: Placement) -> NDArray[np.bool_]:
    """Contacts that the velocity form takes for closed, shape (c,).

    A gap of rounding size is closed, and so is what was pressed to rest: the solver's tolerance lets its
    gap drift, and a step without the contact would end in a second impact.
    """
    shifted = here.gap + scheme.step * (1 - scheme.theta) * state.velocity[:, 0]
    pressed = _pressed(state) & (model.laws.restitution[:, 0] == 0)
    closed: NDArray[np.bool_] = shifted <= np.where(pressed, DRIFT, ROUNDING) * model.length
    return closed


def _pressed(state: SystemState) -> NDArray[np.bool_]:
    """Contacts that bear where the step begins, shape (c,)."""
    pressed: NDArray[np.bool_] = (state.reaction[:, 0] > 0) & (state.status != OPEN)
    return pressed


def _gap_term(
    model: Model,
    soft: NDArray[np.bool_],
    state: SystemState,
    scheme: Scheme,
    here: Placement,
    closure: FloatArray,
) -> FloatArray:
    """What gaps and impacts add to the free velocity, shape (c, d) [m/s].

    ``soft`` contacts have a side that deforms; ``closure`` is the gap at which the faces touch [m].
    """
    laws, h = model.laws, scheme.step
    shifted = exact = here.gap + h * (1 - scheme.theta) * state.velocity[:, 0] - closure
    impact = laws.in_velocities & _closed(model, state, scheme, here)
    if scheme.inertia:
        # what closed contacts open by, as blocks turn, is the square of the turn: gaps that contradict each
        # other where three blocks meet
        none = np.where(soft & _pressed(state), DRIFT, CREEP) * model.length
        shifted = np.where(shifted <= none, np.minimum(shifted, 0.0), shifted)
    term = np.empty_like(state.velocity)
    # an overlap is held, or driven apart slowly; one that is all but rounding is no overlap
    driven = np.where(shifted < -SLIGHT * model.length, model.expulsion, 0.0)
    # a tie has no overlap: what it is stretched by is as it is, or errors of steps would add up
    approach = np.where(model.contacts.tied, exact / h, np.maximum(shifted / h, -driven))
    # cohesion across a gap in the velocity form: contact is for the step that finds it closed
    approach += np.where(laws.in_velocities & ~impact, 2.0 * np.abs(state.velocity[:, 0]), 0.0)
    term[:, 0] = np.where(impact, laws.restitution[:, 0] * state.velocity[:, 0], approach)
    slides_back = np.where(impact, laws.restitution[:, 1], 0.0)
    term[:, 1:] = slides_back[:, None] * state.velocity[:, 1:]
    return term


def shifted_jump(state: SystemState, scheme: Scheme) -> FloatArray:
    """ũ = u + h (1 − θ) v, the displacement jump that the laws see at the start of a step, shape (c, d) [m].

    Parameters
    ----------
    state : Where the step begins: jump u and relative velocity v of the contacts.
    scheme : Length h and weight θ of the step.
    """
    shifted: FloatArray = state.jump + scheme.step * (1 - scheme.theta) * state.velocity
    return shifted


def first_guess(state: SystemState, scheme: Scheme, active: NDArray[np.int64]) -> Start | None:
    """Last step's reactions as a first guess of this step's impulses; None where there are none.

    Its velocities tell statuses: contacts that stick do not slip, though their joints give way.
    In statics the rigid velocities are displacements per unit of the load factor. They do not depend on the
    length of a step, and the last ones are a guess, too.

    Parameters
    ----------
    state : Where the step begins.
    scheme : Length of the step, and whether there is inertia.
    active : Contacts that take part, shape (a,).
    """
    if not state.reaction.any():
        return None
    impulse = scheme.step * state.reaction[active]
    # as the step's contact problem had it: what has opened has left by its gap
    velocity = state.velocity[active]
    velocity[:, 0] = np.maximum(state.gap[active], 0.0) / scheme.step
    velocity[state.status[active] == STICK, 1:] = 0.0
    return Start(impulse, None if scheme.inertia else state.rigid_velocity, velocity)


def contact_status(
    pressed: FloatArray, friction: FloatArray, impulse: FloatArray | None = None
) -> NDArray[np.int8]:
    """Whether each contact is open, sticks, slips or is bonded, shape (c,); zero is 1e-8 of the largest.

    Parameters
    ----------
    pressed : Impulses that contact and friction carry, local frames, shape (c, d) [N s].
    friction : Friction coefficients, shape (c,).
    impulse : With cohesion, the impulses on the blocks, those of cohesion included, shape (c, d) [N s].
    """
    normal, tangent = pressed[:, 0], lengths(pressed[:, 1:])
    small = 1e-8 * np.abs(normal).max(initial=0.0)
    status = np.full(len(pressed), STICK, dtype=np.int8)
    status[tangent >= friction * normal * (1 - 1e-8)] = SLIP
    status[normal <= small] = OPEN
    if impulse is not None:
        held = lengths(impulse)
        status[(status == OPEN) & (held > 1e-8 * held.max(initial=0.0))] = BONDED
    return status
