"""Beginning: a commented scene file to begin with, told from the records themselves.

    beginning("wall")          # text of a scene with a wall, all of whose keys are explained

Keys with a ``#`` before them stand at their default, or have none and are left out.
"""

from __future__ import annotations

import textwrap
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from masonry_fem import structures
from masonry_fem.errors import MasonryError
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.records import docstring
from masonry_fem.records.record import Spec
from masonry_fem.records.structure import Structure
from masonry_fem.scene.combinations import Design
from masonry_fem.scene.explaining import keys_of
from masonry_fem.scene.joint import Joint
from masonry_fem.scene.material import Material
from masonry_fem.scene.misfit import nearest
from masonry_fem.scene.output import Output
from masonry_fem.scene.specs import Loads, Scene

WIDTH = 100
OWN = ("kind", "name", "material")  # of a structure: they stand first
TOP = ("dimension", "plane", "fidelity", "mesh", "mass")


def beginning(kind: str) -> str:
    """A scene with a structure of a kind, as TOML with comments.

    Parameters
    ----------
    kind : Of the structure, a ``kind`` of ``[[structures]]``.

    Raises
    ------
    MasonryError : There is no such kind.
    """
    known = structures.names()
    if kind not in known:
        raise MasonryError(
            f"'{kind}' is no kind of structure{nearest(kind, known)}; expected one of {', '.join(known)}"
        )
    record = structures.record(kind)
    example = tomllib.loads(docstring.example(record))
    parts = [
        [f"# A scene for masonry-fem: masonry-fem run {kind}.toml",
         "# Keys with a '#' before them have their default. More: masonry-fem explain KEY"],
        [f'title = "{kind.replace("_", " ").capitalize()} under its own weight"',
         *_table(Scene, {"dimension": 3, "fidelity": "elastic"}, TOP)],
        ["[materials.stone]", *_table(Material, {"density": "2400 kg/m^3", "young": "10 GPa"})],
        ["[[structures]]", *_table(record, example)],
        *_held(msgspec.convert(example, record)),
        ["[[joints]]", *_table(Joint, {"friction": 0.6})],
        ["[loads]", *_table(Loads, {"gravity": [0.0, 0.0, -9.81]})],
        ["[analysis]", 'kind = "statics"', *_table(Statics, {})],
        ["[design]", *_table(Design, {})],
        ["[output]", *_table(Output, {"report": True})],
    ]  # fmt: skip
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def _held(structure: Structure) -> Iterator[list[str]]:
    """A support for a structure that brings none; names in a file are the user's to give."""
    if structure.carries:
        return
    comment = "# blocks and faces ('block/face') that stand still; 'masonry-fem check' tells the names"
    lines = ["[[supports]]", f'on = "{structure.name}/bottom"']
    yield [comment, *(lines if structure.source is None else (f"# {line}" for line in lines))]


def _table(record: type[Spec], given: Mapping[str, Any], only: tuple[str, ...] = ()) -> Iterator[str]:
    """Lines of a table: what is given first, then all other keys as comments."""
    keys = [key for key in keys_of(record) if not only or key.path[0] in only]
    for name in (name for name in OWN if name in given):
        yield f"{name} = {_toml(given[name])}"
    for key in sorted(keys, key=lambda key: key.path[0] not in given):
        name = key.path[0]
        if name in OWN and name in given:
            continue
        yield from textwrap.wrap(
            f"{key.meaning} ({key.expected})", WIDTH, initial_indent="# ", subsequent_indent="#   "
        )
        if name in given:
            yield f"{name} = {_toml(given[name])}"
        else:
            yield f"# {name} = {key.default if key.default != 'required' else ''}".rstrip()


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)
