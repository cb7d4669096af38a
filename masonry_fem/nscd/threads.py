"""Threads: one for the dense kernels, whatever the machine; several for sweeps that ask for them.

Their matrices are small. Handed out to several threads they cost two to twenty times as much, most where
other programs run, and the last bits depend on the number of cores.

    with one_thread():
        ...
    with several_threads(available_threads(4)):
        ...
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache

import scipy.linalg.blas  # noqa: F401 - the controller sees the libraries that are loaded by then
from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[object]:
    """BLAS on one thread within the context."""
    limit: AbstractContextManager[object] = _controller().limit(limits=1, user_api="blas")
    return limit


# Numba's threads serve one caller at a time, of the process that woke them: its forks have none
_serving = threading.Lock()
_awake: int | None = None


def available_threads(wanted: int) -> int:
    """How many of the wanted threads Numba's loops can have here."""
    import numba  # noqa: PLC0415 - slow to import

    if _awake not in {None, os.getpid()}:
        return 1
    return min(wanted, int(numba.config.NUMBA_NUM_THREADS))


@contextmanager
def several_threads(count: int) -> Iterator[None]:
    """Numba's parallel loops on ``count`` threads within the context; for one, there must be none of them."""
    if count == 1:
        yield
        return
    import numba  # noqa: PLC0415 - slow to import

    global _awake  # noqa: PLW0603 - a fact of this process
    _awake = os.getpid()
    with _serving:
        before = numba.get_num_threads()
        numba.set_num_threads(count)
        try:
            yield
        finally:
            numba.set_num_threads(before)


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()
