"""Abaqus: elements of blocks from the ``.inp`` files of Abaqus, CalculiX and PrePoMax.

    found = read_abaqus(Path("arch.inp"), 3, "structures.arch.path 'arch.inp'")

Blocks are the ``*ELSET`` of solids where these are at least two, have no element in common and leave none
out; otherwise the sets that ``*ELEMENT, ELSET=`` names. Faces of ``*SURFACE, TYPE=ELEMENT`` have its name.
Parts are placed as their ``*INSTANCE`` says. ``*INCLUDE`` brings the lines of files in the same folder or
below. Materials, steps and boundary conditions are not read.
Serendipity elements (C3D20, CPS8) get the nodes in the middle of faces and of the body that they lack,
where their functions put them. Wedges (C3D6) are divided into three tetrahedra.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.naming import UNSELECTABLE, Names, tell_renamed
from masonry_fem.meshing.session import Elements
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

KINDS = {  # kind and number of nodes, by dimension and by how a type's name begins, the longest first
    3: {
        "C3D20": ("hexahedron20", 20), "C3D10": ("tetra10", 10), "C3D8": ("hexahedron", 8),
        "C3D6": ("wedge", 6), "C3D4": ("tetra", 4),
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
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
}
# faces of a hexahedron in our order, by the nodes of a 20-node one on them: 4 corners, 4 middles
HEX_FACES = (
    (0, 3, 7, 4, 11, 19, 15, 16), (1, 2, 6, 5, 9, 18, 13, 17), (0, 1, 5, 4, 8, 17, 12, 16),
    (3, 2, 6, 7, 10, 18, 14, 19), (0, 1, 2, 3, 8, 9, 10, 11), (4, 5, 6, 7, 12, 13, 14, 15),
)  # fmt: skip

# a wedge by the corner that shall be its first, and its tetrahedra by the diagonal of the far face
TURNS = np.array([
    (0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4),
    (3, 5, 4, 0, 2, 1), (4, 3, 5, 1, 0, 2), (5, 4, 3, 2, 1, 0),
])  # fmt: skip
TETRAHEDRA = np.array([
    ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)),
    ((0, 1, 2, 4), (0, 4, 2, 5), (0, 4, 5, 3)),
])  # fmt: skip


@dataclass(frozen=True, slots=True)
class Read:
    """What a file holds.

    Attributes
    ----------
    points : Nodes, shape (n, 3). parts : Name ("" where there are no sets) and elements of each block.
    named : Names of faces by the sorted rows of their corners.
    """

    points: FloatArray
    parts: list[tuple[str, Elements]]
    named: dict[tuple[int, ...], str]


@dataclass(slots=True)
class _Part:
    """Nodes, elements and sets of a part, or of a file without parts."""

    nodes: dict[int, list[float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    own: dict[str, list[int]] = field(default_factory=dict)  # sets that *ELEMENT names
    sets: dict[str, list[int | str]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    unknown: dict[str, str] = field(
        default_factory=dict
    )  # types that are not read, and the first line of each


@dataclass(frozen=True, slots=True)
class _Card:
    """A keyword with its options, the lines under it, and where it stands."""

    word: str
    options: dict[str, str]
    rows: list[list[str]]
    line: str

    def named(self, option: str, title: str) -> str:
        if option not in self.options:
            raise GeometryError(
                f"{title}, line {self.line}: *{self.word} has no {option}=, expected a name; correct the file"
            )
        return self.options[option]


def read_abaqus(path: Path, dimension: int, title: str) -> Read:
    """Elements of the scene's dimension, block by block.

    Parameters
    ----------
    path : The file. dimension : 2 or 3. title : Name of the file in messages.

    Raises
    ------
    GeometryError : A line that cannot be read, solids of a kind that is not known, several kinds in a block.
    """
    cards = list(_cards(path, title))
    points: list[FloatArray] = []
    parts: list[tuple[str, Elements]] = []
    named: dict[tuple[int, ...], str] = {}
    names = Names(UNSELECTABLE)
    for prefix, part, move in _placed(cards, title):
        first = sum(map(len, points))
        made = _made(part, dimension, title)
        points.append(move(made.points))
        for name, elements in made.parts:
            whole = names.of(".".join(filter(None, (prefix, name)))) if prefix or name else ""
            parts.append((whole, Elements(elements.kind, elements.nodes + first)))
        for corners, name in made.named.items():
            named[tuple(first + corner for corner in corners)] = names.of(name)
    tell_renamed(title, names.changed)
    if not parts:
        body = {2: "plane (CPS, CPE)", 3: "solid (C3D)"}[dimension]
        raise GeometryError(
            f"{title} has no {body} elements, expected a meshed {dimension}D model; export the mesh itself"
        )
    return Read(np.concatenate(points), parts, named)


def _cards(path: Path, title: str) -> Iterator[_Card]:
    """The cards of a file."""
    card: _Card | None = None
    for place, words in _lines(path, title, {}):
        if words.startswith("*"):
            if card is not None:
                yield card
            word, options = _head(words)
            card = _Card(word, options, [], place)
        elif card is not None:
            card.rows.append([one.strip() for one in words.rstrip(",").split(",")])
    if card is not None:
        yield card


def _head(words: str) -> tuple[str, dict[str, str]]:
    """A card's keyword and options."""
    head, *rest = (one.strip() for one in words[1:].split(","))
    pairs = (one.partition("=") for one in rest if one)
    options = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
    return " ".join(head.upper().split()), options


