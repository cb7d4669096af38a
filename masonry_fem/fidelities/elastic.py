"""Elastic: stones of linear elasticity and small displacements, by finite elements (DOLFINx)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

from masonry_fem.fidelities import Fidelity, Given
from masonry_fem.host import installation

if TYPE_CHECKING:
    from masonry_fem.fem.groups import Group
    from masonry_fem.fem.material_law import MaterialLaw


class Elastic(Fidelity):
    """One group for each distinct shape, material and clamping, all assembled at once."""

    name = "elastic"
    rank = 2
    deforms = True

    @classmethod
    def load(cls) -> None:
        """Import DOLFINx and PETSc."""
        installation.require_fenicsx()
        installation.require_compiler()
        from masonry_fem.fem import _compat  # noqa: F401, PLC0415

    @classmethod
    def groups(cls, given: Given) -> tuple[Group, ...]:
        """The groups, in the order of their first blocks."""
        return cls.made(given)

    @classmethod
    def made(
        cls, given: Given, laws: Mapping[int, MaterialLaw] | None = None, *, promote: bool = False
    ) -> tuple[Group, ...]:
        """Groups of stones that deform.

        Parameters
        ----------
        given : The stones.
        laws : By which blocks yield; the others stay elastic.
        promote : Whether they do so only once their stress comes near to their strength.
        """
        from masonry_fem.fem.groups import elastic_groups  # noqa: PLC0415
        from masonry_fem.fem.material import ElasticMaterial  # noqa: PLC0415

        materials = {}
        for block, stone in given.materials.items():
            assert stone.young is not None  # checked when the stones were laid
            damping, law = stone.damping, None if laws is None else laws.get(block)
            materials[block] = ElasticMaterial(
                stone.young, stone.poisson, stone.density, damping.mass, damping.stiffness,
                law, stone.promote_at if promote and law is not None else 0.0,
            )  # fmt: skip
        before = cast("tuple[Group, ...]", given.before)
        assert cls.name is not None
        return elastic_groups(
            given.assembly, materials, given.clamps, given.plane, given.lumped, before, given.turns, cls.name,
            given.warming,
        )  # fmt: skip
