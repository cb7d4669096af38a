"""Depth and crosses: what is behind is paler, points of crosses keep apart."""

import numpy as np
import pytest

from masonry_fem.output import principal_picture
from masonry_fem.output.backdrop import BANDS, by_depth, faded
from masonry_fem.output.principal_picture import thinned
from masonry_fem.output.render import View, can_render
from masonry_fem.output.scenery import Scenery


def shells(rows=30):
    """Two parallel walls across the line of sight, 10 m wide and 10 m apart."""
    x, z = (values.ravel() for values in np.meshgrid(np.linspace(0, 10, rows), np.linspace(0, 10, rows)))
    return np.concatenate([np.column_stack([x, np.full_like(x, y), z]) for y in (0.0, 10.0)])


def test_what_is_behind_something_else_is_paler():
    points = shells()
    view = View.along(points, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    strength = np.full(len(points), np.nan)
    for own, share in by_depth(view, points):
        strength[own] = share
    half = len(points) // 2
    assert (strength[:half] == 1).all(), "the wall in front"
    assert (strength[half:] == BANDS[-1][1]).all(), "the one behind it"
    assert by_depth(view, points)[0][1] < 1, "the farthest comes first"


def test_a_long_wall_that_leads_away_is_not():
    """Its far end is far, but behind nothing."""
    points = shells()[:900]
    view = View.along(points, np.array([-0.6, -0.8, 0.0]), np.array([0.0, 0.0, 1.0]))
    ((own, share),) = by_depth(view, points)
    assert share == 1
    assert len(own) == len(points)


def test_few_arrows_and_plane_structures_are_as_they_were():
    points = shells(5)
    view = View.along(points, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    assert [share for _, share in by_depth(view, points)] == [1.0]
    flat = np.random.default_rng(0).normal(size=(500, 3))
    assert [share for _, share in by_depth(View.of(flat, 2), flat)] == [1.0]
    assert (faded("#1f5fa8", 1.0), faded("#1f5fa8", 0.0), faded("#000000", 0.5)) == (
        "#1f5fa8",
        "#ffffff",
        "#808080",
    )


@pytest.mark.parametrize("most", [40, 10_000])
def test_points_of_crosses_keep_apart_and_are_not_too_many(most):
    points = np.random.default_rng(1).uniform(size=(5000, 3))
    rows, apart = thinned(points, 0.2, most)
    assert 0 < len(rows) <= most
    assert apart == 0.2 if most > 1000 else apart > 0.2
    cubes = np.floor((points[rows] - points.min(axis=0)) / apart)
    assert len(np.unique(cubes, axis=0)) == len(rows)


@pytest.mark.skipif(not can_render(), reason="neither EGL nor OSMesa here")
@pytest.mark.parametrize("dimension", [3], indirect=True)
def test_many_stones_have_a_cross_each_and_few_several(elastic, tmp_path, monkeypatch):
    scenery = Scenery.of(*elastic, title="Wall")
    known = np.isfinite(np.asarray(scenery.blocks.cell_data["stress"])[:, 0])
    stones = len(np.unique(np.asarray(scenery.blocks.cell_data["block"])[known]))
    centres, stress, words, _ = principal_picture._crosses(scenery.blocks, scenery.length)
    assert stones < len(centres) <= known.sum()
    assert "elements" in words
    everything = np.asarray(scenery.blocks.cell_data["stress"])[known]
    assert (np.abs(stress[:, None] - everything[None]).max(axis=2).min(axis=1) == 0).all(), (
        "as they are computed"
    )
    monkeypatch.setattr(principal_picture, "FEW", 1)
    centres, _, words, _ = principal_picture._crosses(scenery.blocks, scenery.length)
    assert len(centres) == stones
    assert "Mean" in words
