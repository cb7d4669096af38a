"""Mechanism: how blocks move as a structure falls: what moves as one, and which joints are hinges or slide.

    found = mechanism_of_step(march.last, march.model)      # recognition finds it
    found.sentence()      # "9 blocks move in 3 parts; 4 hinges: arch.v01 / arch.v02, ..."
    found.words()         # part by part, joint by joint, with places

Limit analysis gives such velocities too and is told in the same words. Only ratios have a meaning: the
fastest corner moves at 1 m/s. A joint is a *hinge* where some point of it rests and others part, it *slides*
where a point moves along the joint without leaving it, and else it *opens*.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.records.remark import first_few
from masonry_fem.records.told import Told

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

WAYS = {"hinge": "hinge", "slides": "sliding joint", "opens": "opening joint"}  # ``how`` a joint moves
FEW = 3  # joints alike that are told together
SHOWN = 8  # joints or blocks that a sentence names
STRAIGHT = 0.02  # a part that turns less than this, over its size, for its speed moves straight on


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint that takes part.

    Attributes
    ----------
    interface : Its number in the model, the first of several. label : Of its faces.
    facets : All of its numbers: a joint that is round, or in parts, has several.
    numbers : Of its blocks in the assembly. between : Their names.
    how : ``hinge``, ``slides`` or ``opens``.
    at : Where: the hinge, or the middle of the contact points, of several facets that of the fastest,
        shape (d,) [m].
    turn : Spin of the first block against the second, shape (1 or 3,) [rad/s].
    slip : Velocity of the first against the second there, world axes, shape (d,) [m/s].
    """

    interface: int
    facets: tuple[int, ...]
    numbers: tuple[int, int]
    between: tuple[str, str]
    label: str
    how: str
    at: FloatArray
    turn: FloatArray
    slip: FloatArray


