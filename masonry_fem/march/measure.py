"""Measures of a step: energy, balances and resultants, from the states alone.

They decide whether a step or an equilibrium holds; the contact solver has no say in them.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.bodies.base import FloatArray, Scheme, by_block, nonlinear
from masonry_fem.march.acting import Acting
from masonry_fem.march.coupling import Coupling
from masonry_fem.march.energy import energies, stored_energy
from masonry_fem.march.loads import external_forces, resultant
from masonry_fem.march.model import Model
from masonry_fem.march.rounds import NEWTON_TOLERANCE
from masonry_fem.march.state import BONDED, OPEN, SLIP, STICK, SystemState
from masonry_fem.march.step import Increment
from masonry_fem.march.step_report import StepReport
from masonry_fem.march.ties import tie_forces
from masonry_fem.nscd.graphs import lengths

MOVING = 0.1  # of the fastest block's speed: what moves


def measure(model: Model, coupling: Coupling, made: Increment, largest: float = 0.0) -> StepReport:
    """Everything worth reporting of a step.

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    made : A step of it, with what acts on the blocks in its state (``acting.acted``).
    largest : Norm of the largest contact impulses of its march so far [N s].
    """
    state, quality, acting = made.after, made.solution.quality, made.after.acting
    assert acting is not None
    stored = stored_energy(model, state, made.scheme.inertia)
    energy = energies(model, coupling, made, stored)
    supports = support_resultants(model, made, acting.contact)
    applied = resultant(model, external_forces(model, state.time, state.bodies))
    mass = sum(float(group.mass.sum()) for group in model.groups if not group.prescribed)
    # where nothing loads blocks but each other (warmth, ties, supports that have moved), what they gave
    load = _load(acting) or largest / made.scheme.step
    acceleration = load / mass if mass > 0 else 0.0
    return StepReport(
        step=state.index,
        time=state.time,
        kinetic_energy=stored.kinetic,
        strain_energy=stored.strain,
        joint_energy=stored.joints,
        iterations=made.solution.iterations,
        linear_solves=made.solution.linear_solves,
        rounds=len(made.residuals),
        method=made.solution.method,
        outcome=made.solution.outcome,
        quality=quality,
        rounding=0.0 if made.solution.rounding is None else made.solution.rounding.error,
        natural_map=quality.natural_map,
        max_penetration=float(np.maximum(_overlap(state), 0.0)[state.status != OPEN].max(initial=0.0)),
        block_balance=_balance(model, made, made.forces, made.scheme, acting.held, largest),
        static_balance=_static_balance(model, made, acting.held, largest),
        global_balance=_global_balance(acting, supports, state.reaction),
        support_resultants=supports,
        applied=applied,
        probes={
            probe.name: model.groups[probe.group].displacement(
                state.bodies[probe.group], probe.body, probe.point
            )
            for probe in model.probes
        },
        open=int((state.status == OPEN).sum()),
        stick=int((state.status == STICK).sum()),
        slip=int((state.status == SLIP).sum()),
        bonded=int((state.status == BONDED).sum()),
        speed=float(np.sqrt(2 * stored.kinetic / mass)) if mass > 0 else 0.0,
        load_acceleration=acceleration,
        adhesion_loss=made.adhesion_loss,
        joint_change=made.joint_change,
        unsettled=_unsettled(model, made),
        tie_forces=_tie_forces(model, state),
        **energy,
    )


def _tie_forces(model: Model, state: SystemState) -> dict[str, float]:
    """Force of each tie by name [N]."""
    told = tie_forces(model, state)
    return {} if told is None else dict(zip(told.names, told.force.tolist(), strict=True))


def _unsettled(model: Model, made: Increment) -> str:
    """The stone whose stresses leave the most of balance, and why, in words; "" where all balance."""
    if made.unsettled is None:
        return ""
    name = model.assembly.blocks.names[made.unsettled]
    (group,) = (group for group in model.groups if made.unsettled in group.blocks)
    if not made.residuals or made.residuals[-1] <= NEWTON_TOLERANCE:
        return (
            f"no load factor was found that takes the control, a point of '{name}', to its place: the load "
            "does not move it"
        )
    rounds = "1 round" if len(made.residuals) == 1 else f"{len(made.residuals)} rounds"
    return (
        f"the stresses of '{name}' ({nonlinear(group).material_name}) leave {made.residuals[-1]:.1e} of "
        f"balance after {rounds}"
    )


def _overlap(state: SystemState) -> FloatArray:
    """How far the faces at each contact point are past touching [m], shape (c,).

    Mortar and asperities give way and rough faces stand apart before they do.
    """
    touching: FloatArray = state.joints.given_way[:, 0] + state.joints.dilation
    return touching - state.gap


def _load(acting: Acting) -> float:
    """Sum of the magnitudes of the blocks' loads, or where there are none of what clamps give [N]."""
    loads = float(lengths(acting.load[:, : acting.centre.shape[1]]).sum())
    return loads or float(acting.held.sum())


