"""Parameters: the numbers of a law, each with its unit and its range, which stand in its annotation.

    cohesion: Cohesion                        # >= 0, in Pa; one for all contact points, or one each
    plateau: Annotated[float, Meta(ge=0, lt=1)] = 0.5

From these follow what a law refuses (``check_ranges``) and what a scene file may say of it (``table_of``).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields
from functools import cache
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
from msgspec import Meta, Struct, defstruct
from msgspec.structs import asdict
from numpy.typing import NDArray

from masonry_fem.errors import ExtensionError, LawError
from masonry_fem.records import docstring
from masonry_fem.records.discovery import check_keys

FloatArray = NDArray[np.float64]
Parameter = float | FloatArray  # one for all contact points, or one each, shape (c,)

Stiffness = Annotated[Parameter, Meta(gt=0, extra={"unit": "N/m^3"})]
Strength = Annotated[Parameter, Meta(gt=0, extra={"unit": "Pa"})]
Cohesion = Annotated[Parameter, Meta(ge=0, extra={"unit": "Pa"})]
Energy = Annotated[Parameter, Meta(gt=0, extra={"unit": "J/m^2"})]
Viscosity = Annotated[Parameter, Meta(ge=0, extra={"unit": "J s/m^2"})]
Length = Annotated[Parameter, Meta(gt=0, extra={"unit": "m"})]
Distance = Annotated[Parameter, Meta(ge=0, extra={"unit": "m"})]
Factor = Annotated[Parameter, Meta(ge=0)]
Friction = Factor

# what the program gives, not the scene's table: the joint's own friction, and −Δ among the points
GIVEN = ("friction", "laplacian")
LIMITS = (
    ("gt", ">", operator.gt),
    ("ge", ">=", operator.ge),
    ("lt", "<", operator.lt),
    ("le", "<=", operator.le),
)


@cache
def parameters(law: Any) -> dict[str, Any]:
    """Annotation of each parameter of a law's class."""
    hints = get_type_hints(law, include_extras=True)
    return {one.name: hints[one.name] for one in fields(law)}


def check_ranges(law: Any) -> None:
    """Refuse a parameter that its annotation does not allow.

    Raises
    ------
    LawError : There is one.
    """
    for name, hint in parameters(law.__class__).items():
        value = getattr(law, name)
        for one in _choices(hint) if value is not None else ():
            if get_origin(one) is Annotated:
                check(law, name, *(told for told in one.__metadata__ if isinstance(told, Meta)))
            elif get_origin(one) is Literal and value not in get_args(one):
                expected = " or ".join(map(repr, get_args(one)))
                raise LawError(f"law '{law.name}': {name} is {value!r}, expected {expected}; correct it")


def check(law: Any, name: str, *ranges: Meta) -> None:
    """Refuse a parameter that is not a number in its ranges.

    Parameters
    ----------
    law : The law. name : Of its parameter.
    ranges : What the value must satisfy, all of it.

    Raises
    ------
    LawError : A value is out of range, or not a number.
    """
    value = np.asarray(getattr(law, name), dtype=float)
    limits = [
        (f"{sign} {limit:g}", holds(value, limit))
        for told in ranges
        for key, sign, holds in LIMITS
        if (limit := getattr(told, key)) is not None
    ]
    wrong = ~np.all([holds for _, holds in limits], axis=0)  # of NaN none holds
    if wrong.any():
        shown = value[wrong].flat[0] if value.ndim else float(value)
        expected = " and ".join(words for words, _ in limits)
        raise LawError(f"law '{law.name}': {name} is {shown:g}, expected a number {expected}; correct it")


def keys_of(law: type) -> list[tuple[str, Any] | tuple[str, Any, Any]]:
    """What a scene file says of a law: name, annotation and default of each key."""
    defaults = {one.name: one.default for one in fields(law)}
    return [
        (name, _of_one(hint)) if defaults[name] is MISSING else (name, _of_one(hint), defaults[name])
        for name, hint in parameters(law).items()
        if name not in GIVEN
    ]


def table_of(
    law: type, name: str, base: type[Struct], file: str, again: Callable[[str, dict[str, Any]], Struct]
) -> type[Struct]:
    """The record of what a scene file says of a law: its parameters as keys, its docstring as meanings.

    Parameters
    ----------
    law : Class of the law. name : In scene files. base : Of the record.
    file : Where the law stands, for messages.
    again : Makes such a record of its law's name and its keys: ``pickle`` knows the law by the class's name.

    Raises
    ------
    ExtensionError : The class is no dataclass, or has a parameter that no scene file can fill.
    """
    try:
        record = defstruct(
            law.__name__, keys_of(law), bases=(base,), module=law.__module__, frozen=True, kw_only=True,
            tag=name,
            namespace={
                "__doc__": docstring.whole(law), "__reduce__": lambda own: (again, (name, asdict(own))),
            },
        )  # fmt: skip
    except (TypeError, NameError) as error:
        raise ExtensionError(
            f"{file}: {law.__name__} gives no table of a scene file ({error}), expected a dataclass whose "
            "parameters have types such as Strength, float or Literal; give them one of "
            "masonry_fem/joints/parameters.py"
        ) from error
    check_keys(record, file)
    return record


def spreads(law: type, name: str) -> bool:
    """Whether a parameter may differ from contact point to contact point.

    Parameters
    ----------
    law : Class of the law. name : Of its parameter.
    """
    return any(one == FloatArray for one in _leaves(parameters(law)[name]))


def _choices(hint: Any) -> tuple[Any, ...]:
    """The members of a union; what is none is its only one."""
    return get_args(hint) if get_origin(hint) in {Union, UnionType} else (hint,)


def _leaves(hint: Any) -> Iterator[Any]:
    for one in _choices(hint):
        yield from _leaves(one.__origin__) if get_origin(one) is Annotated else (one,)


def _of_one(hint: Any) -> Any:
    """The annotation without arrays: a scene file has one number for all contact points."""
    if get_origin(hint) is Annotated:
        return Annotated[(_of_one(hint.__origin__), *hint.__metadata__)]
    kept = [one for one in _choices(hint) if one != FloatArray]
    return Union[tuple(map(_of_one, kept))] if len(kept) > 1 else kept[0]  # noqa: UP007  made while running
