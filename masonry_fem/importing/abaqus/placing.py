"""Placing: parts of an Abaqus file where its instances are.

placing = Placing()
for card in cards(text, title):
    placing.take(card)
placing.placed()           # ("left", part, move), ...
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from masonry_fem.importing.abaqus.card import Card
from masonry_fem.importing.abaqus.part import Part
from masonry_fem.solid.pose import FloatArray


@dataclass(frozen=True, slots=True)
class Move:
    """Where an instance is: moved, then turned about an axis.

    Attributes
    ----------
    shift : By how much. about : Two points of the axis and an angle in degrees, shape (7,).
    """

    shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    about: FloatArray | None = None

    @classmethod
    def of(cls, card: Card) -> Move:
        """What the lines of an instance say."""
        rows = card.numbers()
        shift = np.array(rows[0][:3]) if rows else np.zeros(3)
        return cls(shift, np.array(rows[1][:7]) if len(rows) > 1 else None)

    def __call__(self, points: FloatArray) -> FloatArray:
        """The points there."""
        moved = points + self.shift
        if self.about is None:
            return moved
        start, axis, angle = self.about[:3], self.about[3:6] - self.about[:3], np.radians(self.about[6])
        axis = axis / np.linalg.norm(axis)
        arm = moved - start
        along = (arm @ axis)[:, None] * axis
        turned: FloatArray = (
            start + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm)
        )
        return turned


@dataclass(slots=True)
class Placing:
    """What cards put together.

    Attributes
    ----------
    parts : By name in capitals. loose : What stands in no part.
    instances : Name, name of the part, and card of each.
    """

    parts: dict[str, Part] = field(default_factory=dict)
    loose: Part = field(default_factory=Part)
    instances: list[tuple[str, str, Card]] = field(default_factory=list)
    _now: Part | None = None  # the part that cards belong to; None: what is loose
    _inside: bool = False  # an instance, whose own cards are not read

    def take(self, card: Card) -> None:
        """Add what a card says.

        Raises
        ------
        GeometryError : The file is not whole, or the card cannot be read.
        """
        match card.word:
            case "PART":
                self._now = self.parts.setdefault(card.named("NAME").upper(), Part())
            case "END PART":
                self._now = None
            case "INSTANCE":
                self.instances.append((card.named("NAME"), card.named("PART").upper(), card))
                self._inside = True
            case "END INSTANCE":
                self._inside = False
            case "INCLUDE":
                raise card.fault(
                    f"it includes '{card.options.get('INPUT', '')}', expected one file with nodes and "
                    "elements; put them together"
                )
            case _ if not self._inside:
                (self._now or self.loose).take(card)

    def placed(self) -> Iterator[tuple[str, Part, Move]]:
        """Each part by the name of its instance, and where it is; a file without parts is one.

        Raises
        ------
        GeometryError : An instance is of a part that is not there.
        """
        if self.loose.elements or not self.instances:
            yield "", self.loose, Move()
        for name, part, card in self.instances:
            if part not in self.parts:
                raise card.fault(
                    f"instance '{name}' is of the part '{part}', expected one of "
                    f"{', '.join(self.parts) or 'none'}; correct the file"
                )
            yield name, self.parts[part], Move.of(card)
