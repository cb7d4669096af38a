"""Writing: a scene as TOML text that reads back to an equal scene; values equal to defaults are left out.

save(moved(scene, base, folder), folder / "scene.toml")      # with its paths relative to the new folder
"""

from __future__ import annotations

import os
import re
from os import PathLike, fspath
from pathlib import Path
from typing import Any, get_args

import msgspec
import tomli_w

from masonry_fem.host.atomic import write_atomic
from masonry_fem.records.record import FilePath
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
    scene : The scene; relative paths in it are written as they are (``masonry_fem.scene.writing.moved``
        adapts them to another folder).
    path : The file to write.

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


def moved(scene: Scene, base: Path, folder: Path) -> Scene:
    """The scene with its relative paths rewritten for another folder.

    Parameters
    ----------
    scene : The scene.
    base : Folder that its paths are relative to.
    folder : Folder that they will be relative to.
    """

    def renamed(value: Any) -> Any:
        if isinstance(value, msgspec.Struct):
            changes = {
                field.name: _path(own) if _is_path(field.type) and own is not None else renamed(own)
                for field in msgspec.structs.fields(value)
                for own in (getattr(value, field.name),)
            }
            return msgspec.structs.replace(value, **changes)
        if isinstance(value, tuple):
            return tuple(renamed(item) for item in value)
        if isinstance(value, dict):
            return {key: renamed(item) for key, item in value.items()}
        return value

    def _path(name: str) -> str:
        if Path(name).is_absolute():
            return name
        return Path(os.path.relpath(base.resolve() / name, folder.resolve())).as_posix()

    result: Scene = renamed(scene)
    return result


def _is_path(kind: Any) -> bool:
    return kind == FilePath or FilePath in get_args(kind)
