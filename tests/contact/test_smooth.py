"""Round faces: which facets are parts of one, and how they bend."""

import numpy as np
import pytest

from masonry_fem.contact.smooth import curvatures, smooth_faces
from masonry_fem.contact.surface import Surface
from masonry_fem.solid.polytope import Polytope
from tests.contact.blocks import box_shape, ring_shape


def polygon(count):
    angle = 2 * np.pi * np.arange(count) / count
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Polytope(corners, tuple((k, (k + 1) % count) for k in range(count)))


def parts(solid):
    normals = np.array([solid.normal(face) for face in range(len(solid.faces))])
    return len(np.unique(smooth_faces(solid, normals)))


@pytest.mark.parametrize(("corners", "expected"), [(6, 6), (12, 12), (24, 1), (100, 1)])
def test_a_polygon_of_many_sides_is_round(corners, expected):
    assert parts(polygon(corners)) == expected


@pytest.mark.parametrize("d", [2, 3])
def test_a_box_has_its_faces(d):
    assert parts(box_shape("box", (1.0,) * d).solid) == 2 * d


@pytest.mark.parametrize("cells", [(12, 2), (12, 3, 2)])
def test_a_ring_has_as_many_faces_as_a_box(cells):
    assert parts(ring_shape("ring", (0.8, 1.0), cells).solid) == 2 * len(cells)


@pytest.mark.parametrize(("d", "triangles", "within"), [(2, False, 0.01), (3, False, 0.01), (3, True, 0.2)])
def test_curvature_of_a_ring(d, triangles, within):
    """1/R along the arc, none across it, inside with the other sign; triangles tell it less well."""
    shape = ring_shape("ring", (0.8, 1.0), (40, 3, 2) if d == 3 else (40, 2), triangles=triangles)
    surface = Surface.of(shape)
    label = np.array([int(name[-1]) for name in shape.solid.names])[shape.mesh.facet_face]
    for face, radius in ((2 * d - 2, -0.8), (2 * d - 1, 1.0)):
        facets = np.flatnonzero(label == face)
        found = np.linalg.eigvalsh(curvatures(shape.mesh, facets, surface.smooth))
        largest = np.take_along_axis(found, np.abs(found).argmax(axis=1)[:, None], axis=1)[:, 0]
        assert largest == pytest.approx(1 / radius, rel=within)
        assert np.abs(found.sum(axis=1) - largest).max() < within
    assert not curvatures(shape.mesh, np.flatnonzero(label == 0), surface.smooth).any()
