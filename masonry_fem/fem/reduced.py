"""Reduced stones: a few polynomial modes of deformation in place of all displacements of a mesh.

    basis = Basis.of(operators, modes, degree=2)     # once for a shape and material
    compliance = ReducedCompliance(basis, scheme)    # (M̂⁻¹)_el on the modes alone

A block's elastic part is u_el = Ψ η. Ψ spans what polynomials up to a degree have at the nodes, without the
rigid motions, and diagonalises both matrices, Ψᵀ M Ψ = 1 and Ψᵀ K Ψ = Ω², so that

    (M̂⁻¹)_el = Ψ (c_m + c_k Ω²)⁻¹ Ψᵀ

needs no factor, whatever the step. Degree 1 are the uniform strains: with them among the modes the mean stress
of a block is what the forces on it balance. Blocks of this kind are those of ``elastic`` and ``corotational``
with this compliance: frames, loads, energies and stresses are theirs.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Self, override

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray, Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.condense import coefficients
from masonry_fem.fem.corotational import CorotationalGroup
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.modes import RigidModes

DEPENDENT = 1e-10  # share of the largest: polynomials that a mesh cannot tell from others


@dataclass(frozen=True, slots=True)
class Basis:
    """Modes of deformation of a shape with n displacements.

    Attributes
    ----------
    modes : Ψ, orthonormal with respect to the mass, shape (n, k) [kg^−½].
    squares : Ω², squares of their angular frequencies, ascending, shape (k,) [1/s²].
    """

    modes: FloatArray
    squares: FloatArray

    @classmethod
    def of(cls, operators: ShapeOperators, rigid: RigidModes, degree: int) -> Self:
        """The polynomials up to a degree.

        Parameters
        ----------
        operators : Mesh, stiffness and mass of the shape.
        rigid : Its rigid modes.
        degree : Highest degree, >= 1.
        """
        fields = _polynomials(operators.mesh.points - rigid.centroid, degree)
        for _ in range(2):
            fields = fields - rigid.modes @ (rigid.momentum.T @ fields)
            gram = fields.T @ (operators.mass @ fields)
            size, directions = np.linalg.eigh(gram)
            kept = size > DEPENDENT * size[-1]
            fields = fields @ (directions[:, kept] / np.sqrt(size[kept]))
        squares, turn = np.linalg.eigh(fields.T @ (operators.stiffness @ fields))
        return cls(np.ascontiguousarray(fields @ turn), squares)


def _polynomials(points: FloatArray, degree: int) -> FloatArray:
    """Values of all monomials of degree 1 to ``degree`` in each component, shape (n, fields)."""
    count, d = points.shape
    scaled = points / np.abs(points).max(axis=0)
    fields = []
    for power in range(1, degree + 1):
        for axes in itertools.combinations_with_replacement(range(d), power):
            values = scaled[:, axes].prod(axis=1)
            for axis in range(d):
                field = np.zeros((count, d))
                field[:, axis] = values
                fields.append(field.ravel())
    return np.array(fields).T


class ReducedCompliance:
    """(M̂⁻¹)_el of a block that deforms by modes only.

    Parameters
    ----------
    basis : Its modes.
    operators : Matrices of the shape, for its damping.
    scheme : Coefficients of the step.
    """

    def __init__(self, basis: Basis, operators: ShapeOperators, scheme: Scheme) -> None:
        self.basis = basis
        c_m, c_k = coefficients(operators, scheme)
        self.mass: FloatArray = c_m + c_k * basis.squares

    def apply(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r for nodal impulses of b blocks, shape (b, n) [N s] to (b, n) [m/s]."""
        answer: FloatArray = ((impulses @ self.basis.modes) / self.mass) @ self.basis.modes.T
        return answer

    def block(self, dofs: IntArray) -> FloatArray:
        """Dense symmetric block of (M̂⁻¹)_el on some dofs."""
        half = self.basis.modes[dofs] / np.sqrt(self.mass)
        part: FloatArray = half @ half.T
        return part


class Reduced:
    """What blocks have in common that deform by modes only; it goes before the class of their kinematics."""

    operators: ShapeOperators
    modes: RigidModes
    mass: FloatArray

    @cached_property
    def basis(self) -> Basis:
        """The modes."""
        return Basis.of(self.operators, self.modes, self.operators.material.degree)

    @property
    def unknowns(self) -> int:
        """Modes and rigid velocities that a step solves for, of all blocks."""
        return int(len(self.mass) * (len(self.basis.squares) + self.modes.modes.shape[1]))

    def _factorised(self, scheme: Scheme, surface: IntArray | None) -> ReducedCompliance:
        return ReducedCompliance(self.basis, self.operators, scheme)

    def unbalanced(self, nodal: FloatArray) -> FloatArray:
        """Size of what nodal impulses (b, n) of any origin would change in how blocks deform, (b,) [N s]."""
        size: FloatArray = np.sqrt(self.mass) * np.linalg.norm(nodal @ self.basis.modes, axis=1)
        return size


class ReducedElasticGroup(Reduced, ElasticGroup):
    """Reduced blocks of small kinematics."""

    @override
    def imbalance(
        self, state: ElasticState, at: ElasticState, after: ElasticState, force: FloatArray,
        impulse: FloatArray, nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step, rigid and of the modes, (b,) [N s]."""
        residual = self.balance.residual(state, after, force, scheme)
        rigid = np.sqrt(self.mass) * np.linalg.norm(residual @ self.modes.modes - impulse, axis=1)
        size: FloatArray = np.hypot(rigid, self.unbalanced(residual if nodal is None else residual - nodal))
        return size


class ReducedCorotationalGroup(Reduced, CorotationalGroup):
    """Reduced blocks that turn without bound."""
