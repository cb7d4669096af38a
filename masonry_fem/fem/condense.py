"""Compliance: the elastic part of a shape's inverse effective mass, (M̂⁻¹)_el.

    compliance = Compliance(operators, modes, free, scheme)
    velocity = compliance.apply(impulse)           # (b, n) -> (b, n)
    surface = compliance.block(dofs)               # dense, e.g. of all dofs that carry contacts

M̂ = c_m M + c_k K, and M̂⁻¹ = Φ Φᵀ/c_m + (M̂⁻¹)_el. The elastic part x of M̂⁻¹ r solves

    M̂ x + M Φ λ = r,    Φᵀ M x = 0

which holds in statics (c_m = 0) too. Small shapes have it from a dense Cholesky factor of
M̂ + σ M Φ Φᵀ M, projected on both sides; large ones from a sparse LDLᵀ of the bordered matrix.
Subtracting Φ Φᵀ/c_m from M̂⁻¹ would lose all digits in long steps, where the two are nearly equal.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import ClassVar, Protocol, override

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from masonry_fem.bodies.base import Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.modes import RigidModes
from masonry_fem.host.memory import park, trim
from masonry_fem.nscd.mumps import LARGE, MumpsFactor, petsc

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

DENSE_LIMIT = 1500  # dofs; below, a dense factor is as fast and needs no PETSc
AT_ONCE = DENSE_LIMIT**2  # numbers in columns that are solved together; more are slower and fill memory
FEWEST = 64  # columns that are: each portion reads all of the factor


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


class Factor(ABC):
    """Something that applies (M̂⁻¹)_el on the n free dofs.

    Parameters
    ----------
    effective : M̂, shape (n, n) [kg]; it is overwritten.
    modes : Φ, those that clamps leave, shape (n, m) [kg^−½].
    momentum : M Φ, shape (n, m).
    sigma : Size of M̂ beside M.
    """

    def __init__(
        self,
        effective: sparse.csr_array,
        modes: FloatArray,
        momentum: FloatArray,
        sigma: float,
    ) -> None:
        self.size = len(modes)
        self._modes, self._momentum = modes, momentum
        self._factorise(effective, sigma)

    @abstractmethod
    def _factorise(self, effective: sparse.csr_array, sigma: float) -> None:
        """Make the factor."""

    @abstractmethod
    def solve(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r of columns (n, k)."""

    def block(self, dofs: IntArray) -> FloatArray:
        """Rows and columns of (M̂⁻¹)_el for c dofs, ascending, shape (c, c)."""
        part: FloatArray = np.empty((len(dofs), len(dofs)))
        for columns in portions(len(dofs), self.size):
            part[:, columns] = self.solve(units(dofs[columns], self.size))[dofs]
        return part


def portions(count: int, total: int) -> Iterator[slice]:
    """Columns 0 to ``count`` in portions that fit into ``AT_ONCE`` with ``total`` rows, or of ``FEWEST``."""
    width = max(FEWEST, AT_ONCE // max(total, 1))  # clamps may leave no rows
    return (slice(first, first + width) for first in range(0, count, width))


def units(dofs: IntArray, total: int) -> FloatArray:
    """Unit vectors as columns, shape (total, k).

    Parameters
    ----------
    dofs : Where each has its 1, shape (k,).
    total : Their length.
    """
    columns = np.zeros((total, len(dofs)))
    columns[dofs, np.arange(len(dofs))] = 1.0
    return columns


class DenseFactor(Factor):
    """Cholesky factor of M̂ + σ M Φ Φᵀ M, with the projection Π = I − Φ Φᵀ M on both sides."""

    @override
    def _factorise(self, effective: sparse.csr_array, sigma: float) -> None:
        matrix = effective.toarray() + sigma * (self._momentum @ self._momentum.T)
        self._factor = linalg.cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)

    @override
    def solve(self, impulses: FloatArray) -> FloatArray:
        deflated = impulses - self._momentum @ (self._modes.T @ impulses)
        answer: FloatArray = linalg.cho_solve(self._factor, deflated, check_finite=False)
        answer -= self._modes @ (self._momentum.T @ answer)
        return answer


