"""Place: where the impulses of a step are to balance, and how far from balance they are elsewhere.

place = begun(coupling, state.bodies)                     # where the step begins
there = reached(coupling, start, bodies, scheme.step)     # where it has led
turning(coupling, there, ..., place)                      # what the way there leaves of balance
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free, Scheme
from masonry_fem.march.coupling import ROUNDING, Coupling, Placement


@dataclass(frozen=True, slots=True)
class Place:
    """States of all bodies, and their contacts seen from there.

    Attributes
    ----------
    bodies : One state a group.
    contact : Frames, points and gaps.
    rigid_map : B there, supports too, shape (c, 2, d, m).
    bend : What velocities miss of the way there from the start of the step, as points that turn go on
        arcs, shape (c, d) [m/s]. With it the velocity at the contacts is exact, and its derivative is G.
    """

    bodies: tuple[Any, ...]
    contact: Placement
    rigid_map: FloatArray
    bend: FloatArray


@dataclass(frozen=True, slots=True)
class Forecast:
    """Where a step may lead.

    Attributes
    ----------
    impulse : Of all contacts, (c, d) [N s]. place : Of the contacts, and states of the bodies.
    near : Whether nonlinear blocks are all but in balance there.
    """

    impulse: FloatArray
    place: Place
    near: bool = True


def begun(coupling: Coupling, bodies: tuple[Any, ...], *, gathered: bool = False) -> Place:
    """Where a step begins.

    Parameters
    ----------
    coupling : Body groups at their contacts.
    bodies : Body states at the start, one a group.
    gathered : Contacts of one point of the reference act at one, as befits steps in time; see ``Coupling``.
    """
    here = coupling.placement(bodies)
    if gathered:
        here = coupling.gathered(here)
    return Place(bodies, here, coupling.rigid_map(bodies, here), np.zeros_like(here.points))


def reached(coupling: Coupling, start: Place, bodies: tuple[Any, ...], h: float) -> Place:
    """Where a step has led.

    Parameters
    ----------
    coupling : Body groups at their contacts.
    start : Where the step began.
    bodies : Body states at its end, one a group.
    h : Length of the step [s].
    """
    there = coupling.placement(bodies)
    rigid_map = coupling.rigid_map(bodies, there)
    bend = there.offset - start.contact.offset
    bend -= h * relative_velocity(coupling, bodies, there, rigid_map)
    # nothing that rigid blocks do is smaller than the rounding of places; what elastic ones do may be
    bend[(np.abs(bend) <= rounding(there)) & ~coupling.soft[:, None]] = 0.0
    return Place(bodies, there, rigid_map, bend / h)


def relative_velocity(
    coupling: Coupling, bodies: tuple[Any, ...], here: Placement, rigid_map: FloatArray
) -> FloatArray:
    """Relative velocity of the contact points in the local frames, shape (c, d) [m/s].

    Parameters
    ----------
    coupling : Body groups at c contacts.
    bodies : Body states, one a group.
    here : Contact geometry in these states.
    rigid_map : Velocities at the contacts by unit rigid velocities there, shape (c, 2, d, m).
    """
    parts = [group.velocity_parts(state) for group, state in zip(coupling.model.groups, bodies, strict=True)]
    rigid = coupling.rigid_velocity(tuple(part[0] for part in parts), rigid_map)
    return rigid + coupling.elastic_velocity(tuple(part[1] for part in parts), here)


def rounding(here: Placement) -> float:
    """What the difference of two coordinates is no more than rounding of [m]."""
    return float(ROUNDING * np.abs(here.points).max(initial=0.0))


def turning(
    coupling: Coupling,
    there: Place,
    free: tuple[Free, ...],
    forces: tuple[FloatArray, ...],
    scheme: Scheme,
    impulse: FloatArray,
    place: Place,
) -> float:
    """What impulses of statics that balance at one place leave of balance at another.

    Relative to the largest load of a block or impulse of a contact. Lever arms of the contacts turn, and so
    do those of loads on blocks that turn; in blocks that deform, impulses too.

    Parameters
    ----------
    coupling : Body groups at c contacts.
    there : Where the step has led.
    free : The step of each group without contact impulses, with the arms of loads at ``place``.
    forces : Mean external force on each group over the step.
    scheme : Length and weights of the step.
    impulse : Contact impulses, local frames, shape (c, d) [N s].
    place : Where the impulses balance.
    """
    d = impulse.shape[1]
    worst, scale = 0.0, float(np.linalg.norm(impulse, axis=1).max(initial=0.0))
    unbalanced = coupling.rigid_impulses(impulse, there.rigid_map - place.rigid_map)
    now, then = (coupling.nodal_impulses(impulse, at.contact) for at in (there, place))
    rows = zip(coupling.model.groups, there.bodies, free, forces, unbalanced, now, then, strict=True)
    for group, new, part, force, push, nodal, nodal_before in rows:
        if group.prescribed:
            continue
        moments = np.zeros_like(push)
        if group.turns:
            moments = scheme.step * group.generalised(new, force) - part.rigid_impulse
        size = np.sqrt(group.mass) * np.linalg.norm(push + moments, axis=1)
        worst = max(worst, float(size.max(initial=0.0)))
        if nodal is not None and nodal_before is not None and group.turns:
            bending = np.linalg.norm(nodal - nodal_before, axis=1)
            worst = max(worst, float(bending.max(initial=0.0)))
        given = scheme.step * np.linalg.norm(group.resultant(force)[:, :d], axis=1)
        scale = max(scale, float(given.max(initial=0.0)))
    return worst / scale if scale > 0 else worst
