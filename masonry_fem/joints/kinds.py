"""Kinds: the laws of the folder ``laws``, each with the record that a scene file makes of it.

    kind("mohr_coulomb").record(cohesion=0.35e6)      # what a scene says
    kind("mohr_coulomb").law(cohesion=0.35e6, friction=0.75)

A record has the law's parameters as its keys, but for those that the program gives.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from inspect import get_annotations
from typing import Any, cast

from masonry_fem.errors import ExtensionError
from masonry_fem.joints import laws
from masonry_fem.joints.law import Law
from masonry_fem.joints.parameters import parameters, table_of
from masonry_fem.records import discovery
from masonry_fem.records.law import LawRecord


@dataclass(frozen=True, slots=True)
class Kind:
    """A law that scene files can ask for.

    Attributes
    ----------
    record : Class of what a scene says of it.
    law : Its class.
    file : Where it stands, to be named in errors.
    """

    record: type[LawRecord]
    law: type[Law]
    file: str


def names() -> tuple[str, ...]:
    """The laws that a scene may ask for; none is loaded."""
    return discovery.names(laws.__path__)


@cache
def kind(name: str) -> Kind:
    """The law with a name in scene files.

    Raises
    ------
    ExtensionError : Its file lacks what a law owes.
    """
    naming = 'write name: ClassVar[str] = "{name}" in it'
    found = discovery.discovered(laws.__name__, name, Law, "law", lambda law: vars(law).get("name"), naming)
    law = found.kind
    told = table_of(law, name, LawRecord, found.file, _again)
    owed = dict.fromkeys(["friction", *(key for base in law.__mro__ for key in get_annotations(base))])
    if lacking := [key for key in owed if key not in parameters(law) and not hasattr(law, key)]:
        raise ExtensionError(
            f"{found.file}: {law.__name__} has no parameter {', '.join(lacking)}, expected those of its base "
            "classes and the friction, which the joint gives; write them, as in friction: Friction = 0.6"
        )
    return Kind(cast("type[LawRecord]", told), law, found.file)


def kinds() -> Mapping[str, Kind]:
    """Every law by its name in scene files."""
    return {name: kind(name) for name in names()}


def record(name: str) -> type[LawRecord]:
    """What a scene file says of the law with a name."""
    return kind(name).record


def _again(name: str, keys: dict[str, Any]) -> LawRecord:
    return record(name)(**keys)
