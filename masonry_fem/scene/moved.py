"""Moved: a scene whose paths are made relative to another folder, so that it can be saved there."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, get_args

import msgspec

from masonry_fem.records.record import FilePath
from masonry_fem.scene.specs import Scene


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