def support_resultants(model: Model, made: Increment, contact: FloatArray) -> dict[str, FloatArray]:
    """Force and moment about the origin that each support gives to the blocks, by name, shape (m,) [N, N m].

    Parameters
    ----------
    model : The structure of b blocks.
    made : A step of it.
    contact : What contacts give to each block, shape (b, m) [N, N m].
    """
    given: dict[str, FloatArray] = {}
    for index, group in enumerate(model.groups):
        if group.prescribed:
            names = [model.assembly.blocks.names[block] for block in group.blocks]
            given |= dict(zip(names, -contact[group.blocks], strict=True))
        else:
            given |= group.clamp_reactions(
                made.before.bodies[index],
                made.after.bodies[index],
                made.forces[index],
                made.nodal_impulse[index],
                made.scheme,
            )
    return given


def _global_balance(acting: Acting, supports: dict[str, FloatArray], contact: FloatArray) -> float:
    """What forces of loads, supports and inertia leave over the step, relative to the largest."""
    d = acting.centre.shape[1]
    given = [acting.load[:, :d].sum(axis=0), *(force[:d] for force in supports.values())]
    left = sum(given, np.zeros(d)) - acting.inertia[:, :d].sum(axis=0)
    scale = largest_force(acting, supports, contact)
    return float(np.linalg.norm(left)) / scale if scale > 0 else 0.0


def largest_force(acting: Acting, supports: dict[str, FloatArray], contact: FloatArray) -> float:
    """What the global balance is relative to [N]: the blocks' inertia where nothing acts on them.

    Parameters
    ----------
    acting : What acts on the blocks.
    supports : What supports give, force and moment, by name.
    contact : Forces at the contacts, shape (c, d) [N]. Without loads, as where ties squeeze, supports bear
        no more than what these leave by rounding.
    """
    d = acting.centre.shape[1]
    loads = acting.load[:, :d]
    given = [loads.sum(axis=0), *(force[:d] for force in supports.values())]
    scale = max(*(float(np.linalg.norm(force)) for force in given), float(acting.held.max(initial=0.0)))
    if not loads.any():
        scale = max(scale, float(lengths(contact).max(initial=0.0)))
    return scale if scale > 0 else float(np.linalg.norm(acting.inertia[:, :d], axis=1).sum())


def _static_balance(model: Model, made: Increment, held: FloatArray, largest: float) -> float:
    """Distance of the reached state to a static equilibrium, relative to a block's load."""
    forces = external_forces(model, made.after.time, made.after.bodies)
    return _balance(model, made, forces, Scheme(made.scheme.step, 1.0, 0.0), held, largest)


def _balance(
    model: Model,
    made: Increment,
    forces: tuple[FloatArray, ...],
    scheme: Scheme,
    held: FloatArray,
    largest: float,
) -> float:
    """Worst balance of a block, relative to its load, or to what clamps give it where that is more."""
    d = model.assembly.dimension
    residuals, weights = [np.zeros(1)], [np.zeros(1)]
    for index, group in enumerate(model.groups):
        if group.prescribed:
            continue
        residual = group.imbalance(
            made.before.bodies[index],
            made.after.bodies[index],
            made.after.bodies[index],
            forces[index],
            made.rigid_impulse[index],
            made.nodal_impulse[index],
            scheme,
        )
        load = scheme.step * lengths(group.resultant(forces[index])[:, :d])
        # where nothing loads blocks but contacts (supports that move, joints that pull), by those, which may
        # have gone by now (stones that warmth moved apart)
        least = 0.0 if load.any() else max(largest, float(np.abs(made.impulse).max(initial=0.0)))
        pushed = np.maximum(np.maximum(load, scheme.step * held[group.blocks]), least)
        residuals.append(np.abs(residual))
        weights.append(pushed)
    residual, weight = np.concatenate(residuals), np.concatenate(weights)
    typical = weight[weight > 0].mean() if weight.any() else 1.0
    return float((residual / np.maximum(weight, typical)).max())


def _way(turning: float, upward: float, speed: float) -> str:
    """How a block moves, in a word, by speeds [m/s]: of turning, of its mean upwards, greatest."""
    if turning > 0.3 * speed:
        return "tips"
    if abs(upward) > 0.7 * speed:
        return "rises" if upward > 0 else "falls"
    return "slides"


def moving_blocks(model: Model, state: SystemState) -> list[tuple[str, float, str]]:
    """Blocks that move, the fastest first: (name, speed [m/s], 'slides', 'tips', 'falls' or 'rises').

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    """
    found: list[tuple[str, float, str]] = []
    for group, own in zip(model.groups, state.bodies, strict=True):
        if group.prescribed:
            continue
        for block, field in zip(group.blocks, by_block(group, group.velocities(own)), strict=True):
            mean = field.mean(axis=0)
            turn = float(np.linalg.norm(field - mean, axis=1).max())
            speed = float(np.linalg.norm(field, axis=1).max())
            found.append((model.assembly.blocks.names[block], speed, _way(turn, float(mean[-1]), speed)))
    fastest = max((speed for _, speed, _ in found), default=0.0)
    moving = [entry for entry in found if entry[1] > MOVING * fastest and fastest > 0]
    return sorted(moving, key=lambda entry: -entry[1])
