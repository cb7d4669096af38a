"""Compliance: the elastic part of a shape's inverse effective mass, (M̂⁻¹)_el.

    compliance = Compliance.of(operators, modes, free, scheme)
    velocity = compliance.apply(impulse)           # (b, n) -> (b, n)
    surface = compliance.block(dofs)               # dense, e.g. of all dofs that carry contacts

M̂ = c_m M + c_k K, and M̂⁻¹ = Φ Φᵀ/c_m + (M̂⁻¹)_el. The elastic part x of M̂⁻¹ r solves

    M̂ x + M Φ λ = r,    Φᵀ M x = 0

which holds in statics (c_m = 0) too. Small shapes have it from a dense Cholesky factor of
M̂ + σ M Φ Φᵀ M, projected on both sides; large ones from a sparse LDLᵀ of the bordered matrix.
Subtracting Φ Φᵀ/c_m from M̂⁻¹ would lose all digits in long steps, where the two are nearly equal.
"""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from masonry_fem.bodies.base import Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.modes import RigidModes
from masonry_fem.nscd.mumps import Mumps, petsc

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

DENSE_LIMIT = 1500  # dofs; below, a dense factor is as fast and needs no PETSc
AT_ONCE = DENSE_LIMIT**2  # numbers in columns that are solved together; more are slower and fill memory


def coefficients(operators: ShapeOperators, scheme: Scheme) -> tuple[float, float]:
    """c_m and c_k of M̂ = c_m M + c_k K, with Rayleigh damping C = α M + β K.

    Parameters
    ----------
    operators : Matrices of the shape; its material has α [1/s] and β [s].
    scheme : Step h [s], θ, and whether there is inertia.
    """
    material, h, theta = operators.material, scheme.step, scheme.theta
    c_m = scheme.inertia * (1 + h * theta * material.mass_damping)
    c_k = scheme.inertia * h * theta * material.stiffness_damping + (h * theta) ** 2
    return c_m, c_k


