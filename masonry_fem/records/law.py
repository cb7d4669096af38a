"""Law: what a scene says of the law of a joint or of a stone; keys are added by the file of each law."""

from __future__ import annotations

from masonry_fem.records.record import Spec


class LawRecord(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """What a scene says of a joint's law."""

    @property
    def kind(self) -> str:
        """The law's name in scene files."""
        return str(self.__struct_config__.tag)


class MaterialRecord(Spec, frozen=True, kw_only=True, tag_field="law"):
    """What a scene says of the law of a material that yields or breaks."""

    @property
    def law(self) -> str:
        """The law's name in scene files."""
        return str(self.__struct_config__.tag)
