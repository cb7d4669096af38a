"""Compiled: loops that Numba translates to machine code, once for a processor, and keeps beside the sources.

    @compiled
    def speeds(velocity): ...

The first use of a loop after installation takes seconds, and says so once. ``masonry-fem compile`` has all
of them translated before.
"""

from __future__ import annotations

import logging
from functools import partial
from typing import Any

from numba import njit
from numba.core import event

__all__ = ["compiled"]

logger = logging.getLogger(__name__)

compiled = partial(njit, cache=True)


class _Telling(event.Listener):
    """Says, once a process, that code is being compiled and need not be again."""

    told = False

    def on_start(self, event: Any) -> None:
        if not self.told:
            self.told = True
            logger.info(
                "compiling for this processor, once after installation; later runs start at once. "
                "'masonry-fem compile' does all of it beforehand"
            )

    def on_end(self, event: Any) -> None:
        pass


event.register("numba:compile", _Telling())
