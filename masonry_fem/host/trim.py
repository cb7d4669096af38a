"""Trim: memory of this process, and giving what was freed back to the system."""

from __future__ import annotations

import ctypes
import platform
import resource
from contextlib import suppress


def trim() -> None:
    """Give memory that was freed back to the system, where the C library would keep it for itself."""
    with suppress(OSError, AttributeError, TypeError):  # glibc alone has it
        ctypes.CDLL(None).malloc_trim(0)


def peak_memory() -> float:
    """Largest resident memory of this process so far [MB]."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024**2 if platform.system() == "Darwin" else 1024)
