"""Rounding: what rounding alone may leave of a step's global balance and of its balance of energy.

It is the formula of ``nscd.rounding``: with the unit roundoff u a sum of n terms a_k is known to γ Σ|a_k|,
γ = √n u. Here (|·| takes the absolute value of each entry, q are displacements, R the rows of |K| summed up)

- what a block leaves of its balance of forces is the sum of its loads, the impulses p/h of its contacts,
  the momentum √m (U⁺ − U)/h, and the forces K q of clamps, Σ|a_k| = ‖f‖ + Σ‖p‖/h + √m (‖U⁺‖ + ‖U‖)/h +
  R · |q|. Contacts between blocks cancel in the sum over all blocks, and what is left of it is the *global
  balance*: it is known to the sum of what the blocks' are known to;
- the terms of the *energy balance* are products, too. Those of blocks are |F| · |Δq| of loads, q R q of
  strains and U · U of motion (``StepEnergy.summed``), with places and motions before and after the step.
  At contacts p works on v = B U + G u_el: Σ|p| (|B| |U|) + |Gᵀ p| · |u_el|. In statics velocities are ways
  between two places over h, which are no better known than these: Σ|p| |x|/h, with x where a contact is, and
  where a side of it deforms how far it has gone. What joints store and lose are sums of the same products.

    force_rounding(model, made), energy_rounding(model, coupling, made, summed)
"""

from __future__ import annotations

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.march.acting import Acting
from masonry_fem.march.coupling import Coupling
from masonry_fem.march.model import Model
from masonry_fem.march.step import Increment
from masonry_fem.nscd.graphs import lengths
from masonry_fem.nscd.residuals import gamma


def force_rounding(model: Model, made: Increment, acting: Acting) -> float:
    """What rounding alone may leave of the balance of all forces [N].

    Parameters
    ----------
    model : The structure.
    made : A step of it.
    acting : What acts on its blocks in it.
    """
    d, h = model.assembly.dimension, made.scheme.step
    sides = model.contacts.blocks.ravel()
    count = len(acting.load)
    touching = np.bincount(sides, minlength=count)
    pushed = np.bincount(sides, np.repeat(lengths(made.impulse), 2) / h, count)
    summed = lengths(acting.load[:, :d]) + acting.held + acting.summed + pushed
    terms = 3 + d * touching
    for group, before, after in zip(model.groups, made.before.bodies, made.after.bodies, strict=True):
        if made.scheme.inertia and not group.prescribed:
            moved = sum(lengths(group.velocity_parts(state)[0][:, :d]) for state in (before, after))
            summed[group.blocks] += made.scheme.inertia * np.sqrt(group.mass) * moved / h
            terms[group.blocks] += group.unknowns // len(group.blocks)
    known: FloatArray = (gamma(terms) * summed)[acting.solved]
    return float(known.sum())


def energy_rounding(model: Model, coupling: Coupling, made: Increment, summed: float) -> float:
    """What rounding alone may leave of the balance of energy [J].

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    made : A step of it.
    summed : Products that the energies of its blocks are sums of, in absolute values [J].
    """
    pushed, here = np.abs(made.impulse), np.abs(made.rigid_map)
    states = made.before.bodies, made.after.bodies
    motions = [
        [group.velocity_parts(own) for group, own in zip(model.groups, bodies, strict=True)]
        for bodies in states
    ]
    rigid = tuple(np.abs(one[0]) + np.abs(two[0]) for one, two in zip(*motions, strict=True))
    speeds = coupling.rigid_velocity(rigid, here)
    if made.scheme.inertia == 0:
        gone = np.abs(made.here.points - model.contacts.points[:, 0]) + np.abs(made.here.offset)
        places = np.where(coupling.soft[:, None], gone, np.abs(made.here.points).max(initial=0.0))
        speeds = speeds + places / made.scheme.step
    total = summed + float((pushed * speeds).sum())
    for nodal, one, two in zip(made.nodal_impulse, *motions, strict=True):
        if nodal is not None and one[1] is not None and two[1] is not None:
            total += float((np.abs(nodal) * (np.abs(one[1]) + np.abs(two[1]))).sum())
    terms = pushed.size + sum(group.unknowns for group in model.groups)
    return float(gamma(terms)) * total
