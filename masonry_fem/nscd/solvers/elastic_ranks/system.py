"""DividedSystem: the linear system of a Newton step, of which each rank has the rows of its contacts."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import override

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.ranks import AgreedError
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.linear import Library, Solve
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import inverted
from masonry_fem.nscd.solvers.elastic_krylov import FACTORED, Effort, Values, at_rest
from masonry_fem.nscd.solvers.elastic_matrix import Terms
from masonry_fem.nscd.solvers.elastic_ranks.portion import Portion
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Divided(Shared):
    """Rows of W_el of a rank's own contacts: products are those of all ranks' impulses.

    Parameters
    ----------
    portion : What the rank has of the problem.
    """

    def __init__(self, portion: Portion) -> None:
        assert portion.near is not None
        own = portion.near.only(np.arange(portion.share.count))
        super().__init__(own.count, own.dimension, own.kinds, own.symmetric, own.bed)
        self._portion = portion

    @property
    @override
    def nnz(self) -> int:
        """At least one number: other ranks have some."""
        return max(super().nnz, 1)

    @override
    def __matmul__(self, impulse: FloatArray) -> FloatArray:
        return self._portion.moved(impulse.reshape(self.count, self.dimension)).ravel()


class DividedSystem(NewtonSystem):
    """What does not change between the Newton steps of one problem.

    Parameters
    ----------
    problem : Of the rank's own contacts and all bodies. scale, library : As for ``NewtonSystem``.
    portion : What the rank has of the problem.
    """

    def __init__(
        self, problem: ContactProblem, scale: FloatArray, library: Library, portion: Portion
    ) -> None:
        super().__init__(problem, scale, library)
        self._portion = portion

    @property
    @override
    def many(self) -> bool:
        return at_rest(self.problem)

    @property
    @override
    def iterates(self) -> bool:
        return True

    @cached_property
    def _prepared(self) -> Portion:
        """The portion with rows for any step."""
        self._portion.prepare(self.body_matrix.maps)
        return self._portion

    @override
    def factor(
        self,
        own: FloatArray,
        by_velocity: FloatArray,
        closed: Mask,
        plain: Mask,
        mass: FloatArray,
        own_inverse: FloatArray | None = None,
        root: FloatArray | None = None,
        stiffness: FloatArray | None = None,
    ) -> NewtonFactor:
        member = self._portion.member
        inertia = mass if member.rank == 0 else np.zeros_like(mass)  # it is added up
        if self._mixed and own_inverse is None and root is None:
            own_inverse = _agreed(lambda: member.together(lambda: self._inverses(own, closed)))
        return super().factor(own, by_velocity, closed, plain, inertia, own_inverse, root, stiffness)

    @cached_property
    def _mixed(self) -> bool:
        """Whether some contacts have no compliance."""
        return self.problem.any(~self.elastic)

    def _inverses(self, own: FloatArray, closed: Mask) -> FloatArray:
        """D⁻¹ of closed contacts without compliance, zero elsewhere, shape (c, d, d)."""
        inverse, gone = np.zeros_like(own), np.flatnonzero(closed & ~self.elastic)
        inverse[gone] = inverted(own[gone])
        return inverse

    @override
    def _coupled(self, kept: IntArray) -> bool:
        return True

    @override
    def _iteration(self, kept: IntArray, terms: Terms) -> Solve:
        portion, problem, d = self._prepared, self.problem, self.problem.dimension
        values = portion.at_seams(Values.at(terms))
        coupled = terms.coupled.data[portion.slots]
        unknown = int(problem.summed(np.array([float(len(kept))]))[0])
        effort = Effort.of(unknown, rests=at_rest(problem))
        _agreed(lambda: portion.take(values, coupled))

        def solve(rhs: FloatArray) -> FloatArray:
            if portion.rows.values is not values:
                _agreed(lambda: portion.take(values, coupled))
            force, scale = np.zeros_like(problem.free_velocity), np.zeros(problem.count)
            force[kept], scale[kept] = rhs[: len(kept) * d].reshape(-1, d), self.scale[kept]
            balance = rhs[len(kept) * d :].reshape(problem.body_count, -1)
            impulse, moved, ended = portion.solve(force, balance[portion.its_bodies], scale, effort)
            if not ended and unknown <= FACTORED:
                portion.member.together(lambda: _stagnated(effort))
            return np.concatenate([impulse[kept].ravel(), portion.of_all(moved).ravel()])

        return solve


def _agreed[T](work: Callable[[], T]) -> T:
    """What work gives that all ranks do; a singular matrix of one of them is one of all.

    Raises
    ------
    LinAlgError : A matrix is singular.
    """
    try:
        return work()
    except AgreedError as failure:
        if isinstance(failure.error, np.linalg.LinAlgError):
            raise failure.error from None
        raise


def _stagnated(effort: Effort) -> None:
    """Tell that an iteration has failed.

    Raises
    ------
    StagnationError : Always.
    """
    raise StagnationError(f"residual above {effort.accuracy:.0e} of the first after {effort.most} iterations")
