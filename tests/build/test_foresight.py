"""Foresight: sizes told from the keys are those that are built; what is too large is refused at once."""

from __future__ import annotations

import tracemalloc
from pathlib import Path
from typing import Any

import msgspec
import pytest

from masonry_fem.build import build
from masonry_fem.build.foresight import foresee_blocks, foresee_points
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.meshing.mesher import foreseen_cells, mesh_shape
from masonry_fem.scene import loads, specs
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.structures import build_structure, kinds

BRICK = {"brick": (0.5, 0.25, 0.25), "columns": 6, "courses": 5}
# kind, keys, dimension: some whose number of blocks is known exactly, then some with cut bricks
EXACT: list[tuple[str, dict[str, Any], int]] = [
    ("block", {"size": (1.0, 1.0, 1.0)}, 3),
    ("stack", {"size": (1.0, 1.0), "count": 7}, 2),
    ("stack", {"size": (1.0, 1.0, 1.0), "count": 7, "ground": False}, 3),
    ("corbel", {"size": (1.0, 1.0, 1.0), "count": 4, "offset": 0.1}, 3),
    ("arch", {"radius": 5.0, "thickness": 0.5, "voussoirs": 9}, 2),
    ("arch", {"radius": 5.0, "thickness": 0.5, "voussoirs": 9, "springings": False}, 3),
    ("pointed_arch", {"span": 4.0, "radius": 4.0, "thickness": 0.4, "voussoirs": 8}, 2),
    ("flat_arch", {"span": 2.0, "thickness": 0.4, "voussoirs": 7}, 3),
    ("elliptical_arch", {"span": 4.0, "rise": 1.5, "thickness": 0.4, "voussoirs": 11}, 2),
    ("catenary_arch", {"span": 4.0, "rise": 2.0, "thickness": 0.4, "voussoirs": 11}, 3),
    ("barrel_vault", {"radius": 3.0, "thickness": 0.3, "voussoirs": 7, "stones": 4}, 3),
    ("barrel_vault", {"radius": 3.0, "thickness": 0.3, "voussoirs": 8, "stones": 4, "staggered": False}, 3),
    ("portal", {"span": 3.0, "thickness": 0.4, "voussoirs": 9, "pier_width": 0.8, "pier_height": 2.0,
                "courses": 3}, 2),
    ("flying_buttress", {"span": 4.0, "inclination": 40.0, "thickness": 0.5, "voussoirs": 6}, 3),
    ("flying_buttress", {"span": 4.0, "inclination": 40.0, "thickness": 0.5, "voussoirs": 6,
     "foot": False}, 2),
    ("dome", {"radius": 4.0, "thickness": 0.4, "rings": 3, "slices": 8}, 3),
    ("dome", {"radius": 4.0, "thickness": 0.4, "rings": 3, "slices": 4, "sweep": 90.0, "sides": True,
              "oculus": 20.0}, 3),
    ("dome", {"radius": 4.0, "thickness": 0.4, "rings": 2, "slices": 16, "drum_courses": 2,
              "drum_height": 1.0,
              "drum_stones": 8, "piers": 4, "pier_height": 2.0, "pier_slices": 2, "pier_courses": 3}, 3),
    ("dome", {"radius": 4.0, "thickness": 0.4, "rings": 2, "slices": 16, "drum_courses": 2,
              "drum_height": 1.0},
     3),
    ("column", {"drums": 5, "height": 3.0, "diameter": 0.5, "sides": 9, "capital": 0.2}, 3),
    ("column", {"drums": 5, "height": 3.0, "diameter": 0.5, "plinth": 0.2, "ground": False}, 2),
    ("staircase", {"steps": 6, "going": 0.3, "rise": 0.17, "width": 1.2, "lap": 0.02, "bearing": 0.2}, 3),
    ("rubble", {"size": (2.0, 1.0), "stones": 12}, 2),
    ("rubble", {"size": (2.0, 1.0, 1.0), "stones": 12}, 3),
    ("wall", BRICK | {"bond": "stack"}, 3),
    ("wall", {"brick": (0.5, 0.25), "courses": 4, "pattern": ((1.0, 1.0), (0.5, -0.5, 1.0))}, 2),
    ("buttress", {"width": 1.0, "height": 3.0, "courses": 6}, 2),
]  # fmt: skip
ABOUT: list[tuple[str, dict[str, Any], int]] = [
    ("wall", BRICK, 3),
    ("wall", BRICK | {"brick": (0.5, 0.25), "cut": True}, 2),
    ("wall", BRICK | {"bond": "header"}, 3),
    ("wall", BRICK | {"bond": "english", "wythes": 2}, 3),
    ("wall", BRICK | {"bond": "english", "wythes": 5}, 3),
    ("wall", BRICK | {"bond": "flemish", "wythes": 2}, 3),
    ("wall", BRICK | {"header_courses": 2, "wythes": 4, "through": True}, 3),
    ("wall", BRICK | {"openings": (specs.Opening(position=(1.0, 0.25), size=(0.75, 0.5)),)}, 3),
    ("buttress", {"width": 1.0, "height": 3.0, "courses": 6, "stones": 3}, 2),
]


