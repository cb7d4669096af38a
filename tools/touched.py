"""Which lines of the package each test runs, and for how long: a plugin of pytest for `mutations.py`.

Lines in functions that Numba compiled are not seen, nor are those that other processes run. What several
tests share (a fixture, a memory) counts for the first of them.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from types import CodeType

import pytest

LINE = sys.monitoring.events.LINE
TOOL = sys.monitoring.COVERAGE_ID


class Touched:
    """Seconds and lines, by file within the package, of each test that passes, in ``found``."""

    def __init__(self, package: str) -> None:
        self.package = package
        self.found: dict[str, tuple[float, dict[str, list[int]]]] = {}
        self.lines: dict[str, set[int]] = {}
        sys.monitoring.use_tool_id(TOOL, "touched")
        sys.monitoring.register_callback(TOOL, LINE, self._seen)
        sys.monitoring.set_events(TOOL, LINE)

    def _seen(self, code: CodeType, line: int) -> object:
        if code.co_filename.startswith(self.package):
            self.lines.setdefault(code.co_filename.removeprefix(self.package), set()).add(line)
        return sys.monitoring.DISABLE  # until the next test: a line costs once a test

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Count time and lines of one test with its fixtures."""
        self.lines.clear()
        sys.monitoring.restart_events()
        start = time.perf_counter()
        answer = yield
        lines = {file: sorted(numbers) for file, numbers in self.lines.items()}
        self.found[item.nodeid] = (time.perf_counter() - start, lines)
        return answer

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Leave out what failed."""
        reporter = session.config.pluginmanager.getplugin("terminalreporter")
        for report in reporter.stats.get("failed", []) + reporter.stats.get("error", []):
            self.found.pop(report.nodeid, None)
