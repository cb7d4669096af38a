"""Cell: a trial of a search: a scene with changed keys, and the name of what is kept of it.

scene = source.scene("mesh.size=0.2")
cell = Cell((), {"mesh.size": "0.2"}, dumps(scene), fingerprint(scene, source.base))
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_fem import __version__
from masonry_fem.errors import GeometryError
from masonry_fem.fidelities import deforms
from masonry_fem.importing import INPUTS
from masonry_fem.importing.abaqus import included
from masonry_fem.scene import Scene
from masonry_fem.scene.writing import plain

MOST = 2000  # cells of a search


@dataclass(frozen=True, slots=True)
class Cell:
    """A scene with changed keys.

    Attributes
    ----------
    places : Place of its value in each variation of a study.
    settings : Value of each changed key, as written.
    scene : The scene as TOML with all defaults left out; None where there is none.
    key : Hash of what is computed: of the scene, the files it names, those that these include, and the
        program's version; cells of one key are computed once.
    fault : Why there is no scene, else "".
    """

    places: tuple[int, ...]
    settings: dict[str, str]
    scene: str | None
    key: str
    fault: str = ""


def fingerprint(scene: Scene, base: Path) -> str:
    """Hash of all that a cell's results depend on.

    Rigid blocks have no elements: of a scene that has only such the mesh does not count.

    Parameters
    ----------
    scene : The scene.
    base : Folder that the paths in it are relative to.
    """
    tree = plain(scene)
    if _wholly_rigid(scene):
        tree.pop("mesh", None)
    for unseen in ("title", "output", "large", "reading"):
        tree.pop(unseen, None)
    if scene.output.determinacy:  # its reactions are others
        tree["output"] = {"determinacy": True}
    digest = hashlib.blake2b(digest_size=12)
    digest.update(f"{__version__}\n{_ordered(tree)}\n".encode())
    start = scene.analysis.start
    begun = [] if start is None else [base / start / "checkpoint.npz"]
    for path in sorted({*_files(tree, base), *(one for one in begun if one.is_file())}):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _wholly_rigid(scene: Scene) -> bool:
    return not any(deforms(name) for name in scene.fidelities)


def _ordered(value: Any) -> str:
    """A tree as text that does not depend on the order of its keys."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{key!r}:{_ordered(value[key])}" for key in sorted(value)) + "}"
    if isinstance(value, list):
        return "[" + ",".join(map(_ordered, value)) + "]"
    return repr(value)


def _files(value: Any, base: Path) -> Iterator[Path]:
    """Files that texts in a tree name."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from _files(part, base)
    elif isinstance(value, str) and "." in value and "\n" not in value:
        path = base / value
        try:
            if path.is_file():
                yield path
                yield from _included(path)
        except OSError:  # a text too long to be a name
            return


def _included(path: Path) -> list[Path]:
    """Files that an Abaqus file includes; none where one is missing, which the cell will tell."""
    try:
        return included(path) if path.suffix.lower() in INPUTS else []
    except GeometryError:
        return []
