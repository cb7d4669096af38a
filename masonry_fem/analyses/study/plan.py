"""Plan: the cells of a study, one for each combination of its values.

cells = plan(Source.of("demos/arch.toml"), variations)
cells[0].settings, cells[0].key           # {"mesh.size": "0.2", ...}, hash of the scene
"""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from masonry_fem.analyses.cells.cell import MOST, Cell, fingerprint
from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.study.variation import Variation
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.scene import dumps

RIVALS = {"size": "divisions", "divisions": "size"}


def plan(source: Source, vary: Sequence[Variation]) -> list[Cell]:
    """All combinations, the coarsest first.

    Parameters
    ----------
    source : The scene. vary : Keys and their values.

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
    _refuse_doubles(vary, source.overrides)
    cleared = replace(source, overrides=(*room(source, vary), *source.overrides))
    cells = [_cell(cleared, vary, places) for places in _places(vary)]
    if all(cell.scene is None for cell in cells):
        raise SceneError(cells[0].fault)
    return cells


def room(source: Source, vary: Sequence[Variation]) -> list[str]:
    """Overrides that remove keys which varied ones replace: ``mesh.size`` if ``mesh.divisions`` varies.

    Parameters
    ----------
    source : The scene. vary : Keys and their values.
    """
    try:
        tree = tomllib.loads(source.text)
    except tomllib.TOMLDecodeError:
        return []  # reading the scene says it better
    taken = {one.key for one in vary} | {one.partition("=")[0].strip() for one in source.overrides}
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


def _cell(source: Source, vary: Sequence[Variation], places: tuple[int, ...]) -> Cell:
    own = [one.override(place) for one, place in zip(vary, places, strict=True)]
    settings = {one.key: one.text(place) for one, place in zip(vary, places, strict=True)}
    try:
        scene = source.scene(*own)
    except MasonryError as error:
        return Cell(places, settings, None, "", str(error))
    return Cell(places, settings, dumps(scene), fingerprint(scene, source.base))


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
