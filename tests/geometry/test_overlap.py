"""Overlap: blocks that penetrate are named, blocks that touch are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from masonry_fem.geometry import assemble, build_structure
from masonry_fem.geometry.overlap import overlapping
from masonry_fem.scene.specs import ArchStructure, BlockStructure, MeshSettings, WallStructure


def together(dimension: int, *specs):
    return assemble([build_structure(spec, dimension, Path(), MeshSettings()) for spec in specs])


@pytest.mark.parametrize("shift", [1e-3, 0.1, 0.4])
@pytest.mark.parametrize("dimension", [2, 3])
def test_depth_of_two_boxes(shift: float, dimension: int) -> None:
    one = BlockStructure(name="a", material="s", size=(1.0,) * dimension)
    two = BlockStructure(
        name="b", material="s", size=(1.0,) * dimension, position=(1.0 - shift,) + (0.0,) * (dimension - 1)
    )
    found = overlapping(together(dimension, one, two))
    assert [(a, b) for a, b, _ in found] == [(0, 1)]
    assert found[0][2] == pytest.approx(shift)


def test_one_block_inside_another() -> None:
    outer = BlockStructure(name="a", material="s", size=(1.0, 1.0, 1.0))
    inner = BlockStructure(name="b", material="s", size=(0.2, 0.2, 0.2), position=(0.4, 0.4, 0.4))
    assert len(overlapping(together(3, outer, inner))) == 1


@pytest.mark.parametrize("dimension", [2, 3])
def test_structures_touch_without_overlap(dimension: int) -> None:
    wall = WallStructure(name="w", material="s", brick=(0.4, 0.2, 0.2)[:dimension], columns=5, courses=6)
    assert overlapping(together(dimension, wall)) == []
    arch = ArchStructure(name="a", material="s", radius=1.0, thickness=0.2, voussoirs=9, depth=0.3)
    assert overlapping(together(dimension, arch)) == []


def test_tilted_block_on_its_edge() -> None:
    ground = BlockStructure(name="g", material="s", size=(4.0, 0.5), position=(-2.0, -0.5), support=True)
    post = BlockStructure(name="p", material="s", size=(0.5, 2.0), rotation=7.0)
    assert overlapping(together(2, ground, post)) == []
