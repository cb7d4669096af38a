"""Reduced: elastic stones that deform by a few polynomial modes of their shape, between rigid and elastic."""

from __future__ import annotations

from typing import TYPE_CHECKING, override

from masonry_fem.errors import SceneError
from masonry_fem.fidelities import Given
from masonry_fem.fidelities.elastic import Elastic

if TYPE_CHECKING:
    from masonry_fem.fem.groups import Group
    from masonry_fem.scene.specs import Material

# Of the width of a face, over the degree. Of a running bond of 20 × 20 bricks under its weight mean stresses
# differ from elastic ones by 1.8 % with it, of one of 12 × 12 by 1.9 %, and with half of it by 2.5 %.
SKIN = 0.17
# Degree up to which faces count as plane. With degree 3 mean stresses of walls and an arch are then 1.3 to
# 2.2 % off, with contacts at all nodes 0.5 to 0.9 %; with degrees 1 and 2 plane faces are nearer.
FLAT = 2


class Reduced(Elastic):
    """One group for each distinct shape and material; its modes are made once."""

    name = "reduced"
    rank = 1.5

    @classmethod
    @override
    def skin(cls, material: Material) -> float:
        """Modes of a higher degree leave out less."""
        return SKIN / material.degree

    @classmethod
    @override
    def placement(cls, material: Material) -> str:
        """Faces of few modes stay nearly plane; modes of a higher degree follow what more contacts tell."""
        return "navier" if material.degree <= FLAT else "auto"

    @classmethod
    @override
    def groups(cls, given: Given) -> tuple[Group, ...]:
        """The groups, in the order of their first blocks.

        Raises
        ------
        SceneError
            If a face of such a block is held.
        """
        for block, clamps in given.clamps.items():
            for clamp in clamps if block in given.materials else ():
                name, solid = given.assembly.blocks.names[block], given.assembly.solid(block)
                face = solid.names[clamp.face] or str(clamp.face)
                raise SceneError(
                    f"block '{name}' is reduced and a support holds its face '{face}', expected reduced "
                    "blocks whose faces are all free: their modes bend every face; set its fidelity = "
                    "'elastic', or hold the whole block"
                )
        return cls.made(given, reduced=True)
