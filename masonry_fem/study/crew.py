"""Crew: workers side by side, as many as cores and memory allow.

    with Crew(workers=2, limit=60.0) as crew:
        for cell, answer in crew.compute(cells, base=base, folder=folder):
            ...

A cell that crashes, runs out of memory or of time, takes at most its worker with it.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Self

from masonry_fem.errors import MasonryError
from masonry_fem.study.cell import Cell

PINNED = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")
SLACK = 3.0  # wall-clock time over the CPU time that a cell may have: others use the machine, too ...
PATIENCE = 30.0  # ... and what its start may take besides [s]
FIRST = 600.0  # memory that a cell is taken to need before any has told [MB]
GROWTH = 2.0  # memory of a finer cell over that of the largest so far
KILLED = {
    signal.SIGKILL: ("out_of_memory", "the system killed it, most likely for want of memory"),
    signal.SIGXCPU: ("time_limit", "took more than {limit:g} s of CPU time (--time-limit)"),
}


class Crew:
    """Workers and what is known of the memory that cells need.

    Parameters
    ----------
    workers : Cells at a time; None: as many as there are cores.
    limit : CPU time of a cell [s]; None: none.
    """

    def __init__(self, workers: int | None = None, limit: float | None = None) -> None:
        if workers is not None and workers < 1:
            raise MasonryError(f"workers is {workers}, expected at least 1")
        if limit is not None and not limit > 0:
            raise MasonryError(f"time limit is {limit:g} s, expected a positive time")
        self.workers, self.limit = workers or cores(), limit
        self._idle: list[_Worker] = []
        self._peak = 0.0

    def __enter__(self) -> Self:
        """Nothing is started before it is needed."""
        return self

    def __exit__(self, *_: object) -> None:
        """End all workers."""
        for worker in self._idle:
            worker.end()
        self._idle.clear()

    def compute(
        self, cells: Sequence[Cell], *, base: Path, folder: Path
    ) -> Iterator[tuple[Cell, dict[str, Any]]]:
        """Compute cells and give each with its row as it comes; rows stand in ``folder`` as KEY.json."""
        waiting, busy = list(cells), dict[threading.Thread, _Worker]()
        done: queue.Queue[tuple[threading.Thread, Cell, dict[str, Any]]] = queue.Queue()
        try:
            while waiting or busy:
                while waiting and len(busy) < self.workers and self._fits(len(busy)):
                    worker = self._idle.pop() if self._idle else _Worker(folder / "worker.log")
                    thread = self._start(worker, waiting.pop(0), base, folder, done)
                    busy[thread] = worker
                thread, cell, row = done.get()
                worker = busy.pop(thread)
                if worker.alive:
                    self._idle.append(worker)
                else:
                    worker.end()
                self._peak = max(self._peak, row.get("peak_memory_mb", 0.0))
                yield cell, row
        finally:
            for worker in busy.values():
                worker.end()

    def _start(
        self, worker: _Worker, cell: Cell, base: Path, folder: Path, done: queue.Queue[Any]
    ) -> threading.Thread:
        def work() -> None:
            try:
                row = worker.compute(cell, base, folder, self.limit)
            except Exception as error:
                worker.end()
                row = {"outcome": "failed", "message": f"its worker: {type(error).__name__}: {error}"}
            done.put((threading.current_thread(), cell, row))

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        return thread

    def _fits(self, running: int) -> bool:
        """Whether the memory that is left holds another cell; one cell runs in any case."""
        if not running:
            return True
        import psutil  # noqa: PLC0415 - only a study asks

        need = max(FIRST, GROWTH * self._peak)
        return bool(psutil.virtual_memory().available / 2**20 > need)


class _Worker:
    """One worker process."""

    def __init__(self, log: Path) -> None:
        self._log = log
        environment = os.environ | dict.fromkeys(PINNED, "1")
        # PETSc would turn a crash into an exit code of its own
        options = os.environ.get("PETSC_OPTIONS", "")
        environment["PETSC_OPTIONS"] = f"{options} -no_signal_handler".strip()
        package = str(Path(__file__).resolve().parents[2])
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))
        with log.open("w") as said:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "masonry_fem.study.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
                start_new_session=True,  # Ctrl-C is the study's to answer
                env=environment,
            )
        self._ready = False

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    def compute(self, cell: Cell, base: Path, folder: Path, limit: float | None) -> dict[str, Any]:
        """Compute a cell here and wait for it."""
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
            answer = {"signal": 0, "code": -1, "cpu": 0.0, "peak_memory_mb": 0.0, "late": late.is_set()}
        finally:
            if guard is not None:
                guard.cancel()
        row = _row(answer, out, log, limit) | {"wall": round(time.monotonic() - begun, 3)}
        from masonry_fem.post.summary import write_summary  # noqa: PLC0415 - not on the path of --help

        write_summary(out, row)
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


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _row(answer: dict[str, Any], out: Path, log: Path, limit: float | None) -> dict[str, Any]:
    """What a cell left, with what the kernel says of it."""
    measured = {"peak_memory_mb": round(answer["peak_memory_mb"], 1)}
    if answer["signal"] == 0 and answer["code"] == 0 and out.exists():
        row: dict[str, Any] = json.loads(out.read_text(encoding="utf-8"))
        if row["outcome"] != "failed":
            log.unlink(missing_ok=True)
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
