"""Cell: one combination of a study's values, with the scene that it makes.

cells = plan(text, variations, overrides, base=Path("demos"), source="arch.toml")
cells[0].settings, cells[0].key           # {"mesh.size": "0.2", ...}, hash of the scene
"""

from __future__ import annotations

import hashlib
import itertools
import math
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_fem import __version__
from masonry_fem.analyses.study.variation import Variation
from masonry_fem.errors import GeometryError, MasonryError, SceneError
from masonry_fem.fidelities import deforms
from masonry_fem.importing.abaqus import included
from masonry_fem.importing.endings import INPUTS
from masonry_fem.scene import Scene, dumps, loads
from masonry_fem.scene.writing import plain

MOST = 2000
RIVALS = {"size": "divisions", "divisions": "size"}


@dataclass(frozen=True, slots=True)
class Cell:
    """One combination.

    Attributes
    ----------
    places : Place of its value in each variation.
    settings : Value of each varied key, as written.
    scene : The scene as TOML with all defaults left out; None where there is none.
    key : Hash of what is computed: of the scene, the files it names and the program's version; cells of
        one key are computed once.
    fault : Why there is no scene, else "".
    """

    places: tuple[int, ...]
    settings: dict[str, str]
    scene: str | None
    key: str
    fault: str = ""


def plan(
    text: str, vary: Sequence[Variation], overrides: Sequence[str], *, base: Path, source: str
) -> list[Cell]:
    """All combinations, the coarsest first.

    Parameters
    ----------
    text : The scene as TOML.
    vary : Keys and their values.
    overrides : Texts ``key=value`` for all cells.
    base : Folder that the scene's paths are relative to.
    source : What messages call the scene.

    Raises
    ------
    MasonryError : There are too many combinations, or none makes a valid scene.
    """
    count = math.prod(len(one.values) for one in vary)
    if count > MOST:
        shape = " x ".join(str(len(one.values)) for one in vary)
        raise MasonryError(
            f"the study has {shape} = {count} cells, expected at most {MOST}; vary fewer values"
        )
    _refuse_doubles(vary, overrides)
    cleared = [*room(text, vary, overrides), *overrides]
    cells = [_cell(text, vary, places, cleared, base, source) for places in _places(vary)]
    if all(cell.scene is None for cell in cells):
        raise SceneError(cells[0].fault)
    return cells


def room(text: str, vary: Sequence[Variation], overrides: Sequence[str]) -> list[str]:
    """Overrides that remove keys which varied ones replace: ``mesh.size`` if ``mesh.divisions`` varies.

    Parameters
    ----------
    text : The scene as TOML.
    vary : Keys and their values.
    overrides : Texts ``key=value`` for all cells.
    """
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return []  # reading the scene says it better
    taken = {one.key for one in vary} | {one.partition("=")[0].strip() for one in overrides}
    made = []
    for one in vary:
        path, _, name = one.key.rpartition(".")
        table = _table(tree, path)
        rival = RIVALS.get(name)
        if path.endswith("mesh") and rival in table and f"{path}.{rival}" not in taken:
            kept = {key: value for key, value in table.items() if key != rival}
            made.append(Variation(path, (kept,)).override(0))
    return made


def _places(vary: Sequence[Variation]) -> Iterator[tuple[int, ...]]:
    """Places of the values of each cell, coarse values first."""
    by_rank = [sorted(range(len(one.values)), key=one.ranks.__getitem__) for one in vary]
    return itertools.product(*by_rank)


def _cell(
    text: str,
    vary: Sequence[Variation],
    places: tuple[int, ...],
    overrides: Sequence[str],
    base: Path,
    source: str,
) -> Cell:
    own = [one.override(place) for one, place in zip(vary, places, strict=True)]
    settings = {one.key: one.text(place) for one, place in zip(vary, places, strict=True)}
    try:
        scene = loads(text, [*overrides, *own], base=base, source=source)
    except MasonryError as error:
        return Cell(places, settings, None, "", str(error))
    return Cell(places, settings, dumps(scene), fingerprint(scene, base))


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


def _table(tree: Any, path: str) -> dict[str, Any]:
    """The table at a dotted path; empty where there is none."""
    for part in path.split("."):
        if isinstance(tree, list):
            named = {one.get("name"): one for one in tree if isinstance(one, dict)}
            tree = tree[int(part)] if part.isdigit() and int(part) < len(tree) else named.get(part)
        else:
            tree = tree.get(part) if isinstance(tree, dict) else None
    return tree if isinstance(tree, dict) else {}


def _refuse_doubles(vary: Sequence[Variation], overrides: Sequence[str]) -> None:
    fixed = {one.partition("=")[0].strip() for one in overrides}
    for one in vary:
        if one.key in fixed:
            raise MasonryError(f"'{one.key}' is both varied and set; leave --set {one.key} out")
