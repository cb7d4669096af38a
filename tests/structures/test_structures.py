"""Structures: shapes shared, blocks where they belong, exact masses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.errors import ExtensionError, GeometryError, SceneError
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import assemble, build_structure, kind
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure


def built(spec, dimension: int) -> Assembly:
    return build_structure(spec, dimension, Path(), MeshSettings())


def wall(**keys) -> WallStructure:
    return WallStructure(
        **({"name": "wall", "material": "s", "brick": (0.5, 0.25, 0.25), "columns": 4, "courses": 5} | keys)
    )


def arch(**keys) -> ArchStructure:
    return ArchStructure(
        **({"name": "arch", "material": "s", "radius": 1.0, "thickness": 0.2, "voussoirs": 11} | keys)
    )


def test_low_wall_is_the_reference_case() -> None:
    """A10.4: 22 bricks on a floor, two shapes of brick; 53 interfaces."""
    made = built(wall(), 3)
    assert len(made.blocks) == 23
    used = {block.shape for block in made.blocks if not block.support}
    assert len(used) == 2
    volume = sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)
    assert volume == pytest.approx(2.0 * 0.25 * 1.25)
    interfaces = detect(made)
    assert len(interfaces) == 53
    assert sum(one.label == "head" for one in interfaces) == 17
    assert next(block.name for block in made.blocks if "wall.c2" in block.groups) == "wall.c2.b1"


@pytest.mark.parametrize(("halves", "first", "second"), [("even", 4, 5), ("odd", 5, 4), ("none", 4, 3)])
def test_half_bricks(halves: str, first: int, second: int) -> None:
    made = built(wall(half_bricks=halves, courses=2), 3)
    counts = [sum(f"wall.c{course}" in block.groups for block in made.blocks) for course in (1, 2)]
    assert counts == [first, second]


@pytest.mark.parametrize("dimension", [2, 3])
def test_cut_bricks_are_two_halves_with_a_joint_of_their_own(dimension: int) -> None:
    size = (0.5, 0.25, 0.25)[3 - dimension :] if dimension == 3 else (0.5, 0.25)
    whole, cut = (built(wall(brick=size, cut=one), dimension) for one in (False, True))
    labels = [[one.label for one in detect(made)] for made in (whole, cut)]
    bricks = sum(block.shape == 0 for block in whole.blocks)
    assert bricks == 18
    assert labels[1].count("brick") == bricks
    assert labels[1].count("head") == labels[0].count("head") == 17
    assert len(cut.blocks) == len(whole.blocks) + bricks
    assert "wall.c1.b2" in next(b for b in cut.blocks if b.name == "wall.c1.b2.l").groups
    volumes = [
        sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)
        for made in (whole, cut)
    ]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("straight", [False, True])
def test_voussoirs_have_their_exact_mass(dimension: int, straight: bool) -> None:
    made = built(arch(straight=straight, depth=0.3), dimension)
    solid = made.shapes[0].solid
    angle, inner, outer = np.pi / 11, 0.9, 1.1
    area = (np.sin(angle) if straight else angle) * (outer**2 - inner**2) / 2
    expected = area * (0.3 if dimension == 3 else 1.0)
    assert solid.mass_properties().volume == pytest.approx(expected, rel=1e-12)
    # radius of the centroid of a sector; facets move it by their angle squared
    if not straight:
        radius = 2 / 3 * (outer**3 - inner**3) / (outer**2 - inner**2) * np.sin(angle / 2) / (angle / 2)
        assert solid.mass_properties().centroid[-1] == pytest.approx(radius, rel=2e-5)
    total = sum(solid.area_vector(face) for face in range(len(solid.faces)))
    assert np.abs(total).max() < 1e-14


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("voussoirs", [1, 2, 11, 30])
def test_arch_has_a_joint_between_all_neighbours(dimension: int, voussoirs: int) -> None:
    made = built(arch(voussoirs=voussoirs, embrace=150.0, depth=0.4), dimension)
    interfaces = detect(made)
    assert len(interfaces) == voussoirs + 1
    assert {one.label for one in interfaces} == {"radial"}
    area = 0.2 * (0.4 if dimension == 3 else 1.0)
    assert [one.area for one in interfaces] == pytest.approx([area] * (voussoirs + 1))
    assert sum(block.support for block in made.blocks) == 2


def test_arch_stands_the_right_way_up() -> None:
    made = built(arch(centre=(5.0, 0.0, 2.0)), 3)
    names = [block.name for block in made.blocks]
    crown, left = (made.solid(names.index(n)).mass_properties().centroid for n in ("arch.v06", "arch.v01"))
    assert crown[[0, 2]] == pytest.approx([5.0, 3.0], abs=5e-3)
    assert left[0] < 5.0
    assert left[2] > 2.0


def test_arch_thicker_than_its_radius_is_refused() -> None:
    with pytest.raises(GeometryError, match="thickness"):
        built(arch(thickness=2.5), 2)


def test_stack_and_stair() -> None:
    made = built(StackStructure(name="s", material="s", size=(1.0, 1.0, 0.5), count=3, offset=0.2), 3)
    lows = [made.solid(i).vertices.min(axis=0) for i in range(1, 4)]
    assert np.array(lows) == pytest.approx(np.array([[0, 0, 0], [0.2, 0, 0.5], [0.4, 0, 1.0]]))
    assert len(detect(made)) == 3


def test_gap_of_a_stack_opens_every_joint() -> None:
    made = built(StackStructure(name="s", material="s", size=(1.0, 1.0), count=2, gap=0.1), 2)
    assert [made.solid(i).vertices[:, 1].min() for i in (1, 2)] == pytest.approx([0.1, 1.2])


def test_block_turns_about_its_corner() -> None:
    made = built(
        BlockStructure(name="b", material="s", size=(1.0, 2.0), position=(3.0, 4.0), rotation=90.0), 2
    )
    solid = made.solid(0)
    assert solid.vertices.min(axis=0) == pytest.approx([1.0, 4.0])
    assert solid.vertices.max(axis=0) == pytest.approx([3.0, 5.0])


def test_equal_shapes_of_two_structures_are_one() -> None:
    one = BlockStructure(name="a", material="s", size=(1.0, 1.0))
    two = BlockStructure(name="b", material="s", size=(1.0, 1.0), position=(2.0, 0.0))
    made = assemble([built(one, 2), built(two, 2)])
    assert len(made.shapes) == 1
    assert [block.shape for block in made.blocks] == [0, 0]


def test_names_are_unique() -> None:
    one = built(BlockStructure(name="a", material="s", size=(1.0, 1.0)), 2)
    with pytest.raises(SceneError, match="'a'"):
        assemble([one, one])


@pytest.mark.parametrize(
    ("made", "fault"),
    [
        (lambda good: None, "a NoneType, expected an Assembly"),
        (lambda good: replace(good, shapes=good.shapes[:1]), r"block '.*' the shape 2, expected 0 to 0"),
        (lambda good: built(wall(brick=(0.5, 0.25)), 2), r"the 2D shape '.*', expected one in 3D"),
    ],
)
def test_what_a_build_gives_is_checked(made, fault, monkeypatch) -> None:
    given = made(built(wall(), 3))
    wrong = replace(kind("wall"), build=lambda *asked: given)
    monkeypatch.setattr("masonry_fem.structures.kind", lambda name: wrong)
    with pytest.raises(ExtensionError, match=rf"\.py: build gives {fault}"):
        built(wall(), 3)
