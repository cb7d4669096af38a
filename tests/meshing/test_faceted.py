"""Curved stones with the facets of their elements: each face is a whole number of facets of the mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.meshing.faceted import faceted
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.structures import build_structure
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.barrel_vault import BarrelVaultStructure
from masonry_fem.structures.elliptical_arch import EllipticalArchStructure
from masonry_fem.structures.pointed_arch import PointedArchStructure
from tests.meshing.test_meshing import check

COMMON = {"name": "s", "material": "m", "thickness": 0.2, "voussoirs": 5}
KINDS = {
    "arch": ArchStructure(radius=1.0, depth=0.4, **COMMON),
    "vault": BarrelVaultStructure(radius=1.0, stones=2, **COMMON),
    "elliptical": EllipticalArchStructure(span=2.0, rise=0.7, depth=0.4, **COMMON),
    "pointed": PointedArchStructure(span=2.0, rise=1.2, depth=0.4, **COMMON),
}
CASES = [(kind, d) for kind in KINDS for d in (2, 3) if (kind, d) != ("vault", 2)]


def stones(kind: str, dimension: int) -> list[Shape]:
    made = build_structure(KINDS[kind], dimension, Path(), MeshSettings())
    return [made.shapes[k] for k in {block.shape for block in made.blocks if not block.support}]


@pytest.mark.parametrize("along", [1, 2, 6, 20])
@pytest.mark.parametrize(("kind", "dimension"), CASES)
def test_faces_are_those_of_the_elements(kind: str, dimension: int, along: int) -> None:
    settings = MeshSettings(divisions=(along, *(1,) * (dimension - 2), 2))
    for shape in stones(kind, dimension):
        fine, origin = faceted(shape, settings)
        assert [shape.solid.names[old] for old in origin] == list(fine.solid.names)
        mesh = mesh_shape(shape, settings, dimension, fine.solid)
        # where elements divide the facets of an arc, its nodes are on the arc
        check(mesh, fine.solid, exact=len(fine.arcs) == 0 or fine is not shape)
        assert set(fine.solid.names) == set(shape.solid.names)
        assert set(fine.solid.labels) == set(shape.solid.labels)


@pytest.mark.parametrize("along", [16, 32])
@pytest.mark.parametrize("kind", ["arch", "elliptical"])
def test_facets_that_elements_divide_stay(kind: str, along: int) -> None:
    for shape in stones(kind, 2):
        assert faceted(shape, MeshSettings(divisions=(along, 1)))[0] is shape


@pytest.mark.parametrize("dimension", [2, 3])
def test_curves_are_followed_with_the_new_facets_too(dimension: int) -> None:
    settings = MeshSettings(divisions=(3, *(1,) * (dimension - 2), 2))
    for kind in ("arch", "elliptical"):
        for shape in stones(kind, dimension):
            once, again = (
                mesh_shape(one, settings, dimension) for one in (shape, faceted(shape, settings)[0])
            )
            np.testing.assert_allclose(again.points, once.points, atol=1e-14)
