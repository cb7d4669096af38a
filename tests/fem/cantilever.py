"""Cantilever with a known stress: Airy's polynomial for a force at the end, parabolic shear, ν = 0 in 3D.

σ_xx = −P (L − x) y / I,  σ_xy = P (c² − y²) / 2I on x in (0, L), y in (−c, c).

In 2D (plane stress) the exact displacement holds the end x = 0; in 3D, where this is exact for ν = 0, the
exact tractions act on both ends and rigid motions are held. The other end has its exact traction.
"""

import numpy as np
from scipy.sparse import linalg

from masonry_fem.fem.assemble import assemble_shapes
from masonry_fem.fem.error_estimate import energy_density
from masonry_fem.fem.lagrange import fine_quadrature, lagrange
from masonry_fem.fem.material import ElasticMaterial
from tests.fem.meshes import box_mesh, dimension_of

LENGTH, HALF, FORCE = 4.0, 0.5, 1e5
SECOND = 2 * HALF**3 / 3
LOW_Z, HIGH_Z = -0.25, 0.25


def exact_stress(points):
    """Stress (..., 6) at points (..., d); the beam bends towards the last axis."""
    x, y = points[..., 0], points[..., -1]
    stress = np.zeros((*points.shape[:-1], 6))
    stress[..., 0] = -FORCE * (LENGTH - x) * y / SECOND
    stress[..., 3 if points.shape[-1] == 2 else 5] = FORCE / (2 * SECOND) * (HALF**2 - y**2)
    return stress


def _exact_displacement(points, material):
    """Plane stress, from the strains of ``exact_stress``."""
    E, nu, P, I, L = material.young, material.poisson, FORCE, SECOND, LENGTH  # noqa: E741
    G, (x, y) = E / (2 * (1 + nu)), points.T
    along = -P / (E * I) * (L * x - x**2 / 2) * y + P * y**3 / (6 * I) * (nu / E - 1 / G)
    across = nu * P * (L - x) * y**2 / (2 * E * I) + P * HALF**2 * x / (2 * G * I)
    return np.stack([along, across + P / (E * I) * (L * x**2 / 2 - x**3 / 6)], axis=1)


def solved(cell, n, distort=0.0):
    """Mesh, material and nodal displacements (dofs,) with ``n`` cells over the depth."""
    d = dimension_of(cell)
    counts = (4 * n, n) if d == 2 else (4 * n, n // 2, n)
    low = (0, -HALF) if d == 2 else (0, LOW_Z, -HALF)
    high = (LENGTH, HALF) if d == 2 else (LENGTH, HIGH_Z, HALF)
    mesh = box_mesh(cell, counts, low, high, distort)
    material = ElasticMaterial(10e9, 0.2 if d == 2 else 0.0, 2400.0)
    (operators,) = assemble_shapes([mesh], [material], "stress" if d == 2 else None)
    force, moved = _traction(mesh, 1, 1.0), np.zeros(mesh.points.shape)
    if d == 2:
        left = np.flatnonzero(np.isclose(mesh.points[:, 0], 0))
        moved[left] = _exact_displacement(mesh.points[left], material)
        held = (left[:, None] * 2 + np.arange(2)).ravel()
    else:
        force += _traction(mesh, 0, -1.0)
        held = _tripod(mesh)
    moved, free = moved.ravel(), np.setdiff1d(np.arange(moved.size), held)
    K = operators.stiffness
    moved[free] = linalg.spsolve(K[free][:, free].tocsc(), (force.ravel() - K @ moved)[free])
    return mesh, material, moved


def _traction(mesh, face, sign):
    """Nodal forces (nodes, d) of the exact traction on an end."""
    facets, element = mesh.facets[mesh.facet_face == face], lagrange(mesh.facet)
    points, weights = fine_quadrature(mesh.facet)
    tangents = np.einsum("fkd,pkt->fpdt", mesh.points[facets], element.gradients(points))
    area = np.sqrt(np.linalg.det(np.einsum("fpdt,fpds->fpts", tangents, tangents))) * weights
    stress = exact_stress(np.einsum("pk,fkd->fpd", element.values(points), mesh.points[facets]))
    d = mesh.dimension
    traction = np.zeros((*area.shape, d))
    traction[..., 0], traction[..., -1] = sign * stress[..., 0], sign * stress[..., 3 if d == 2 else 5]
    force = np.zeros(mesh.points.shape)
    np.add.at(force, facets, np.einsum("fp,pk,fpd->fkd", area, element.values(points), traction))
    return force


def _tripod(mesh):
    """Six dofs that hold rigid motions only."""

    def node(*place):
        return int(np.linalg.norm(mesh.points - np.array(place), axis=1).argmin())

    a, b, c = node(0, LOW_Z, -HALF), node(0, HIGH_Z, -HALF), node(LENGTH, LOW_Z, -HALF)
    return np.array([3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + 2, 3 * c + 2])


def true_square(mesh, material, moved):
    """∫ (σ − σ_h) : C⁻¹ : (σ − σ_h) with the exact stress [J]."""
    points, weights = fine_quadrature(mesh.cell)
    element, d = lagrange(mesh.cell), mesh.dimension
    reference = element.gradients(points)
    jacobian = np.einsum("mkd,pkt->mpdt", mesh.points[mesh.cells], reference)
    gradient = np.einsum("pkt,mptd->mpkd", reference, np.linalg.inv(jacobian))
    D = material.stress_matrix(d, "stress" if d == 2 else None)
    stress = np.einsum("sij,mpkj,mki->mps", D, gradient, moved.reshape(-1, d)[mesh.cells])
    places = np.einsum("pk,mkd->mpd", element.values(points), mesh.points[mesh.cells])
    missing = energy_density(exact_stress(places) - stress, material)
    return float((missing * np.linalg.det(jacobian) * weights).sum())
