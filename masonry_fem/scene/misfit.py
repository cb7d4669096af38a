"""Misfit: a value of a scene that does not fit its key, before its line in the file is known."""

from __future__ import annotations

import math
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from masonry_fem.scene.lines import KeyPath

LONGEST_VALUE = 60
LONGEST_NUMBER = 1000  # binary digits of a whole number that is shown


class MisfitError(Exception):
    """A value that does not fit, with its key path; the reader adds file and line.

    Attributes
    ----------
    path : Keys and list indexes that lead to the value.
    sentence : What is wrong with it, with ``{path}`` where the path's text belongs.
    line_path : Path whose line is to be named, where it is another one.
    """

    def __init__(self, path: KeyPath, sentence: str, line_path: KeyPath | None = None) -> None:
        super().__init__(sentence)
        self.path = path
        self.sentence = sentence
        self.line_path = path if line_path is None else line_path


def wrong(path: KeyPath, value: Any, expected: str, hint: str = "") -> MisfitError:
    """The error for a value that is not what its key expects.

    Parameters
    ----------
    path : Key path.
    value : What stands there.
    expected : What is expected, in words.
    hint : Further words, such as those of ``nearest``.
    """
    return MisfitError(path, f"{{path}} is {braced(shown(value))}, expected {braced(expected)}{braced(hint)}")


def braced(text: str) -> str:
    """Text that survives ``str.format``."""
    return text.replace("{", "{{").replace("}", "}}")


def shown(value: Any) -> str:
    """A value as a user would write it in TOML, shortened."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return str(float(value))
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int) and value.bit_length() > LONGEST_NUMBER:  # Python refuses to write some
        return f"a number of {value.bit_length() * math.log10(2):.0f} digits"
    if isinstance(value, list | tuple):
        text = "[" + ", ".join(shown(item) for item in value) + "]"
    else:
        text = repr(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."


def listed(names: Iterable[str]) -> str:
    """Names in quotes, separated by commas."""
    return ", ".join(f"'{name}'" for name in names)


def nearest(name: Any, known: Iterable[str]) -> str:
    """``; did you mean 'x'?`` for the known name that is most similar to ``name``; empty if none is.

    Parameters
    ----------
    name : What was written.
    known : All names that would be right.
    """
    by_small_letters = {candidate.lower(): candidate for candidate in reversed(list(known))}
    close = get_close_matches(str(name).lower(), by_small_letters, n=1, cutoff=0.5)
    return f"; did you mean '{by_small_letters[close[0]]}'?" if close else ""


def path_text(path: KeyPath, tree: Any = None) -> str:
    """A key path in the form that ``--set`` takes: dotted, list items by name where the name is unique.

    Parameters
    ----------
    path : Key path.
    tree : The scene as tables and lists, for the names.
    """
    parts: list[str] = []
    for key in path:
        parts.append(_item_name(tree, key) if isinstance(key, int) else str(key))
        try:
            tree = tree[key]
        except (TypeError, KeyError, IndexError):
            tree = None
    return ".".join(parts)


def _item_name(items: Any, index: int) -> str:
    names = [item.get("name") if isinstance(item, dict) else None for item in items or ()]
    name = names[index] if index < len(names) else None
    return name if isinstance(name, str) and name and names.count(name) == 1 else str(index)
