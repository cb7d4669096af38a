"""Elastic: stones of linear elasticity, with small strains and any rotation, by finite elements (DOLFINx)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np

from masonry_fem.contact.interfaces import numbered
from masonry_fem.fidelities import Fidelity, Given, distinct
from masonry_fem.host import installation
from masonry_fem.solid.assembly import taken

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
        laws : By which materials yield, by their ``id``; the others stay elastic.
        promote : Whether they do so only once their stress comes near to their strength.
        reduced : Whether blocks deform by polynomials of their material's degree only.
        """
        from masonry_fem.fem.groups import elastic_groups  # noqa: PLC0415
        from masonry_fem.fem.material import ElasticMaterial  # noqa: PLC0415

        blocks = np.array(list(given.materials), dtype=np.int64)
        stones, kinds = distinct(given)
        rotation = given.assembly.blocks.rotation[blocks]
        # the axes of stone that is stiffer in some directions turn with the blocks
        rotation[np.array([stone.orthotropic is None for stone in stones])[kinds]] = 0.0
        number, first = numbered(np.column_stack([kinds, rotation.reshape(len(blocks), -1)]))
        made = []
        for block, turn in zip(blocks[first].tolist(), rotation[first], strict=True):
            stone = given.materials[block]
            damping, law = stone.damping, None if laws is None else laws.get(id(stone))
            own, young = None, stone.young
            if stone.orthotropic is not None:
                own, young = _orthotropic(stone.orthotropic, turn), max(stone.orthotropic.young)
            assert young is not None  # checked when the stones were laid
            made.append(ElasticMaterial(
                young, stone.poisson, stone.density, damping.mass, damping.stiffness,
                law, stone.promote_at if promote and law is not None else 0.0, own,
                stone.degree if reduced else 0,
            ))  # fmt: skip
        before = cast("tuple[Group, ...]", given.before)
        assert cls.name is not None
        return elastic_groups(
            given.assembly, dict(zip(blocks.tolist(), taken(made, number), strict=True)), given.clamps,
            given.plane, given.lumped, before, given.turns, cls.name,
            given.warming, dict(zip(blocks.tolist(), kinds.tolist(), strict=True)),
        )  # fmt: skip