@dataclass(frozen=True, slots=True)
class Part:
    """Blocks that move as one.

    Attributes
    ----------
    numbers : In the assembly. blocks : Their names.
    at : The mean of their middles, shape (d,) [m]. velocity : There, shape (d,) [m/s].
    spin : shape (1 or 3,) [rad/s].
    pole : Point that rests, of a plane part that turns, shape (2,) [m]; else None.
    """

    numbers: tuple[int, ...]
    blocks: tuple[str, ...]
    at: FloatArray
    velocity: FloatArray
    spin: FloatArray
    pole: FloatArray | None

    def sentence(self) -> str:
        """The part and its motion in words."""
        return f"{_spans(self.numbers, self.blocks)} {self.way()}"

    def brief(self) -> str:
        """The same of many blocks: their number and where they are."""
        speed = float(np.linalg.norm(self.velocity))
        return f"{len(self.blocks)} around {_place(self.at)} {self.way()}, {speed:.2g} of the greatest speed"

    def way(self) -> str:
        """Its motion in words."""
        one = len(self.blocks) == 1
        if self.pole is not None:
            way = "counter-clockwise" if self.spin[0] > 0 else "clockwise"
            return f"turn{'s' if one else ''} {way} about {_place(self.pole)}"
        speed = float(np.linalg.norm(self.velocity))
        if len(self.spin) == 3 and float(np.linalg.norm(self.spin)) > STRAIGHT * speed:
            axis = self.spin / np.linalg.norm(self.spin)
            return f"turn{'s' if one else ''} about the axis {_vector(axis)}"
        return f"move{'s' if one else ''} along {_vector(self.velocity / (speed or 1.0))}"


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Velocities of b blocks, the fastest corner's being 1 m/s.

    Attributes
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    centre : Points that the velocities are of, shape (b, d) [m].
    velocity : shape (b, d) [m/s]. spin : shape (b, 1 or 3) [rad/s].
    contact : Relative velocity at the contact points, local frames, shape (c, d) [m/s].
    joints : Joints that do not stay closed. parts : Blocks that move as one.
    macroblocks : Parts that move nearly as one, the largest group first; () where there are few parts.
    speed : What the fastest corner's was, of a simulation [m/s].
    """

    blocks: IntArray
    centre: FloatArray
    velocity: FloatArray
    spin: FloatArray
    contact: FloatArray
    joints: tuple[Joint, ...]
    parts: tuple[Part, ...]
    macroblocks: tuple[Part, ...] = ()
    speed: float = 1.0

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Names of the blocks that move, those that move as one together."""
        return tuple(part.blocks for part in self.parts)

    @property
    def moving(self) -> int:
        """Number of blocks that move."""
        return sum(len(part.blocks) for part in self.parts)

    @property
    def bodies(self) -> tuple[Part, ...]:
        """What one sees moving: the parts, or where there are many macro-blocks and those by themselves."""
        taken = {number for part in self.macroblocks for number in part.numbers}
        return (*self.macroblocks, *(part for part in self.parts if not taken.intersection(part.numbers)))

    def of(self, how: str) -> tuple[Joint, ...]:
        """Joints that move in a way: ``hinge``, ``slides`` or ``opens``."""
        return tuple(joint for joint in self.joints if joint.how == how)

    def sentence(self) -> str:
        """The motion in words, on one line."""
        if not self.parts:
            return "nothing moves"
        parts = "as one" if len(self.parts) == 1 else f"in {len(self.parts)} parts"
        plural = "block moves" if self.moving == 1 else "blocks move"
        words = [f"{self.moving} {plural} {parts}" if self.moving > 1 else f"{self.groups[0][0]} moves"]
        words += [self._counted(found, name) for how, name in WAYS.items() if (found := self.of(how))]
        if self.macroblocks:
            alike = "; ".join(part.brief() for part in self.macroblocks)
            words[0] += f", nearly so in {len(self.macroblocks)}: {alike}"
            alone = self.moving - sum(len(part.blocks) for part in self.macroblocks)
            words[0] += f"; {alone} by themselves" if alone else ""
        return "; ".join(words)

    def _counted(self, joints: Sequence[Joint], name: str) -> str:
        """Number of joints that move alike, and which, unless macro-blocks say where they are."""
        named = "" if self.macroblocks else f": {_listed(joints)}"
        return f"{len(joints)} {name}{'' if len(joints) == 1 else 's'}{named}"

    def words(self) -> tuple[str, ...]:
        """Part by part and joint by joint, where and how; many joints between two parts together.

        Of many parts the macro-blocks are told, and the joints between these.
        """
        if self.macroblocks:
            seams = sorted(self._seams(self.macroblocks), key=len, reverse=True)
            lines = [f"{part.brief()}: {_spans(part.numbers, part.blocks)}" for part in self.macroblocks]
            return (*lines, *(_seam(found) if len(found) > 1 else _told(found[0]) for found in seams))
        lines = [part.sentence() for part in self.parts]
        for found in self._seams(self.parts):
            lines += [_told(joint) for joint in found] if len(found) < FEW else [_seam(found)]
        return tuple(lines)

    def _seams(self, parts: Sequence[Part]) -> list[list[Joint]]:
        """Joints between the same two parts that move alike."""
        part = {number: rank for rank, one in enumerate(parts) for number in one.numbers}
        found: dict[Any, list[Joint]] = {}
        for joint in self.joints:
            sides = frozenset(part.get(number, -1) for number in joint.numbers)
            found.setdefault((joint.how, joint.label, sides), []).append(joint)
        return list(found.values())

    def told(self) -> Falling:
        """What summaries hold."""
        return Falling(
            sentence=self.sentence(),
            words=self.words(),
            groups=self.groups,
            parts=self.parts,
            macroblocks=self.macroblocks,
            joints=self.joints,
        )


