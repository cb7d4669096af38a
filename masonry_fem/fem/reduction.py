"""Reduction: a few polynomial modes of deformation in place of all displacements of a mesh.

    basis = Basis.of(operators, modes, degree=2)     # once for a shape and material
    compliance = ReducedCompliance(operators, basis, scheme)    # (M̂⁻¹)_el on the modes alone

A block's elastic part is u_el = Ψ η. Ψ spans what polynomials up to a degree have at the nodes, without the
rigid motions, and diagonalises both matrices, Ψᵀ M Ψ = 1 and Ψᵀ K Ψ = Ω², so that

    (M̂⁻¹)_el = Ψ (c_m + c_k Ω²)⁻¹ Ψᵀ

needs no factor, whatever the step. Degree 1 are the uniform strains: with them among the modes the mean
stress of a block is what the forces on it balance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray, Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.condense import coefficients
from masonry_fem.fem.modes import RigidModes
from masonry_fem.fem.monomials import monomials

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
        away = operators.mesh.points - rigid.centroid
        values = monomials(away / np.abs(away).max(axis=0), degree)
        fields = np.kron(values.T, np.eye(away.shape[1]))  # each in each component
        for _ in range(2):
            fields = fields - rigid.modes @ (rigid.momentum.T @ fields)
            gram = fields.T @ (operators.mass @ fields)
            size, directions = np.linalg.eigh(gram)
            kept = size > DEPENDENT * size[-1]
            fields = fields @ (directions[:, kept] / np.sqrt(size[kept]))
        squares, turn = np.linalg.eigh(fields.T @ (operators.stiffness @ fields))
        return cls(np.ascontiguousarray(fields @ turn), squares)


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
