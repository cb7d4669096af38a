"""Overlap: blocks that penetrate are named, blocks that touch are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from masonry_fem.contact.depth import overlapping
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures import assemble, build_structure
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.wall import WallStructure


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


def test_supports_may_penetrate() -> None:
    one, two = (
        BlockStructure(name=name, material="s", size=(1.0, 1.0, 1.0), position=(x, 0.0, 0.0), support=True)
        for name, x in (("a", 0.0), ("b", 0.5))
    )
    assert overlapping(together(3, one, two)) == []


@pytest.mark.parametrize("gap", [-0.02, 0.02])
def test_many_sided_blocks(gap: float) -> None:
    """Two balls of a thousand facets on a diagonal: pairs of edges would fill the memory."""
    rings, around = np.meshgrid(np.linspace(0.05, np.pi - 0.05, 24), np.linspace(0, 2 * np.pi, 48, False))
    points = np.column_stack(
        [
            np.ravel(np.sin(rings) * np.cos(around)),
            np.ravel(np.sin(rings) * np.sin(around)),
            np.ravel(np.cos(rings)),
        ]
    )
    hull = ConvexHull(points)
    turned = np.linalg.det(points[hull.simplices])
    loops = tuple(
        tuple(map(int, s if t > 0 else s[::-1])) for s, t in zip(hull.simplices, turned, strict=True)
    )
    ball = Shape("ball", Polytope(points, loops))
    apart = np.array([1.0, 1.0, 0.0]) / np.sqrt(2) * (2 + gap)
    poses = (Pose.identity(3), Pose(np.eye(3), apart))
    blocks = tuple(Block(name, 0, pose) for name, pose in zip("ab", poses, strict=True))
    found = overlapping(Assembly(3, (ball,), blocks))
    assert bool(found) == (gap < 0)
    assert all(0.25 * -gap < depth <= -gap for _, _, depth in found)
