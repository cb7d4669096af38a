"""Surfaces: skins of blocks from ``.stl``, ``.obj`` and ``.ply`` files.

    skins = read_surfaces(Path("arch.stl"), "structures.arch.path 'arch.stl'")

STL: each ``solid`` of a text file is a block; in a binary file each connected body. OBJ: each object ``o``
is a block, or each group ``g`` in a file without objects, and ``usemtl`` names faces. PLY: each connected
body.
A solid, object or group with several bodies gives one block each, ``name_1``, ``name_2``...
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.foreign import quietly_read
from masonry_fem.importing.naming import UNSPACED, Names, tell_renamed, unlike
from masonry_fem.importing.skin import Skin, parts_of, rows_by
from masonry_fem.solid.pose import FloatArray

HEAD, RECORD = 84, 50  # bytes of a binary STL file before its triangles, and of each
ANY = "b"  # blocks without a name of their own are b1, b2, ...


def read_surfaces(path: Path, title: str) -> list[Skin]:
    """The blocks of a surface file, in its order, with different names.

    Parameters
    ----------
    path : An STL, OBJ or PLY file.
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : The file does not describe surfaces.
    """
    skins = READERS[path.suffix.lower()](path, title)
    if not skins:
        raise GeometryError(f"{title} holds no face, expected closed surfaces; export the solids again")
    return skins


def _stl(path: Path, title: str) -> list[Skin]:
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little") if len(data) >= HEAD else -1
    if len(data) == HEAD + RECORD * count:  # some binary files begin with 'solid' too
        kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(data, kind, offset=HEAD)["corners"].astype(float)
        return parts_of(_soup(ANY, corners.reshape(-1, 3)), "") if count else []
    if not data.lstrip().lower().startswith(b"solid"):
        raise GeometryError(
            f"{title} has {len(data)} bytes, expected text that begins with 'solid' or "
            f"{HEAD + RECORD * max(count, 0)} bytes of triangles; the file is cut off or no "
            "STL: export it again"
        )
    return _named(list(_solids(data.decode(errors="replace"), title)), title)


def _solids(text: str, title: str) -> Iterator[tuple[str, FloatArray]]:
    """Name and corners (3 a triangle) of the solids of a text file."""
    name = ""
    corners: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        key = words[0].lower() if words else ""
        if key == "solid":
            name, corners = " ".join(words[1:]), []
        elif key == "vertex":
            corners.append(_numbers(words[1:], 3, title, number))
        elif key == "endloop" and len(corners) % 3:
            raise GeometryError(
                f"{title}, line {number}: a facet has not three corners, expected triangles; export it again"
            )
        elif key == "endsolid":
            yield name, np.array(corners).reshape(-1, 3)
            corners = []
    if corners:
        raise GeometryError(
            f"{title} ends within solid '{name}', expected 'endsolid'; the file is cut off: export it again"
        )


def _named(solids: list[tuple[str, FloatArray]], title: str) -> list[Skin]:
    filled = [(name, corners) for name, corners in solids if len(corners)]
    if len(filled) == 1:  # its name is mostly that of the program or of the whole model, so it is not used
        return parts_of(_soup(ANY, filled[0][1]), "")
    tidy = Names(UNSPACED)
    names = unlike([tidy.of(name) or f"{ANY}{number}" for number, (name, _) in enumerate(filled, start=1)])
    said = [name for name, _ in filled]
    tell_renamed(title, {one: own for one, own in zip(said, names, strict=True) if one not in ("", own)})
    return [
        part
        for name, (_, corners) in zip(names, filled, strict=True)
        for part in parts_of(_soup(name, corners), "_")
    ]


def _soup(name: str, corners: FloatArray) -> Skin:
    """Triangles given by their corners one after another."""
    loops = np.arange(len(corners)).reshape(-1, 3).tolist()
    return Skin(name, corners, tuple((a, b, c) for a, b, c in loops))


def _obj(path: Path, title: str) -> list[Skin]:
    return _by_group(*faces_of_obj(path, title))


@dataclass(frozen=True, slots=True)
class ObjFace:
    """A polygon of an OBJ file: the names that hold for it ("" for none), and rows of its corners."""

    object: str
    group: str
    material: str
    corners: tuple[int, ...]


def faces_of_obj(path: Path, title: str) -> tuple[FloatArray, list[ObjFace]]:
    """Points of an OBJ file, shape (n, 3), and its polygons.

    Parameters
    ----------
    path : The file.
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : A line that cannot be read.
    """
    points: list[list[float]] = []
    faces: list[ObjFace] = []
    word = {"o": "", "g": "", "usemtl": ""}
    names = {key: Names(UNSPACED) for key in word}
    for number, line in enumerate(_joined(path.read_text(encoding="utf-8", errors="replace")), start=1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] == "v":
            points.append(_numbers(words[1:4], 3, title, number))
        elif words[0] in word:
            word[words[0]] = names[words[0]].of(" ".join(words[1:]))
        elif words[0] == "f":
            corners = tuple(_corner(one, len(points), title, number) for one in words[1:])
            if len(corners) < 3:
                raise GeometryError(
                    f"{title}, line {number}: a face has {len(corners)} corners, expected 3 or more; "
                    "correct the file"
                )
            faces.append(ObjFace(word["o"], word["g"], word["usemtl"], corners))
    tell_renamed(title, names["o"].changed | names["g"].changed | names["usemtl"].changed)
    return np.array(points, dtype=float).reshape(-1, 3), faces


def _joined(text: str) -> list[str]:
    """Lines; one that goes on in the next (by a backslash) leaves an empty one behind."""
    lines = text.splitlines()
    for i in range(len(lines) - 1, 0, -1):
        if lines[i - 1].endswith("\\"):
            lines[i - 1], lines[i] = lines[i - 1][:-1] + " " + lines[i], ""
    return lines


def _corner(word: str, count: int, title: str, line: int) -> int:
    """Row of a corner ``7``, ``7/1/2`` or ``-1`` (counted from the last point)."""
    try:
        number = int(word.split("/", maxsplit=1)[0])
    except ValueError:
        number = 0
    row = number - 1 if number > 0 else count + number
    if number == 0 or not 0 <= row < count:
        raise GeometryError(
            f"{title}, line {line}: a face has the corner '{word}', expected the number of one of the "
            f"{count} points above; correct the file"
        )
    return row


def _by_group(points: FloatArray, faces: list[ObjFace]) -> list[Skin]:
    objects, groups = [one.object for one in faces], [one.group for one in faces]
    by_object = len(set(objects)) > 1 or (any(objects) and not any(groups))
    whole = Skin(ANY, points, tuple(one.corners for one in faces), tuple(one.material for one in faces))
    return [
        part
        for name, rows in rows_by(objects if by_object else groups).items()
        for part in parts_of(whole.part(name or ANY, rows), "_" if name else "")
    ]


def _ply(path: Path, title: str) -> list[Skin]:
    if not any(line.strip() == b"end_header" for line in path.read_bytes().split(b"\n")):
        # meshio would look for it without end
        raise GeometryError(
            f"{title} has no line 'end_header', expected a header that ends so; the file is cut off: "
            "export it again"
        )
    mesh = quietly_read(path, title)
    loops = [
        tuple(int(vertex) for vertex in row)
        for block in mesh.cells
        if block.type in {"triangle", "quad"} or block.type.startswith("polygon")
        for row in block.data
    ]
    return parts_of(Skin(ANY, np.array(mesh.points, dtype=float), tuple(loops)), "") if loops else []


def _numbers(words: list[str], count: int, title: str, line: int) -> list[float]:
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = []
    if len(found) != count:
        said = "; write decimal points for commas" if any("," in word for word in words) else "; correct it"
        raise GeometryError(
            f"{title}, line {line}: '{' '.join(words)}' are no coordinates, expected {count} numbers{said}"
        )
    return found


READERS: dict[str, Callable[[Path, str], list[Skin]]] = {".stl": _stl, ".obj": _obj, ".ply": _ply}
