"""Expectation: what an annotation demands of a value, in words: ``a pressure > 0 in Pa``."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from typing import Any, cast

from msgspec import inspect

from masonry_fem.scene.quantity import noun_of


def expectation(kind: inspect.Type, dimension: int | None = None) -> str:
    """What a type expects, in words: ``a pressure > 0 in Pa``.

    Parameters
    ----------
    kind : Type as msgspec describes it, with its unit and range.
    dimension : Of the scene, where it is known: vectors then have so many numbers.
    """
    kind, extra = bare(kind)
    words = extra.get("expected") or _WORDS.get(type(kind), "a table")
    return str(words) if isinstance(words, str) else words(kind, extra, dimension)


def bare(kind: inspect.Type) -> tuple[inspect.Type, dict[str, Any]]:
    """A type without what is said beside it, and that; where a room has names it is one of these."""
    extra: dict[str, Any] = {}
    if isinstance(kind, inspect.Metadata):
        extra, kind = kind.extra or {}, kind.type
    if "named in" in extra:
        kind = inspect.LiteralType(tuple(import_module(extra["named in"]).names()))
    return kind, extra


def tables_of(kind: inspect.Type) -> dict[str, Callable[[], inspect.StructType]]:
    """The tables that a value may be, by the names that choose them; {} where it is none.

    The only table has no name. Of a room's tables each is loaded when it is called for.
    """
    kind, extra = bare(kind)
    if "kinds in" in extra:
        room = import_module(extra["kinds in"])
        return {name: partial(_described, room.record, name) for name in room.names()}
    if isinstance(kind, inspect.UnionType):
        return {name: table for one in kind.types for name, table in tables_of(one).items()}
    return {str(kind.tag or ""): lambda: kind} if isinstance(kind, inspect.StructType) else {}


@cache
def _described(record: Callable[[str], type], name: str) -> inspect.StructType:
    return cast("inspect.StructType", inspect.type_info(record(name)))


def _number_expectation(kind: Any, extra: dict[str, Any], _: int | None) -> str:
    unit = extra.get("unit")
    return noun_of(unit) + _range_text(kind) + (f" in {unit}" if unit else "")


def _choice_expectation(kind: Any, extra: dict[str, Any], _: int | None) -> str:
    return ("one of " if len(kind.values) > 1 else "") + ", ".join(repr(choice) for choice in kind.values)


def _union_expectation(kind: Any, extra: dict[str, Any], dimension: int | None) -> str:
    choices = alternatives(kind)
    if isinstance(bare(choices[0])[0], inspect.StructType):
        return "a table"
    return ", or ".join(expectation(one, dimension) for one in choices)


def _tuple_expectation(kind: Any, extra: dict[str, Any], _: int | None) -> str:
    return f"a list of {len(kind.item_types)}: " + ", ".join(map(expectation, kind.item_types))


def _list_expectation(kind: Any, extra: dict[str, Any], dimension: int | None) -> str:
    if isinstance(bare(kind.item_type)[0], inspect.StructType | inspect.UnionType):
        least = {0: "an array of", 1: "one or more"}.get(kind.min_length or 0, f"{kind.min_length} or more")
        return f"{least} tables ([[...]])"
    item = expectation(kind.item_type)
    if is_vector(kind):
        return f"a list of {dimension or '2 or 3'} (the scene's dimension), each {item}"
    if kind.min_length == kind.max_length and kind.min_length:
        return f"a list of {kind.min_length}, each {item}"
    return f"a list{' that is not empty' if kind.min_length else ''}, each {item}"


def alternatives(kind: inspect.UnionType) -> list[inspect.Type]:
    """The members of a union other than None."""
    return [one for one in kind.types if not isinstance(one, inspect.NoneType)]


def is_vector(kind: inspect.VarTupleType) -> bool:
    """True for a list that has as many items as the scene has dimensions."""
    return kind.min_length == 2 and kind.max_length == 3


def _range_text(kind: Any) -> str:
    limits = ((">", kind.gt), (">=", kind.ge), ("<", kind.lt), ("<=", kind.le))
    text = " and ".join(f"{sign} {limit:g}" for sign, limit in limits if limit is not None)
    steps = f" in steps of {kind.multiple_of:g}" if kind.multiple_of is not None else ""
    return (f" {text}" if text else "") + steps


_WORDS: dict[type, str | Callable[[Any, dict[str, Any], int | None], str]] = {
    inspect.FloatType: _number_expectation,
    inspect.IntType: lambda kind, *_: "a whole number" + _range_text(kind),
    inspect.LiteralType: _choice_expectation,
    inspect.StrType: "a text in quotes",
    inspect.BoolType: "true or false",
    inspect.UnionType: _union_expectation,
    inspect.VarTupleType: _list_expectation,
    inspect.TupleType: _tuple_expectation,
}
