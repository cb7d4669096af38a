"""Settings of a solution, and where it starts.

solve(problem, SolverSettings(method="newton", tolerance=1e-9), Start(impulse=last.impulse))
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING, Literal, get_args

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import methods

if TYPE_CHECKING:  # scenes that are only read need no NumPy
    import numpy as np
    from numpy.typing import NDArray

    from masonry_fem.nscd.problem import Products

LinearName = Literal["auto", "direct", "krylov"]

TARGET = 1e-10  # the tolerance where nobody asks for one
OVER = 1e-9  # a limit of time that is over [s]
ACCEPTABLE = 1e-6  # error up to which a state that misses it may be an answer where nobody asks for one


@dataclass(frozen=True, slots=True, kw_only=True)
class SolverSettings:
    """Method, tolerance and limits with which a contact problem is solved.

    Attributes
    ----------
    method : Name of a file of ``nscd/methods`` such as "newton", or "auto": methods that suit the problem are
        tried in turn.
    tolerance : Bound on ``Quality.error``, unit-free.
    acceptable : Larger error that is accepted, with outcome INEXACT, if no method gets below the tolerance;
        of elastic bodies in dynamics, if Newton's method comes no nearer. 0: none is accepted, except of
        rigid blocks if rounding alone may cause it.
    max_iterations : Largest number of sweeps or Newton steps; None: the method's own limit.
    time_limit : Wall-clock seconds after which the best state so far is returned; None: no limit.
        Only a run that is cut short by it can differ from the next one.
    least_impulse : Impulse to which errors are relative if all impulses are smaller [N s]. An analysis of
        many steps sets it such that the tolerance is not below the rounding of its largest impulses.
    relaxation : ω of "nsgs", between 0 and 2: how far a contact goes towards its own solution.
    threads : Of "nsgs": largest number of threads. Results do not depend on it, except that None, one thread
        that visits the contacts in a shuffled order, gives slightly different ones.
    linear : How linear systems are solved: "direct" by factorisation, "krylov" by iterations (and by
        factorisation if they fail), "auto" by whichever is expected to cost less.
    """

    method: str = "auto"
    tolerance: float = TARGET
    acceptable: float = 0.0
    max_iterations: int | None = None
    time_limit: float | None = None
    least_impulse: float = 0.0
    relaxation: float = 1.0
    threads: int | None = None
    linear: LinearName = "auto"

    def __post_init__(self) -> None:
        names = ("auto", *methods.names())
        if self.method not in names:
            expected = ", ".join(repr(name) for name in names)
            gone = f"; {methods.GONE[self.method]}" if self.method in methods.GONE else ""
            raise ProblemError(f"method is {self.method!r}, expected one of {expected}{gone}")
        known = get_args(LinearName)
        self._check("linear", self.linear in known, "one of " + ", ".join(map(repr, known)))
        self._check("tolerance", 0 < self.tolerance < 1, "a number between 0 and 1")
        self._check("acceptable", 0 <= self.acceptable < 1, "a number from 0 to 1")
        self._check("max_iterations", self.max_iterations is None or self.max_iterations >= 1, "at least 1")
        self._check("time_limit", self.time_limit is None or self.time_limit > 0, "more than 0", " s")
        self._check("least_impulse", 0 <= self.least_impulse < math.inf, "at least 0", " N s")
        self._check("relaxation", 0 < self.relaxation < 2, "a number between 0 and 2")
        whole = self.threads is None or (self.threads >= 1 and self.threads == int(self.threads))
        self._check("threads", whole, "a whole number of at least 1")
        for name, usual in (("relaxation", 1.0), ("threads", None)):
            if self.method != "nsgs" and getattr(self, name) != usual:
                raise ProblemError(
                    f"{name} is {getattr(self, name)} with method {self.method!r}, expected {usual}: "
                    "only sweeps have it; leave it out or choose method 'nsgs'"
                )

    def _check(self, name: str, holds: bool, expected: str, unit: str = "") -> None:
        """Refuse a value that is not as expected."""
        if not holds:
            value = getattr(self, name)
            told = repr(value) if isinstance(value, str) else f"{value}{unit}"
            raise ProblemError(f"{name} is {told}, expected {expected}")


@dataclass(frozen=True, slots=True)
class Start:
    """A first guess, mostly the step before; None where there is none.

    Attributes
    ----------
    impulse : Impulses in the contact frames [N s], shape (c, d).
    rigid_velocity : Rigid velocities U, shape (b, m).
    velocity : Velocities at the contacts that the impulses belong to, in the problem that they solve, shape
        (c, d) [m/s]. They tell which contacts stick, slip or are open; None: the velocities that the
        impulses have in this problem do, which are far off where blocks have turned.
    products : Those of the problem with the impulses and rigid velocities, if they are known.
    """

    impulse: NDArray[np.float64] | None = None
    rigid_velocity: NDArray[np.float64] | None = None
    velocity: NDArray[np.float64] | None = None
    products: Products | None = None


def time_left(until: float | None) -> float | None:
    """Limit of time of what is to end by then [s]; None: no limit.

    Parameters
    ----------
    until : Monotonic clock [s]; None: no limit.
    """
    return None if until is None else max(until - monotonic(), OVER)
