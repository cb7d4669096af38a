"""Which lines of the package each test runs, and for how long: a plugin of pytest for `mutations.py`.

    TOUCHED=touched.json python -m pytest -p touched --rootdir . tests/march      # with tools/ on PYTHONPATH

`{test: [seconds, {file: [lines]}]}`. Lines in functions that Numba compiled are not seen, nor are those that
other processes run. What several tests share (a fixture, a memory) counts for the first of them.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType

import pytest

PACKAGE = str(Path.cwd() / "masonry_fem") + os.sep
found: dict[str, tuple[float, dict[str, list[int]]]] = {}
lines: dict[str, set[int]] = {}


def pytest_configure() -> None:
    """Have Python say which lines it runs; after the first time in a test a line costs nothing."""
    sys.monitoring.use_tool_id(sys.monitoring.COVERAGE_ID, "touched")
    sys.monitoring.register_callback(sys.monitoring.COVERAGE_ID, sys.monitoring.events.LINE, _seen)
    sys.monitoring.set_events(sys.monitoring.COVERAGE_ID, sys.monitoring.events.LINE)


def _seen(code: CodeType, line: int) -> object:
    if code.co_filename.startswith(PACKAGE):
        lines.setdefault(code.co_filename.removeprefix(PACKAGE), set()).add(line)
    return sys.monitoring.DISABLE


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Count time and lines of one test with its fixtures."""
    lines.clear()
    sys.monitoring.restart_events()
    start = time.perf_counter()
    answer = yield
    found[item.nodeid] = (
        time.perf_counter() - start,
        {file: sorted(numbers) for file, numbers in lines.items()},
    )
    return answer


def pytest_sessionfinish() -> None:
    """Write what was found."""
    sys.monitoring.set_events(sys.monitoring.COVERAGE_ID, 0)
    Path(os.environ["TOUCHED"]).write_text(json.dumps(found))
