"""Compiled: loops that Numba translates to machine code, once for a processor, and keeps beside the sources.

    @compiled
    def speeds(velocity): ...

The first use of a loop after installation takes seconds, and says so once. ``masonry-fem compile`` has all
of them translated before.
"""

from __future__ import annotations

import logging
import time
from typing import Any

from numba import njit
from numba.core import event

from masonry_fem.host.phases import At, listener

__all__ = ["compiled", "put"]

TELLING = 3  # functions whose mean time tells that of others
logger = logging.getLogger(__name__)

_known = 0  # functions that may be compiled, of the modules that are loaded


def compiled(*function: Any, **options: Any) -> Any:
    """A decorator: the function as machine code, made where it is first called, kept beside its source."""
    global _known  # noqa: PLW0603
    _known += "inline" not in options  # those are compiled with what calls them
    return njit(*function, cache=True, **options)


@compiled
def put(target: Any, values: Any) -> None:
    """``target[: len(values)] = values``; Numba's own takes seconds to compile its error message.

    Parameters
    ----------
    target : Array in C order. values : Array that is no longer and has the same shape otherwise.
    """
    for i in range(values.size):
        target.flat[i] = values.flat[i]


class _Telling(event.Listener):
    """Says, once a process, that code is being compiled and need not be again; and shows each function."""

    told = False
    made, seconds = 0, 0.0
    depth, begun = 0, 0.0
    at: At | None = None

    def on_start(self, event: Any) -> None:
        self.depth += 1
        if self.depth == 1:
            self._show(event)
        if not self.told:
            self.told = True
            logger.info(
                "compiling for this processor, once after installation; later runs start at once. "
                "'masonry-fem compile' does all of it beforehand"
            )

    def on_end(self, event: Any) -> None:
        self.depth -= 1
        self.made += 1
        if self.depth:
            return
        self.seconds += time.monotonic() - self.begun
        if (by := listener()) is not None and self.at is not None:
            by.end(self.at)
        self.at = None

    def _show(self, event: Any) -> None:
        """Tell which function it is, and how long the rest takes at most."""
        self.begun = time.monotonic()
        if (by := listener()) is None:
            return
        name = getattr(getattr(event.data.get("dispatcher"), "py_func", None), "__name__", "a loop")
        self.at = by.begin(f"compiling {name}", None)
        self.at(0, f"once after installation, at most {max(_known - self.made, 1)} to go{self._left()}")

    def _left(self) -> str:
        """How long the rest would take at the mean speed so far, after some that tell it."""
        if self.made < TELLING:
            return ""
        return f", {self.seconds / self.made * max(_known - self.made, 1):.0f} s"


event.register("numba:compile", _Telling())
