"""Energy: where the energy of one step went, each part from what has it.

Bodies tell the work of loads, of moving clamps, of heat, of damping and of the θ-scheme; contacts what
friction and impacts took; joint laws what they store and dissipate. Nothing is found as the rest of a sum, so
that what is missing shows as the step's ``energy_error``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.joints.law import layers_of
from masonry_fem.joints.state import JointState
from masonry_fem.march.coupling import Coupling
from masonry_fem.march.model import Model
from masonry_fem.march.place import relative_velocity
from masonry_fem.march.rounding import energy_rounding
from masonry_fem.march.state import OPEN, SystemState
from masonry_fem.march.step import Increment
from masonry_fem.march.ties import yield_on_the_way


@dataclass(frozen=True, slots=True)
class Stored:
    """Energy of a state [J]: ``kinetic`` (0 in statics), ``strain`` of stones, ``joints`` with cohesion."""

    kinetic: float
    strain: float
    joints: float

    @property
    def total(self) -> float:
        """All of it [J]."""
        return self.kinetic + self.strain + self.joints


def stored_energy(model: Model, state: SystemState, inertia: float) -> Stored:
    """Energy of all free blocks and of the joints.

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    inertia : 1 in dynamics; 0 in statics, where velocities are increments and kinetic energy is none.
    """
    kinetic = strain = 0.0
    for group, own in zip(model.groups, state.bodies, strict=True):
        if not group.prescribed:
            kinetic += inertia * float(group.kinetic_energy(own).sum())
            strain += float(group.strain_energy(own).sum())
    joints = float(model.laws.stored(state.joints, model.contacts.area).sum())
    return Stored(kinetic, strain, joints)


def energies(model: Model, coupling: Coupling, made: Increment, after: Stored) -> dict[str, float]:
    """The energy terms of a step's report [J], by their names there.

    A step satisfies, to rounding, and where stones yield to the tolerance of their balance,

        Δ stored = external + support + heat − friction − impacts − joint losses − material losses
                   − damping − numerical

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    made : A step of it.
    after : Energy stored at the end of the step.

    Notes
    -----
    Reactions work on v_θ = v⁺ − (1 − θ)(v⁺ − v⁻). The part with the end velocity v⁺ closes gaps, is lost to
    friction and strains the joints. The rest acts on the jump of the velocity: at points that hit in this
    step it is what the impact takes; elsewhere its tangential part is friction of a sliding that speeds up or
    slows down, and numerical where friction would drive the sliding, which turns round or comes to an end. In
    a static step points of blocks that turn move on arcs, not on chords; the work of impulses on the
    difference counts as numerical.
    """
    before = stored_energy(model, made.before, made.scheme.inertia)
    start = relative_velocity(coupling, made.before.bodies, made.here, made.rigid_map)
    straight = end = made.after.velocity
    if made.scheme.inertia == 0:
        straight = relative_velocity(coupling, made.after.bodies, made.here, made.rigid_map)
    jolt = (1 - made.scheme.theta) * made.impulse * (straight - start)
    contact = float((made.impulse * end).sum() - jolt.sum())
    hits = (start[:, 0] < 0) & ((made.before.status == OPEN) | (made.before.index == 0))
    aside, rubs = jolt[:, 1:].sum(axis=1), _speeding(made, start)
    terms = _bodies(model, made) | {"impact_tangential": float(aside[hits].sum())}
    for name, taken in _joints(model, made).items():
        terms[name] = terms.get(name, 0.0) + taken
    terms["friction_dissipation"] += float(rubs[~hits].sum())
    terms["numerical_dissipation"] += float((aside - rubs)[~hits].sum())
    terms["impact_normal"] += float(jolt[:, 0].sum())
    terms["numerical_dissipation"] += float((made.impulse * (end - straight)).sum())
    given = terms["external_work"] + terms["support_work"] + terms["heat_work"]
    missing = after.total - before.total - given
    summed = terms.pop("summed")
    return terms | {
        "kinetic_before": before.kinetic,
        "strain_before": before.strain,
        "joint_energy_before": before.joints,
        "contact_work": contact,
        "energy_error": missing + sum(terms[name] for name in LOSSES),
        "energy_rounding": energy_rounding(model, coupling, made, summed),
    }


def _speeding(made: Increment, start: FloatArray) -> FloatArray:
    """What friction takes beside its work on the end velocity, as sliding began with another, shape (c,) [J].

    Friction is against the sliding at the end. Where it is against that of the start (c, d), too, it works on
    both, by θ and 1 − θ; else on the end's alone, by θ. How fast a layer in the joint gave way at the start
    is not kept: there sliding counts as even.
    """
    slid, friction = _faces(made), _borne(made)[:, 1:]
    before = np.where((slid != made.after.velocity).any(axis=1)[:, None], slid, start)
    works = np.einsum("ci,ci->c", friction, slid[:, 1:])
    against = np.minimum(np.einsum("ci,ci->c", friction, before[:, 1:]), 0.0)
    taken: FloatArray = (1 - made.scheme.theta) * (works - against)
    return taken


def _bodies(model: Model, made: Increment) -> dict[str, float]:
    """Work of loads, supports and clamped faces that move, and heat; damping, yielding, what θ > ½ takes.

    And ``summed`` of ``StepEnergy``.
    """
    theta = made.scheme.theta
    external = support = damping = numerical = yielded = heat = summed = 0.0
    for group, before, after, force, push, nodal, end in zip(
        model.groups, made.before.bodies, made.after.bodies, made.forces, made.rigid_impulse,
        made.nodal_impulse, made.rigid, strict=True,
    ):  # fmt: skip
        if group.prescribed:
            # as contacts see it: the state goes on with the velocity that the motion has at that time
            moved = (1 - theta) * group.velocity_parts(before)[0] + theta * end
            support -= float((push * moved).sum())
            continue
        spent = group.step_energy(before, after, force, nodal, made.scheme)
        external += float(spent.external.sum())
        support += float(spent.support.sum())
        damping += float(spent.damping.sum())
        numerical += float(spent.numerical.sum())
        yielded += float(np.sum(spent.dissipation))
        heat += float(np.sum(spent.heat))
        summed += float(np.sum(spent.summed))
    return {
        "external_work": external,
        "support_work": support,
        "damping_dissipation": damping,
        "numerical_dissipation": numerical,
        "material_dissipation": yielded,
        "heat_work": heat,
        "summed": summed,
    }


def _joints(model: Model, made: Increment) -> dict[str, float]:
    """What pressure and friction work on is the way of the faces, without that of their mortar.

    Where they are rough sliding raises them: what that works against pressure is friction's. A backward step
    works with the forces of its end; on springs, damaged ones too, half of their change times the way is
    more than the mean force does, which is numerical.
    """
    laws, area, h = model.laws, model.contacts.area, made.scheme.step
    before, after = made.before.joints, made.after.joints
    bed, lift = after.given_way - before.given_way, after.dilation - before.dilation
    faces, pressed = _faces(made), _borne(made)
    work = -(pressed * faces)
    raising = float((pressed[:, 0] * lift).sum()) / h
    pulled = laws.spring_reaction(after, area) - laws.spring_reaction(before, area)
    delayed = float((after.delayed - before.delayed).sum())
    springs = (pulled * faces * h - made.impulse / h * bed).sum(axis=1)
    springs += _at_start(model, before, after) + yield_on_the_way(model, before, after)
    return {
        "impact_normal": float(work[:, 0].sum()) + raising,
        "friction_dissipation": float(work[:, 1:].sum()) - raising,
        "joint_dissipation": float((after.dissipated - before.dissipated).sum()) - delayed,
        "joint_viscosity": delayed,
        "numerical_dissipation": 0.5 * float(springs.sum()),
    }


def _at_start(model: Model, before: JointState, after: JointState) -> FloatArray:
    """Work of what layers and ties bear before a step, on what they give way in it, shape (c,) [J]."""
    work = np.zeros(model.contacts.count)
    for law, points in model.laws.parts:
        layers = [layer for layer in layers_of(law) if not layer.plain]
        if layers:
            ends, area = (before.take(points), after.take(points)), model.contacts.area[points]
            work[points] = sum(layer.work_at_start(*ends, area) for layer in layers)
    return work


def _faces(made: Increment) -> FloatArray:
    """Velocity at which faces part and slide at the step's end, without their layers' share, shape (c, d)."""
    given_way: FloatArray = made.after.joints.given_way - made.before.joints.given_way
    return made.after.velocity - given_way / made.scheme.step


def _borne(made: Increment) -> FloatArray:
    """Impulse of pressure and friction, without that of cohesion, shape (c, d)."""
    borne = made.impulse.copy()
    borne[made.contacts] = made.problem.contact_part(made.solution.impulse, made.solution.velocity)
    return borne


LOSSES = (
    "friction_dissipation", "impact_normal", "impact_tangential", "joint_dissipation", "joint_viscosity",
    "material_dissipation", "damping_dissipation", "numerical_dissipation",
)  # fmt: skip
