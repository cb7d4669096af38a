"""Blocks from a mesh that are not convex: an L with a cube in its hollow, on a floor."""

from __future__ import annotations

from pathlib import Path

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Loads, Material, Scene
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.file import FileStructure

ELL = """SetFactory("Built-in"); h = 0.25;
Point(1) = {0, 0, 0, h}; Point(2) = {1, 0, 0, h}; Point(3) = {1, 0.5, 0, h};
Point(4) = {0.5, 0.5, 0, h}; Point(5) = {0.5, 1, 0, h}; Point(6) = {0, 1, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Curve Loop(1) = {1:6}; Plane Surface(1) = {1};
o[] = Extrude{0, 0, 0.5}{Surface{1};};
Physical Volume("ell") = {o[1]};
"""


@pytest.mark.parametrize("fidelity", [pytest.param("elastic", marks=pytest.mark.slow), "rigid"])
def test_ell_with_a_cube_in_its_hollow(tmp_path: Path, fidelity: str) -> None:
    """Three faces meet the cube's, four triangles of the L's bottom the floor: all the weight goes down."""
    (tmp_path / "ell.geo").write_text(ELL)
    scene = Scene(
        materials={"stone": Material(density=2000.0, young=1e9)},
        fidelity=fidelity,
        structures=(
            FileStructure(name="file", material="stone", path="ell.geo", trusted=True),
            BlockStructure(
                name="floor",
                material="stone",
                size=(3.0, 3.0, 0.5),
                position=(-1.0, -1.0, -0.5),
                support=True,
            ),
            BlockStructure(name="cube", material="stone", size=(0.5, 0.5, 0.5), position=(0.5, 0.5, 0.0)),
        ),
        loads=Loads(gravity=(0.0, 0.0, -10.0)),
    )
    result = solve_scene(scene, tmp_path)
    assert result.outcome == "equilibrium"
    assert result.summary.supports["floor"].force == pytest.approx([0, 0, 1e4], rel=1e-8, abs=1e-4)
    model = result.built.model
    area: dict[frozenset[str], float] = {}
    for interface in model.interfaces:
        names = frozenset(model.assembly.blocks[block].name for block in interface.blocks)
        area[names] = area.get(names, 0.0) + interface.area
    assert area == {
        frozenset({"file.ell", "floor"}): pytest.approx(0.75),
        frozenset({"file.ell", "cube"}): pytest.approx(0.5),
        frozenset({"cube", "floor"}): pytest.approx(0.25),
    }
