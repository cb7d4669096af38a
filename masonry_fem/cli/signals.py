"""Signals: SIGTERM and SIGHUP end a command as Ctrl-C does, with what was written so far left readable."""

from __future__ import annotations

import _thread
import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any

ANSWERED = (signal.SIGTERM, signal.SIGHUP)
AGAIN = 0.01  # seconds after which a lost signal is sent again: `__del__` has ended by then


class Ended(KeyboardInterrupt):
    """A signal that asks for the end; its number tells which."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


class Received:
    """Number of the signal that came; SIGINT where none of the others did."""

    number: int = signal.SIGINT


@contextlib.contextmanager
def answered() -> Iterator[Received]:
    """Raise ``Ended`` for these signals; those that are ignored (nohup) or answered otherwise stay so."""
    received = Received()

    def end(number: int, _: FrameType | None) -> None:
        received.number = number
        raise Ended(number)

    kept = {}
    if threading.current_thread() is threading.main_thread():
        kept = {one: signal.signal(one, end) for one in ANSWERED if signal.getsignal(one) == signal.SIG_DFL}
    reported = sys.unraisablehook

    def lost(what: Any) -> None:
        """Send again, a moment later, a signal that came in ``__del__``, out of which no exception leads."""
        if isinstance(what.exc_value, KeyboardInterrupt):
            number = getattr(what.exc_value, "number", signal.SIGINT)
            threading.Timer(AGAIN, _thread.interrupt_main, (number,)).start()
        else:
            reported(what)

    sys.unraisablehook = lost
    try:
        yield received
    finally:
        sys.unraisablehook = reported
        for one, before in kept.items():
            signal.signal(one, before)
