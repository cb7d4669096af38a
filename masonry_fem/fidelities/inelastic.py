"""Inelastic: elastic stones that yield by the law of their material, by finite elements (DOLFINx)."""

from __future__ import annotations

from typing import TYPE_CHECKING, override

from masonry_fem.fidelities import Given, distinct
from masonry_fem.fidelities.elastic import Elastic

if TYPE_CHECKING:
    from masonry_fem.fem.groups import Group


class Inelastic(Elastic):
    """One group for each distinct shape, material and clamping; what stays elastic costs no more.

    Attributes
    ----------
    promotes : Whether stones are elastic until their stress comes near to their strength.
    """

    name = "inelastic"
    rank = 3
    yields = True
    promotes = False

    @classmethod
    @override
    def groups(cls, given: Given) -> tuple[Group, ...]:
        """The groups, in the order of their first blocks."""
        from masonry_fem.fem.plane_stress import PlaneStress  # noqa: PLC0415

        free = given.assembly.dimension == 2 and given.plane == "stress"
        own = {id(stone): given.law(stone) for stone in distinct(given)[0] if stone.inelastic is not None}
        laws = {key: PlaneStress(law) if free else law for key, law in own.items()}
        return cls.made(given, laws, promote=cls.promotes)