def _lines(
    path: Path, title: str, files: dict[Path, None], within: tuple[Path, ...] = ()
) -> Iterator[tuple[str, str]]:
    """The lines of a file that say something, those of included files in their place, and where each is.

    Included files are added to ``files``.
    """
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        words = line.strip()
        if not words or words.startswith("**"):
            continue
        place = f"{number} of '{path.name}'" if within else str(number)
        if not words.startswith("*") or _head(words)[0] != "INCLUDE":
            yield place, words
            continue
        name = _head(words)[1].get("INPUT", "")
        folder = (within[0] if within else path).parent
        found = (folder / name).resolve()
        if found in (one.resolve() for one in (*within, path)):
            raise GeometryError(
                f"{title}, line {place}: '{name}' includes itself, expected an end; correct the file"
            )
        if not found.is_relative_to(folder.resolve()) or not found.is_file():
            raise GeometryError(
                f"{title}, line {place}: it includes '{name}', expected a file in its folder or below; "
                "put it there"
            )
        files[found] = None
        yield from _lines(found, title, files, (*within, path))


def included(path: Path) -> list[Path]:
    """The files beside an ``.inp`` that it includes, and those that these include.

    Raises
    ------
    GeometryError : One is missing, not below the file's folder, or includes itself.
    """
    files: dict[Path, None] = {}
    for _ in _lines(path, path.name, files):
        pass
    return list(files)


def _placed(cards: list[_Card], title: str) -> Iterator[tuple[str, _Part, _Move]]:
    """Each part by the name of its instance, and where it is; a file without parts is one."""
    parts: dict[str, _Part] = {}
    loose, now = _Part(), None
    instances: list[tuple[str, str, _Card]] = []
    inside = False
    for card in cards:
        if card.word == "PART":
            now = parts.setdefault(card.named("NAME", title).upper(), _Part())
        elif card.word == "END PART":
            now = None
        elif card.word == "INSTANCE":
            instances.append((card.named("NAME", title), card.named("PART", title).upper(), card))
            inside = True
        elif card.word == "END INSTANCE":
            inside = False
        elif not inside:
            _take(now if now is not None else loose, card, title)
    if loose.elements or not instances:
        yield "", loose, _Move()
    for name, part, card in instances:
        if part not in parts:
            raise GeometryError(
                f"{title}, line {card.line}: instance '{name}' is of the part '{part}', expected one of "
                f"{', '.join(parts) or 'none'}; correct the file"
            )
        yield name, parts[part], _Move.of(card, title)


@dataclass(frozen=True, slots=True)
class _Move:
    """Where an instance is: moved, then turned about an axis."""

    shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    about: FloatArray | None = None  # two points of the axis and an angle in degrees, shape (7,)

    @classmethod
    def of(cls, card: _Card, title: str) -> _Move:
        rows = [_numbers(row, card, title) for row in card.rows]
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


def _take(part: _Part, card: _Card, title: str) -> None:
    """Add what a card says to a part."""
    if card.word == "NODE":
        for row in card.rows:
            number, *place = _numbers(row, card, title)
            part.nodes[int(number)] = [*place, 0.0, 0.0][:3]
    elif card.word == "ELEMENT":
        _take_elements(part, card, title)
    elif card.word == "ELSET":
        members = part.sets.setdefault(card.named("ELSET", title), [])
        if "GENERATE" in card.options:
            for row in card.rows:
                first, last, *step = (int(one) for one in _numbers(row, card, title))
                members.extend(range(first, last + 1, step[0] if step else 1))
        else:
            members.extend(int(word) if word.isdigit() else word for row in card.rows for word in row if word)
    elif card.word == "SURFACE" and card.options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
        pairs = part.surfaces.setdefault(card.named("NAME", title), [])
        pairs.extend((row[0], row[1].upper()) for row in card.rows if len(row) > 1)


