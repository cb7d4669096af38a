"""Global solvers, one file each. ``make_method`` is the list: a new solver adds one line."""

from __future__ import annotations

from masonry_fem.nscd.iterate import Method

NAMES = ("nsgs", "newton", "interior_point", "admm", "pivoting")


def make_method(name: str) -> Method:
    """The method of a name with its default settings; its code is imported only now."""
    if name == "nsgs":
        from masonry_fem.nscd.solvers.gauss_seidel import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

        return GaussSeidel()
    if name == "newton":
        from masonry_fem.nscd.solvers.newton import ProximalNewton  # noqa: PLC0415

        return ProximalNewton()
    if name == "interior_point":
        from masonry_fem.nscd.solvers.interior_point import InteriorPoint  # noqa: PLC0415

        return InteriorPoint()
    if name == "admm":
        from masonry_fem.nscd.solvers.admm import ADMM  # noqa: PLC0415 - Numba is slow to import

        return ADMM()
    if name == "pivoting":
        from masonry_fem.nscd.solvers.pivoting import Pivoting  # noqa: PLC0415

        return Pivoting()
    raise KeyError(name)
