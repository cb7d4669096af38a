"""Clock: CPU time by phase."""

from __future__ import annotations

import time


class Clock:
    """Adds the CPU time since the last lap to a named phase [s]."""

    def __init__(self) -> None:
        self.phases: dict[str, float] = {}
        self._last = time.process_time()

    def lap(self, phase: str) -> None:
        """End a stretch of ``phase``."""
        now = time.process_time()
        self.phases[phase] = self.phases.get(phase, 0.0) + now - self._last
        self._last = now
