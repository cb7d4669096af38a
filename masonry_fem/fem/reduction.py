"""Reduction: a few polynomial modes of deformation in place of all displacements of a mesh.

    basis = Basis.of(operators, modes, degree=2)     # once for a shape and material
    compliance = ReducedCompliance(basis, scheme)    # (M̂⁻¹)_el on the modes alone

A block's elastic part is u_el = Ψ η. Ψ spans what polynomials up to a degree have at the nodes, without the
rigid motions, and diagonalises both matrices, Ψᵀ M Ψ = 1 and Ψᵀ K Ψ = Ω², so that

    (M̂⁻¹)_el = Ψ (c_m + c_k Ω²)⁻¹ Ψᵀ

needs no factor, whatever the step. Degree 1 are the uniform strains: with them among the modes the mean
stress of a block is what the forces on it balance.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Self

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray, Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.condense import coefficients
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
