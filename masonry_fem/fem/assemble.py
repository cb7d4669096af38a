"""Assembly: stiffness and mass of all distinct shapes, by DOLFINx.

    operators = assemble_shapes([brick_mesh, half_mesh], [stone, stone], plane=None)
    operators[0].stiffness, operators[0].mass       # CSR, dof = node · d + component

All shapes of one kind of cell are disconnected parts of one DOLFINx mesh, so that a hundred
shapes cost one mesh and two forms; the matrices are then cut apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.errors import GeometryError
from masonry_fem.fem import _compat
from masonry_fem.fem.lagrange import basix_name, fine_quadrature, lagrange, order, stiffness_degree
from masonry_fem.fem.material import ElasticMaterial, Plane
from masonry_fem.fem.strains import Strains
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ROWS = 10_000  # of a matrix, that are worked on at a time


@dataclass(frozen=True)
class ShapeOperators:
    """Matrices of one shape in its own frame; dof = node · d + component, Mesh node numbers.

    Attributes
    ----------
    mesh : Elements.
    material : What it is made of.
    plane : ``strain`` or ``stress`` in 2D, None in 3D.
    stiffness : K, shape (n, n) [N/m; per metre of depth in 2D].
    mass : M, consistent or lumped, shape (n, n) [kg].
    """

    mesh: Mesh
    material: ElasticMaterial
    plane: Plane
    stiffness: sparse.csr_array
    mass: sparse.csr_array

    @cached_property
    def row_sums(self) -> FloatArray:
        """R_i = Σ_j |K_ij|, (n,) [N/m]: Σ |K| |q| is R · |q|, and |q|ᵀ |K| |q| is at most Σ R_i q_i²."""
        rows = range(0, self.stiffness.shape[0], ROWS)  # the whole of |K| would take as much memory as K
        sums: FloatArray = np.concatenate([abs(self.stiffness[a : a + ROWS]).sum(axis=1) for a in rows])
        return sums


def assemble_shapes(
    meshes: Sequence[Mesh],
    materials: Sequence[ElasticMaterial],
    plane: Plane,
    lumped: bool = False,
) -> list[ShapeOperators]:
    """Stiffness and mass of each (mesh, material) pair, all assembled together.

    Parameters
    ----------
    meshes, materials : One of each a shape.
    plane : What 2D means; None in 3D.
    lumped : Diagonal mass, by row sums for order 1 and by Hinton-Rock-Zienkiewicz for order 2.

    Raises
    ------
    GeometryError
        If a mesh has a flat or inverted cell, or nodes that no cell has.
    InstallationError
        If there is no usable DOLFINx.
    """
    for index, mesh in enumerate(meshes):
        _check(mesh, index)
    made: dict[int, ShapeOperators] = {}
    for cell in sorted({mesh.cell for mesh in meshes}):
        members = [index for index, mesh in enumerate(meshes) if mesh.cell == cell]
        own = plane if meshes[members[0]].dimension == 2 else None
        pairs = _assemble_kind([meshes[i] for i in members], [materials[i] for i in members], own)
        for index, pair in zip(members, pairs, strict=True):
            made[index] = _operators(meshes[index], materials[index], own, *pair, lumped=lumped)
    return [made[index] for index in range(len(meshes))]


def _operators(
    mesh: Mesh,
    stone: ElasticMaterial,
    plane: Plane,
    isotropic: sparse.csr_array,
    consistent: sparse.csr_array,
    *,
    lumped: bool,
) -> ShapeOperators:
    """Operators of one shape from the stiffness of its E and ν and its consistent mass."""
    mass = lumped_mass(mesh, stone.density) if lumped else consistent
    stiffness = isotropic if stone.orthotropic is None else _by_moduli(mesh, stone.moduli(plane))
    return ShapeOperators(mesh, stone, plane, stiffness, mass)


def _by_moduli(mesh: Mesh, moduli: FloatArray) -> sparse.csr_array:
    """Stiffness of moduli that are no two numbers, (6, 6) [Pa], at the same points as DOLFINx's."""
    strains = Strains.of(mesh)
    everywhere = np.broadcast_to(moduli, (*strains.weight.shape, 6, 6))
    return _cut(strains.stiffness(everywhere), 0, mesh.points.size)


def _check(mesh: Mesh, index: int) -> None:
    unused = np.setdiff1d(np.arange(len(mesh.points)), mesh.cells)
    if unused.size:
        raise GeometryError(
            f"mesh {index} ({mesh.cell}): node {unused[0]} belongs to no cell, expected every node to carry "
            "an element; remove unused nodes from the mesh"
        )
    volumes = cell_jacobians(mesh)[1]
    smallest = volumes.min()
    if smallest <= 1e-12 * np.abs(volumes).max():
        raise GeometryError(
            f"mesh {index} ({mesh.cell}): cell {volumes.min(axis=1).argmin()} has a Jacobian of "
            f"{smallest:.3g} at an integration point, expected > 0; remesh, or order its nodes as VTK does"
        )


