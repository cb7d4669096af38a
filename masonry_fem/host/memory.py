"""Memory of this process: how much, whether what was freed goes back, arrays in files, search for garbage.

    with put_off():
        ...             # modules are loaded, a scene is built: half a million objects that stay
        taken_up()
        ...             # a march: what it makes is searched as ever, what was there before is not

Garbage is objects that only each other hold. To search what stays takes a tenth of the start, and a last time
at the end of the process (``left_at_exit``) a fifth of a small scene. Only a program of its own asks for
either; within the process of another ``taken_up`` does nothing.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from scipy import sparse


# Codes of mallopt, as <malloc.h> has them.
TRIM_THRESHOLD, MMAP_MAX = -1, -4

_waits: ContextVar[bool] = ContextVar("_waits", default=False)  # whether the search is put off


def trim() -> None:
    """Give memory that was freed back to the system, where the C library would keep it for itself."""
    with suppress(OSError, AttributeError, TypeError):  # glibc alone has it
        ctypes.CDLL(None).malloc_trim(0)


def keep() -> None:
    """Let the C library keep what is freed, for large arrays that are made again and again.

    It gives arrays from 32 MB on back at once, and the system clears each page before it is used next.
    """
    with suppress(OSError, AttributeError, TypeError):  # glibc alone has it
        library = ctypes.CDLL(None)
        library.mallopt(MMAP_MAX, 0)
        library.mallopt(TRIM_THRESHOLD, 2**31 - 1)


def peak_memory() -> float:
    """Largest resident memory of this process so far [MB]."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024**2 if sys.platform == "darwin" else 1024)


def park(matrix: sparse.csr_array) -> None:
    """Move a matrix's numbers to a file without a name, out of which they are read as they are asked for.

    Parameters
    ----------
    matrix : It remains what it is; what is written to it stays in memory.

    Raises
    ------
    OSError : The folder for temporary files has no room.
    """
    matrix.data, matrix.indices = _on_disk(matrix.data), _on_disk(matrix.indices)


def _on_disk[T: np.generic](values: NDArray[T]) -> NDArray[T]:
    import numpy as np  # noqa: PLC0415 - the command line reads this file

    if values.size == 0 or isinstance(values.base, np.memmap):
        return values
    import tempfile  # noqa: PLC0415 - not on the path of --help

    with tempfile.TemporaryFile(prefix="masonry_fem-") as file:
        values.tofile(file)
        file.flush()
        return np.asarray(np.memmap(file, values.dtype, "c", shape=values.shape))


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
