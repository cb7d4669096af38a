"""Signals: SIGTERM and SIGHUP end a command as Ctrl-C does, with what was written so far left readable."""

from __future__ import annotations

import _thread
import contextlib
import gc
import importlib._bootstrap
import logging
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType
from typing import Any

logger = logging.getLogger(__name__)

# signals that ask for the end, and what answers each of them unless somebody has changed that
ANSWERED = {
    signal.SIGTERM: signal.SIG_DFL,
    signal.SIGHUP: signal.SIG_DFL,
    signal.SIGINT: signal.default_int_handler,
}
AGAIN = 0.01  # seconds after which a signal is sent again if it came where no exception could be raised
IMPORTING = importlib._bootstrap._find_and_load.__code__  # type: ignore[attr-defined]  # private, as old as Python 3.3


class Ended(KeyboardInterrupt):
    """A signal that asks for the end, with its number."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


class Received:
    """Whether a signal came, and its number; SIGINT where none of the others did."""

    came: bool = False
    number: int = signal.SIGINT


@contextlib.contextmanager
def answered() -> Iterator[Received]:
    """Raise ``Ended`` for these signals; those that are ignored (nohup) or answered otherwise stay so.

    Not while a module is being loaded: the signal waits until that is done. Libraries in C load modules from
    within their own, and do not expect an exception from that: VTK is left with half of its classes, and
    crashes; others say that a module is missing.
    """
    received = Received()

    def end(number: int, frame: FrameType | None) -> None:
        if _loads(frame):
            _send_again(number)
            return
        received.came, received.number = True, number
        raise KeyboardInterrupt if number == signal.SIGINT else Ended(number)

    kept = {}
    if threading.current_thread() is threading.main_thread():
        kept = {
            one: signal.signal(one, end) for one, usual in ANSWERED.items() if signal.getsignal(one) == usual
        }
    reported = sys.unraisablehook

    def lost(what: Any) -> None:
        """Send again a signal that came in ``__del__``, out of which no exception leads; tell of all else."""
        if isinstance(what.exc_value, KeyboardInterrupt):
            _send_again(getattr(what.exc_value, "number", signal.SIGINT))
        elif received.came:
            logger.debug("%s: %r", what.object, what.exc_value)
        else:
            reported(what)

    sys.unraisablehook = lost
    try:
        yield received
    finally:
        if received.came:
            gc.collect()  # what is half made and holds itself would complain later
        sys.unraisablehook = reported
        for one, before in kept.items():
            signal.signal(one, before)


def behind(error: BaseException) -> KeyboardInterrupt | None:
    """The signal that an error comes from, if it does: in functions that Numba compiled one becomes such.

    Parameters
    ----------
    error : What a command ended with.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__ or cause.__context__
    return cause


def _loads(frame: FrameType | None) -> bool:
    """Whether a module is being loaded, by an import statement or from within a library in C."""
    while frame is not None and frame.f_code is not IMPORTING:
        frame = frame.f_back
    return frame is not None


def _send_again(number: int) -> None:
    """Send the signal to this thread, the main one, a moment later."""
    main = threading.get_ident()

    def send() -> None:
        time.sleep(AGAIN)
        # a real signal, not a pending one: the thread may wait by now for what only a signal interrupts
        signal.pthread_kill(main, number)

    # not threading.Thread: what the signal came into may hold its lock
    _thread.start_new_thread(send, ())
