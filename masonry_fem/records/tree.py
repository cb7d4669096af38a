"""Tree: records of numbers, texts and arrays as plain JSON and a list of arrays, and back, bit for bit.

    node, arrays = packed(state)          # node: what JSON holds; arrays: what it points to
    state = unpacked(node, arrays)

A record is a frozen dataclass or a frozen ``msgspec.Struct`` of this package. It is taken apart by its
fields, so that a new one needs no line here. What is read back makes such records: no code of a file runs.
"""

from __future__ import annotations

import dataclasses
import operator
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import MasonryError

Node = Any  # what JSON holds
Arrays = list[NDArray[Any]]

PACKAGE = "masonry_fem."
NUMBERS = "biuf"  # kinds of arrays that are written: truth values, whole numbers, numbers
_RECORD = re.compile(r"[a-z_]\w*(?:\.[a-z_]\w*)*:[A-Z_]\w*")


class TreeError(MasonryError):
    """A tree holds what is no record, number, text or array of numbers."""


def is_record(kind: type) -> bool:
    """Whether a class is one whose values are packed: frozen, with fields, of this package."""
    if not kind.__module__.startswith(PACKAGE) or "<" in kind.__qualname__:
        return False
    if dataclasses.is_dataclass(kind):
        return bool(kind.__dataclass_params__.frozen)  # type: ignore[attr-defined]  # what the decorator leaves
    return issubclass(kind, msgspec.Struct) and bool(kind.__struct_config__.frozen)


def packed(value: Any) -> tuple[Node, Arrays]:
    """A value as what JSON holds, and the arrays in it, each once.

    Raises
    ------
    TreeError : Something in it is no record, number, text or array of numbers.
    """
    packer = _Packer()
    return packer.node(value, "it"), packer.arrays


def unpacked(node: Node, arrays: Sequence[NDArray[Any]]) -> Any:
    """The value that was packed.

    Parameters
    ----------
    node : What JSON held.
    arrays : The arrays that it points to.

    Raises
    ------
    TreeError : It is not what ``packed`` makes.
    """
    try:
        return _value(node, arrays)
    except (AttributeError, ImportError, IndexError, KeyError, TypeError, ValueError) as error:
        raise TreeError(f"a node is not as expected ({type(error).__name__}: {error})") from error


def contiguous(value: Any) -> Any:
    """The same with every array as it would be read back: in one piece of memory.

    Sums depend on the order in which numbers lie there, so that who goes on with a value and who reads it
    later get the same bits only if both have it like this.
    """
    if isinstance(value, np.ndarray):
        return value if value.flags.c_contiguous or value.flags.f_contiguous else np.ascontiguousarray(value)
    if isinstance(value, tuple | list):
        parts = type(value)(contiguous(one) for one in value)
        return value if all(map(operator.is_, parts, value)) else parts
    old = None if isinstance(value, Mapping) else _parts(value)
    if old is None:
        return value
    new = {name: contiguous(one) for name, one in old.items()}
    return value if all(new[name] is old[name] for name in old) else type(value)(**new)


def same_bits(one: Any, other: Any) -> bool:
    """Whether two values are packed alike.

    Parameters
    ----------
    one, other : Values.
    """
    (node, arrays), (again, others) = packed(one), packed(other)
    pairs = zip(arrays, others, strict=True)
    return repr(node) == repr(again) and all(a.tobytes() == b.tobytes() for a, b in pairs)


def differences(one: Any, other: Any, path: str = "") -> list[str]:
    """Where two values are not alike in kinds and shapes, in words; numbers may differ.

    Parameters
    ----------
    one, other : Values. path : What to call them.
    """
    if type(one) is not type(other):
        return [f"{path} is {_kind(one)}, expected {_kind(other)}"]
    if isinstance(one, np.ndarray):
        alike = one.shape == other.shape and one.dtype == other.dtype
        return [] if alike else [f"{path} is {_kind(one)}, expected {_kind(other)}"]
    if isinstance(one, tuple | list):
        if len(one) != len(other):
            return [f"{path} has {len(one)} parts, expected {len(other)}"]
        pairs = [(f"{path}.{k}", a, b) for k, (a, b) in enumerate(zip(one, other, strict=True))]
    elif is_record(type(one)):
        pairs = [(f"{path}.{name}", getattr(one, name), getattr(other, name)) for name in _names(type(one))]
    else:
        return []
    return [found for name, a, b in pairs for found in differences(a, b, name)]


