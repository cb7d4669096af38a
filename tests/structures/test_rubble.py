"""Rubble: stones that fill a box, without slivers, the same for the same seed."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import SceneError
from masonry_fem.scene import check
from masonry_fem.scene.specs import Equilibrium, Joint, Material, MeshSettings, Scene, Statics
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.polytope import Polytope
from masonry_fem.structures import build_structure
from masonry_fem.structures.parts.healing import _around, _slopes, edge_lengths, healed
from masonry_fem.structures.parts.voronoi import Tiling
from masonry_fem.structures.rubble import RubbleStructure
from tests.validation.scenes import G, solved

SIZE = (1.5, 0.6, 1.0)


def rubble(dimension: int, **keys) -> RubbleStructure:
    size = SIZE if dimension == 3 else (SIZE[0], SIZE[2])
    return RubbleStructure(**({"name": "r", "material": "stone", "size": size, "stones": 20} | keys))


def built(spec: RubbleStructure) -> Assembly:
    return build_structure(spec, len(spec.size), Path(), MeshSettings())


def stones(made: Assembly) -> list[Polytope]:
    return [made.solid(number) for number, block in enumerate(made.blocks) if not block.support]


def edges(solid: Polytope) -> np.ndarray:
    pairs = {
        tuple(sorted(pair)) for loop in solid.faces for pair in zip(loop, (*loop[1:], loop[0]), strict=True)
    }
    ends = solid.vertices[np.array(sorted(pairs))]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


@given(
    dimension=st.sampled_from([2, 3]), count=st.integers(1, 30), seed=st.integers(0, 2**32),
    relaxation=st.integers(0, 3), elongation=st.sampled_from([0.7, 1.0, 2.5]),
)  # fmt: skip
@settings(max_examples=25, deadline=None)
def test_stones_are_convex_and_fill_the_box(dimension, count, seed, relaxation, elongation) -> None:
    spec = rubble(
        dimension, stones=count, seed=seed, relaxation=relaxation, elongation=elongation, shortest=0.02
    )
    made = built(spec)
    solids = stones(made)
    assert len(solids) == count
    volume = sum(solid.mass_properties().volume for solid in solids)
    assert volume == pytest.approx(np.prod(spec.size), rel=1e-12)
    for solid in solids:
        heights = [
            (solid.vertices - solid.face_points(f)[0]) @ solid.normal(f) for f in range(len(solid.faces))
        ]
        assert np.max(heights) < 1e-9
    assert overlapping(made) == []


@pytest.mark.parametrize(("dimension", "count"), [(2, 60), (3, 40)])
def test_joints_cover_all_faces(dimension, count) -> None:
    """Each inner face is one joint of its area; the stones' surface is that of joints (twice) and box."""
    made = built(rubble(dimension, stones=count))
    interfaces = detect(made)
    inner = [
        (solid, face)
        for solid in stones(made)
        for face, label in enumerate(solid.labels)
        if label == "rubble"
    ]
    assert 2 * sum(one.label == "rubble" for one in interfaces) == len(inner)
    area = sum(np.linalg.norm(solid.area_vector(face)) for solid, face in inner)
    assert 2 * sum(one.area for one in interfaces if one.label == "rubble") == pytest.approx(area, rel=1e-9)
    foot = 1.5 * (0.6 if dimension == 3 else 1.0)
    assert sum(one.area for one in interfaces if one.label == "bed") == pytest.approx(foot, rel=1e-9)
    for name, expected in (
        (("left", 0.6), ("right", 0.6), ("top", 0.9)) if dimension == 3 else (("left", 1.0),)
    ):
        found = [s.area_vector(f) for s in stones(made) for f, own in enumerate(s.names) if own == name]
        assert np.linalg.norm(np.sum(found, axis=0)) == pytest.approx(expected, rel=1e-12)


def test_the_seed_makes_the_stones() -> None:
    one, two, other = (built(rubble(3, seed=seed)) for seed in (7, 7, 8))
    for mine, same in zip(stones(one), stones(two), strict=True):
        assert mine.faces == same.faces
        assert np.array_equal(mine.vertices, same.vertices)
    volumes = [[solid.mass_properties().volume for solid in stones(made)] for made in (one, other)]
    assert np.abs(np.subtract(*volumes)).max() > 1e-3


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("dimension", "count", "shortest"), [(2, 100, 0.2), (3, 60, 0.1)])
def test_no_edge_is_shorter_than_asked(dimension, count, shortest, seed) -> None:
    least = [
        min(edges(solid).min() for solid in stones(built(spec))) / spec.stone_size
        for spec in (rubble(dimension, stones=count, seed=seed, shortest=given) for given in (0.0, shortest))
    ]
    assert least[0] < 0.05  # the points alone leave slivers
    assert least[1] >= shortest