class Factor(Protocol):
    """Something that applies (M̂⁻¹)_el on the free dofs."""

    def __init__(
        self, effective: sparse.csr_array, modes: FloatArray, momentum: FloatArray, sigma: float
    ) -> None: ...

    def solve(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r of columns (n_free, k)."""
        ...


class DenseFactor:
    """Cholesky factor of M̂ + σ M Φ Φᵀ M, with the projection Π = I − Φ Φᵀ M on both sides."""

    def __init__(self, effective: sparse.csr_array, modes: FloatArray, momentum: FloatArray, sigma: float):
        self._modes, self._momentum = modes, momentum
        matrix = effective.toarray() + sigma * (momentum @ momentum.T)
        self._factor = linalg.cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)

    def solve(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r of columns (n_free, k)."""
        deflated = impulses - self._momentum @ (self._modes.T @ impulses)
        answer: FloatArray = linalg.cho_solve(self._factor, deflated, check_finite=False)
        answer -= self._modes @ (self._momentum.T @ answer)
        return answer


class SparseFactor:
    """LDLᵀ of the bordered matrix by MUMPS, or SciPy's LU where PETSc has no MUMPS."""

    def __init__(self, effective: sparse.csr_array, modes: FloatArray, momentum: FloatArray, sigma: float):
        self._modes, self._momentum = modes, momentum
        self._size = effective.shape[0]
        matrix = bordered(effective, momentum)
        self._backend = _SuperLU(matrix) if petsc() is None else _Mumps(matrix)

    def solve(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r of columns (n_free, k)."""
        deflated = impulses - self._momentum @ (self._modes.T @ impulses)
        padding = np.zeros((self._modes.shape[1], deflated.shape[1]))
        answer = self._backend.solve(np.concatenate([deflated, padding]))[: self._size]
        projected: FloatArray = answer - self._modes @ (self._momentum.T @ answer)
        return projected


def bordered(effective: sparse.csr_array, momentum: FloatArray) -> sparse.csr_array:
    """M̂ with the border M Φ, whose solutions are M-orthogonal to the rigid modes.

    Parameters
    ----------
    effective : M̂ on the free dofs, shape (n, n) [kg]. momentum : M Φ there, shape (n, m).
    """
    if not momentum.shape[1]:
        return effective
    # the border is scaled like M̂, since pivots are chosen by magnitude
    largest = float((momentum**2).sum(axis=0).max())
    scale = float(effective.diagonal().max()) / np.sqrt(largest)
    border = sparse.csr_array(scale * momentum)
    nothing = sparse.csr_array((border.shape[1], border.shape[1]))
    top, bottom = sparse.hstack([effective, border]), sparse.hstack([border.T, nothing])
    return sparse.csr_array(sparse.vstack([top, bottom]))


class _SuperLU:
    def __init__(self, matrix: sparse.csr_array) -> None:
        self._factor = splu(sparse.csc_array(matrix))

    def solve(self, columns: FloatArray) -> FloatArray:
        answer: FloatArray = self._factor.solve(columns)
        return answer


class _Mumps:
    """MUMPS' factor of a symmetric matrix, with one step of refinement."""

    def __init__(self, matrix: sparse.csr_array) -> None:
        self._matrix = sparse.csr_array(matrix + sparse.csr_array(sparse.eye_array(matrix.shape[0]) * 0.0))
        self._matrix.sort_indices()
        self._factor = Mumps(self._matrix, symmetric=True)

    def solve(self, columns: FloatArray) -> FloatArray:
        answer = self._factor.solve(self._matrix, columns)
        return answer + self._factor.solve(self._matrix, columns - self._matrix @ answer)


class Compliance:
    """(M̂⁻¹)_el of one shape with clamped dofs, for one scheme; zero at clamped dofs.

    Parameters
    ----------
    operators : Stiffness and mass of the shape.
    modes : Its rigid modes.
    free : Dofs that are not clamped, shape (n_free,).
    scheme : Coefficients of the step.
    dense : Whether to factorise densely; None: by size.
    """

    kinds: ClassVar[tuple[type[Factor], type[Factor]]] = (DenseFactor, SparseFactor)

    def __init__(
        self,
        operators: ShapeOperators,
        modes: RigidModes,
        free: IntArray,
        scheme: Scheme,
        dense: bool | None = None,
    ) -> None:
        c_m, c_k = coefficients(operators, scheme)
        self._total = operators.mass.shape[0]
        self._free: IntArray | slice = slice(None) if len(free) == self._total else free
        whole = sparse.csr_array(c_m * operators.mass + c_k * operators.stiffness)
        effective = whole if len(free) == self._total else sparse.csr_array(whole[free][:, free])
        sigma = float(whole.diagonal().sum() / operators.mass.diagonal().sum())
        dense = len(free) <= DENSE_LIMIT if dense is None else dense
        kind = self.kinds[0 if dense else 1]
        # momentum on free dofs is M_ff Φ, as Φ vanishes elsewhere
        own = np.ascontiguousarray(modes.modes[self._free, : modes.count])
        momentum = np.ascontiguousarray(modes.momentum[self._free, : modes.count])
        self._factor = kind(effective, own, momentum, sigma)

    def apply(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r for nodal impulses of b blocks, shape (b, n) [N s] to (b, n) [m/s]."""
        answer = np.zeros_like(impulses)
        answer[:, self._free] = self._factor.solve(impulses[:, self._free].T).T
        return answer

    def block(self, dofs: IntArray) -> FloatArray:
        """Dense symmetric block of (M̂⁻¹)_el on some dofs, by solves with many columns."""
        part = self.columns(dofs)
        return 0.5 * (part + part.T)

    def columns(self, dofs: IntArray) -> FloatArray:
        """The same as the solves give it."""
        part: FloatArray = np.empty((len(dofs), len(dofs)))
        width = max(1, AT_ONCE // self._total)
        for first in range(0, len(dofs), width):
            columns = slice(first, first + width)
            own = dofs[columns]
            unit = np.zeros((self._total, len(own)))
            unit[own, np.arange(len(own))] = 1.0
            answer = np.zeros_like(unit)
            answer[self._free] = self._factor.solve(unit[self._free])
            part[:, columns] = answer[dofs]
        return part