class SparseFactor(Factor):
    """Sparse factor of M̂ on m springs, A = M̂ + s E Eᵀ, and what the springs change.

    M̂ is singular in statics where a stone is free; a border M Φ would fill the factor, springs at m dofs fill
    nothing. With U = [√s E, M Φ] and D = [1, 0] the solution of the bordered system is exactly

        x = A⁻¹ (r + U w),    (Uᵀ A⁻¹ U − D) w = −Uᵀ A⁻¹ r
    """

    symmetric: ClassVar[bool] = True

    @override
    def _factorise(self, effective: sparse.csr_array, sigma: float) -> None:
        self._springs = independent(self._modes)
        diagonal, count = effective.diagonal(), len(self._springs)
        stiffness = float(diagonal.max())
        self._root = np.sqrt(stiffness)
        diagonal[self._springs] += stiffness
        effective.setdiag(diagonal)
        effective.sort_indices()
        self._factor: MumpsFactor | _SuperLU
        if petsc() is None:
            self._factor = _SuperLU(effective)
        else:
            trim()  # what assembly has left would be a tenth of the peak
            self._factor = MumpsFactor(effective, definite=self.symmetric)
            trim()
        added = np.concatenate([self._root * units(self._springs, self.size), self._momentum], axis=1)
        self._moved = self._factor.answer(added)
        self._missing = self._seen(self._moved)
        self._missing[np.arange(count), np.arange(count)] -= 1.0

    def _seen(self, columns: FloatArray) -> FloatArray:
        """Uᵀ x of columns (n, k), shape (2 m, k)."""
        return np.concatenate([self._root * columns[self._springs], self._momentum.T @ columns])

    @override
    def solve(self, impulses: FloatArray) -> FloatArray:
        deflated = impulses - self._momentum @ (self._modes.T @ impulses)
        answer = self._factor.answer(deflated)
        answer -= self._moved @ np.linalg.solve(self._missing, self._seen(answer))
        answer -= self._modes @ (self._momentum.T @ answer)
        return answer

    @override
    def block(self, dofs: IntArray) -> FloatArray:
        factor = self._factor
        if self.symmetric and isinstance(factor, MumpsFactor):
            part, seen = factor.among(dofs), self._moved[dofs].T
        else:
            part, seen = np.empty((len(dofs), len(dofs))), np.empty((len(self._missing), len(dofs)))
            for columns in portions(len(dofs), self.size):
                answer = factor.columns(dofs[columns])
                part[:, columns], seen[:, columns] = answer[dofs], self._seen(answer)
        seen = np.linalg.solve(self._missing, seen)
        for rows in portions(len(dofs), len(dofs)):  # all at once would be another such matrix
            part[rows] -= self._moved[dofs[rows]] @ seen
        return part


def independent(modes: FloatArray) -> IntArray:
    """As many dofs as there are modes, in which no combination of these vanishes; far apart, shape (m,)."""
    order = linalg.qr(modes.T, mode="r", pivoting=True, check_finite=False)[1]
    return np.sort(order[: modes.shape[1]]).astype(np.int64)


class _SuperLU:
    """SciPy's LU, where PETSc has no MUMPS."""

    def __init__(self, matrix: sparse.csr_array) -> None:
        self._size = matrix.shape[0]
        self._factor = splu(sparse.csc_array(matrix))

    def answer(self, columns: FloatArray) -> FloatArray:
        answer: FloatArray = self._factor.solve(columns)
        return answer

    def columns(self, dofs: IntArray) -> FloatArray:
        return self.answer(units(dofs, self._size))


class Condensed(Protocol):
    """(M̂⁻¹)_el of one shape for one scheme, however it is found."""

    def apply(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r for nodal impulses of b blocks, shape (b, n) [N s] to (b, n) [m/s]."""
        ...

    def block(self, dofs: IntArray) -> FloatArray:
        """Dense symmetric block of it on c dofs, shape (c, c) [1/kg]."""
        ...


class Compliance:
    """(M̂⁻¹)_el of one shape with clamped dofs, for one scheme; zero at clamped dofs.

    Parameters
    ----------
    operators : Stiffness and mass of the shape.
    modes : Its rigid modes.
    free : Dofs that are not clamped, shape (n_free,).
    scheme : Coefficients of the step.
    dense : Whether to factorise densely; None: by size.

    Attributes
    ----------
    dense : Whether the factor is: then it can be sent to another process.
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
        stiff = operators.stiffness
        whole = sparse.csr_array((c_k * stiff.data, stiff.indices, stiff.indptr), shape=stiff.shape)
        if c_m:
            whole = sparse.csr_array(c_m * operators.mass + whole)
        sigma = float(whole.diagonal().sum() / operators.mass.diagonal().sum())
        effective = whole if len(free) == self._total else sparse.csr_array(whole[free][:, free])
        del whole  # a large factor leaves no room for it, nor for what is not needed meanwhile
        if len(free) >= LARGE:
            park(operators.stiffness)
            park(operators.mass)
        dense = len(free) <= DENSE_LIMIT if dense is None else dense
        kind = self.kinds[0 if dense else 1]
        # momentum on free dofs is M_ff Φ, as Φ vanishes elsewhere
        own = np.ascontiguousarray(modes.modes[self._free, : modes.count])
        momentum = np.ascontiguousarray(modes.momentum[self._free, : modes.count])
        self._place = np.full(self._total, -1)
        self._place[free] = np.arange(len(free))
        self._factor = kind(effective, own, momentum, sigma)
        self.dense = dense

    def apply(self, impulses: FloatArray) -> FloatArray:
        """(M̂⁻¹)_el r for nodal impulses of b blocks, shape (b, n) [N s] to (b, n) [m/s]."""
        answer = np.zeros_like(impulses)
        answer[:, self._free] = self._factor.solve(impulses[:, self._free].T).T
        return answer

    def block(self, dofs: IntArray) -> FloatArray:
        """Dense symmetric block of (M̂⁻¹)_el on some dofs, by solves with many columns."""
        part = self.columns(dofs)
        for some in portions(len(dofs), len(dofs)):
            rows, columns = part[some, some.start :], part[some.start :, some]
            rows += columns.T
            rows *= 0.5
            columns[:] = rows.T
        return part

    def columns(self, dofs: IntArray) -> FloatArray:
        """The same as the solves give it."""
        place = self._place[dofs]
        free = np.flatnonzero(place >= 0)
        own = self._factor.block(place[free])
        if len(free) == len(dofs):
            return own
        part: FloatArray = np.zeros((len(dofs), len(dofs)))
        part[np.ix_(free, free)] = own
        return part
