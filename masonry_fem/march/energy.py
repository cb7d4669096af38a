"""Energy: where the energy of one step went, each part from what has it.

Bodies tell the work of loads, of moving clamps, of damping and of the θ-scheme; contacts what friction and
impacts took; joint laws what they store and dissipate. Nothing is found as the rest of a sum, so that what is
missing shows as the step's ``energy_error``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_fem.joints.laws.parts.adhesive import held
from masonry_fem.march.coupling import Coupling
from masonry_fem.march.model import Model
from masonry_fem.march.place import relative_velocity
from masonry_fem.march.state import OPEN, SystemState
from masonry_fem.march.step import Increment


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
    """Energy of all free blocks and of the joints; in statics (inertia 0) velocities are increments."""
    kinetic = strain = joints = 0.0
    for group, own in zip(model.groups, state.bodies, strict=True):
        if not group.prescribed:
            kinetic += inertia * float(group.kinetic_energy(own).sum())
            strain += float(group.strain_energy(own).sum())
    if model.laws is not None and state.joints is not None:
        joints = float(model.laws.stored(state.joints, model.contacts.area).sum())
    return Stored(kinetic, strain, joints)


def energies(model: Model, coupling: Coupling, made: Increment, after: Stored) -> dict[str, float]:
    """The energy terms of a step's report [J], by their names there; ``after`` is what is stored at its end.

    A step of linear blocks satisfies, to rounding,

        Δ stored = external + support − friction − impacts − joint losses − damping − numerical

    Notes
    -----
    Reactions work on v_θ = v⁺ − (1 − θ)(v⁺ − v⁻). At the end velocity v⁺ they close gaps, rub, and strain the
    joints; what is left acts on the jump of the velocity. At points that hit in this step that is what an
    impact takes, elsewhere the tangential part is friction of a sliding that speeds up or slows down.
    Points of stones that turn in a static step go on arcs: what impulses do beside the chord is numerical.
    """
    before = stored_energy(model, made.before, made.scheme.inertia)
    start = relative_velocity(model, coupling, made.before.bodies, made.here, made.rigid_map)
    straight = end = made.after.velocity
    if made.scheme.inertia == 0:
        straight = relative_velocity(model, coupling, made.after.bodies, made.here, made.rigid_map)
    jolt = (1 - made.scheme.theta) * made.impulse * (straight - start)
    contact = float((made.impulse * end).sum() - jolt.sum())
    hits = (start[:, 0] < 0) & ((made.before.status == OPEN) | (made.before.index == 0))
    aside = jolt[:, 1:].sum(axis=1)
    closing, rubbed, joints = _dry(made) if model.laws is None else _joints(model, made)
    terms = _bodies(model, made)
    terms["numerical_dissipation"] += joints.pop("numerical", 0.0)
    terms["numerical_dissipation"] += float((made.impulse * (end - straight)).sum())
    terms |= {
        "friction_dissipation": rubbed + float(aside[~hits].sum()),
        "impact_normal": closing + float(jolt[:, 0].sum()),
        "impact_tangential": float(aside[hits].sum()),
        "joint_dissipation": 0.0,
        "joint_viscosity": 0.0,
    }
    terms |= joints
    missing = after.total - before.total - terms["external_work"] - terms["support_work"]
    return terms | {
        "kinetic_before": before.kinetic,
        "strain_before": before.strain,
        "joint_energy_before": before.joints,
        "contact_work": contact,
        "energy_error": missing + sum(terms[name] for name in LOSSES),
    }


def _bodies(model: Model, made: Increment) -> dict[str, float]:
    """Work of loads, of supports and clamped faces that move, damping and what θ > ½ takes."""
    theta = made.scheme.theta
    external = support = damping = numerical = 0.0
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
    return {
        "external_work": external,
        "support_work": support,
        "damping_dissipation": damping,
        "numerical_dissipation": numerical,
    }


def _dry(made: Increment) -> tuple[float, float, dict[str, float]]:
    """What dry contacts take at the end velocity: by gaps that close, by friction, and no more [J]."""
    work = -(made.impulse * made.after.velocity)
    return float(work[:, 0].sum()), float(work[:, 1:].sum()), {}


def _joints(model: Model, made: Increment) -> tuple[float, float, dict[str, float]]:
    """The same where joints have laws, with what these dissipate, all by the laws' own states [J].

    A backward step works with the forces of its end. On springs, damaged ones too, half of their change times
    the displacement is more than the mean force does: the joints' share of ``numerical``.
    """
    laws, area = model.laws, model.contacts.area
    before, after = made.before.joints, made.after.joints
    assert laws is not None
    assert before is not None
    assert after is not None
    h, solution = made.scheme.step, made.solution
    pressed = np.zeros_like(made.impulse)
    pressed[made.contacts] = made.problem.contact_part(solution.impulse, solution.velocity)
    stretch = after.jump - held(before.jump)
    pulled = laws.adhesive_reaction(after, area) - laws.adhesive_reaction(before, area)
    pushed = made.impulse / h - made.before.reaction
    excess = 0.5 * float((pulled * stretch).sum() - (pushed * (after.bed - before.bed)).sum())
    delayed = float((after.delayed - before.delayed).sum())
    damaged = float((after.dissipated - before.dissipated).sum()) - delayed
    closing = -float((pressed[:, 0] * stretch[:, 0]).sum()) / h
    rubbed = float((after.rubbed - before.rubbed).sum())
    return (
        closing,
        rubbed,
        {
            "joint_dissipation": damaged,
            "joint_viscosity": delayed,
            "numerical": excess,
        },
    )


LOSSES = (
    "friction_dissipation", "impact_normal", "impact_tangential", "joint_dissipation", "joint_viscosity",
    "damping_dissipation", "numerical_dissipation",
)  # fmt: skip
