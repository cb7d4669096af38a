"""Part: nodes, elements and sets of a part of an Abaqus file, or of a file without parts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.abaqus.card import Card

KINDS = {  # kind and number of nodes, by dimension and by how a type's name begins, the longest first
    3: {
        "C3D20": ("hexahedron20", 20), "C3D10": ("tetra10", 10), "C3D8": ("hexahedron", 8),
        "C3D4": ("tetra", 4),
    },
    2: {
        prefix + number: kind
        for prefix in ("CPS", "CPE")
        for number, kind in (
            ("8", ("quad8", 8)), ("6", ("triangle6", 6)), ("4", ("quad", 4)), ("3", ("triangle", 3)),
        )
    },
}  # fmt: skip
FACES = {  # corners of faces S1, S2 ..., as both programs number them
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
}


@dataclass(slots=True)
class Part:
    """What cards say of a part.

    Attributes
    ----------
    nodes : Coordinates by number. elements : Type and nodes by number.
    own : Elements of sets that ``*ELEMENT`` names. sets : Elements, or names of sets, of the others.
    surfaces : Elements, or sets of such, and which of their faces, by name.
    """

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    own: dict[str, list[int]] = field(default_factory=dict)
    sets: dict[str, list[int | str]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=dict)

    def take(self, card: Card) -> None:
        """Add what a card says, where it says something of these.

        Raises
        ------
        GeometryError : It cannot be read.
        """
        match card.word:
            case "NODE":
                for number, *place in card.numbers():
                    self.nodes[int(number)] = [*place, 0.0, 0.0][:3]
            case "ELEMENT":
                self._take_elements(card)
            case "ELSET":
                self._take_set(card)
            case "SURFACE" if card.options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
                pairs = self.surfaces.setdefault(card.named("NAME"), [])
                pairs.extend((row[0], row[1].upper()) for row in card.rows if len(row) > 1)

    def solids(self, dimension: int) -> dict[int, tuple[str, list[int]]]:
        """Kind and nodes of the elements of the scene's dimension."""
        made = {}
        for number, (kind, nodes) in self.elements.items():
            own = next((told for name, told in KINDS[dimension].items() if _is(kind, name)), None)
            if own is not None:
                made[number] = own[0], nodes
        return made

    def blocks(self, solids: set[int], title: str) -> dict[str, list[int]]:
        """Members of each block, by its name; "" where the file has no sets.

        Parameters
        ----------
        solids : Numbers of the elements that count. title : Of the file, for messages.
        """
        if not solids:
            return {}
        sets = [(name, self.members(name, title) & solids) for name in self.sets]
        proper = {name: found for name, found in sets if found and found != solids}
        if len(proper) > 1 and _divide(list(proper.values()), solids):
            return {name: sorted(found) for name, found in proper.items()}
        own = {name: sorted(solids.intersection(found)) for name, found in self.own.items()}
        left = sorted(solids.difference(*own.values()))
        return {name: found for name, found in [*own.items(), ("", left)] if found}

    def members(self, name: str, title: str, within: tuple[str, ...] = ()) -> set[int]:
        """Elements of a set, which may name other sets.

        Parameters
        ----------
        name : Of the set. title : Of the file, for messages. within : Sets that this one is a member of.

        Raises
        ------
        GeometryError : It holds itself.
        """
        if name in within:
            raise GeometryError(
                f"{title}: the set '{name}' holds itself, expected elements; correct the file"
            )
        known = {one.upper(): one for one in self.sets}
        made: set[int] = set()
        for set_name, numbers in self.own.items():
            if set_name.upper() == name.upper():
                made.update(numbers)
        for member in self.sets.get(known.get(name.upper(), name), []):
            made |= {member} if isinstance(member, int) else self.members(member, title, (*within, name))
        return made

    def _take_elements(self, card: Card) -> None:
        """Elements, whose nodes may go on in further lines."""
        kind = card.named("TYPE").upper()
        words = [int(one) for row in card.numbers() for one in row]
        counts = (count for named in KINDS.values() for own, (_, count) in named.items() if _is(kind, own))
        width = 1 + next(counts, 0)
        if width == 1:  # shells, springs and whatever else is no solid: a line each
            return
        if len(words) % width:
            raise card.fault(
                f"*ELEMENT, TYPE={kind} has {len(words)} numbers, expected {width} an element; the file is "
                "cut off or damaged: export it again"
            )
        rows = np.array(words).reshape(-1, width).tolist()
        self.elements.update({number: (kind, nodes) for number, *nodes in rows})
        if "ELSET" in card.options:
            self.own.setdefault(card.options["ELSET"], []).extend(number for number, *_ in rows)

    def _take_set(self, card: Card) -> None:
        members = self.sets.setdefault(card.named("ELSET"), [])
        if "GENERATE" not in card.options:
            words = (word for row in card.rows for word in row if word)
            members.extend(int(word) if word.isdigit() else word for word in words)
            return
        for row in card.numbers():
            first, last, *step = map(int, row)
            members.extend(range(first, last + 1, step[0] if step else 1))


def _divide(sets: list[set[int]], whole: set[int]) -> bool:
    """Whether each member of a set is in one of some others, and in no second one."""
    return sum(map(len, sets)) == len(whole) == len(set().union(*sets))


def _is(kind: str, own: str) -> bool:
    """Whether a type such as C3D8R is C3D8 with letters for its integration."""
    return kind.startswith(own) and not kind[len(own) :][:1].isdigit()