@pytest.mark.parametrize("dimension", [2, 3])
def test_vertices_follow_their_points(dimension) -> None:
    """The derivatives that healing works with are those by differences, on sides and edges too."""
    size = np.ones(dimension)
    tiling = Tiling.of(np.random.default_rng(3).uniform(size=(12, dimension)), size)
    around = _around(tiling, np.arange(len(tiling.vertices)))
    rng = np.random.default_rng(4)
    step = 1e-7 * rng.normal(size=tiling.points.shape)
    moved = Tiling.of(tiling.points + step, size).vertices
    for vertex, place in enumerate(tiling.vertices):
        near = moved[np.argmin(np.linalg.norm(moved - place, axis=1))]
        direction = rng.normal(size=dimension)
        slopes = _slopes(tiling, vertex, around[vertex], direction)
        expected = sum(slope @ step[cell] for cell, slope in slopes)
        assert (near - place) @ direction == pytest.approx(expected, rel=1e-4, abs=1e-11)  # to second order


def test_healing_leaves_alone_what_is_well() -> None:
    tiling = Tiling.of(np.random.default_rng(3).uniform(size=(30, 2)), np.ones(2))
    assert healed(tiling, float(edge_lengths(tiling).min())) is tiling


def test_what_cannot_be_reached_is_said(caplog) -> None:
    """A stone in a box as thin as that has no edge longer than the box is thick."""
    spec = RubbleStructure(name="r", material="stone", size=(100.0, 0.1), stones=1, shortest=0.2)
    with caplog.at_level(logging.WARNING):
        built(spec)
    assert "structures.r.shortest asks for" in caplog.text


@pytest.mark.parametrize("dimension", [2, 3])
def test_joints_are_cut_out(dimension) -> None:
    """Stones stand a joint apart, half of it cut from each, and keep to the box's sides."""
    spec = rubble(dimension, joint=0.02)
    cut = stones(built(spec))
    gaps = [gap for one in detect(built(spec), reach=0.021) if one.label == "rubble" for gap in one.gap]
    assert gaps == pytest.approx([0.02] * len(gaps), rel=1e-9)
    assert len(gaps) > 40
    corners = np.concatenate([solid.vertices for solid in cut])
    assert np.ptp(corners, axis=0) == pytest.approx(spec.size, rel=1e-12)
    assert [one for one in detect(built(spec)) if one.label == "rubble"] == []
    for solid in cut:
        assert edges(solid).min() > 0.02 * spec.stone_size
        total = sum(solid.area_vector(face) for face in range(len(solid.faces)))
        assert np.abs(total).max() < 1e-12


def test_too_thick_joints_are_refused() -> None:
    scene = Scene(dimension=2, fidelity="rigid", structures=(rubble(2, stones=150, joint=0.03),),
                  materials={"stone": Material(density=2000.0)})  # fmt: skip
    with pytest.raises(
        SceneError, match=r"joint is 0.03, expected at most a quarter of the stones' mean size"
    ):
        check(scene)


@pytest.mark.parametrize("dimension", [2, 3])
def test_rigid_rubble_of_flat_stones_stands(dimension) -> None:
    result = solved(
        dimension=dimension,
        fidelity="rigid",
        structures=(rubble(dimension, stones=40, elongation=2.0),),
        joints=(Joint(friction=0.7),),
        analysis=Equilibrium(strategy="large_step", step=0.01, max_steps=5, tolerance=1e-6),
    )
    assert result.outcome == "equilibrium"
    weight = 2400 * G * 1.5 * (0.6 if dimension == 3 else 1.0)
    assert result.summary.supports["r.ground"].force[-1] == pytest.approx(weight, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("dimension", "count"), [(2, 12), (3, 5)])
def test_elastic_rubble_carries_its_weight(dimension, count) -> None:
    result = solved(
        dimension=dimension,
        fidelity="elastic",
        mesh=MeshSettings(element="P1", size=0.2),
        structures=(rubble(dimension, stones=count, elongation=2.0),),
        joints=(Joint(friction=0.7),),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    weight = 2400 * G * 1.5 * (0.6 if dimension == 3 else 1.0)
    assert result.summary.supports["r.ground"].force[-1] == pytest.approx(weight, rel=1e-6)
