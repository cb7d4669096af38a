"""Kinds: the laws of the folder ``laws``, each with the record that a scene file makes of it.

    kinds()["mohr_coulomb"].record(cohesion=0.35e6)      # what a scene says
    kinds()["mohr_coulomb"].law(cohesion=0.35e6, friction=0.75)

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
from masonry_fem.records.discovery import Found, discovered
from masonry_fem.records.record import Spec


class LawRecord(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """What a scene says of a joint's law."""

    @property
    def kind(self) -> str:
        """The law's name in scene files."""
        return str(self.__struct_config__.tag)


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


@cache
def kinds() -> Mapping[str, Kind]:
    """Every law by its name in scene files."""
    base, naming = Law, 'write name: ClassVar[str] = "..." in it'
    found = discovered("masonry_fem.joints.laws", laws.__path__, base, "law", _name, naming)
    return {name: _kind(name, one) for name, one in found.items()}


def _again(kind: str, keys: dict[str, Any]) -> LawRecord:
    return kinds()[kind].record(**keys)


def _name(law: type[Law]) -> str | None:
    return vars(law).get("name")


def _kind(name: str, found: Found) -> Kind:
    law = found.kind
    record = table_of(law, name, LawRecord, found.file, _again)
    owed = dict.fromkeys(["friction", *(key for base in law.__mro__ for key in get_annotations(base))])
    if lacking := [key for key in owed if key not in parameters(law) and not hasattr(law, key)]:
        raise ExtensionError(
            f"{found.file}: {law.__name__} has no parameter {', '.join(lacking)}, expected those of its base "
            "classes and the friction, which the joint gives; write them, as in friction: Friction = 0.6"
        )
    return Kind(cast("type[LawRecord]", record), law, found.file)
