"""Stiffness and mass of all kinds of cells: null space, patch tests, closed forms, rates."""

import numpy as np
import pytest

from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.fem.assemble import assemble_shapes
from masonry_fem.fem.lagrange import fine_quadrature, is_simplex, lagrange, order, quadrature
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.modes import rigid_modes
from masonry_fem.fem.stress import StressRecovery
from masonry_fem.fem.traction import face_weights
from masonry_fem.solid.mesh import Mesh
from tests.fem.meshes import CELLS, box_mesh, dimension_of

STONE = ElasticMaterial(30e9, 0.2, 2400.0)
GRADIENT = np.array([[1e-5, 4e-6, -3e-6], [2e-6, -2e-5, 5e-6], [7e-6, 1e-6, 3e-5]])


def planes(cell):
    return ("strain", "stress") if dimension_of(cell) == 2 else (None,)


CASES = [(cell, plane) for cell in CELLS for plane in planes(cell)]


def distorted(cell, counts=(3, 2, 2)):
    d = dimension_of(cell)
    return box_mesh(cell, counts[:d], (0.1, -0.2, 0.3)[:d], (0.9, 0.3, 0.7)[:d], 0.25)


def operators_of(mesh, plane="strain", lumped=False, material=STONE):
    return assemble_shapes([mesh], [material], plane, lumped)[0]


def hooke(gradient, plane, d):
    strain = np.zeros((3, 3))
    strain[:d, :d] = 0.5 * (gradient + gradient.T)[:d, :d]
    E, nu = STONE.young, STONE.poisson
    if plane == "stress":
        strain[2, 2] = -nu / (1 - nu) * (strain[0, 0] + strain[1, 1])
    return E / (1 + nu) * (strain + nu / (1 - 2 * nu) * np.trace(strain) * np.eye(3))


@pytest.mark.parametrize("cell", CELLS)
def test_shape_functions_are_one_at_their_node_and_reproduce_polynomials(cell):
    element = lagrange(cell)
    np.testing.assert_allclose(element.values(element.nodes), np.eye(len(element.nodes)), atol=1e-13)
    points = np.random.default_rng(0).dirichlet(np.ones(4), 5)[:, : element.nodes.shape[1]]
    power = order(cell)
    field = (element.nodes @ np.arange(1, 1 + points.shape[1])) ** power
    np.testing.assert_allclose(
        element.values(points) @ field, (points @ np.arange(1, 1 + points.shape[1])) ** power, rtol=1e-12
    )
    step = 1e-6
    for axis in range(points.shape[1]):
        shift = step * np.eye(points.shape[1])[axis]
        slope = (element.values(points + shift) - element.values(points - shift)) / (2 * step)
        np.testing.assert_allclose(element.gradients(points)[..., axis], slope, atol=1e-8)


@pytest.mark.parametrize("cell", CELLS)
def test_rules_integrate_their_degree(cell):
    d = dimension_of(cell)
    for rule, degree in ((quadrature, 2 * (order(cell) - 1)), (fine_quadrature, 2 * order(cell))):
        points, weights = rule(cell)
        got = weights @ points[:, 0] ** degree
        # ∫ x^k over the unit simplex = k!/(k + d)!
        simplex = 1 / np.prod([degree + i for i in range(1, d + 1)])
        exact = simplex if is_simplex(cell) else 1 / (degree + 1)
        assert got == pytest.approx(exact, rel=1e-13)
    if not is_simplex(cell):
        assert len(quadrature(cell)[0]) == (order(cell) + 1) ** d


@pytest.mark.parametrize(("cell", "plane"), CASES)
def test_null_space_of_stiffness_is_the_rigid_motions(cell, plane):
    mesh = distorted(cell, (2, 1, 1))
    operators = operators_of(mesh, plane)
    stiffness = operators.stiffness.toarray()
    assert (stiffness == stiffness.T).all()
    values = np.linalg.eigvalsh(stiffness)
    m = 3 if mesh.dimension == 2 else 6
    assert np.abs(values[:m]).max() <= 1e-12 * values[-1]
    assert values[m] >= 1e-5 * values[-1]
    modes = rigid_modes(mesh.points, operators.mass, np.arange(mesh.points.size))
    assert modes.count == m
    np.testing.assert_allclose(modes.modes.T @ operators.mass @ modes.modes, np.eye(m), atol=1e-13)
    assert (
        np.abs(stiffness @ modes.modes).max() <= 1e-12 * np.abs(stiffness).max() * np.abs(modes.modes).max()
    )


@pytest.mark.parametrize("lumped", [False, True])
@pytest.mark.parametrize("cell", CELLS)
def test_mass_adds_up(cell, lumped):
    mesh = distorted(cell)
    mass = operators_of(mesh, lumped=lumped).mass
    d = mesh.dimension
    volume = np.prod([0.8, 0.5, 0.4][:d])
    for axis in range(d):
        unit = np.tile(np.eye(d)[axis], len(mesh.points))
        assert unit @ mass @ unit == pytest.approx(2400 * volume, rel=1e-12)
        position = (mesh.points[:, [axis]] * np.eye(d)[axis]).ravel()
        centre = (0.5, 0.05, 0.5)[axis]
        if not lumped or order(cell) == 1:  # scaled diagonals keep the total, not every moment
            assert unit @ mass @ position == pytest.approx(2400 * volume * centre, rel=1e-12)
    assert (mass.diagonal() > 0).all()


