"""Trim: memory of this process, and whether what was freed goes back to the system."""

from __future__ import annotations

import ctypes
import platform
import resource
from contextlib import suppress

# Codes of mallopt, as <malloc.h> has them.
TRIM_THRESHOLD, MMAP_MAX = -1, -4


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
    return peak / (1024**2 if platform.system() == "Darwin" else 1024)