def counted(kind: str, keys: dict[str, Any], dimension: int) -> tuple[float, int]:
    """Blocks foreseen and made."""
    structure = kinds()[kind].record(name="s", material="stone", **keys)
    assert not list(structure.faults(dimension))
    found = structure.foreseen(dimension)
    assert found is not None
    assert all(hasattr(structure, key) for key in found.keys)
    made = build_structure(structure, dimension, Path(), specs.MeshSettings())
    return found.blocks, len(made.blocks)


@pytest.mark.parametrize(("kind", "keys", "dimension"), EXACT)
def test_blocks_are_foreseen(kind: str, keys: dict[str, Any], dimension: int) -> None:
    foreseen, made = counted(kind, keys, dimension)
    assert foreseen == made


@pytest.mark.parametrize(("kind", "keys", "dimension"), ABOUT)
def test_cut_bricks_are_foreseen_roughly(kind: str, keys: dict[str, Any], dimension: int) -> None:
    foreseen, made = counted(kind, keys, dimension)
    assert made / 1.5 <= foreseen <= 1.5 * made


def arch(**keys: Any) -> specs.Scene:
    text = """
        fidelity = "rigid"
        materials.stone.density = 2400
        loads.gravity = [0, 0, -9.81]
        [[structures]]
        kind = "arch"
        name = "a"
        radius = 5.0
        thickness = 0.5
        voussoirs = 5
        material = "stone"
        """
    return loads(text, [f"{key}={value}" for key, value in keys.items()])


def test_too_many_blocks_name_key_value_and_what_to_do() -> None:
    many = arch(**{"structures.a.voussoirs": 1000000})
    with pytest.raises(SceneError, match=r"structures\.a with voussoirs = 1000000 .* 1e\+06 blocks.*--yes"):
        build(many, Path())
    foresee_blocks(msgspec.structs.replace(many, large=True))


@pytest.mark.parametrize("key", ["courses", "wythes", "columns"])
def test_nothing_is_made_of_what_is_refused(key: str) -> None:
    """Neither counting courses nor looking for their openings grows with the number."""
    text = f"""
        fidelity = "rigid"
        materials.stone.density = 2400
        [[structures]]
        kind = "wall"
        name = "w"
        brick = [0.5, 0.25, 0.25]
        columns = {10**15 if key == "columns" else 6}
        courses = {10**15 if key == "courses" else 8}
        wythes = {10**15 if key == "wythes" else 1}
        openings = [{{ position = [1.0, 0.0], size = [0.75, 0.5] }}]
        material = "stone"
        """
    tracemalloc.start()
    with pytest.raises(SceneError, match=rf"{key} = 1000000000000000"):
        build(loads(text), Path())
    assert tracemalloc.get_traced_memory()[1] < 5e6
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mesh.divisions": [10000, 100, 10]}, r"mesh\.divisions = \[10000, 100, 10\].*3e\+07 unknowns"),
        ({"mesh.divisions": [10000, 10000, 10000]}, "1.0e.12 elements"),
        ({"mesh.size": 1e-300}, "inf elements"),
        ({"mesh.size": 0.008}, r"mesh\.size = 0\.008"),
    ],
)
def test_too_many_elements_are_refused_before_they_are_made(changes: dict[str, Any], said: str) -> None:
    scene = arch(fidelity="elastic", **{"materials.stone.young": 1e10}, **changes)
    with pytest.raises(MasonryError, match=said):
        build(scene, Path())


def test_too_many_gauss_points_are_refused() -> None:
    scene = arch(joints='[{placement = "gauss", density = 100000}]')
    with pytest.raises(SceneError, match="density = 100000"):
        build(scene, Path())
    foresee_points(msgspec.structs.replace(scene, large=True), [100000])


@pytest.mark.parametrize("element", ["Q1", "P1"])
@pytest.mark.parametrize("settings", [{"size": 0.1}, {"divisions": (3, 4, 5)}])
def test_elements_are_foreseen(element: str, settings: dict[str, Any]) -> None:
    """Of a box exactly (six tetrahedra in each hexahedron), of a wedge of three sides roughly."""
    wanted = specs.MeshSettings(element=element, **settings)
    box = Shape("box", Polytope.box((0.0,) * 3, (1.0, 0.5, 0.3)))
    count = len(mesh_shape(box, wanted, 3).cells)
    assert foreseen_cells(box, wanted) * (6 if element == "P1" else 1) == count
