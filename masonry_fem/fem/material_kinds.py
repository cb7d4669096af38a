"""Material kinds: the laws of the folder ``materials``, each with the record that a scene file makes of it.

    record("drucker_prager")(cohesion=2e6, friction_angle=35.0)      # what a scene says
    law_of(told)                                                     # the law itself, of such a record

A record has the law's parameters as its keys.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import msgspec

from masonry_fem.fem import materials
from masonry_fem.fem.material_law import MaterialLaw
from masonry_fem.joints.parameters import table_of
from masonry_fem.records import discovery
from masonry_fem.records.law import MaterialRecord


@dataclass(frozen=True, slots=True)
class MaterialKind:
    """A law that scene files can ask for: its record, its class and where they stand."""

    record: type[MaterialRecord]
    law: type[MaterialLaw]
    file: str


def names() -> tuple[str, ...]:
    """The laws that a scene may ask for; none is loaded."""
    return discovery.names(materials.__path__)


@cache
def material_kind(name: str) -> MaterialKind:
    """The law with a name in scene files."""
    found = discovery.discovered(
        materials.__name__, name, MaterialLaw, "material law", lambda law: vars(law).get("name"),
        'write name: ClassVar[str] = "{name}" in it',
    )  # fmt: skip
    told = table_of(found.kind, name, MaterialRecord, found.file, _again)
    return MaterialKind(cast("type[MaterialRecord]", told), found.kind, found.file)


def material_kinds() -> Mapping[str, MaterialKind]:
    """Every law by its name in scene files."""
    return {name: material_kind(name) for name in names()}


def record(name: str) -> type[MaterialRecord]:
    """What a scene file says of the law with a name."""
    return material_kind(name).record


def law_of(told: MaterialRecord) -> MaterialLaw:
    """The law that a record describes.

    Raises
    ------
    LawError : Its parameters contradict mechanics or each other.
    """
    return material_kind(told.law).law(**msgspec.structs.asdict(told))


def _again(law: str, keys: dict[str, Any]) -> MaterialRecord:
    return record(law)(**keys)