@pytest.mark.parametrize(("cell", "plane"), CASES)
def test_patch_of_uniform_strain(cell, plane):
    """Distorted cells hold a uniform stress: boundary tractions balance K q, stresses are exact."""
    mesh = distorted(cell)
    d, q = mesh.dimension, (mesh.points @ GRADIENT.T[: mesh.dimension, : mesh.dimension]).ravel()
    operators, sigma = operators_of(mesh, plane), hooke(GRADIENT, plane, mesh.dimension)
    force = np.zeros_like(mesh.points)
    for face in range(2 * d):
        normal = np.zeros(d)
        normal[face // 2] = 2 * (face % 2) - 1
        force += np.outer(face_weights(mesh, face, "patch"), sigma[:d, :d] @ normal)
    residual = operators.stiffness @ q - force.ravel()
    assert np.abs(residual).max() <= 1e-10 * np.abs(force).max()
    field = StressRecovery.of(mesh, STONE, operators.plane).field(q[None], np.eye(d)[None])
    components = sigma[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    np.testing.assert_allclose(
        field.gauss, np.broadcast_to(components, field.gauss.shape), atol=1e-9 * np.abs(sigma).max()
    )
    np.testing.assert_allclose(
        field.nodal, np.broadcast_to(components, field.nodal.shape), atol=1e-9 * np.abs(sigma).max()
    )
    assert field.weight.sum() == pytest.approx(np.prod([0.8, 0.5, 0.4][:d]), rel=1e-12)


@pytest.mark.parametrize("cell", CELLS)
def test_facets_face_outwards(cell):
    """The boundary's ∮ x·n dA is d times the volume: facets are all there and turned outwards."""
    mesh = distorted(cell)
    d = mesh.dimension
    element, (points, weights) = lagrange(mesh.facet), fine_quadrature(mesh.facet)
    corners = mesh.points[mesh.facets]
    place = np.einsum("pk,fkd->fpd", element.values(points), corners)
    tangent = np.einsum("fkd,pkt->fpdt", corners, element.gradients(points))
    normal = (
        np.stack([tangent[..., 1, 0], -tangent[..., 0, 0]], -1)
        if d == 2
        else np.cross(tangent[..., 0], tangent[..., 1])
    )
    flux = np.einsum("fpd,fpd,p->", place, normal, weights)
    assert flux == pytest.approx(d * np.prod([0.8, 0.5, 0.4][:d]), rel=1e-12)


@pytest.mark.parametrize(("cell", "rate"), [("quad", 2), ("triangle", 2), ("quad9", 4), ("triangle6", 4)])
def test_strain_energy_converges_at_the_order_of_the_elements(cell, rate):
    """Energy of the interpolated field u = (sin x, 0): error of order 2p."""
    energies, sizes = [], (2, 4, 8)
    for n in sizes:
        mesh = box_mesh(cell, (n, n), (0.0, 0.0), (1.0, 1.0))
        q = np.column_stack([np.sin(mesh.points[:, 0]), np.zeros(len(mesh.points))]).ravel()
        energies.append(0.5 * q @ operators_of(mesh).stiffness @ q)
    lam, mu = STONE.lame("strain")
    exact = 0.5 * (lam + 2 * mu) * (0.5 + np.sin(2) / 4)
    errors = np.abs(np.array(energies) - exact)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(rate, abs=0.15)


def test_shapes_assembled_together_are_as_assembled_alone():
    meshes = [box_mesh("hexahedron", (2, 1, 1), (0, 0, 0), (0.5, 0.25, 0.25)),
              box_mesh("tetra", (1, 1, 1), (0, 0, 0), (1, 1, 1)),
              box_mesh("hexahedron", (1, 1, 2), (3, 0, 0), (3.2, 0.25, 0.25))]  # fmt: skip
    materials = [STONE, ElasticMaterial(1e9, 0.3, 1800.0), ElasticMaterial(5e9, 0.0, 2000.0)]
    together = assemble_shapes(meshes, materials, None)
    for mesh, material, operators in zip(meshes, materials, together, strict=True):
        alone = assemble_shapes([mesh], [material], None)[0]
        for own, other in ((operators.stiffness, alone.stiffness), (operators.mass, alone.mass)):
            assert np.abs((own - other).toarray()).max() <= 1e-14 * np.abs(other.data).max()


def test_bad_meshes_are_refused():
    good = box_mesh("hexahedron", (1, 1, 1), (0, 0, 0), (1, 1, 1))
    inverted = Mesh(
        good.points, good.cell, good.cells[:, [4, 5, 6, 7, 0, 1, 2, 3]], good.facets, good.facet_face
    )
    with pytest.raises(GeometryError, match="cell 0 has a Jacobian"):
        operators_of(inverted)
    row = box_mesh("hexahedron", (3, 1, 1), (0, 0, 0), (3, 1, 1))
    cells = row.cells.copy()
    cells[1] = cells[1][[4, 5, 6, 7, 0, 1, 2, 3]]  # one among good ones
    one = Mesh(row.points, row.cell, cells, row.facets, row.facet_face)
    with pytest.raises(GeometryError, match="cell 1 has a Jacobian"):
        operators_of(one)
    idle = Mesh(np.vstack([good.points, [9, 9, 9]]), good.cell, good.cells, good.facets, good.facet_face)
    with pytest.raises(GeometryError, match="node 8 belongs to no cell"):
        operators_of(idle)
    with pytest.raises(GeometryError, match="block 'x': face 7"):
        face_weights(good, 7, "x")


def test_bad_materials_are_refused():
    with pytest.raises(SceneError, match=r"poisson is 0\.5"):
        ElasticMaterial(1e9, 0.5, 2000.0)
    with pytest.raises(SceneError, match=r"young is -1"):
        ElasticMaterial(-1.0, 0.2, 2000.0)
