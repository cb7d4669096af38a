"""Elastic groups of a scene; importing this module imports DOLFINx and PETSc."""

from __future__ import annotations

from pathlib import Path

from masonry_fem.bodies.base import BodyGroup
from masonry_fem.build.stones import Stones
from masonry_fem.build.supports import motion_of
from masonry_fem.fem import _compat  # noqa: F401 - DOLFINx counts as import, not as assembly
from masonry_fem.fem.clamp import Clamp
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.groups import elastic_groups
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.scene import specs


def elastic(
    scene: specs.Scene, stones: Stones, base: Path, before: tuple[BodyGroup, ...] = ()
) -> list[BodyGroup]:
    """One group for each distinct shape, material and clamping, all assembled at once.

    Parameters
    ----------
    scene : The scene.
    stones : Its blocks, meshed.
    base : Folder that its paths are relative to.
    before : Groups of an earlier model; matrices that are the same are taken from them.

    Raises
    ------
    GeometryError : A mesh that elements cannot use.
    InstallationError : There is no usable DOLFINx.
    """
    materials = {block: _material(scene, stones.material[block]) for block in stones.of_role("elastic")}
    clamps = {
        block: tuple(
            Clamp(
                held.face,
                held.components,
                None if held.motion is None else motion_of(scene, held.motion, base),
            )
            for held in several
        )
        for block, several in stones.clamps.items()
    }
    known = [group for group in before if isinstance(group, ElasticGroup)]
    lumped = scene.mass == "lumped"
    return list(elastic_groups(stones.assembly, materials, clamps, scene.plane, lumped, known))


def _material(scene: specs.Scene, name: str) -> ElasticMaterial:
    stone = scene.materials[name]
    assert stone.young is not None  # checked when the stones were laid
    return ElasticMaterial(
        young=stone.young,
        poisson=stone.poisson,
        density=stone.density,
        mass_damping=stone.damping.mass,
        stiffness_damping=stone.damping.stiffness,
    )
