"""Reduced: elastic stones that deform by a few polynomial modes of their shape, between rigid and elastic."""

from __future__ import annotations

from typing import TYPE_CHECKING, override

from masonry_fem.errors import SceneError
from masonry_fem.fidelities import Given
from masonry_fem.fidelities.elastic import Elastic

if TYPE_CHECKING:
    from masonry_fem.fem.groups import Group


class Reduced(Elastic):
    """One group for each distinct shape and material; its modes are made once."""

    name = "reduced"
    rank = 1.5
    skin = 0.25

    @classmethod
    @override
    def groups(cls, given: Given) -> tuple[Group, ...]:
        """The groups, in the order of their first blocks.

        Raises
        ------
        SceneError
            If a face of such a block is held.
        """
        for block in given.materials:
            for clamp in given.clamps.get(block, ()):
                name = given.assembly.blocks[block].name
                raise SceneError(
                    f"block '{name}' is reduced and its face {clamp.face} is held, expected reduced blocks "
                    "whose faces are all free: their modes bend every face; set its fidelity = 'elastic', or "
                    "hold the whole block"
                )
        return cls.made(given, reduced=True)