class Moving(Told, frozen=True, kw_only=True):
    """How one block moves.

    Attributes
    ----------
    block : Its name.
    at : Point that the velocity is of, shape (d,) [m].
    velocity : Velocity, shape (d,) [m/s].
    spin : Angular velocity, shape (1 or 3,) [rad/s].
    """

    block: str
    at: FloatArray
    velocity: FloatArray
    spin: FloatArray


class Falling(Told, frozen=True, kw_only=True):
    """A mechanism in words and numbers, as summaries hold it.

    Attributes
    ----------
    sentence : The motion on one line.
    words : Part by part and joint by joint, a line each.
    groups : Names of the blocks that move, those that move as one together.
    parts : Blocks that move as one.
    macroblocks : Parts that move nearly as one, the largest group first; empty where there are few parts.
    joints : Joints that do not stay closed.
    blocks : Block by block, where limit analysis found the mechanism; else None.
    """

    sentence: str
    words: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    parts: tuple[Part, ...]
    macroblocks: tuple[Part, ...]
    joints: tuple[Joint, ...]
    blocks: tuple[Moving, ...] | None = None


# --- words ------------------------------------------------------------------------------------


def _told(joint: Joint) -> str:
    """A joint with its place and motion."""
    where = f"{f'{joint.label} ' if joint.label else ''}{joint.between[0]} / {joint.between[1]}"
    turn = float(np.linalg.norm(joint.turn))
    if joint.how == "hinge":
        return f"hinge {where} at {_place(joint.at)}, turning {turn:.3g} rad a metre"
    way = "slides" if joint.how == "slides" else "opens"
    speed = float(np.linalg.norm(joint.slip))
    along = f" along {_vector(joint.slip / speed)}" if speed > 0 else ""
    return f"{where} at {_place(joint.at)} {way}{along}, {speed:.3g} of the greatest speed"


def _seam(joints: Sequence[Joint]) -> str:
    """Joints between two parts, the first and the last of them named."""
    ends = [f"{joint.between[0]} / {joint.between[1]}" for joint in (joints[0], joints[-1])]
    label = f"{joints[0].label} joints" if joints[0].label else "joints"
    where = f"{len(joints)} {label} from {ends[0]} to {ends[1]}"
    if joints[0].how == "hinge":
        return f"{where} are hinges, turning {float(np.linalg.norm(joints[0].turn)):.3g} rad a metre"
    speeds = [float(np.linalg.norm(joint.slip)) for joint in joints]
    fastest = joints[int(np.argmax(speeds))]
    along = f" along {_vector(fastest.slip / max(speeds))}" if max(speeds) > 0 else ""
    way = "slide" if joints[0].how == "slides" else "open"
    return f"{where} {way}{along}, up to {max(speeds):.3g} of the greatest speed"


def _place(point: FloatArray) -> str:
    return f"({', '.join(_number(value) for value in point)}) m"


def _vector(values: FloatArray) -> str:
    return f"({', '.join(_number(value) for value in values)})"


def _number(value: float) -> str:
    rounded = round(float(value), 3)
    return f"{rounded + 0.0:.4g}" if abs(value) < 1e4 else f"{value:.4g}"


def _spans(numbers: Sequence[int], names: Sequence[str]) -> str:
    """Names, ``a to c`` where they follow each other in the assembly."""
    runs: list[list[int]] = []
    for place, number in enumerate(numbers):
        if runs and numbers[runs[-1][-1]] == number - 1:
            runs[-1].append(place)
        else:
            runs.append([place])
    said = [
        f"{names[run[0]]} to {names[run[-1]]}" if len(run) > 2 else ", ".join(names[i] for i in run)
        for run in runs
    ]
    if len(said) <= SHOWN:
        return ", ".join(said)
    left = len(names) - sum(len(run) for run in runs[:SHOWN])
    return f"{', '.join(said[:SHOWN])} and {left} more"


def _listed(joints: Sequence[Joint]) -> str:
    return first_few((f"{joint.between[0]} / {joint.between[1]}" for joint in joints), SHOWN)
