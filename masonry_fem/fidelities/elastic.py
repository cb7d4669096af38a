"""Elastic: stones of linear elasticity and small displacements, by finite elements (DOLFINx)."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from masonry_fem.fidelities import Fidelity, Given
from masonry_fem.host import installation

if TYPE_CHECKING:
    from masonry_fem.fem.elastic import ElasticGroup


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
    def groups(cls, given: Given) -> tuple[ElasticGroup, ...]:
        """The groups, in the order of their first blocks."""
        from masonry_fem.fem.groups import elastic_groups  # noqa: PLC0415
        from masonry_fem.fem.material import ElasticMaterial  # noqa: PLC0415

        materials = {}
        for block, stone in given.materials.items():
            assert stone.young is not None  # checked when the stones were laid
            damping = stone.damping
            materials[block] = ElasticMaterial(
                stone.young, stone.poisson, stone.density, damping.mass, damping.stiffness
            )
        before = cast("tuple[ElasticGroup, ...]", given.before)
        return elastic_groups(given.assembly, materials, given.clamps, given.plane, given.lumped, before)
