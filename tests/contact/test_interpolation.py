"""Facet shape functions: nodal values, partition of unity, linear and quadratic fields, inverse map."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.contact.interpolation import CORNERS_OF, KINDS, weights, weights_at
from tests.contact.blocks import grid_mesh, turning

REFERENCE = {
    "line": [[-1, 0], [1, 0]],
    "line3": [[-1, 0], [1, 0], [0, 0]],
    "triangle": [[0, 0], [1, 0], [0, 1]],
    "triangle6": [[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]],
    "quad": [[-1, -1], [1, -1], [1, 1], [-1, 1]],
    "quad9": [[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0], [0, 0]],
}
QUADRATIC = ("line3", "triangle6", "quad9")


def placed(kind):
    """A facet of each kind turned in space (in the plane for lines), straight sides, distorted quads."""
    nodes = np.array(REFERENCE[kind], dtype=float)
    if kind.startswith("quad"):
        nodes = nodes + 0.2 * np.outer(nodes[:, 0] * nodes[:, 1], [1.0, 0.5])
    if kind.startswith("line"):
        return nodes @ np.array([[0.6, 0.8], [0, 0]]) + (2.0, -1.0)
    return np.concatenate([nodes, np.zeros((len(nodes), 1))], axis=1) @ turning(0.9).T * 0.3 + (
        5.0,
        1.0,
        -2.0,
    )


def inside(kind, a, b):
    """A point well inside the facet, by its corners."""
    corners = placed(kind)[: CORNERS_OF[kind]]
    share = {
        2: [1 - a, a],
        3: [1 - a, a * (1 - b), a * b],
        4: [(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b],
    }
    return np.array(share[len(corners)]) @ corners


@pytest.mark.parametrize("kind", KINDS)
def test_each_node_weighs_one_at_itself(kind):
    nodes = placed(kind)
    found = weights_at(KINDS[kind], np.repeat(nodes[None], len(nodes), 0), nodes)
    assert found == pytest.approx(np.eye(len(nodes)), abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@given(a=st.floats(0, 1), b=st.floats(0, 1))
def test_unity_and_linear_fields(kind, a, b):
    point = inside(kind, a, b)
    nodes = placed(kind)
    (found,) = weights_at(KINDS[kind], nodes[None], point[None])
    assert found.sum() == pytest.approx(1, abs=1e-13)
    assert found @ nodes == pytest.approx(point, abs=1e-12)


@pytest.mark.parametrize("kind", ["line3", "triangle6"])
@given(a=st.floats(0, 1), b=st.floats(0, 1))
def test_quadratic_fields(kind, a, b):
    point, nodes = inside(kind, a, b), placed(kind)
    (found,) = weights_at(KINDS[kind], nodes[None], point[None])
    direction = np.array([0.7, -0.4, 0.2])[: nodes.shape[1]]
    assert found @ (nodes @ direction) ** 2 == pytest.approx((point @ direction) ** 2, rel=1e-11)


@pytest.mark.parametrize("kind", ["quad", "triangle", "quad9"])
def test_a_point_off_the_facet_is_projected(kind):
    nodes = placed(kind)
    normal = np.cross(nodes[1] - nodes[0], nodes[2] - nodes[0])
    normal /= np.linalg.norm(normal)
    on = inside(kind, 0.3, 0.6)
    (there,) = weights_at(KINDS[kind], nodes[None], on[None])
    (above,) = weights_at(KINDS[kind], nodes[None], (on + 0.05 * normal)[None])
    assert above == pytest.approx(there, abs=1e-9)


@pytest.mark.parametrize(("cells", "order"), [((3, 2), 1), ((3, 2), 2), ((2, 3, 2), 1), ((2, 1, 2), 2)])
def test_weights_on_a_mesh_reproduce_positions(cells, order):
    d = len(cells)
    mesh = grid_mesh((0.0,) * d, (1.0,) * d, cells, order=order)
    facets = np.arange(len(mesh.facets))
    points = mesh.points[mesh.facets].mean(axis=1) + 0.01
    points[np.arange(len(facets)), mesh.facet_face // 2] = mesh.facet_face % 2
    found = weights(mesh, facets, points)
    assert found.shape == mesh.facets.shape
    assert np.einsum("kn,knd->kd", found, mesh.points[mesh.facets]) == pytest.approx(points)