def cell_jacobians(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Jacobians (m, p, d, d) at the fine quadrature points and their determinants (m, p)."""
    gradients = lagrange(mesh.cell).gradients(fine_quadrature(mesh.cell)[0])
    jacobians = np.einsum("mkd,pkt->mpdt", mesh.points[mesh.cells], gradients)
    return jacobians, np.linalg.det(jacobians)


def _assemble_kind(
    meshes: list[Mesh], materials: list[ElasticMaterial], plane: Plane
) -> list[tuple[sparse.csr_array, sparse.csr_array]]:
    """(K, M) of shapes that have one kind of cell, on one DOLFINx mesh."""
    cell, d = meshes[0].cell, meshes[0].dimension
    counts = [len(mesh.points) for mesh in meshes]
    first = np.concatenate([[0], np.cumsum(counts)])
    permutation = np.argsort(lagrange(cell).own)
    cells = np.concatenate([mesh.cells + start for mesh, start in zip(meshes, first[:-1], strict=True)])
    element = _compat.lagrange_element(basix_name(cell), order(cell), d)
    domain = _compat.create_mesh(
        np.ascontiguousarray(cells[:, permutation]), np.concatenate([mesh.points for mesh in meshes]), element
    )
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.cells) for mesh in meshes])
    stiffness_form, mass_form, space = _forms(domain, element, owner, materials, plane, cell)
    place = _dof_of_input(domain, space, first[-1], d)
    stiffness, mass = (
        sparse.csr_array(_compat.assemble(form))[place][:, place] for form in (stiffness_form, mass_form)
    )
    mass.eliminate_zeros()  # between components: two thirds of it
    return [
        (_cut(stiffness, start * d, end * d), _cut(mass, start * d, end * d))
        for start, end in pairwise(first)
    ]


def _forms(
    domain: Any,
    element: Any,
    owner: IntArray,
    materials: list[ElasticMaterial],
    plane: Plane,
    cell: str,
) -> tuple[Any, Any, Any]:
    """UFL forms of stiffness and mass, and their space."""
    dolfinx, ufl = _compat.dolfinx, _compat.ufl
    space = dolfinx.fem.functionspace(domain, element)
    constants = dolfinx.fem.functionspace(domain, ("DG", 0))
    shape_of_cell = owner[domain.topology.original_cell_index]

    def by_shape(values: list[float]) -> Any:
        field = dolfinx.fem.Function(constants)
        field.x.array[constants.dofmap.list[: len(shape_of_cell)].ravel()] = np.array(values)[shape_of_cell]
        return field

    lame = [material.lame(plane) for material in materials]
    lam, mu = by_shape([pair[0] for pair in lame]), by_shape([pair[1] for pair in lame])
    density = by_shape([material.density for material in materials])
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    strain, virtual = ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))
    # degrees 2 and 4 give boxes two and three Gauss points per direction; simplices are integrated exactly
    dx = ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": 2 * order(cell)})
    metadata = {"quadrature_degree": stiffness_degree(cell)}
    dx_stiffness = ufl.Measure("dx", domain=domain, metadata=metadata)
    stiffness = (lam * ufl.tr(strain) * ufl.tr(virtual) + 2 * mu * ufl.inner(strain, virtual)) * dx_stiffness
    return stiffness, density * ufl.inner(u, v) * dx, space


def _dof_of_input(domain: Any, space: Any, nodes: int, d: int) -> IntArray:
    """DOLFINx dof of each input dof: both dofmaps list a cell's nodes in one order."""
    dofs = np.asarray(space.dofmap.list, dtype=np.int64).ravel()
    inputs = np.asarray(domain.geometry.input_global_indices, dtype=np.int64)
    node = np.empty(nodes, dtype=np.int64)
    node[inputs[_compat.geometry_dofmap(domain).ravel()]] = dofs
    place: IntArray = (node[:, None] * d + np.arange(d)).ravel()
    return place


def _cut(matrix: sparse.csr_array, start: int, end: int) -> sparse.csr_array:
    """Diagonal block, made exactly symmetric: assembly order leaves differences of rounding size."""
    block = sparse.csr_array(matrix[start:end, start:end])
    block.sort_indices()
    other = sparse.csr_array(block.T)
    other.sort_indices()
    block.data = 0.5 * (block.data + other.data)
    return block


def lumped_mass(mesh: Mesh, density: float) -> sparse.csr_array:
    """Diagonal mass: row sums for order 1; for order 2 the scaled diagonal, which stays positive.

    Parameters
    ----------
    mesh : Elements.
    density : [kg/m³].

    References
    ----------
    Hinton, Rock, Zienkiewicz, A note on mass lumping and related processes in the finite element method,
    Earthquake Engng Struct. Dyn. 4 (1976).
    """
    points, weights = fine_quadrature(mesh.cell)
    values = lagrange(mesh.cell).values(points)
    volumes = cell_jacobians(mesh)[1] * weights
    if mesh.order == 1:
        share = volumes @ values
    else:
        share = volumes @ values**2
        share *= (volumes.sum(axis=1) / share.sum(axis=1))[:, None]
    nodal = np.bincount(mesh.cells.ravel(), weights=density * share.ravel(), minlength=len(mesh.points))
    return sparse.csr_array(sparse.diags_array(np.repeat(nodal, mesh.dimension)))
