"""Recognition: which mechanism the velocities of blocks are.

    found = mechanism_of_step(march.last, march.model)

Blocks that a closed joint connects move as one part. A joint is a *hinge* where some point of it rests and
others part, it *slides* where a point moves along the joint without leaving it, and else it *opens*. A round
joint, and a flat one in parts, is one joint, whatever the number of its facets.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.rotation import lever
from masonry_fem.contact.smooth import joints_of
from masonry_fem.march.macroblocks import ALIKE, macroblocks
from masonry_fem.march.mechanism import STRAIGHT, FloatArray, IntArray, Joint, Mechanism, Part
from masonry_fem.march.model import Model
from masonry_fem.march.motion import BlockMotion, PointMotion
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.nscd.graphs import lengths

# speeds that count as rest, over that of the fastest corner: a step is finite and solved to a tolerance
RIGID, DEFORMED = 1e-3, 1e-2
BLURRED = 0.05  # of a joint's fastest point: a hinge of blocks that deform is no point
OPEN = 1e-3  # of the typical size: a contact point that stands further apart takes no part
AS_FAST = 1e-6  # of the greatest speed: what rounding may decide
MANY = 12  # parts from which those that move nearly alike are told together


def recognise(
    model: Model,
    motion: BlockMotion,
    points: PointMotion,
    *,
    rest: float,
    share: float = 0.0,
    friction: FloatArray | float = 0.0,
) -> Mechanism:
    """The mechanism in the motion of all blocks of a model.

    Parameters
    ----------
    model : Blocks and interfaces. motion : Of all its blocks, supports too. points : Of its contact points.
    rest : Speed over that of the fastest corner below which something rests.
    share : The same over the fastest point of a joint: hinges of deformable or displaced blocks are blurred.
    friction : By how much what slides parts, over its slip: μ where joints are associated, else 0.
    """
    fastest = motion.fastest() or 1.0
    motion = motion.scaled(1 / fastest)
    contact = points.relative(motion, model.contacts.blocks)
    joint = joints_of(model.assembly, model.interfaces)
    how, telling = _ways(model, joint, contact, points.active, friction, rest, share)
    moves = motion.moves(rest)
    first = np.unique(joint, return_index=True)[1].tolist()
    part = [index for index, way in enumerate(how) if way not in ("closed", "apart")]
    # along the structure: by the first of their blocks that is no support
    part.sort(key=lambda index: sorted((motion.held[b], b) for b in model.interfaces[first[index]].blocks))
    facets = _by_number(joint, len(how))
    points_of = _by_number(np.where(telling, joint[model.contacts.interface], -1), len(how))
    joints = tuple(
        _joint(model, motion, points, facets[index], how[index], points_of[index]) for index in part
    )
    shown = np.flatnonzero(~motion.held | moves)
    closed = [first[index] for index, way in enumerate(how) if way == "closed"]
    parts = _parts(model, motion, closed, moves)
    return Mechanism(
        blocks=shown,
        centre=motion.centre[shown],
        velocity=motion.velocity[shown],
        spin=motion.spin[shown],
        contact=np.where(points.active[:, None], contact, 0.0),
        joints=joints,
        parts=parts,
        macroblocks=_macroblocks(model, motion, parts) if len(parts) > MANY else (),
        speed=fastest,
    )


def mechanism_of_step(made: Increment, model: Model) -> Mechanism:
    """How blocks move at the end of a step, shown where they were at its start.

    Blocks that deform are taken with their mean rigid motion, and what counts as rest is larger for them.

    Parameters
    ----------
    made : The step.
    model : The structure, as the step was made with it.
    """
    touches = (made.here.gap <= OPEN * model.length) & ~model.contacts.tied
    points = PointMotion(made.here.points, made.here.frame, touches)
    return _blurred(model, BlockMotion.of_step(made, model), points)


def mechanism_of_state(model: Model, state: SystemState) -> Mechanism:
    """How blocks move in a state, where they are in it.

    Parameters
    ----------
    model : The structure.
    state : Its state, with velocities.
    """
    touches = (state.gap <= OPEN * model.length) & ~model.contacts.tied
    points = PointMotion(state.points, state.frame, touches)
    return _blurred(model, BlockMotion.of(model, state.bodies, state.bodies), points)


def _blurred(model: Model, motion: BlockMotion, points: PointMotion) -> Mechanism:
    """The mechanism in motions that steps of a finite length have found."""
    deforms = any(group.deforms for group in model.groups)
    return recognise(model, motion, points, rest=DEFORMED if deforms else RIGID, share=BLURRED)


def _ways(
    model: Model,
    joint: IntArray,
    contact: FloatArray,
    active: NDArray[np.bool_],
    friction: FloatArray | float,
    rest: float,
    share: float,
) -> tuple[list[str], NDArray[np.bool_]]:
    """What each joint does: ``closed``, ``hinge``, ``slides``, ``opens``, ``apart``; points that tell where.

    Those that stood open, ``apart``, are no joints; of a hinge all points but one may. ``joint`` is that of
    each interface.
    """
    count, number = int(joint.max(initial=-1)) + 1, joint[model.contacts.interface]
    slip, speed = lengths(contact[:, 1:]), lengths(contact)
    most = np.zeros(count)
    np.maximum.at(most, number, speed)
    small = np.maximum(rest, share * most[number])
    resting = active & (speed <= small)
    sheared = active & (slip > small) & (contact[:, 0] - friction * slip <= small)
    rests, slides, touches = (np.zeros(count, dtype=bool) for _ in range(3))
    np.logical_or.at(rests, number, resting)
    np.logical_or.at(slides, number, sheared)
    np.logical_or.at(touches, number, active)
    slides &= ~rests if share else True  # a hinge may slide a little at its other end
    found = np.full(count, "opens", dtype=object)
    found[rests] = "hinge"
    found[slides] = "slides"
    found[most <= rest] = "closed"
    found[~touches] = "apart"
    fastest = _fastest(joint, model.contacts.interface, np.where(sheared | ~slides[number], speed, 0.0))
    telling = np.where((rests & ~slides)[number], resting, fastest)
    return [str(way) for way in found], telling


def _fastest(joint: IntArray, interface: IntArray, speed: FloatArray) -> NDArray[np.bool_]:
    """Points of that facet of each joint where one moves fastest; the first of several that are as fast."""
    facet, top = np.zeros(len(joint)), np.zeros(int(joint.max(initial=-1)) + 1)
    np.maximum.at(facet, interface, speed)
    np.maximum.at(top, joint, facet)
    alike = np.flatnonzero(facet >= (1 - AS_FAST) * top[joint])
    chosen = alike[np.unique(joint[alike], return_index=True)[1]]
    mask: NDArray[np.bool_] = np.isin(interface, chosen)
    return mask


def _by_number(number: IntArray, count: int) -> list[IntArray]:
    """Where each of so many numbers stands, ascending; less than 0 is none."""
    order = np.argsort(number, kind="stable")
    ends = np.searchsorted(number[order], np.arange(count + 1))
    return [order[start:end] for start, end in itertools.pairwise(ends.tolist())]


def _joint(
    model: Model,
    motion: BlockMotion,
    points: PointMotion,
    facets: IntArray,
    how: str,
    telling: IntArray,
) -> Joint:
    """Place and relative motion of a joint, from its facets and the points that tell where."""
    interface = model.interfaces[facets[0]]
    at = points.at[telling].mean(axis=0)
    first, second = interface.blocks
    slip = motion.at(np.array([first]), at[None])[0] - motion.at(np.array([second]), at[None])[0]
    names = tuple(model.assembly.blocks.names[block] for block in interface.blocks)
    turn = motion.spin[first] - motion.spin[second]
    return Joint(
        interface=int(facets[0]),
        facets=tuple(facets.tolist()),
        numbers=interface.blocks,
        between=(names[0], names[1]),
        label=interface.label,
        how=how,
        at=at,
        turn=turn,
        slip=slip,
    )


def _parts(
    model: Model, motion: BlockMotion, closed: Sequence[int], moves: NDArray[np.bool_]
) -> tuple[Part, ...]:
    """The moving blocks, joined by interfaces that stay ``closed``."""
    names = model.assembly.blocks.names
    pairs = model.interfaces.blocks[closed]
    links = sparse.coo_array(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(names), len(names))
    )
    _, part = sparse.csgraph.connected_components(links, directed=False)
    standing = np.isin(part, part[motion.held & ~moves])  # what is one with a support that rests
    members: dict[int, list[int]] = {}
    for block in np.flatnonzero(moves & ~standing).tolist():
        members.setdefault(int(part[block]), []).append(block)
    return tuple(_part(names, motion, np.array(numbers)) for numbers in members.values())


def _part(names: Sequence[str], motion: BlockMotion, numbers: IntArray) -> Part:
    at = motion.centre[numbers].mean(axis=0)
    velocity = motion.at(numbers, np.broadcast_to(at, (len(numbers), len(at)))).mean(axis=0)
    return _moving(names, motion, numbers, at, velocity, motion.spin[numbers].mean(axis=0))


def _moving(
    names: Sequence[str], motion: BlockMotion, numbers: IntArray, at: FloatArray, velocity: FloatArray,
    spin: FloatArray, straight: float = STRAIGHT,
) -> Part:  # fmt: skip
    """The part of some blocks with a velocity ``at`` a point, and its pole where it is not ``straight``."""
    pole = None
    if len(at) == 2:
        corners = np.concatenate([motion.corners[block] for block in numbers.tolist()]) - at
        turning = float(abs(spin[0]) * np.linalg.norm(corners, axis=1).max())
        if turning > straight * float(np.linalg.norm(velocity)):
            pole = at + np.array([-velocity[1], velocity[0]]) / spin[0]
    who = tuple(names[block] for block in numbers.tolist())
    return Part(tuple(numbers.tolist()), who, at, velocity, spin, pole)


def _macroblocks(model: Model, motion: BlockMotion, parts: Sequence[Part]) -> tuple[Part, ...]:
    """The parts in groups that move nearly as one."""
    names = model.assembly.blocks.names
    numbers = np.array(sorted(number for part in parts for number in part.numbers))
    corners = [motion.corners[number] for number in numbers.tolist()]
    owner = np.repeat(np.arange(len(numbers)), [len(own) for own in corners])
    points = np.concatenate(corners)
    found = macroblocks(points, motion.at(numbers[owner], points), owner)
    made = []
    for group, (velocity, spin) in enumerate(zip(found.velocity, found.spin, strict=True)):
        own = numbers[found.member == group]
        at = motion.centre[own].mean(axis=0)
        made.append(_moving(names, motion, own, at, velocity + lever(at) @ spin, spin, ALIKE))
    return tuple(made)