def _kind(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"an array {value.dtype} of shape {value.shape}"
    return "nothing" if value is None else f"a {type(value).__name__}"


def _names(kind: type) -> tuple[str, ...]:
    if dataclasses.is_dataclass(kind):
        return tuple(field.name for field in dataclasses.fields(kind))
    names: tuple[str, ...] = kind.__struct_fields__  # type: ignore[attr-defined]  # of a Struct
    return names


class _Packer:
    """Takes values apart; an array that is met twice is kept once."""

    def __init__(self) -> None:
        self.arrays: Arrays = []
        self._numbers: dict[int, int] = {}

    def node(self, value: Any, path: str) -> Node:
        """What JSON holds of a value, which messages call ``path``."""
        if value is None or type(value) in (bool, int, str) or (type(value) is float and np.isfinite(value)):
            return value
        if type(value) is list:
            return [self.node(one, f"{path}[{k}]") for k, one in enumerate(value)]
        form, content = self._taken_apart(value, path)
        return {form: content}

    def _taken_apart(self, value: Any, path: str) -> tuple[str, Node]:
        """What JSON has no word for: the form, and what is in it."""
        kind, parts = type(value), _parts(value)
        form: str
        content: Node
        if kind is float:
            form, content = "float", repr(value)
        elif isinstance(value, np.ndarray):
            form, content = "array", self._number(value, path)
        elif isinstance(value, np.generic):
            form, content = "number", self._number(np.asarray(value), path)
        elif kind is tuple:
            form, content = "tuple", [self.node(one, f"{path}[{k}]") for k, one in enumerate(value)]
        elif parts is not None:
            form = "table" if isinstance(value, Mapping) else f"{kind.__module__}:{kind.__qualname__}"
            content = {name: self.node(one, f"{path}.{name}") for name, one in parts.items()}
        elif kind.__name__ == "csr_array":  # SciPy's, without importing it
            rows = (value.data, value.indices, value.indptr, tuple(map(int, value.shape)))
            form, content = "rows", [self.node(one, path) for one in rows]
        else:
            raise TreeError(
                f"{path} is a {kind.__module__}.{kind.__qualname__}, expected a frozen record of "
                "masonry_fem, a number, a text or an array of numbers: nothing else is saved of a state"
            )
        return form.removeprefix(PACKAGE), content

    def _number(self, array: NDArray[Any], path: str) -> int:
        if array.dtype.kind not in NUMBERS:
            raise TreeError(f"{path} is an array of {array.dtype}, expected numbers")
        number = self._numbers.get(id(array))
        if number is None:
            number = self._numbers[id(array)] = len(self.arrays)
            self.arrays.append(array)
        return number


def _value(node: Node, arrays: Sequence[NDArray[Any]]) -> Any:
    if isinstance(node, list):
        return [_value(one, arrays) for one in node]
    if not isinstance(node, dict):
        return node
    ((form, content),) = node.items()
    if form in ("float", "array", "number"):
        return (
            float(content) if form == "float" else arrays[content] if form == "array" else arrays[content][()]
        )
    if form in ("tuple", "rows"):
        parts = tuple(_value(one, arrays) for one in content)
        return parts if form == "tuple" else _rows(*parts)
    fields = {name: _value(one, arrays) for name, one in content.items()}
    return fields if form == "table" else _kind_named(form)(**fields)


def _rows(data: Any, indices: Any, indptr: Any, shape: tuple[int, int]) -> Any:
    from scipy import sparse  # noqa: PLC0415 - scenes that are only read need no SciPy

    return sparse.csr_array((data, indices, indptr), shape=shape)


def _parts(value: Any) -> dict[str, Any] | None:
    """The fields of a record or the entries of a table; None of anything else."""
    if isinstance(value, Mapping):
        return dict(value) if all(type(key) is str for key in value) else None
    kind = type(value)
    return {name: getattr(value, name) for name in _names(kind)} if is_record(kind) else None


def _kind_named(name: str) -> type:
    """The record of a name such as ``march.state:SystemState``."""
    if not isinstance(name, str) or not _RECORD.fullmatch(name):
        raise TreeError(f"a record is called {name!r}, expected module:Class of masonry_fem")
    module, _, own = name.partition(":")
    kind = getattr(import_module(PACKAGE + module), own)
    if not isinstance(kind, type) or not is_record(kind) or kind.__module__ != PACKAGE + module:
        raise TreeError(f"'{name}' is no record whose values are saved")
    return kind
