"""Garbage: Python's search for objects that only each other hold, put off while a program starts.

    with put_off():
        ...             # modules are loaded, a scene is built: half a million objects that stay
        taken_up()
        ...             # a march: what it makes is searched as ever, what was there before is not

Searching what stays takes a tenth of the start, and a last time at the end of the process (``left_at_exit``)
a fifth of a small scene. Only a program of its own asks for either; within another's process ``taken_up``
does nothing.
"""

from __future__ import annotations

import atexit
import gc
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_waits: ContextVar[bool] = ContextVar("_waits", default=False)  # whether the search is put off


@contextmanager
def put_off() -> Iterator[None]:
    """No search until ``taken_up``; at the end all is as before."""
    _waits.set(gc.isenabled())
    gc.disable()
    try:
        yield
    finally:
        taken_up()
        gc.unfreeze()


def taken_up() -> None:
    """Search from here on, where that was put off, and never what is there."""
    if _waits.get():
        _waits.set(False)
        gc.freeze()
        gc.enable()


def left_at_exit() -> None:
    """What is there when the process ends goes back to the system with it, unsearched."""
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)
