"""Phases: what is being done, and how much of it, told to whoever listens: a console.

    with heard(console):
        with phase("meshes", total=3) as at:
            for number, shape in enumerate(shapes):
                mesh(shape)
                at(number + 1)

Where nobody listens, which is the default, a phase costs a microsecond and a call in it nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Protocol, cast

LOADING = "loading libraries"  # what is done before anything else is

type At = Callable[..., None]
"""``at(done, note="", total=None)``: how much is done, what else is worth a few words, another total."""


class Listener(Protocol):
    """Somebody who is told."""

    def begin(self, what: str, total: float | None) -> At:
        """A phase has begun.

        Parameters
        ----------
        what : Is done, in a few words. total : How much of it there is, in any unit; None: not known.
        """
        ...

    def end(self, at: At) -> None:
        """The phase has ended that ``begin`` gave this for."""
        ...


_heard: ContextVar[Listener | None] = ContextVar("heard", default=None)


def listener() -> Listener | None:
    """Who listens."""
    return _heard.get()


@contextmanager
def heard(by: Listener | None) -> Iterator[None]:
    """Tell phases meanwhile to this listener; None: to nobody."""
    token = _heard.set(by)
    try:
        yield
    finally:
        _heard.reset(token)


@contextmanager
def phase(what: str, total: float | None = None) -> Iterator[At]:
    """Something that may take long.

    Parameters
    ----------
    what : Is done, in a few words.
    total : How much of it there is, in any unit; None: not known.
    """
    by = _heard.get()
    if by is None:
        yield _unheard
        return
    at = by.begin(what, total)
    try:
        yield at
    finally:
        by.end(at)


def counted[T](what: str, items: Iterable[T], total: int | None = None) -> Iterator[T]:
    """The items one after another, as a phase that is done when all have been.

    Parameters
    ----------
    what : Is done with each of them. items : Of any kind.
    total : Their number; None: they have a length.
    """
    with phase(what, len(cast("Sized", items)) if total is None else total) as at:
        for number, item in enumerate(items):
            yield item
            at(number + 1)


def _unheard(done: float, note: str = "", total: float | None = None) -> None:
    pass
