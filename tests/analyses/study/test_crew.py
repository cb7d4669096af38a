"""Cells that break, hang or are killed are rows; Ctrl-C keeps what is done. The breaking is a law file's."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
import types
from pathlib import Path
from typing import Any

import pytest
from numba.core import event

from masonry_fem.analyses.cells import worker
from masonry_fem.analyses.cells.cell import Cell
from masonry_fem.analyses.cells.crew import Crew
from masonry_fem.analyses.cells.kept import Kept
from masonry_fem.analyses.cells.process import WorkerProcess
from masonry_fem.analyses.study import study
from masonry_fem.errors import MasonryError
from masonry_fem.records.told import known, write

SCENE = """
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2000
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 1.0]
count = 1
[[joints]]
law = { kind = "python", file = "fine.py", law = "Fine", trusted = true }
[loads]
gravity = [0, -10.0]
"""
FILES = {
    "crash.py": "import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n",
    "killed.py": "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n",
    "hang.py": "while True:\n    pass\n",
    "leave.py": "import os, sys\nprint('enough', flush=True)\nos._exit(3)\n",
    "wrong.py": "1 / 0\n",
    "murder.py": "import os, signal\nos.kill(os.getppid(), signal.SIGKILL)\nos._exit(1)\n",
    "fine.py": "",
}
EXPECTED = {
    "crash.py": ("failed", "crashed with SIGSEGV"),
    "killed.py": ("out_of_memory", "the system killed it"),
    "hang.py": ("time_limit", "more than 1 s of CPU time"),
    "leave.py": ("failed", "enough"),
    "wrong.py": ("refused", "ZeroDivisionError"),
    "murder.py": ("failed", "killed from outside"),
    "absent.py": ("bad_scene", "expected an existing file"),
}


@pytest.mark.slow
def test_cells_that_break_are_rows(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    vary = {"joints.0.law.file": list(EXPECTED)}
    made = study(tmp_path / "scene.toml", vary, out=tmp_path / "out", time_limit=1.0)
    found = {row.cell.settings["joints.0.law.file"]: row for row in made.rows}
    for name, (outcome, words) in EXPECTED.items():
        assert found[name].outcome == outcome, name
        assert words in found[name].message, name
    assert made.recommendations == ()
    assert any("no cell was solved" in note for note in made.notes)


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(tmp_path: Path, repository: Path) -> None:
    command = [
        sys.executable, "-m", "masonry_fem", "study", str(repository / "demos" / "low_wall.toml"),
        "--vary", "mesh.divisions=[1,1,1],[2,1,1],[16,8,8]", "--workers", "1", "--out", str(tmp_path),
    ]  # fmt: skip
    # a test runner in the background has the signal ignored
    running = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=repository,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # noqa: PLW1509
    )  # fmt: skip
    end = time.monotonic() + 90
    while len(list((tmp_path / "cells").glob("*.json"))) < 2 and time.monotonic() < end:
        time.sleep(0.1)
    time.sleep(0.5)
    running.send_signal(signal.SIGINT)
    out, said = running.communicate(timeout=30)
    assert running.returncode == 130
    assert "2 of 3 cells are done" in said
    assert "goes on with the 1 left" in said
    assert "missing" in out
    assert (tmp_path / "study.csv").exists()


def test_what_a_worker_found_before_it_was_killed_is_kept(tmp_path: Path, monkeypatch) -> None:
    """As by Ctrl-C, between the row's writing and the worker's word that it is written."""
    process = WorkerProcess(tmp_path / "worker.log")
    cell = Cell((), {}, "", "own")

    def killed() -> None:
        write(tmp_path / f"{cell.key}.json", {"outcome": "equilibrium", "start": 1.0})
        raise OSError

    process._ready = True
    monkeypatch.setattr(process, "_answer", killed)
    row = process.compute(cell, tmp_path, tmp_path, None)
    process.end()
    assert row["outcome"] == "equilibrium"
    assert known(tmp_path / f"{cell.key}.json", dict[str, Any]) == row


def test_halves_of_rows_that_a_kill_left_are_removed(tmp_path: Path) -> None:
    kept = Kept(tmp_path, fresh=False)
    kept.keep("own", {"outcome": "equilibrium"})
    half = tmp_path / "cells" / "own.json.part"
    half.touch()
    kept = Kept(tmp_path, fresh=False)
    assert not half.exists()
    assert kept.row("own", dict[str, Any]) == {"outcome": "equilibrium"}


def test_nonsense_is_refused() -> None:
    with pytest.raises(MasonryError, match="workers is 0"):
        Crew(workers=0)
    with pytest.raises(MasonryError, match="time limit is -1"):
        Crew(limit=-1.0)


def test_memory_decides_how_many_cells_run(monkeypatch) -> None:
    left = types.SimpleNamespace(available=4000 * 2**20)
    monkeypatch.setattr("psutil.virtual_memory", lambda: left)
    crew = Crew(workers=8)
    assert crew._fits(3)
    crew._peak = 2500.0  # a finer cell may need twice as much
    assert not crew._fits(1)
    assert crew._fits(0)


def test_what_lacked_memory_has_another_attempt_alone(monkeypatch, tmp_path: Path) -> None:
    """Two cells need all of the memory there is: side by side each of them breaks."""
    running, together = [], []

    class Process:
        alive = True

        def __init__(self, log: Path) -> None:
            self.log = log

        def compute(
            self, cell: Cell, base: Path, folder: Path, limit: float | None, task: str
        ) -> dict[str, object]:
            running.append(cell.key)
            together.append(len(running))
            time.sleep(0.2)
            crowded = len(running) > 1
            time.sleep(0.2)
            running.remove(cell.key)
            return {"outcome": "out_of_memory" if crowded else "equilibrium"}

        def end(self) -> None:
            self.alive = False

    monkeypatch.setattr("masonry_fem.analyses.cells.crew.WorkerProcess", Process)
    cells = [Cell((i,), {}, "", str(i)) for i in range(4)]
    with Crew(workers=2) as crew:
        rows = {cell.key: row["outcome"] for cell, row in crew.compute(cells, base=tmp_path, folder=tmp_path)}
    assert rows == dict.fromkeys("0123", "equilibrium")
    assert max(together) == 2


def test_compilation_is_not_the_cost_of_the_cell_that_is_first() -> None:
    def busy(seconds: float) -> None:
        end = time.process_time() + seconds
        while time.process_time() < end:
            pass

    def run(scene: Any, base: Path) -> dict[str, Any]:
        busy(0.05)
        with event.trigger_event("numba:compile"):
            busy(0.1)
            with event.trigger_event("numba:compile"):  # of a function that it calls
                busy(0.1)
        return {}

    _, cpu, compiled = worker._timed(run, None, Path())
    assert compiled == pytest.approx(0.2, abs=0.02)
    assert cpu == pytest.approx(0.05, abs=0.02)