def _take_elements(part: _Part, card: _Card, title: str) -> None:
    """Elements, whose nodes may go on in further lines."""
    kind = card.named("TYPE", title).upper()
    words = [int(one) for row in card.rows for one in _numbers(row, card, title)]
    counts = (count for named in KINDS.values() for own, (_, count) in named.items() if _is(kind, own))
    width = 1 + next(counts, 0)
    if width == 1:  # shells, springs and whatever else is no solid: a line each
        part.unknown.setdefault(kind, card.line)
        return
    if len(words) % width:
        raise GeometryError(
            f"{title}, line {card.line}: *ELEMENT, TYPE={kind} has {len(words)} numbers, expected {width} an "
            "element; the file is cut off or damaged: export it again"
        )
    rows = np.array(words).reshape(-1, width).tolist()
    part.elements.update({number: (kind, nodes) for number, *nodes in rows})
    if "ELSET" in card.options:
        part.own.setdefault(card.options["ELSET"], []).extend(number for number, *_ in rows)


def _is(kind: str, own: str) -> bool:
    """Whether a type such as C3D8R is C3D8 with letters for its integration."""
    return kind.startswith(own) and not kind[len(own) :][:1].isdigit()


def _numbers(row: list[str], card: _Card, title: str) -> list[float]:
    try:
        return [float(one) for one in row if one]
    except ValueError:
        raise GeometryError(
            f"{title}, below line {card.line} (*{card.word}): '{', '.join(row)}' are no numbers; correct it"
        ) from None


def _made(part: _Part, dimension: int, title: str) -> Read:
    """Nodes by rows, blocks and named faces of a part."""
    tags = np.array(sorted(part.nodes), dtype=np.int64)
    points = np.array([part.nodes[tag] for tag in tags.tolist()], dtype=float).reshape(-1, 3)
    solids = _solids(part, dimension)
    for kind, line in part.unknown.items():
        if kind.startswith({2: ("CPS", "CPE"), 3: ("C3D",)}[dimension]):
            raise GeometryError(
                f"{title}, line {line}: elements of TYPE={kind}, expected "
                f"{', '.join(sorted(KINDS[dimension]))}; without them the blocks would have "
                "holes: mesh it with these"
            )
    blocks = _blocks(part, set(solids), title)
    parts: list[tuple[str, Elements]] = []
    for name, members in blocks.items():
        for kind in dict.fromkeys(solids[one][0] for one in members):
            nodes = np.array([solids[one][1] for one in members if solids[one][0] == kind])
            if name and any(solids[one][0] != kind for one in members):
                raise GeometryError(
                    f"{title}: the set '{name}' has elements of several kinds, expected one; mesh it "
                    "anew, or part it"
                )
            rows = _rows(nodes, tags, name, title)
            if kind in FULL:
                rows, points = FULL[kind](rows, points)
            parts.append((name, Elements(COMPLETE.get(kind, kind), rows)))
    return Read(points, parts, _named(part, solids, tags))


def _solids(part: _Part, dimension: int) -> dict[int, tuple[str, list[int]]]:
    """Kind and nodes of the elements of the scene's dimension."""
    made = {}
    for number, (kind, nodes) in part.elements.items():
        own = next((told for name, told in KINDS[dimension].items() if _is(kind, name)), None)
        if own is not None:
            made[number] = own[0], nodes
    return made


def _blocks(part: _Part, solids: set[int], title: str) -> dict[str, list[int]]:
    """Members of each block, by its name; "" where the file has no sets."""
    if not solids:
        return {}
    sets = {name: _members(name, part, title) & solids for name in part.sets}
    sets = {name: found for name, found in sets.items() if found and found != solids}
    if len(sets) > 1 and sum(map(len, sets.values())) == len(solids) == len(set.union(*sets.values())):
        return {name: sorted(found) for name, found in sets.items()}
    own = {name: sorted(set(found) & solids) for name, found in part.own.items()}
    left = sorted(solids - {one for found in own.values() for one in found})
    return {name: found for name, found in own.items() if found} | ({"": left} if left else {})


