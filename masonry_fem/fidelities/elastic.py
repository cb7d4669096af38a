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

    @staticmethod
    def made(given: Given, laws: Mapping[int, MaterialLaw] | None = None) -> tuple[Group, ...]:
        """Groups of stones that deform.

        Parameters
        ----------
        given : The stones.
        laws : By which each block yields; None: all stay elastic.
        """
        from masonry_fem.fem.constitution import LinearElasticity  # noqa: PLC0415
        from masonry_fem.fem.groups import elastic_groups  # noqa: PLC0415
        from masonry_fem.fem.inelastic import Inelasticity  # noqa: PLC0415
        from masonry_fem.fem.material import ElasticMaterial  # noqa: PLC0415

        materials = {}
        for block, stone in given.materials.items():
            assert stone.young is not None  # checked when the stones were laid
            damping = stone.damping
            materials[block] = ElasticMaterial(
                stone.young, stone.poisson, stone.density, damping.mass, damping.stiffness,
                None if laws is None else laws[block],
            )  # fmt: skip
        before = cast("tuple[Group, ...]", given.before)
        return elastic_groups(
            given.assembly, materials, given.clamps, given.plane, given.lumped, before,
            LinearElasticity if laws is None else Inelasticity, given.turns,
        )  # fmt: skip
