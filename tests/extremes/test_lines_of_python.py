"""Lines of Python: none runs once for each stone, contact or interface of a scene."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import pytest

import masonry_fem
from masonry_fem.cli import main

ROOT = f"{Path(masonry_fem.__file__).parent}/"
TOOL = 4  # of ``sys.monitoring``: neither a debugger's, a profiler's nor coverage's
# what is iterated here ends when it has converged, later in larger walls
ITERATED = ("nscd/", "output/stress_block.py", "output/polygon_moments.py")
SCENE = """
dimension = 3
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = 1e10, poisson = 0.2, compressive_strength = 1e7 }}
joints = [{{ friction = 0.6 }}]
loads.gravity = [0.0, 0.0, -9.81]
analysis = {{ {analysis} }}
mesh = {{ divisions = [2, 1, 1] }}
solver = {{ tolerance = 1e-6 }}
output = {{ pictures = false, stones = true, interfaces = true }}

[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.5, 0.25, 0.25]
columns = {size}
courses = {size}
"""


class Lines:
    """How often each line of the package runs."""

    def __init__(self):
        self.times, self._starts = Counter(), {}

    def __enter__(self):
        events = sys.monitoring.events
        sys.monitoring.use_tool_id(TOOL, "lines")
        sys.monitoring.register_callback(TOOL, events.LINE, self._line)
        sys.monitoring.register_callback(TOOL, events.JUMP, self._jump)  # loops within a line
        sys.monitoring.set_events(TOOL, events.LINE | events.JUMP)
        return self

    def __exit__(self, *_):
        sys.monitoring.set_events(TOOL, 0)
        sys.monitoring.free_tool_id(TOOL)

    def _line(self, code, line):
        if not code.co_filename.startswith(ROOT):
            return sys.monitoring.DISABLE
        self.times[code.co_filename.removeprefix(ROOT), line, "runs"] += 1
        return None

    def _jump(self, code, offset, _):
        if not code.co_filename.startswith(ROOT):
            return sys.monitoring.DISABLE
        if code not in self._starts:
            self._starts[code] = [place[0] for place in code.co_positions()]
        line = self._starts[code][offset // 2]
        self.times[code.co_filename.removeprefix(ROOT), line, "goes round"] += 1
        return None


def lines_of(folder, size, fidelity, analysis):
    folder.mkdir()
    path = folder / "wall.toml"
    path.write_text(SCENE.format(size=size, fidelity=fidelity, analysis=analysis))
    with Lines() as lines:
        assert main(["run", str(path), "--out", str(folder / "results"), "--quiet"]) == 0
    return lines.times


@pytest.mark.parametrize(
    ("fidelity", "analysis"),
    [
        ("elastic", 'kind = "statics"'),
        ("rigid", 'kind = "dynamics", step = 0.01, duration = 0.02'),
        ("reduced", 'kind = "dynamics", step = 0.01, duration = 0.02'),
    ],
)
def test_no_line_runs_once_for_each_stone(tmp_path, fidelity, analysis):
    lines_of(tmp_path / "first", 3, fidelity, analysis)  # what is done once in a process
    small, large = (lines_of(tmp_path / f"of_{size}", size, fidelity, analysis) for size in (8, 16))
    stones = 16 * 16
    growing = [
        f"{file}:{line} {how} {count} times, {small[file, line, how]} before"
        for (file, line, how), count in large.items()
        if not file.startswith(ITERATED) and count > stones / 2 and count > 2 * small[file, line, how]
    ]
    assert not growing