def _members(name: str, part: _Part, title: str, within: tuple[str, ...] = ()) -> set[int]:
    """Elements of a set, which may name other sets."""
    known = {one.upper(): one for one in part.sets}
    made = {
        one for set_name, numbers in part.own.items() if set_name.upper() == name.upper() for one in numbers
    }
    if name in within:
        raise GeometryError(f"{title}: the set '{name}' holds itself, expected elements; correct the file")
    for member in part.sets.get(known.get(name.upper(), name), []):
        made |= {member} if isinstance(member, int) else _members(member, part, title, (*within, name))
    return made


def _rows(nodes: IntArray, tags: IntArray, name: str, title: str) -> IntArray:
    """Rows of nodes by their numbers."""
    rows = np.searchsorted(tags, nodes)
    lost = rows == len(tags)
    lost |= tags[np.where(lost, 0, rows)] != nodes
    if lost.any():
        raise GeometryError(
            f"{title}: an element of '{name}' has the node {nodes[lost][0]}, expected one of the file's; "
            "export it again"
        )
    return rows


def _named(
    part: _Part, solids: dict[int, tuple[str, list[int]]], tags: IntArray
) -> dict[tuple[int, ...], str]:
    """Names of faces, by the sorted rows of their corners."""
    row = {tag: number for number, tag in enumerate(tags.tolist())}
    named: dict[tuple[int, ...], str] = {}
    for name, pairs in part.surfaces.items():
        for which, side in pairs:
            members = {int(which)} if which.isdigit() else _members(which, part, "")
            for member in members & set(solids):
                kind, nodes = solids[member]
                faces = FACES[kind.rstrip("0123456789")]
                number = int(side[1:]) - 1 if side[1:].isdigit() else -1
                if 0 <= number < len(faces):
                    corners = [row[nodes[corner]] for corner in faces[number]]
                    for face in _halves(corners) if kind == "wedge" else [corners]:
                        named[tuple(sorted(face))] = name
    return named


def _complete_hexahedra(rows: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """27 nodes of 20: those of faces are shared by the two elements that meet there."""
    faces = rows[:, np.array(HEX_FACES)]  # (elements, 6, 8)
    keys = np.sort(faces[..., :4], axis=2).reshape(-1, 4)
    _, first, where = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    own = points[faces.reshape(-1, 8)[first]]
    middle = 0.5 * own[:, 4:].sum(axis=1) - 0.25 * own[:, :4].sum(axis=1)
    body = 0.25 * points[rows[:, 8:]].sum(axis=1) - 0.25 * points[rows[:, :8]].sum(axis=1)
    count = len(points)
    inner = count + len(middle) + np.arange(len(rows))[:, None]
    whole = np.hstack([rows, count + where.reshape(-1, 6), inner])
    return whole, np.concatenate([points, middle, body])


def _complete_quads(rows: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """9 nodes of 8."""
    middle = 0.5 * points[rows[:, 4:]].sum(axis=1) - 0.25 * points[rows[:, :4]].sum(axis=1)
    inner = len(points) + np.arange(len(rows))[:, None]
    return np.hstack([rows, inner]), np.concatenate([points, middle])


def _divide_wedges(rows: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Three tetrahedra of each wedge, whose faces fit those of its neighbours.

    Each face with four corners is cut from the corner with the least number, in both wedges alike.

    References
    ----------
    Dompierre, Labbé, Vallet and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra,
    8th International Meshing Roundtable (1999).
    """
    turned = np.take_along_axis(rows, TURNS[rows.argmin(axis=1)], axis=1)  # its least number comes first
    first = np.minimum(turned[:, 1], turned[:, 5]) < np.minimum(turned[:, 2], turned[:, 4])
    cut = np.where(first[:, None, None], TETRAHEDRA[0], TETRAHEDRA[1])
    divided = np.take_along_axis(turned[:, None, :], cut, axis=2).reshape(-1, 4)
    return divided, points


def _halves(corners: list[int]) -> list[list[int]]:
    """The triangles of a wedge's face: itself, or two that are cut from the corner with the least number."""
    if len(corners) == 3:
        return [corners]
    at = corners.index(min(corners))
    a, b, c, d = corners[at:] + corners[:at]
    return [[a, b, c], [a, c, d]]


FULL = {"hexahedron20": _complete_hexahedra, "quad8": _complete_quads, "wedge": _divide_wedges}
COMPLETE = {"hexahedron20": "hexahedron27", "quad8": "quad9", "wedge": "tetra"}
