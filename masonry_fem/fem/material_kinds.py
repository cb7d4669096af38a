"""Material kinds: the laws of the folder ``materials``, each with the record that a scene file makes of it.

    material_kinds()["drucker_prager"].record(cohesion=2e6, friction_angle=35.0)    # what a scene says
    law_of(record)                                                                  # the law itself

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
from masonry_fem.records.discovery import Found, discovered
from masonry_fem.records.record import Spec


class MaterialRecord(Spec, frozen=True, kw_only=True, tag_field="law"):
    """What a scene says of the law of a material that yields or breaks."""

    @property
    def law(self) -> str:
        """The law's name in scene files."""
        return str(self.__struct_config__.tag)


@dataclass(frozen=True, slots=True)
class MaterialKind:
    """A law that scene files can ask for: its record, its class and where they stand."""

    record: type[MaterialRecord]
    law: type[MaterialLaw]
    file: str


@cache
def material_kinds() -> Mapping[str, MaterialKind]:
    """Every law by its name in scene files."""
    naming = 'write name: ClassVar[str] = "..." in it'
    found = discovered(
        "masonry_fem.fem.materials", materials.__path__, MaterialLaw, "material law", _name, naming
    )
    return {name: _kind(name, one) for name, one in found.items()}


def law_of(record: MaterialRecord) -> MaterialLaw:
    """The law that a record describes.

    Raises
    ------
    LawError : Its parameters contradict mechanics or each other.
    """
    return material_kinds()[record.law].law(**msgspec.structs.asdict(record))


def material_record(law: str, **keys: Any) -> MaterialRecord:
    """The record of a law: ``material_record("drucker_prager", cohesion=2e6, friction_angle=35.0)``."""
    return material_kinds()[law].record(**keys)


def _again(law: str, keys: dict[str, Any]) -> MaterialRecord:
    return material_record(law, **keys)


def _name(law: type[MaterialLaw]) -> str | None:
    return vars(law).get("name")


def _kind(name: str, found: Found) -> MaterialKind:
    record = table_of(found.kind, name, MaterialRecord, found.file, _again)
    return MaterialKind(cast("type[MaterialRecord]", record), found.kind, found.file)
