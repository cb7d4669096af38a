"""Methods of the contact solver, one file each.

A file's name is what ``[solver] method`` calls it, its ``method()`` makes it with default settings. Nothing
else lists it; which ones ``auto`` takes, and when, stands in ``turns``.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from masonry_fem.errors import ExtensionError

if TYPE_CHECKING:
    from masonry_fem.nscd.iterate import Method


# Methods of earlier versions, and what to write instead.
GONE = {
    name: f"'{name}' is gone, and 'auto' solves what it solved; write 'auto', or leave method out"
    for name in ("admm", "pivoting")
}


@cache
def names() -> tuple[str, ...]:
    """Every method; none is loaded, as Numba is slow to import.

    The folder is read once: settings are checked several times a step.
    """
    return tuple(file.name for file in iter_modules(__path__))


def make_method(name: str) -> Method:
    """The method of a name with its default settings.

    Raises
    ------
    ExtensionError : Its file has no ``method``, or what that makes is none.
    """
    module = import_module(f"{__name__}.{name}")
    make = getattr(module, "method", None)
    if not callable(make):
        raise ExtensionError(
            f"{module.__file__} has no function method, expected one that makes the solver '{name}' with its "
            "default settings; write def method() -> Method"
        )
    made: Method = make()
    owed = {
        f"name = {name!r}": getattr(made, "name", None) == name,
        "iterations, a whole number": isinstance(getattr(made, "iterations", None), int),
        "init(problem, start)": callable(getattr(made, "init", None)),
    }
    if lacking := [what for what, there in owed.items() if not there]:
        raise ExtensionError(
            f"{module.__file__}: what method() makes, a {type(made).__name__}, lacks "
            f"{' and '.join(lacking)}; write it as masonry_fem.nscd.iterate.Method has it"
        )
    return made
