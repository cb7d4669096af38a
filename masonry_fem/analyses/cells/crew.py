"""Crew: workers side by side, as many as cores and memory allow.

    with Crew(workers=2, limit=60.0) as crew:
        for cell, answer in crew.compute(cells, base=base, folder=folder):
            ...

A cell that crashes, runs out of memory or of time, takes at most its worker with it.
"""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Self

from masonry_fem.analyses.cells.cell import Cell
from masonry_fem.analyses.cells.process import WorkerProcess
from masonry_fem.errors import MasonryError

FIRST = 600.0  # memory that a cell is taken to need before any has told [MB]
GROWTH = 2.0  # memory of a finer cell over that of the largest so far


class Crew:
    """Workers and what is known of the memory that cells need.

    Parameters
    ----------
    workers : Cells at a time; None: as many as there are cores.
    limit : CPU time of a cell [s]; None: none.
    task : What is done with a cell's scene, one of the worker's.
    """

    def __init__(self, workers: int | None = None, limit: float | None = None, task: str = "measure") -> None:
        if workers is not None and workers < 1:
            raise MasonryError(f"workers is {workers}, expected at least 1")
        if limit is not None and not limit > 0:
            raise MasonryError(f"time limit is {limit:g} s, expected a positive time")
        self.workers, self.limit, self.task = workers or cores(), limit, task
        self._idle: list[WorkerProcess] = []
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
        """Compute cells and give each with its row as it comes; rows stand in ``folder`` as KEY.json.

        A cell that ran out of memory beside others has another attempt, alone, when these are done.
        """
        waiting, busy = list(cells), dict[threading.Thread, WorkerProcess]()
        alone: list[Cell] = []
        done: queue.Queue[tuple[threading.Thread, Cell, dict[str, Any]]] = queue.Queue()
        try:
            while waiting or busy or alone:
                if not waiting and not busy:
                    self.workers, waiting, alone = 1, alone, []
                while waiting and len(busy) < self.workers and self._fits(len(busy)):
                    thread, worker = self._start(waiting.pop(0), base, folder, done)
                    busy[thread] = worker
                thread, cell, row = done.get()
                self._release(busy.pop(thread))
                self._peak = max(self._peak, row.get("peak_memory_mb", 0.0))
                if row["outcome"] == "out_of_memory" and self.workers > 1:
                    alone.append(cell)
                else:
                    yield cell, row
        finally:
            for worker in busy.values():
                worker.end()

    def _start(
        self, cell: Cell, base: Path, folder: Path, done: queue.Queue[Any]
    ) -> tuple[threading.Thread, WorkerProcess]:
        worker = self._idle.pop() if self._idle else WorkerProcess(folder / "worker.log")

        def work() -> None:
            try:
                row = worker.compute(cell, base, folder, self.limit, self.task)
            except Exception as error:
                worker.end()
                row = {"outcome": "failed", "message": f"its worker: {type(error).__name__}: {error}"}
            done.put((threading.current_thread(), cell, row))

        thread = threading.Thread(target=work, daemon=True)
        thread.start()
        return thread, worker

    def _release(self, worker: WorkerProcess) -> None:
        """Keep a worker for other cells, if its cell has left it alive."""
        if worker.alive:
            self._idle.append(worker)
        else:
            worker.end()

    def _fits(self, running: int) -> bool:
        """Whether the memory that is left holds another cell; one cell runs in any case."""
        if not running:
            return True
        import psutil  # noqa: PLC0415 - only searches ask

        need = max(FIRST, GROWTH * self._peak)
        return bool(psutil.virtual_memory().available / 2**20 > need)


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
