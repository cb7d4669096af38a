"""Elastic: stones of linear elasticity, with small strains and any rotation, by finite elements (DOLFINx)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np

from masonry_fem.fidelities import Fidelity, Given
from masonry_fem.host import installation

if TYPE_CHECKING:
    from masonry_fem.fem.groups import Group
    from masonry_fem.fem.material_law import MaterialLaw
    from masonry_fem.fem.orthotropic import Orthotropic
    from masonry_fem.scene.material import Orthotropy


def _orthotropic(stone: Orthotropy, rotation: np.ndarray) -> Orthotropic:
    """The elasticity of a stone that stands turned by ``rotation``, shape (d, d), in axes of its shape."""
    from masonry_fem.bodies.rotation import exponential  # noqa: PLC0415
    from masonry_fem.fem.orthotropic import Orthotropic  # noqa: PLC0415

    axis = np.array((0.0, 0.0, 1.0) if stone.axis is None else stone.axis)
    turn = exponential(np.radians(stone.angle) * axis / np.linalg.norm(axis))
    own = Orthotropic(stone.young, stone.poisson, stone.shear).turned(turn)
    return own.turned(rotation.T) if stone.frame == "world" else own


class Elastic(Fidelity):
    """One group for each distinct shape, material and clamping, all assembled at once."""

    name = "elastic"
    rank: ClassVar[float] = 2
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
        cls,
        given: Given,
        laws: Mapping[int, MaterialLaw] | None = None,
        *,
        promote: bool = False,
        reduced: bool = False,
    ) -> tuple[Group, ...]:
        """Groups of stones that deform.

        Parameters
        ----------
        given : The stones.
        laws : By which blocks yield; the others stay elastic.
        promote : Whether they do so only once their stress comes near to their strength.
        reduced : Whether blocks deform by polynomials of their material's degree only.
        """
        from masonry_fem.fem.groups import elastic_groups  # noqa: PLC0415
        from masonry_fem.fem.material import ElasticMaterial  # noqa: PLC0415

        materials = {}
        for block, stone in given.materials.items():
            damping, law = stone.damping, None if laws is None else laws.get(block)
            own, young = None, stone.young
            if stone.orthotropic is not None:
                rotation = given.assembly.blocks[block].pose.rotation
                own, young = _orthotropic(stone.orthotropic, rotation), max(stone.orthotropic.young)
            assert young is not None  # checked when the stones were laid
            materials[block] = ElasticMaterial(
                young, stone.poisson, stone.density, damping.mass, damping.stiffness,
                law, stone.promote_at if promote and law is not None else 0.0, own,
                stone.degree if reduced else 0,
            )  # fmt: skip
        before = cast("tuple[Group, ...]", given.before)
        assert cls.name is not None
        return elastic_groups(
            given.assembly, materials, given.clamps, given.plane, given.lumped, before, given.turns, cls.name,
            given.warming, {block: id(stone) for block, stone in given.materials.items()},
        )  # fmt: skip
