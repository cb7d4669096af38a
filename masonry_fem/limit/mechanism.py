"""Mechanism: how the blocks move at collapse, and which joints are hinges, slide or open.

    mechanism.velocity[k], mechanism.spin[k]    # of free block k, the fastest corner moving at 1 m/s
    mechanism.sentence()                        # "7 blocks move: v03 to v09; hinges between ..."

It is the velocity part of a limit analysis: only ratios have a meaning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.rotation import lever
from masonry_fem.dynamics.model import Model
from masonry_fem.nscd.graphs import lengths

if TYPE_CHECKING:
    from masonry_fem.limit.problem import LimitProblem

FloatArray = NDArray[np.float64]

AT_REST = 1e-6  # of the fastest corner
SHOWN = 8  # joints or blocks that a sentence names


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint that takes part: its interface, and whether it is a ``hinge``, ``slides`` or ``opens``."""

    interface: int
    blocks: tuple[str, str]
    how: str


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Velocities of b free blocks, the fastest corner's being 1 m/s.

    Attributes
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    centre : Points that the velocities are of, shape (b, d) [m].
    velocity : shape (b, d) [m/s]. spin : shape (b, 1 or 3) [rad/s].
    contact : Relative velocity at the contact points, local frames, shape (c, d) [m/s].
    joints : Joints that do not stay closed.
    groups : Names of the blocks that move, those that move as one together.
    """

    blocks: NDArray[np.int64]
    centre: FloatArray
    velocity: FloatArray
    spin: FloatArray
    contact: FloatArray
    joints: tuple[Joint, ...]
    groups: tuple[tuple[str, ...], ...]

    @property
    def moving(self) -> int:
        """Number of blocks that move."""
        return sum(len(group) for group in self.groups)

    def sentence(self) -> str:
        """The motion in words."""
        parts = "as one" if len(self.groups) == 1 else f"in {len(self.groups)} parts"
        plural = "block moves" if self.moving == 1 else "blocks move"
        words = [f"{self.moving} {plural} {parts}" if self.moving > 1 else f"{self.groups[0][0]} moves"]
        for how, name in (("hinge", "hinge"), ("slides", "sliding joint"), ("opens", "opening joint")):
            found = [joint for joint in self.joints if joint.how == how]
            if found:
                plural = "" if len(found) == 1 else "s"
                words.append(f"{len(found)} {name}{plural}: {_listed(found)}")
        return "; ".join(words)


def mechanism_of(problem: LimitProblem, velocity: FloatArray) -> Mechanism:
    """The mechanism of the dual velocities of a program, (b m,) or more, in its units."""
    d, model = problem.dimension, problem.model
    motion = velocity[: len(problem.blocks) * (3 if d == 2 else 6)]
    contact = (problem.equilibrium.T @ motion)[: problem.points.size].reshape(problem.points.shape)
    contact = np.where(problem.active[:, None], contact, 0.0)
    motion = motion.reshape(len(problem.blocks), -1)
    linear, spin = motion[:, :d], motion[:, d:] / problem.length
    fastest = _fastest(problem, linear, spin) or 1.0
    linear, spin, contact = linear / fastest, spin / fastest, contact / fastest
    how = _ways(problem, contact)
    names = [block.name for block in model.assembly.blocks]
    joints = tuple(
        Joint(index, (names[interface.blocks[0]], names[interface.blocks[1]]), how[index])
        for index, interface in enumerate(model.interfaces)
        if how[index] != "closed"
    )
    moves = np.zeros(len(names), dtype=bool)
    # of a block at rest the centre may not move, but then it does not turn either
    moves[problem.blocks] = (lengths(linear) > AT_REST) | (problem.length * lengths(spin) > AT_REST)
    groups = _groups(model, how, moves, names)
    return Mechanism(problem.blocks, problem.centre, linear, spin, contact, joints, groups)


def _fastest(problem: LimitProblem, linear: FloatArray, spin: FloatArray) -> float:
    """Speed of the fastest corner of all free blocks."""
    fastest = 0.0
    for number, block in enumerate(problem.blocks.tolist()):
        arms = problem.model.assembly.solid(block).vertices - problem.centre[number]
        fastest = max(fastest, float(lengths(linear[number] + lever(arms) @ spin[number]).max()))
    return fastest


def _ways(problem: LimitProblem, contact: FloatArray) -> list[str]:
    """What each interface does: ``closed``, ``hinge``, ``slides`` or ``opens``."""
    count, number = len(problem.model.interfaces), problem.model.contacts.interface
    slip, speed = lengths(contact[:, 1:]), lengths(contact)
    sheared = (slip > AT_REST) & (contact[:, 0] - problem.strength.friction * slip <= AT_REST)
    least, most, slides = np.full(count, np.inf), np.zeros(count), np.zeros(count, dtype=bool)
    np.minimum.at(least, number, speed)
    np.maximum.at(most, number, speed)
    np.logical_or.at(slides, number, sheared)
    found = np.full(count, "opens", dtype=object)
    found[least <= AT_REST] = "hinge"
    found[slides] = "slides"
    found[most <= AT_REST] = "closed"
    return [str(way) for way in found]


def _groups(
    model: Model, how: list[str], moves: NDArray[np.bool_], names: list[str]
) -> tuple[tuple[str, ...], ...]:
    """Names of the moving blocks, joined where the joint between them stays closed."""
    pairs = np.array(
        [interface.blocks for index, interface in enumerate(model.interfaces) if how[index] == "closed"],
        dtype=int,
    ).reshape(-1, 2)
    links = sparse.coo_array(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(names), len(names))
    )
    _, part = sparse.csgraph.connected_components(links, directed=False)
    members: dict[int, list[str]] = {}
    for block in np.flatnonzero(moves).tolist():
        members.setdefault(int(part[block]), []).append(names[block])
    return tuple(tuple(group) for group in members.values())


def _listed(joints: Sequence[Joint]) -> str:
    shown = ", ".join(f"{joint.blocks[0]} / {joint.blocks[1]}" for joint in joints[:SHOWN])
    return f"{shown} and {len(joints) - SHOWN} more" if len(joints) > SHOWN else shown
