"""Explaining: what a key of scene files means and expects, told from the records themselves.

    for part in explain("materials.stone.young"): print(part)
    for part in explain("young"): ...          # wherever a key of that name stands

A path names the keys that lead to a key, and after those with a ``kind`` or a ``law`` the name of one of
these: ``structures.wall.brick``. What a user names freely stands as NAME, and any word may be in its place.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import msgspec
from msgspec import inspect

from masonry_fem.errors import MasonryError
from masonry_fem.records import docstring
from masonry_fem.records.record import Spec
from masonry_fem.scene.expectation import bare, expectation, tables_of
from masonry_fem.scene.misfit import nearest
from masonry_fem.scene.specs import Scene
from masonry_fem.scene.writing import plain

NAME = "NAME"
TAGS = ("kind", "law")  # keys that choose a kind of table
UNIT = re.compile(r" in (\S+)$")  # at the end of what a key expects


@dataclass(frozen=True, slots=True)
class Key:
    """A key of scene files.

    Attributes
    ----------
    path : Keys and kinds that lead to it, and its name.
    expected : What its value must be, in words. default : As one would write it, ``required``, or nothing.
    meaning : In words.
    table : The records that its value may be, by kind; {} where it is a value. The only one has no name.
    """

    path: tuple[str, ...]
    expected: str
    default: str
    meaning: str
    table: dict[str, type[Spec]]

    @property
    def name(self) -> str:
        """The path as one writes it."""
        return ".".join(self.path)


def keys_of(record: type[Spec], path: tuple[str, ...] = ()) -> list[Key]:
    """The keys of one record.

    Parameters
    ----------
    record : The record. path : What leads to it.
    """
    info = inspect.type_info(record)
    assert isinstance(info, inspect.StructType)
    meanings = docstring.meanings(record)
    return [
        Key(
            (*path, field.encode_name, *([NAME] if _named(field.type) else [])),
            expectation(field.type),
            default_of(field),
            _readable(meanings.get(field.name, "")),
            _records(field.type),
        )
        for field in info.fields
    ]


def default_of(field: inspect.Field) -> str:
    """A default as one would write it, ``required``, or nothing where there is none."""
    if field.required:
        return "required"
    value = plain(field.default)
    if value is None or isinstance(field.default, msgspec.Struct) or value in ([], [{}]):
        return ""
    return str(value).lower() if isinstance(value, bool) else repr(value).replace("'", '"')


def all_keys(record: type[Spec] = Scene, path: tuple[str, ...] = ()) -> Iterator[Key]:
    """Every key of scene files, outer ones before inner ones.

    Parameters
    ----------
    record : Where to begin. path : What leads to it.
    """
    for key in keys_of(record, path):
        yield key
        for kind, own in key.table.items():
            yield from all_keys(own, (*key.path, kind) if kind else key.path)


def unit_of(path: str) -> str:
    """Unit of plain numbers at a key, "" where there is none or where it depends on the kind of a table.

    Parameters
    ----------
    path : Of a key as overrides write it: ``structures.arch.thickness``.
    """
    first, *_, last = path.split(".") if "." in path else (path, path)
    alike = [key.expected for key in all_keys() if key.path[0] == first and last in _plain(key.path)[-1:]]
    units = {found[1] if (found := UNIT.search(words)) else "" for words in alike}
    return units.pop() if len(units) == 1 else ""


def explain(query: str) -> str:
    """What a key, a table or a kind of table means, as text.

    Parameters
    ----------
    query : A path of keys, or its last parts.

    Raises
    ------
    MasonryError : There is no such key.
    """
    asked = tuple(part for part in query.strip("[]").split(".") if part and not part.isdecimal())
    keys = list(all_keys())
    parts = [*_meanings(keys, asked), *_meanings_of_kinds(keys, asked)]
    if not parts and asked[1:] and asked[-1] in TAGS:
        return explain(".".join(asked[:-1]))
    if not parts:
        known = [*{part for key in keys for part in (key.name, key.path[-1], *key.table)} - {NAME, ""}]
        raise MasonryError(
            f"'{query}' is no key of scene files{nearest(query, known)}; expected one such as "
            "materials.NAME.young, joints.law or structures.wall; docs/scene.md has all"
        )
    return "\n\n".join(dict.fromkeys(parts))


def _meanings(keys: Sequence[Key], asked: tuple[str, ...]) -> list[str]:
    """What the keys mean that end with what is asked; where some are just that, of these alone."""
    found = [key for key in keys if _ends_with(key.path, asked)]
    exact = [key for key in found if len(_plain(key.path)) == len(asked)]
    return [_told(key) for key in exact or found]


def _meanings_of_kinds(keys: Sequence[Key], asked: tuple[str, ...]) -> list[str]:
    """What the kinds of tables mean that end with what is asked."""
    return [
        _told_kind((*key.path, kind), record)
        for key in keys
        for kind, record in key.table.items()
        if kind and _ends_with((*key.path, kind), asked)
    ]


def _told(key: Key) -> str:
    lines = [f"{key.name}: {key.expected}{_default(key)}", f"  {key.meaning}"]
    only = key.table.get("")
    if only is not None:
        lines += ["", *_table(only, key.path)]
    elif key.table:
        lines += ["", "  kinds: " + ", ".join(key.table)]
    return "\n".join(lines)


def _told_kind(path: tuple[str, ...], record: type[Spec]) -> str:
    text = _readable(" ".join(docstring.text(record).split("\n\n")[0].split()))
    example = docstring.example(record)
    lines = [f"{'.'.join(path)}: {text}", "", *_table(record, path)]
    if example:
        lines += ["", "  example:", *(f"    {line}" for line in example.splitlines())]
    return "\n".join(lines)


def _table(record: type[Spec], path: tuple[str, ...]) -> Iterator[str]:
    for key in keys_of(record, path):
        yield f"  {key.path[len(path)]}: {key.expected}{_default(key)}"
        yield f"    {key.meaning}"


def _readable(text: str) -> str:
    """Text of a docstring for a terminal: links name their page."""
    return re.sub(r"\[([^]]*)\]\(([^)\s]+)\)", r"\1 (docs/\2)", text).replace("``", "`")


def _default(key: Key) -> str:
    if key.default == "required":
        return "; required"
    return f"; default {key.default}" if key.default else ""


def _plain(path: tuple[str, ...]) -> tuple[str, ...]:
    """A path without a free name at its end."""
    return path[:-1] if path and path[-1] == NAME else path


def _ends_with(path: tuple[str, ...], asked: tuple[str, ...]) -> bool:
    """Whether the last parts of a path are those asked for; a free name is any word."""
    return any(
        0 < len(asked) <= len(own)
        and all(have in (NAME, word) for have, word in zip(own[-len(asked) :], asked, strict=True))
        and (own[-1] != NAME or len(asked) > 1)
        for own in (path, _plain(path))
    )


def _named(kind: inspect.Type) -> bool:
    return isinstance(bare(kind)[0], inspect.DictType)


def _records(kind: inspect.Type) -> dict[str, type[Spec]]:
    """The records within a type, by their tags; one without has the name ""."""
    match bare(kind)[0]:
        case inspect.DictType(value_type=own) | inspect.VarTupleType(item_type=own):
            return _records(own)
        case inspect.TupleType(item_types=items):
            return {name: record for one in items for name, record in _records(one).items()}
    return {name: cast("type[Spec]", table().cls) for name, table in tables_of(kind).items()}
