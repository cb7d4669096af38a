"""Meshes: volumes, orientation, node order, nodes on arcs, faces recovered."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.fem.lagrange import lagrange, quadrature
from masonry_fem.meshing.cells import corner_count
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.mesh import FACET_OF, NODES_OF, Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.arch import build as build_arch

ELEMENTS = ("Q1", "P1", "Q2", "P2")


def volumes(mesh: Mesh) -> np.ndarray:
    """Volume of each cell by quadrature of its Jacobian, which must be positive everywhere."""
    points, weights = quadrature(mesh.cell)
    gradients = lagrange(mesh.cell).gradients(points)
    jacobian = np.linalg.det(np.einsum("pkt,mkd->mpdt", gradients, mesh.points[mesh.cells]))
    assert (jacobian > 0).all()
    return jacobian @ weights


def facet_areas(mesh: Mesh) -> np.ndarray:
    """Outward area vectors of the flat facets through the corners, shape (f, d)."""
    corner = mesh.points[mesh.facets[:, : corner_count(mesh.facet)]]
    if mesh.dimension == 2:
        edge = corner[:, 1] - corner[:, 0]
        return np.column_stack([edge[:, 1], -edge[:, 0]])
    spokes = corner[:, 1:] - corner[:, :1]
    return 0.5 * np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1)


def check(mesh: Mesh, solid: Polytope, exact: bool = True) -> None:
    assert mesh.cells.shape[1] == NODES_OF[mesh.cell]
    assert mesh.facets.shape[1] == NODES_OF[FACET_OF[mesh.cell]]
    assert set(np.unique(mesh.cells)) == set(range(len(mesh.points)))
    areas = facet_areas(mesh)
    assert np.abs(areas.sum(axis=0)).max() < 1e-12
    if exact:
        assert volumes(mesh).sum() == pytest.approx(solid.mass_properties().volume, rel=1e-12)
        for face in range(len(solid.faces)):
            on_face = areas[mesh.facet_face == face].sum(axis=0)
            assert on_face == pytest.approx(solid.area_vector(face), abs=1e-12)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_box(element: str, dimension: int) -> None:
    solid = Polytope.box((0.0,) * dimension, (1.0, 0.5, 0.25)[:dimension])
    mesh = mesh_shape(
        Shape("box", solid), MeshSettings(element=element, divisions=(4, 2, 1)[:dimension]), dimension
    )
    check(mesh, solid)
    assert mesh.order == int(element[1])


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_irregular_six_sided_solid(element: str, dimension: int) -> None:
    solid = Polytope.box((0.0,) * dimension, (1.0,) * dimension)
    vertices = solid.vertices.copy()
    top = vertices[:, -1] > 0.5
    vertices[top, 0] = 0.2 + 0.5 * vertices[top, 0]
    frustum = Polytope(vertices, solid.faces, solid.names, solid.labels)
    mesh = mesh_shape(
        Shape("f", frustum), MeshSettings(element=element, divisions=(3, 2, 2)[:dimension]), dimension
    )
    check(mesh, frustum)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_sector_has_its_nodes_on_the_arcs(element: str, dimension: int) -> None:
    spec = ArchStructure(name="a", material="s", radius=1.0, thickness=0.2, voussoirs=5, depth=0.3)
    shape = build_arch(spec, dimension).shapes[0]
    mesh = mesh_shape(
        shape, MeshSettings(element=element, divisions=(4, 2, 3)[:: 3 - dimension + 1][:dimension]), dimension
    )
    check(mesh, shape.solid, exact=False)
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, -1])
    assert radius.min() == pytest.approx(0.9, rel=1e-14)
    assert radius.max() == pytest.approx(1.1, rel=1e-14)
    names = np.array(shape.solid.names)[mesh.facet_face]
    nodes = np.unique(mesh.facets[names == "extrados"])
    assert radius[nodes] == pytest.approx(1.1, rel=1e-12)
    volume = shape.solid.mass_properties().volume
    # chords of order 1 lose the square of the element's angle, curved elements its fourth power
    assert volumes(mesh).sum() == pytest.approx(volume, rel=1e-4 if mesh.order == 2 else 6e-3)


def test_size_and_divisions() -> None:
    box = Shape("box", Polytope.box((0.0, 0.0, 0.0), (0.5, 0.25, 0.25)))
    assert len(mesh_shape(box, MeshSettings(size=0.125), 3).cells) == 16
    assert len(mesh_shape(box, MeshSettings(size=0.12), 3).cells) == 5 * 3 * 3
    assert len(mesh_shape(box, MeshSettings(divisions=(1, 2, 3)), 3).cells) == 6


@pytest.mark.parametrize("element", ["P1", "P2", "Q1"])
def test_any_flat_faced_solid_gets_simplices(element: str, caplog: pytest.LogCaptureFixture) -> None:
    pyramid = Polytope(
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, 0.5, 1]]),
        ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    )
    mesh = mesh_shape(Shape("pyramid", pyramid), MeshSettings(element=element, size=0.4), 3)
    check(mesh, pyramid)
    assert ("instead of Q1" in caplog.text) == (element == "Q1")


@pytest.mark.parametrize("element", ["Q1", "Q2"])
@pytest.mark.parametrize("image", [np.diag([0.6, 0.6, 1.0]), np.eye(3) + np.outer([0.1, -0.2, 0], [0, 0, 1])])
def test_frusta_get_hexahedra(element: str, image: np.ndarray) -> None:
    """A base of twelve sides; the top is smaller, or tilted, and sides have two elements each."""
    angle = np.arange(12) * np.pi / 6
    base = np.stack([np.cos(angle), 0.7 * np.sin(angle), 0 * angle], axis=1)
    top = np.array([0.0, 0.0, 0.8]) + base @ image
    sides = tuple((i, (i + 1) % 12, (i + 1) % 12 + 12, i + 12) for i in range(12))
    loops = (*sides, tuple(range(11, -1, -1)), tuple(range(12, 24)))
    frustum = Polytope(np.concatenate([base, top]), loops)
    mesh = mesh_shape(Shape("frustum", frustum), MeshSettings(element=element, divisions=(2, 2, 2)), 3)
    assert mesh.cell == {"Q1": "hexahedron", "Q2": "hexahedron27"}[element]
    assert [int((mesh.facet_face == side).sum()) for side in range(12)] == [4] * 12
    check(mesh, frustum)


def test_pentagon() -> None:
    corners = np.array([[0.0, 0], [2, 0], [2, 1], [1, 2], [0, 1]])
    outline = Polytope(corners, tuple((i, (i + 1) % 5) for i in range(5)))
    check(mesh_shape(Shape("p", outline), MeshSettings(element="P2", size=0.5), 2), outline)


def test_same_mesh_twice() -> None:
    box = Shape("box", Polytope.box((0.0, 0.0, 0.0), (0.5, 0.25, 0.25)))
    one, two = (mesh_shape(box, MeshSettings(size=0.1), 3) for _ in range(2))
    assert np.array_equal(one.points, two.points)
    assert np.array_equal(one.cells, two.cells)
