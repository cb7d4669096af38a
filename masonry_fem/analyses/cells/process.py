"""WorkerProcess: a worker as a search sees it: cells go in, rows come out, whatever happens there.

process = WorkerProcess(folder / "worker.log")
row = process.compute(cell, base, folder, limit=60.0)
process.end()
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

from masonry_fem.analyses.cells.cell import Cell
from masonry_fem.records.told import write

PINNED = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")
SLACK = 3.0  # wall-clock time over the CPU time that a cell may have: others use the machine, too ...
PATIENCE = 30.0  # ... and what its start may take besides [s]
KILLED = {
    signal.SIGKILL: ("out_of_memory", "the system killed it, most likely for want of memory"),
    signal.SIGXCPU: ("time_limit", "took more than {limit:g} s of CPU time (--time-limit)"),
}


class WorkerProcess:
    """One worker process; what it says besides answers goes to ``log``."""

    def __init__(self, log: Path) -> None:
        self._log = log
        environment = os.environ | dict.fromkeys(PINNED, "1")
        # PETSc would turn a crash into an exit code of its own
        options = os.environ.get("PETSC_OPTIONS", "")
        environment["PETSC_OPTIONS"] = f"{options} -no_signal_handler".strip()
        package = str(Path(__file__).resolve().parents[3])
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))
        with log.open("w") as said:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "masonry_fem.analyses.cells.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
                start_new_session=True,  # Ctrl-C is the search's to answer
                env=environment,
            )
        self._ready = False

    @property
    def alive(self) -> bool:
        """Whether it can take another cell."""
        return self._process.poll() is None

    def compute(
        self, cell: Cell, base: Path, folder: Path, limit: float | None, task: str = "measure"
    ) -> dict[str, Any]:
        """Compute a cell here and wait for it.

        Parameters
        ----------
        cell : What to compute. base : Folder that the paths in its scene are relative to.
        folder : Where its row goes. limit : CPU time that it may take [s]; None: no limit.
        task : What is done with its scene.
        """
        out, log = folder / f"{cell.key}.json", folder / f"{cell.key}.log"
        out.unlink(missing_ok=True)
        if not self._ready:
            self._answer()
            self._ready = True
        request = {
            "scene": cell.scene,
            "base": str(base.resolve()),
            "out": str(out.resolve()),
            "log": str(log.resolve()),
            "limit": limit,
            "task": task,
        }
        late = threading.Event()

        def give_up() -> None:
            late.set()
            self.end()

        guard = None if limit is None else threading.Timer(SLACK * limit + PATIENCE, give_up)
        if guard is not None:
            guard.start()
        begun = time.monotonic()
        try:
            assert self._process.stdin is not None
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
            answer = self._answer()
        except OSError:  # the guard, or something from outside, ended it
            answer = {"signal": 0, "code": -1, "cpu": 0.0, "peak_memory_mb": 0.0, "loaded": 0.0}
            answer["late"] = late.is_set()
        finally:
            if guard is not None:
                guard.cancel()
        row = _row(answer, out, log, limit) | {"wall": round(time.monotonic() - begun, 3)}
        write(out, row)
        return row

    def end(self) -> None:
        """Kill the process and its fork."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            said = self._log.read_text(errors="replace").strip().splitlines()
            raise OSError(said[-1] if said else "ended without a word")
        answer: dict[str, Any] = json.loads(line)
        return answer


def _row(answer: dict[str, Any], out: Path, log: Path, limit: float | None) -> dict[str, Any]:
    """What a cell left, with what the kernel says of it."""
    measured = {"peak_memory_mb": round(answer["peak_memory_mb"], 1)}
    # it may have been ended from outside just after it had written what it found
    if answer["signal"] == 0 and answer["code"] in (0, -1) and out.exists():
        row: dict[str, Any] = json.loads(out.read_text(encoding="utf-8"))
        row["start"] = row.get("start", 0.0) + answer["loaded"]
        return row | measured
    measured |= {"cpu": answer["cpu"], "limit": limit or 0.0}
    if answer["signal"]:
        name = signal.Signals(answer["signal"]).name
        unknown = ("failed", f"crashed with {name}; what it said is in {log.name}")
        outcome, words = KILLED.get(signal.Signals(answer["signal"]), unknown)
        return {"outcome": outcome, "message": words.format(limit=limit or 0.0), **measured}
    if answer["code"] == -1:
        if answer["late"]:
            return {"outcome": "time_limit", "message": "did not end, without using its CPU time", **measured}
        return {"outcome": "failed", "message": "its worker was killed from outside", **measured}
    last = log.read_text(errors="replace").strip().splitlines() if log.exists() else []
    return {"outcome": "failed", "message": last[-1] if last else "ended without a word", **measured}
