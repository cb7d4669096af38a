"""Barrel vaults: two shapes, stones in bond, the statics of the arch that is their section."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Scene,
    Solver,
    Statics,
)
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import build_structure
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.barrel_vault import BarrelVaultStructure
from tests.meshing.test_meshing import check as check_mesh

G, DENSITY = 9.81, 2000.0


def spec(**keys) -> BarrelVaultStructure:
    given = {"radius": 1.0, "thickness": 0.2, "voussoirs": 9, "stones": 4, "depth": 2.0}
    return BarrelVaultStructure(**({"name": "vault", "material": "stone"} | given | keys))


def vault(**keys) -> Assembly:
    return build_structure(spec(**keys), 3, Path(), MeshSettings())


def solve(**keys):
    given = {
        "fidelity": "rigid",
        "materials": {"stone": Material(density=DENSITY, young=10e9)},
        "joints": (Joint(friction=0.6),),
        "loads": Loads(gravity=(0.0, 0.0, -G)),
    }
    return solve_scene(Scene(**(given | keys)))


@pytest.mark.parametrize("embrace", [180.0, 120.0])
@pytest.mark.parametrize("staggered", [True, False])
def test_stones_are_counted_and_have_their_volume(staggered: bool, embrace: float) -> None:
    made = vault(staggered=staggered, embrace=embrace)
    stones = [made.solid(i) for i, block in enumerate(made.blocks) if not block.support]
    assert len(stones) == 9 * 4 + (4 if staggered else 0)
    volume = sum(solid.mass_properties().volume for solid in stones)
    step = np.radians(embrace) / 9
    assert volume == pytest.approx(9 * np.sin(step) * (1.1**2 - 0.9**2) / 2 * 2.0, rel=1e-12)
    assert len({b.shape for b in made.blocks if not b.support}) == (2 if staggered else 1)
    assert overlapping(made) == []
    points = np.concatenate([solid.vertices for solid in stones])
    assert points.min(axis=0)[1] == pytest.approx(0.0, abs=1e-12)
    assert points.max(axis=0) == pytest.approx([1.1 * np.sin(np.radians(embrace) / 2), 2.0, 1.1], rel=0.02)


@pytest.mark.parametrize("staggered", [True, False])
def test_stones_lie_in_bond(staggered: bool) -> None:
    made = vault(staggered=staggered)
    interfaces = detect(made)
    # four whole courses of 5 pieces among five of 4; every joint between two courses is cut eight times
    expected = {"head": 5 * 3 + 4 * (4 if staggered else 3), "radial": 8 * (8 if staggered else 4) + 2 * 4}
    assert Counter(one.label for one in interfaces) == expected
    assert max(np.abs(one.gap).max() for one in interfaces) < 1e-12
    radial = sum(one.area for one in interfaces if one.label == "radial")
    assert radial == pytest.approx(10 * 0.2 * 2.0, rel=1e-9)


@pytest.mark.parametrize("staggered", [True, False])
def test_irregular_stones_are_all_unlike_and_fill_the_vault(staggered: bool) -> None:
    made = vault(staggered=staggered, irregularity=0.2, seed=3)
    stones = [made.solid(i) for i, block in enumerate(made.blocks) if not block.support]
    volumes = np.sort([solid.mass_properties().volume for solid in stones])
    assert len(stones) == 9 * 4 + (4 if staggered else 0)
    assert np.diff(volumes).min() > 1e-6 * volumes.max()
    assert overlapping(made) == []
    interfaces = detect(made)
    assert max(np.abs(one.gap).max() for one in interfaces) < 1e-12
    radial = sum(one.area for one in interfaces if one.label == "radial")
    assert radial == pytest.approx(10 * 0.2 * 2.0, rel=1e-9)
    # a course is a prism between two bed joints through the axis
    beds = np.array([made.solid(b).vertices[:, [0, 2]] for b in range(len(made.blocks))][2:], dtype=object)
    angles = np.unique(np.round([np.arctan2(*point) for stone in beds for point in stone], 9))
    ring = np.sin(np.diff(angles)).sum() * (1.1**2 - 0.9**2) / 2
    assert volumes.sum() == pytest.approx(2.0 * ring, rel=1e-6)


def test_a_seed_tells_irregular_vaults_apart() -> None:
    def first(**keys):
        return vault(irregularity=0.1, **keys).shapes[-1].solid.vertices

    np.testing.assert_array_equal(first(seed=1), first(seed=1))
    assert np.abs(first(seed=1) - first(seed=2)).max() > 1e-3


def test_courses_have_names() -> None:
    made = vault(voussoirs=3, stones=2)
    names = [block.name for block in made.blocks]
    assert names == [
        "vault.springing_left", "vault.springing_right", "vault.c1.s1", "vault.c1.s2", "vault.c2.s1",
        "vault.c2.s2", "vault.c2.s3", "vault.c3.s1", "vault.c3.s2",
    ]  # fmt: skip
    groups = {b.name: b.groups for b in made.blocks}
    assert groups["vault.c2.s3"] == ("vault", "vault.c2", "vault.keystone")
    assert groups["vault.c1.s1"] == ("vault", "vault.c1", "vault.springers")


def test_stones_are_hexahedra() -> None:
    made = vault()
    for number in {block.shape for block in made.blocks if not block.support}:
        shape = made.shapes[number]
        mesh = mesh_shape(shape, MeshSettings(divisions=(3, 2, 1)), 3)
        check_mesh(mesh, shape.solid)
        assert mesh.cell == "hexahedron"
        joint = mesh.facet_face == shape.solid.names.index("start")
        assert joint.sum() == 2  # along the depth


def test_a_vault_pushes_as_the_arch_that_is_its_section() -> None:
    """Elastic: the base force is the weight; stones of one piece along the axis give the same thrust."""
    mesh = MeshSettings(divisions=(2, 2, 4))
    result = solve(fidelity="elastic", structures=(spec(stones=2, depth=1.0, mesh=mesh),), analysis=Statics())
    assert result.outcome == "equilibrium"
    arch = ArchStructure(
        name="vault", material="stone", radius=1.0, thickness=0.2, voussoirs=9, straight=True, mesh=mesh
    )
    whole = solve(fidelity="elastic", structures=(arch,), analysis=Statics())
    forces = [
        np.array([one.summary.supports[f"vault.springing_{side}"].force for side in ("left", "right")])
        for one in (result, whole)
    ]
    weight = 9 * np.sin(np.pi / 9) * 0.2 * DENSITY * G
    for one in forces:
        assert one.sum(axis=0) == pytest.approx([0.0, 0.0, weight], rel=1e-8, abs=1e-6 * weight)
        assert one[0] == pytest.approx(one[1] * [-1, 1, 1], rel=1e-6, abs=1e-6 * weight)
    assert forces[0][0, 0] == pytest.approx(forces[1][0, 0], rel=0.02)


@pytest.mark.parametrize(("share", "outcome"), [(1.03, "equilibrium"), (0.97, "no_equilibrium")])
def test_a_vault_is_as_thin_as_its_section_may_be(share: float, outcome: str) -> None:
    """A3.2 for 11 voussoirs, .10491 R; straight stones move the centroids by less than a per cent."""
    structure = spec(voussoirs=11, stones=2, depth=0.6, thickness=share * 0.10491)
    analysis = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
    result = solve(
        structures=(structure,), joints=(Joint(friction=5.0),), analysis=analysis,
        solver=Solver(tolerance=1e-10),
    )  # fmt: skip
    assert result.outcome == outcome


@pytest.mark.parametrize(
    ("keys", "words"),
    [({"thickness": 2.0}, "less than twice the mean radius"), ({"voussoirs": 1}, "less than half a circle")],
)
def test_what_cannot_be_built(keys: dict, words: str) -> None:
    scene = Scene(
        fidelity="rigid",
        materials={"stone": Material(density=DENSITY)},
        structures=(spec(**keys),),
        joints=(Joint(friction=0.6),),
    )
    with pytest.raises(SceneError, match=words):
        check(scene, base=Path())


def test_a_vault_is_not_plane() -> None:
    with pytest.raises(GeometryError, match="dimension 2, expected 3"):
        build_structure(spec(), 2, Path(), MeshSettings())
