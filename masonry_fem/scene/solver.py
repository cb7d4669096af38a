"""Solver: how the contact problem of each step is solved."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

from masonry_fem.nscd.methods import GONE
from masonry_fem.nscd.methods import names as methods
from masonry_fem.nscd.settings import ACCEPTABLE, SolverSettings
from masonry_fem.records.record import Count, Seconds, Spec

if TYPE_CHECKING:
    MethodName = str
else:  # what ``method`` may be, told from the files there
    MethodName = Literal["auto", *methods()]

AIM = 1e-10  # of a contact solution whose tolerance nobody set


class Solver(Spec, frozen=True, kw_only=True):
    """How the contact problem of each step is solved, and how accurately.

    Without a ``tolerance`` the solver aims at 1e-10; if it gets stuck at an error of up to 1e-6, it accepts
    the answer and warns, stating the error. A ``tolerance`` that is given must be met.

    Attributes
    ----------
    method : sweeps by nonlinear Gauss-Seidel (``nsgs``), proximal Newton or interior point;
        ``auto`` chooses by the problem
    tolerance : bound on the relative contact error
    max_iterations : largest number of sweeps or Newton steps
    time_limit : wall-clock time for a contact problem; the step ends where one takes all of it
    relaxation : for ``nsgs``: how far a sweep moves a contact towards the solution of its local problem,
        1 being all the way
    threads : for ``nsgs``: number of threads that share a sweep, colour by colour. By default one thread
        sweeps in a shuffled order. Any number of threads gives the same results; see
        [which contact solver](solvers.md)
    linear : how linear systems are solved: ``direct`` by factorisation, ``krylov`` by iterations (for
        thick masonry with tens of thousands of contacts, and for many elastic blocks), ``auto`` by
        whichever is expected to cost less; see [which contact solver](solvers.md)
    tangent : of stones that yield, in Newton's iterations of a step: ``consistent``, anew in each, or
        ``initial``, that of the first one, as long as each leaves at most half of what the last one left of
        balance (modified Newton); see [stones that yield](method.md#stones-that-yield)
    """

    method: Annotated[MethodName, Meta(extra={"gone": GONE})] = "auto"
    tolerance: Annotated[float, Meta(gt=0, lt=1)] | None = None
    max_iterations: Count | None = None
    time_limit: Seconds | None = None
    relaxation: Annotated[float, Meta(gt=0, lt=2)] = 1.0
    threads: Count | None = None
    linear: Literal["auto", "direct", "krylov"] = "auto"
    tangent: Literal["consistent", "initial"] = "consistent"

    @property
    def aim(self) -> float:
        """The tolerance that is asked for, or aimed at."""
        return AIM if self.tolerance is None else self.tolerance

    @property
    def settings(self) -> SolverSettings:
        """The same as settings of the contact solver."""
        return SolverSettings(
            method=self.method,
            tolerance=self.aim,
            acceptable=ACCEPTABLE if self.tolerance is None else 0.0,
            max_iterations=self.max_iterations,
            time_limit=self.time_limit,
            relaxation=self.relaxation,
            threads=self.threads,
            linear=self.linear,
        )
