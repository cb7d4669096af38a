"""How deep blocks are in each other: rigid ones, deformed ones, whatever way they are turned."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.contact.depth import overlaps
from masonry_fem.contact.skin import Layout, Skin
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.mesh import Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.contact.blocks import grid_mesh, turning, turning_2d


def skin_of(
    *solids: tuple[Polytope, Mesh | None], supports: tuple[int, ...] = ()
) -> tuple[Skin, list[np.ndarray]]:
    """The skin of blocks in place, each of its own shape, and their nodes."""
    d = solids[0][0].dimension
    shapes = tuple(Shape(f"s{k}", solid, mesh) for k, (solid, mesh) in enumerate(solids))
    blocks = tuple(
        Block(f"b{k}", k, Pose(np.eye(d), np.zeros(d)), support=k in supports) for k in range(len(shapes))
    )
    nodes = [solid.vertices if mesh is None else mesh.points for solid, mesh in solids]
    starts = np.concatenate([[0], np.cumsum([len(own) for own in nodes])])
    layouts = [
        Layout(k, mesh is not None, np.array([k]), starts[k : k + 1]) for k, (_, mesh) in enumerate(solids)
    ]
    return Skin.of(Assembly(d, shapes, blocks), layouts), nodes


def box(low: tuple[float, ...], high: tuple[float, ...]) -> Polytope:
    return Polytope.box(low, high)


@pytest.mark.parametrize("depth", [-0.02, 0.0, 1e-5, 0.03])
@pytest.mark.parametrize("dimension", [2, 3])
def test_boxes_on_each_other_wherever_they_are(dimension: int, depth: float) -> None:
    side = (1.0,) * (dimension - 1)
    skin, nodes = skin_of(
        (box((0.0,) * dimension, (*side, 0.5)), None), (box((0.3,) * dimension, (*side, 0.9)), None)
    )
    up = np.zeros(dimension)
    up[-1] = 0.2 - depth
    turn = turning_2d(0.7) if dimension == 2 else turning(0.7)
    points = np.concatenate([nodes[0], nodes[1] + up]) @ turn.T + 3.0
    found = overlaps(skin, points)
    assert found.pairs.tolist() == ([[0, 1]] if depth > 0 else [])
    np.testing.assert_allclose(found.depth, [depth] if depth > 0 else [], rtol=1e-9)


@pytest.mark.parametrize("depth", [-0.01, 0.01])
def test_bars_that_cross_edge_on_edge(depth: float) -> None:
    """No face parts them; the edges do: each bar rests on its edge, half of its diagonal high."""
    bar = box((-2.0, -0.5, -0.5), (2.0, 0.5, 0.5))
    skin, (lower, upper) = skin_of((bar, None), (bar, None))
    edgewise = turning(np.pi / 4, (1.0, 0.0, 0.0))
    across = turning(np.pi / 2, (0.0, 0.0, 1.0))
    lift = np.array([0.0, 0.0, np.sqrt(2.0) - depth])
    found = overlaps(skin, np.concatenate([lower @ edgewise.T, upper @ edgewise.T @ across.T + lift]))
    np.testing.assert_allclose(found.depth, [depth] if depth > 0 else [], rtol=1e-9)


def test_supports_may_overlap_and_blocks_far_apart_cost_nothing() -> None:
    boxes = [(box((x, 0.0), (x + 1.0, 1.0)), None) for x in (0.0, 0.5, 3.0)]
    skin, nodes = skin_of(*boxes, supports=(0, 1))
    assert len(overlaps(skin, np.concatenate(nodes)).depth) == 0
    skin, nodes = skin_of(*boxes, supports=(0,))
    np.testing.assert_allclose(overlaps(skin, np.concatenate(nodes)).depth, [0.5])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_bent_beam_touches_only_where_it_is(dimension: int, order: int) -> None:
    """Bent up its hull fills the hollow below it, where a block stands; bent down it is in that block."""
    deep = (0.2,) * (dimension - 2)
    zero = (0.0,) * (dimension - 2)
    cells = (8, *(1,) * (dimension - 2), 1)
    mesh = grid_mesh((0.0, *zero, 0.0), (2.0, *deep, 0.2), cells, order=order)
    beam = box((0.0, *zero, 0.0), (2.0, *deep, 0.2))
    block = box((0.75, *zero, -0.5), (1.25, *deep, 0.0))
    skin, nodes = skin_of((beam, mesh), (block, None))
    for rise in (0.05, -0.05):
        bent = nodes[0].copy()
        bent[:, -1] += rise * (1.0 - (bent[:, 0] - 1.0) ** 2)
        found = overlaps(skin, np.concatenate([bent, nodes[1] + 0.0]))
        np.testing.assert_allclose(found.depth, [0.05] if rise < 0 else [], rtol=1e-6)


def test_the_deepest_of_two_meshes_is_at_the_facets_that_meet() -> None:
    """A tip that has sagged by 0.03 onto another meshed block 0.01 below it."""
    arm, rest = box((0.0, 0.0), (2.0, 0.2)), box((1.5, -0.51), (2.0, -0.01))
    skin, nodes = skin_of(
        (arm, grid_mesh((0.0, 0.0), (2.0, 0.2), (10, 2))),
        (rest, grid_mesh((1.5, -0.51), (2.0, -0.01), (3, 3))),
    )
    sagged = nodes[0].copy()
    sagged[:, 1] -= 0.03 * (sagged[:, 0] / 2.0) ** 2
    found = overlaps(skin, np.concatenate([sagged, nodes[1]]))
    # along the mean normal of two faces at an angle of 0.03
    np.testing.assert_allclose(found.depth, [0.02], rtol=2e-3)
