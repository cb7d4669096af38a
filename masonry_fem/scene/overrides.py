"""Override: one value of a scene changed from outside, ``dotted.key=value``.

    apply(tree, ["analysis.step=1e-3", "structures.arch.voussoirs=21"])

A list item is given by its index or its ``name``; ``*`` stands for all items that have the rest of the key
(``materials.*.tensile_strength=2 MPa``). The value is read as TOML; what is not valid TOML is
taken as a string (``materials.stone.young=10 GPa``).
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from masonry_fem.errors import SceneError
from masonry_fem.scene.lines import KeyPath
from masonry_fem.scene.misfit import listed, nearest


def texts(given: str | Iterable[str]) -> tuple[str, ...]:
    """Several texts; a single one is not taken apart into its letters."""
    return (given,) if isinstance(given, str) else tuple(given)


def apply(tree: dict[str, Any], overrides: Iterable[str]) -> dict[KeyPath, str]:
    """Write overrides into a tree, in place; returns each changed path with the override's text.

    Parameters
    ----------
    tree : The scene as tables and lists.
    overrides : Texts ``dotted.key=value``.

    Raises
    ------
    SceneError : An override has no ``=``, or its key leads through something that does not exist.
    """
    changed: dict[KeyPath, str] = {}
    for text in texts(overrides):
        if not isinstance(text, str):
            raise SceneError(f"override {text!r}, expected a text key=value, as 'analysis.step=1e-3'")
        key, equals, value = text.partition("=")
        parts = [part.strip() for part in key.split(".")]
        if not equals or not all(parts):
            raise SceneError(f"--set {text}: expected key=value, for example analysis.step=1e-3")
        for path in _spread(tree, parts, text):
            changed[_write(tree, path, parsed(value.strip()), text)] = text
    return changed


def trusting(scene: Path, overrides: Iterable[str]) -> list[str]:
    """Overrides by which every program of a scene is trusted; none if the scene cannot be read.

    Parameters
    ----------
    scene : The scene's file.
    overrides : Texts ``dotted.key=value`` that apply before.
    """
    try:
        return trusting_text(scene.read_text(encoding="utf-8-sig"), overrides)
    except (OSError, UnicodeDecodeError):
        return []  # the error is reported when the scene is loaded


def trusting_text(text: str, overrides: Iterable[str]) -> list[str]:
    """The same of a scene's text.

    Parameters
    ----------
    text : The scene as TOML.
    overrides : Texts ``dotted.key=value`` that apply before.
    """
    try:
        tree = tomllib.loads(text)
    except (ValueError, RecursionError):
        return []  # the error is reported when the scene is loaded
    apply(tree, overrides)
    programs = [
        f"structures.{index}" for index, one in _tables(tree, "structures") if one.get("kind") == "file"
    ]
    programs += [
        f"{key}.{index}.{part}"
        for key, part, tag in (("joints", "law", "kind"), ("materials", "inelastic", "law"))
        for index, one in _tables(tree, key)
        if isinstance(one.get(part), dict) and one[part].get(tag) == "python"
    ]
    return [f"{program}.trusted=true" for program in programs]


def _tables(tree: dict[str, Any], key: str) -> list[tuple[Any, dict[str, Any]]]:
    """The tables of a list, with their indices, or those of a table, with their names."""
    items = tree.get(key)
    found = items.items() if isinstance(items, dict) else enumerate(items if isinstance(items, list) else ())
    return [(index, one) for index, one in found if isinstance(one, dict)]


def parsed(text: str) -> Any:
    """The TOML value that a text is, else the text itself."""
    try:
        document = tomllib.loads(f"value = {text}")
    except ValueError:  # TOMLDecodeError, and numbers of thousands of digits
        return text
    return document["value"] if list(document) == ["value"] else text


def _spread(tree: Any, parts: list[str], text: str) -> list[list[str]]:
    """The keys that a key with ``*`` stands for; any other one is its own."""
    if "*" not in parts:
        return [parts]
    found: list[tuple[list[str], Any]] = [([], tree)]
    for part in parts:
        found = [
            ([*path, key], value)
            for path, inner in found
            for key, name, value in _items(inner)
            if part in ("*", key, name)
        ]
    if not found:
        raise SceneError(
            f"--set {text}: nothing has such a key, expected that an item which '*' stands for has the rest "
            "of the key; write the item's name instead"
        )
    return [path for path, _ in found]


def _items(tree: Any) -> list[tuple[str, Any, Any]]:
    """Keys and values of a table; of a list indices, names of its tables, and values."""
    if isinstance(tree, dict):
        return [(key, key, value) for key, value in tree.items()]
    items = enumerate(tree) if isinstance(tree, list) else ()
    return [(str(index), one.get("name") if isinstance(one, dict) else None, one) for index, one in items]


def _write(tree: Any, parts: list[str], value: Any, text: str) -> KeyPath:
    """Put a value at the end of a dotted path; tables on the way are made where they lack."""
    path: KeyPath = ()
    for part, following in zip(parts, [*parts[1:], None], strict=True):
        if isinstance(tree, list):
            key: str | int = _index(tree, part, path, text)
            if key == len(tree):
                tree.append({})
        elif isinstance(tree, dict):
            key = part
        else:
            raise SceneError(f"--set {text}: '{'.'.join(map(str, path))}' is a value, it has no key '{part}'")
        path = (*path, key)
        if following is None:
            tree[key] = value
        elif isinstance(tree, dict) and key not in tree:
            tree[key] = [] if following.isdecimal() else {}
        tree = tree[key]
    return path


def _index(items: list[Any], part: str, path: KeyPath, text: str) -> int:
    """Index of the list item that ``part`` names; the list's length is a new item."""
    place = ".".join(map(str, path))
    if part.isdecimal():
        if int(part) > len(items):
            raise SceneError(f"--set {text}: '{place}' has {len(items)} items, expected an index up to that")
        return int(part)
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    if part in names:
        return names.index(part)
    known = [name for name in names if isinstance(name, str)]
    cure = nearest(part, known) or (f"; known names: {listed(known)}" if known else "; give its index")
    raise SceneError(f"--set {text}: '{place}' has no item named '{part}'{cure}")
