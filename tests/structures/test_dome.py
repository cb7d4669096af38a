"""Domes: one shape a ring, joints between all neighbours, volumes of a shell."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures import build_structure
from masonry_fem.structures.dome import DomeStructure
from tests.meshing.test_meshing import check


def dome(**keys) -> Assembly:
    given = {"name": "dome", "material": "s", "radius": 5.0, "thickness": 0.5, "rings": 4, "slices": 8}
    return build_structure(DomeStructure(**(given | keys)), 3, Path(), MeshSettings())


def volume(made: Assembly) -> float:
    return sum(made.solid(i).mass_properties().volume for i, b in enumerate(made.blocks) if not b.support)


def shell(low: float, high: float, base: float, eye: float = 0.0, sweep: float = 360.0) -> float:
    """Volume between two spheres and two cones, angles in degrees from the crown."""
    band = np.cos(np.radians(eye)) - np.cos(np.radians(base))
    return np.radians(sweep) * band * (high**3 - low**3) / 3


def test_stones_of_a_ring_share_a_shape_and_stones_have_names() -> None:
    made = dome()
    stones = [block for block in made.blocks if not block.support]
    assert len(stones) == 4 * 8 + 1
    assert len({block.shape for block in stones}) == 5
    assert stones[0].name == "dome.r1.s1"
    assert stones[0].groups == ("dome", "dome.r1", "dome.s1")
    assert stones[-1].name == "dome.crown"
    supports = [block.name for block in made.blocks if block.support]
    assert supports == [f"dome.base.s{i}" for i in range(1, 9)]


@pytest.mark.parametrize(
    "keys",
    [{}, {"oculus": 20.0}, {"springing": 60.0}, {"staggered": True}, {"sweep": 90.0, "slices": 3}],
    ids=str,
)
def test_solids_are_closed_and_their_faces_flat(keys: dict) -> None:
    made = dome(**keys)
    for shape in made.shapes:
        solid = shape.solid
        total = sum(solid.area_vector(face) for face in range(len(solid.faces)))
        assert np.abs(total).max() < 1e-12
        assert solid.mass_properties().volume > 0
        for face in range(len(solid.faces)):
            points, normal = solid.face_points(face), solid.normal(face)
            assert np.abs((points - points[0]) @ normal).max() < 1e-12
    stones = [i for i, block in enumerate(made.blocks) if not block.support]
    for i in stones:
        solid = made.solid(i)
        middle = solid.mass_properties().centroid
        face = solid.names.index("extrados")
        assert solid.normal(face) @ middle > 0


@pytest.mark.parametrize("oculus", [0.0, 20.0])
@pytest.mark.parametrize("springing", [60.0, 90.0])
def test_volumes_approach_the_shell(springing: float, oculus: float) -> None:
    """Chords for arcs leave out a part that falls with the square of a stone's angle."""
    exact = shell(4.75, 5.25, springing, oculus)
    lacking = [
        1 - volume(dome(rings=4 * n, slices=8 * n, springing=springing, oculus=oculus)) / exact
        for n in (1, 2, 4)
    ]
    assert 0 < lacking[2] < lacking[1] < lacking[0] < 0.2
    assert lacking[1] / lacking[2] == pytest.approx(4.0, rel=0.05)


def test_volume_of_a_sector() -> None:
    whole, part = dome(slices=24), dome(slices=6, sweep=90.0)
    assert volume(part) == pytest.approx(volume(whole) / 4, rel=1e-12)


@pytest.mark.parametrize("oculus", [0.0, 15.0])
def test_every_face_meets_its_neighbour(oculus: float) -> None:
    made = dome(oculus=oculus)
    interfaces = detect(made)
    labels = Counter(one.label for one in interfaces)
    assert labels == {"bed": (4 if oculus else 5) * 8, "meridian": 4 * 8}
    for one in interfaces:
        assert np.abs(one.gap).max() < 1e-12
        areas = [
            np.linalg.norm(made.solid(block).area_vector(face))
            for block, face in zip(one.blocks, one.faces, strict=True)
            if not made.blocks[block].support
        ]
        assert areas == pytest.approx([one.area] * len(areas), rel=1e-9)


def test_staggered_rings_meet_on_halves() -> None:
    made = dome(staggered=True, oculus=15.0)
    interfaces = detect(made)
    labels = Counter(one.label for one in interfaces)
    assert labels == {"bed": 4 * 16, "meridian": 4 * 8}
    lower = next(one for one in interfaces if one.label == "meridian")
    upper = next(one for one in interfaces if made.blocks[one.blocks[0]].name == "dome.r2.s1")
    assert lower.area > 0
    assert upper.area > 0
    assert np.abs(np.concatenate([one.gap for one in interfaces])).max() < 1e-12


def test_a_sector_stands_between_its_sides() -> None:
    made = dome(sweep=30.0, slices=2, sides=True, oculus=0.0)
    interfaces = detect(made)
    names = [{made.blocks[block].name for block in one.blocks} for one in interfaces]
    start = [one for one, pair in zip(interfaces, names, strict=True) if "dome.side_start" in pair]
    end = [one for one, pair in zip(interfaces, names, strict=True) if "dome.side_end" in pair]
    assert len(start) == len(end) == 5  # four rings and the crown
    assert {one.label for one in start + end} == {"meridian"}
    outward = sum(one.area for one in start)
    assert outward == pytest.approx(sum(one.area for one in end), rel=1e-12)


@pytest.mark.parametrize("element", ["Q1", "Q2"])
def test_stones_are_meshed_with_hexahedra_along_their_axes(element: str) -> None:
    made = dome()
    shape = next(shape for shape in made.shapes if shape.name == "dome.r2")
    mesh = mesh_shape(shape, MeshSettings(element=element, divisions=(3, 2, 1)), 3)
    check(mesh, shape.solid)
    assert len(mesh.cells) == 6
    beds = [shape.solid.names.index(name) for name in ("lower", "upper")]
    assert [(mesh.facet_face == face).sum() for face in beds] == [3, 3]
    side = shape.solid.names.index("left")
    assert (mesh.facet_face == side).sum() == 2


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"thickness": 11.0}, r"dome.thickness is 11.0 m, expected less than twice"),
        ({"oculus": 90.0}, r"dome.springing is 90.0 degrees, expected between the oculus"),
        ({"slices": 2}, r"dome.slices is 2, expected at least 3"),
        ({"sides": True}, r"dome.sides is true, expected false for a whole dome"),
        ({"sweep": 90.0, "staggered": True}, r"dome.staggered is true"),
        ({"sweep": 200.0, "sides": True}, r"dome.sweep is 200 degrees, expected below 180"),
    ],
)
def test_what_cannot_be_built(keys: dict, words: str) -> None:
    with pytest.raises(GeometryError, match=words):
        dome(**keys)


def test_a_dome_is_not_plane() -> None:
    spec = DomeStructure(name="dome", material="s", radius=1.0, thickness=0.1, rings=2, slices=6)
    with pytest.raises(GeometryError, match="dimension 2, expected 3"):
        build_structure(spec, 2, Path(), MeshSettings())
