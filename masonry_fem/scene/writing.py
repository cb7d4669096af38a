"""Writing: a scene as TOML text that reads back to an equal scene; values equal to defaults are left out."""

from __future__ import annotations

import re
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from masonry_fem.host.atomic import write_atomic
from masonry_fem.scene.specs import Scene

# a list without lists in it; only an opened list ends a line with a bracket
_SHORT_LIST = re.compile(r"\[\n((?: +[^\[\]{}\n]+,\n)+) *\]")


def dumps(scene: Scene) -> str:
    """The scene as TOML text."""
    return _SHORT_LIST.sub(_on_one_line, tomli_w.dumps(plain(scene)))


def save(scene: Scene, path: str | Path) -> None:
    """Write a scene to a TOML file.

    Parameters
    ----------
    scene : The scene; relative paths in it stay as they are (``moved`` adapts them).
    path : The file.

    Raises
    ------
    OutputError : The file cannot be written.
    """
    write_atomic(Path(path), dumps(scene).encode())


def plain(value: Any) -> Any:
    """Records as tables, tuples as lists, NumPy values as numbers; defaults left out."""
    if isinstance(value, msgspec.Struct):
        return _table(value)
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, PathLike):
        return fspath(value)
    if hasattr(value, "tolist"):  # NumPy, without importing it
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def _on_one_line(written: re.Match[str]) -> str:
    """A vector as people write it."""
    # a string may hold other characters that splitlines() would take for line ends
    items = [line.strip(" ") for line in written[1].rstrip("\n").split("\n")]
    return "[" + " ".join(items).removesuffix(",") + "]"


def _table(record: msgspec.Struct) -> dict[str, Any]:
    config = record.__struct_config__
    table: dict[str, Any] = {config.tag_field: config.tag} if config.tag_field and config.tag else {}
    for field in msgspec.structs.fields(record):
        value = plain(getattr(record, field.name))
        if not _same(value, plain(field.default)):
            table[field.encode_name] = value
    return table


def _same(value: Any, default: Any) -> bool:
    """True where a value is its field's default; 1, 1.0 and true are three things."""
    return type(value) is type(default) and bool(value == default)
