"""Variation: a key of the scene and the values that a study gives it.

    vary = Variation.parse("mesh.size=0.2,0.1,0.05")
    vary.key, vary.values, vary.finest          # "mesh.size", (0.2, 0.1, 0.05), 2

A key is what ``--set`` takes; values are separated by commas that stand in no bracket and no quotes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from masonry_fem.analyses.study.setting import Setting, fineness, setting_of
from masonry_fem.errors import MasonryError
from masonry_fem.scene.overrides import parsed, texts

PAIRS = {"[": "]", "{": "}", "(": ")"}


@dataclass(frozen=True)
class Variation:
    """A key and its values, in the order given.

    Attributes
    ----------
    key : Dotted key. values : As TOML reads them.
    compared : Whether its values are compared with each other even where they pose different problems.
    """

    key: str
    values: tuple[Any, ...]
    compared: bool = False

    def __post_init__(self) -> None:
        """Refuse what makes no sweep."""
        if not self.values:
            raise MasonryError(f"--vary {self.key}: expected values, as {self.key}=1,2,3")
        texts = [written(value) for value in self.values]
        for text in texts:
            if texts.count(text) > 1:
                raise MasonryError(f"--vary {self.key}: the value {text} is given twice; leave one out")

    @classmethod
    def parse(cls, text: str) -> Variation:
        """Read ``key=value,value,...``.

        Raises
        ------
        MasonryError : Where there is no key or no value.
        """
        key, equals, values = text.partition("=")
        key = key.strip()
        parts = split(values)
        if not equals or not key or not all(key.split(".")) or not all(parts):
            raise MasonryError(f"--vary {text}: expected key=value,value, for example mesh.size=0.2,0.1")
        return cls(key, tuple(parsed(part) for part in parts))

    @cached_property
    def setting(self) -> Setting:
        """What the key is to accuracy."""
        return setting_of(self.key)

    @cached_property
    def ranks(self) -> tuple[int, ...]:
        """Rank of each value, 0 the coarsest."""
        return tuple(fineness(self.key, self.values)[0])

    @cached_property
    def widths(self) -> tuple[float | None, ...]:
        """Width of each value; None where it has none."""
        return tuple(fineness(self.key, self.values)[1])

    @property
    def finest(self) -> int:
        """Place of the finest value."""
        return self.ranks.index(len(self.values) - 1)

    @property
    def is_case(self) -> bool:
        """Whether each value is a problem of its own, with a reference of its own."""
        return self.setting.role == "case" and not self.compared

    @property
    def is_graded(self) -> bool:
        """Whether finer values are nearer to the truth, by widths or by tolerances."""
        return self.setting.role in ("width", "tolerance")

    def text(self, place: int) -> str:
        """A value as a user writes it."""
        return written(self.values[place])

    def override(self, place: int) -> str:
        """The text that ``--set`` takes."""
        return f"{self.key}={written(self.values[place])}"


def variations(given: Iterable[str] | Mapping[str, Sequence[Any]]) -> tuple[Variation, ...]:
    """Variations from texts or from a table of values, each key once.

    Raises
    ------
    MasonryError : Where there is none, or a key stands twice.
    """
    if isinstance(given, Mapping):
        made = tuple(Variation(key, _several(key, values)) for key, values in given.items())
    else:
        made = tuple(Variation.parse(text) for text in texts(given))
    if not made:
        raise MasonryError("a study varies at least one key: give --vary, for example mesh.size=0.2,0.1")
    keys = [one.key for one in made]
    for key in keys:
        if keys.count(key) > 1:
            raise MasonryError(f"--vary {key} is given twice; put all of its values into one")
    return made


def split(text: str) -> list[str]:
    """Parts of a text between commas that stand in no bracket and no quotes."""
    parts, awaited, quote = [""], [], ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in PAIRS:
            awaited.append(PAIRS[letter])
        elif awaited and letter == awaited[-1]:
            awaited.pop()
        elif letter == "," and not awaited:
            parts.append("")
            continue
        parts[-1] += letter
    return [part.strip() for part in parts]


def written(value: Any) -> str:
    """A value as ``--set`` takes it."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_quoted(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_quoted(part) for part in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value!r}"
    return str(value)


def _quoted(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else written(value)


def _several(key: str, values: Any) -> tuple[Any, ...]:
    if isinstance(values, str | bytes | Mapping) or not hasattr(values, "__iter__"):
        raise MasonryError(f"vary: {key} has the value {values!r}, expected a list of values")
    return tuple(values)
