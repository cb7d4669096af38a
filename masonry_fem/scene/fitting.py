"""Fitting: a plain tree (as TOML gives it) held against the annotations of the records.

``fitted(tree, type, path, dimension)`` returns the tree with every quantity as a number in SI
units, and every table as its record, or raises a MisfitError that names the first value that does not
fit. One function a kind of type; the types are msgspec's own description of the records.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import Any

from msgspec import inspect

from masonry_fem.scene.expectation import alternatives, bare, expectation, is_vector, tables_of
from masonry_fem.scene.lines import KeyPath
from masonry_fem.scene.misfit import MisfitError, braced, listed, nearest, wrong
from masonry_fem.scene.quantity import QuantityError, si_value

SMALLEST = sys.float_info.min  # smaller numbers have fewer digits
LARGEST = 1e100  # squares and most products of such numbers do not overflow
LARGEST_COUNT = 2**63 - 1  # what TOML promises


def fitted(value: Any, kind: inspect.Type, path: KeyPath, dimension: int | None) -> Any:
    """The value with quantities converted and tables made records, where it fits ``kind``.

    Parameters
    ----------
    value : Plain value: table, list, string, number or truth value.
    kind : What the annotation says.
    path : Where the value stands.
    dimension : The scene's dimension, which vectors must have; None where it is not known.
    """
    kind, extra = bare(kind)
    return _FITTERS[type(kind)](value, kind, extra, path, dimension)


def _fit_number(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, _: int | None) -> Any:
    expected = expectation(inspect.Metadata(kind, extra=extra))
    number = value
    if isinstance(value, str):
        try:
            number = si_value(value, extra.get("unit"))
        except QuantityError as error:
            raise wrong(path, value, expected, str(error)) from error
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise wrong(path, value, expected)
    if not abs(number) <= sys.float_info.max or not _in_range(number, kind):  # the first is true for nan, too
        raise wrong(path, value, expected, f"; {extra['cure']}" if "cure" in extra else "")
    if number and not SMALLEST <= abs(number) <= LARGEST:
        raise wrong(
            path, value, f"{expected}, where it is not 0 from {SMALLEST:.0e} to {LARGEST:.0e} in size"
        )
    return float(number)


def _fit_count(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, _: int | None) -> Any:
    if isinstance(value, bool) or not isinstance(value, int) or not _in_range(value, kind):
        raise wrong(path, value, expectation(inspect.Metadata(kind, extra=extra)))
    if abs(value) > LARGEST_COUNT:
        raise wrong(path, value, f"a whole number up to {LARGEST_COUNT:.0e}")
    return value


def _fit_text(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, _: int | None) -> Any:
    fits = isinstance(value, str) and len(value) >= (kind.min_length or 0)
    if not fits or (kind.pattern and not re.search(kind.pattern, value)):
        raise wrong(path, value, expectation(inspect.Metadata(kind, extra=extra)))
    return value


def _fit_truth(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, _: int | None) -> Any:
    if not isinstance(value, bool):
        raise wrong(path, value, expectation(kind))
    return value


def _fit_choice(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, _: int | None) -> Any:
    if isinstance(value, bool) or not isinstance(value, str | int) or value not in kind.values:
        names = [choice for choice in kind.values if isinstance(choice, str)]
        gone = extra.get("gone", {}).get(str(value))
        raise wrong(path, value, expectation(kind), f"; {gone}" if gone else nearest(value, names))
    return value


def _fit_list(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, dimension: int | None) -> Any:
    fits = isinstance(value, list | tuple) and len(value) >= (kind.min_length or 0)
    fits = fits and (kind.max_length is None or len(value) <= kind.max_length)
    if fits and is_vector(kind) and dimension is not None:
        fits = len(value) == dimension
    if not fits:
        expected = expectation(kind, dimension).replace("[[...]]", f"[[{'.'.join(map(str, path))}]]")
        raise wrong(path, value, expected)
    return tuple(fitted(item, kind.item_type, (*path, i), dimension) for i, item in enumerate(value))


def _fit_tuple(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, dimension: int | None) -> Any:
    if not isinstance(value, list | tuple) or len(value) != len(kind.item_types):
        raise wrong(path, value, expectation(kind))
    pairs = zip(value, kind.item_types, strict=True)
    return tuple(fitted(item, one, (*path, i), dimension) for i, (item, one) in enumerate(pairs))


def _fit_named(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, dimension: int | None) -> Any:
    if not isinstance(value, dict):
        raise wrong(path, value, "a table of named tables" + _table_hint(path, value))
    for name in value:
        fitted(name, kind.key_type, (*path, name), dimension)
    return {name: fitted(item, kind.value_type, (*path, name), dimension) for name, item in value.items()}


def _fit_table(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, dimension: int | None) -> Any:
    if "kinds in" in extra:
        kind = _tagged(value, inspect.Metadata(kind, extra=extra), kind.tag_field, path)
    if not isinstance(value, dict):
        raise wrong(path, value, "a table" + _table_hint(path, value))
    _check_keys(value, kind, path, dimension)
    return kind.cls(
        **{
            field.name: fitted(value[field.encode_name], field.type, (*path, field.encode_name), dimension)
            for field in kind.fields
            if field.encode_name in value
        }
    )


def _check_keys(value: dict[str, Any], kind: Any, path: KeyPath, dimension: int | None) -> None:
    """A table has no key that is unknown, and all that are required."""
    place = "{path}" if path else "the scene"
    known = [kind.tag_field] if kind.tag_field else []
    known += [field.encode_name for field in kind.fields]
    for key in value:
        if key not in known:
            near = nearest(key, known) or f"; known keys: {listed(known)}"
            sentence = f"unknown key {braced(repr(key))} in {place}{braced(near)}"
            raise MisfitError(path, sentence, line_path=(*path, key))
    for field in kind.fields:
        if field.required and field.encode_name not in value:
            expected = braced(expectation(field.type, dimension))
            raise MisfitError(path, f"{place} lacks the key '{field.encode_name}' ({expected})")


def _fit_union(value: Any, kind: Any, extra: dict[str, Any], path: KeyPath, dimension: int | None) -> Any:
    choices = alternatives(kind)
    if value is None and len(choices) < len(kind.types):
        return None
    first, _ = bare(choices[0])
    if choices[1:] and isinstance(first, inspect.StructType):
        return fitted(value, _tagged(value, kind, first.tag_field, path), path, dimension)
    fitting = _suiting(value, choices)
    if len(fitting) == 1:
        return fitted(value, fitting[0], path, dimension)
    for one in fitting:  # a number or a text: take the first type that accepts the value
        try:
            return fitted(value, one, path, dimension)
        except MisfitError:
            continue
    raise wrong(path, value, expectation(kind, dimension))


def _suiting(value: Any, choices: list[inspect.Type]) -> list[inspect.Type]:
    """Of several types those of lists for a list, and the others for anything else."""
    of_list = isinstance(value, list | tuple)
    several = [one for one in choices if isinstance(one, inspect.VarTupleType) is of_list]
    return several if choices[1:] else choices


def _tagged(value: Any, kind: inspect.Type, key: str | None, path: KeyPath) -> inspect.StructType:
    """The record that a table's ``kind`` names, or its ``law``."""
    tables = tables_of(kind)
    expected = f"one of {listed(tables)}"
    if not isinstance(value, dict):
        raise wrong(path, value, f"a table with the key '{key}', {expected}")
    if key not in value:
        raise MisfitError(path, f"{{path}} lacks the key '{key}', {expected}")
    tag = value[key]
    if not isinstance(tag, str) or tag not in tables:
        raise wrong((*path, str(key)), tag, expected, nearest(tag, tables))
    return tables[tag]()


def _table_hint(path: KeyPath, value: Any) -> str:
    """Why a list may stand where a table belongs."""
    if isinstance(value, list) and path:
        return f" ([{path[-1]}] with single brackets)"
    return ""


def _in_range(number: float, kind: Any) -> bool:
    return (
        (kind.gt is None or number > kind.gt)
        and (kind.ge is None or number >= kind.ge)
        and (kind.lt is None or number < kind.lt)
        and (kind.le is None or number <= kind.le)
        and (kind.multiple_of is None or number % kind.multiple_of == 0)
    )


_FITTERS: dict[type, Callable[[Any, Any, dict[str, Any], KeyPath, int | None], Any]] = {
    inspect.FloatType: _fit_number,
    inspect.IntType: _fit_count,
    inspect.StrType: _fit_text,
    inspect.BoolType: _fit_truth,
    inspect.LiteralType: _fit_choice,
    inspect.VarTupleType: _fit_list,
    inspect.TupleType: _fit_tuple,
    inspect.DictType: _fit_named,
    inspect.StructType: _fit_table,
    inspect.UnionType: _fit_union,
}
