"""Threads of the dense kernels: one, whatever the machine.

Fronts are small. Handed out to several threads they cost two to twenty times as much, most where
other programs run, and the last bits depend on the number of cores.

    with one_thread():
        ...
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache

import scipy.linalg.blas  # noqa: F401 - the controller sees the libraries that are loaded by then
from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[object]:
    """BLAS on one thread within the context."""
    limit: AbstractContextManager[object] = _controller().limit(limits=1, user_api="blas")
    return limit


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()
