"""Worker: a process that computes cells, each in a fork of its own.

    python -m masonry_fem.analyses.cells.worker   # a request a line on standard input, an answer on output

What every cell needs is loaded once, compiled code included; the forks begin with it. So a cell's CPU time
and peak memory are its own, told by the kernel even where the cell crashes, and a crash ends nothing else.
DOLFINx and MPI, which do not survive a fork, are loaded within it, before the clock starts.
"""

from __future__ import annotations

import faulthandler
import json
import logging
import math
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from masonry_fem.errors import MasonryError

TINY = """
dimension = {dimension}
fidelity = "{fidelity}"
mesh = {{ divisions = {divisions} }}
structures = [{{ kind = "stack", name = "s", material = "stone", size = {size}, count = 2 }}]
loads = {{ gravity = {gravity} }}
[materials.stone]
density = 2000
young = 1e9
inelastic = {{ law = "brittle_damage", tensile_strength = 1e6, fracture_energy = 1e6 }}
"""
SHORT = 2.0  # CPU time below which a cell is run twice [s]
Task = Callable[[Any, Path], dict[str, Any]]
LOST = 64  # exit code of a cell whose own error could not be told


def serve() -> None:
    """Answer requests until the input ends: scene (TOML), base, out, log, limit and task of a cell."""
    from masonry_fem.fidelities import fidelities  # noqa: PLC0415

    for dimension in (2, 3):
        _warm(dimension, next(iter(fidelities())))
    loaded = time.process_time()
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", buffering=1)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # answers are all that may stand there
    print(json.dumps({"ready": os.getpid()}), file=answers)
    for line in sys.stdin:
        request = json.loads(line)
        child = os.fork()
        if child == 0:
            _in_fork(request)
        _, status, used = os.wait4(child, 0)
        answer = {
            "loaded": loaded,
            "signal": os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0,
            "code": os.WEXITSTATUS(status) if os.WIFEXITED(status) else 0,
            "cpu": used.ru_utime + used.ru_stime,
            "peak_memory_mb": used.ru_maxrss / (1024**2 if sys.platform == "darwin" else 1024),
        }
        print(json.dumps(answer), file=answers)


def _in_fork(request: dict[str, Any]) -> None:
    """Compute a cell and end the fork, whatever comes: nothing of the server's may run here again."""
    code = LOST
    try:
        log = os.open(request["log"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(log, 1)
        os.dup2(log, 2)
        faulthandler.enable()
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        row = compute(request["scene"], Path(request["base"]), request["limit"], request["task"])
        _write(Path(request["out"]), row)
        if row["outcome"] != "failed":  # here, as whoever asked may have been killed by now
            Path(request["log"]).unlink(missing_ok=True)
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def compute(text: str, base: Path, limit: float | None, task: str = "measure") -> dict[str, Any]:
    """Run a scene and tell what the task asks for and its costs; a failure is an outcome, too.

    Parameters
    ----------
    text : The scene as TOML. base : Folder that the paths in it are relative to.
    limit : CPU time after which the kernel ends the process [s]; None: no limit.
    task : ``measure`` for quantities and costs, ``shake`` for demands of a record.
    """
    from masonry_fem.fidelities import deforms  # noqa: PLC0415 - with the rest, after the fork
    from masonry_fem.records.remark import gathered  # noqa: PLC0415
    from masonry_fem.scene import loads  # noqa: PLC0415

    scene = loads(text, base=base, source="scene of the cell")
    for fidelity in scene.fidelities:
        if deforms(fidelity):
            logging.disable()
            _warm(scene.dimension, fidelity)
            logging.disable(logging.NOTSET)
    start, cpu = time.process_time(), 0.0
    if limit is not None:
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(start + min(limit, SHORT) + limit), hard))
    run = TASKS[task]
    with gathered() as remarks:
        try:
            row, cpu, compiled = _timed(run, scene, base)
            start += compiled
            if (
                cpu < SHORT and run is _measure
            ):  # loading of compiled code is a large part of it: the second time it is not
                first = cpu
                row, cpu, _ = _timed(run, scene, base)
                start += max(first - cpu, 0.0)
        except MasonryError as error:
            row = {"outcome": "refused", "message": str(error)}
        except MemoryError:
            row = {"outcome": "out_of_memory", "message": "the memory was not enough"}
        except Exception as error:
            traceback.print_exc()
            row = {"outcome": "failed", "message": f"unexpected {type(error).__name__}: {error}"}
    return row | {
        "cpu": cpu or time.process_time() - start,
        "start": start,
        "warnings": list(dict.fromkeys(one.sentence for one in remarks)),
    }


def _timed(run: Task, scene: Any, base: Path) -> tuple[dict[str, Any], float, float]:
    """A row, and CPU times: of the run, and of compilation, which only the first cell of all pays for [s]."""
    from numba.core import event  # noqa: PLC0415

    class Compiling(event.Listener):
        depth, seconds = 0, 0.0

        def on_start(self, event: Any) -> None:
            self.seconds -= 0.0 if self.depth else time.process_time()
            self.depth += 1

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            self.seconds += 0.0 if self.depth else time.process_time()

    compiling, start = Compiling(), time.process_time()
    with event.install_listener("numba:compile", compiling):
        row = run(scene, base)
    return row, time.process_time() - start - compiling.seconds, compiling.seconds


def _measure(scene: Any, base: Path) -> dict[str, Any]:
    from masonry_fem.analyses.run import solve_scene  # noqa: PLC0415
    from masonry_fem.analyses.study.peak import Peaks  # noqa: PLC0415
    from masonry_fem.analyses.study.quantity import measured  # noqa: PLC0415
    from masonry_fem.records.told import plain  # noqa: PLC0415

    peaks = Peaks(scene.dimension)
    result = solve_scene(scene, base, [peaks])
    summary = plain(result.summary)
    measures = summary["certificate"]
    measures["rounding"] = measures["rounding"]["natural_map"]
    sizes = ("blocks", "shapes", "interfaces", "contacts", "unknowns", "steps")
    return {
        "outcome": result.outcome,
        "message": result.message,
        "seconds": summary["seconds"],
        "size": {name: summary[name] for name in sizes},
        "certificate": {name: value for name, value in measures.items() if name != "written"},
        "solver": summary["solver"],
        "peaks": peaks.told(),
        "yielded": (summary.get("stress") or {}).get("yielded") or [],
        "quantities": {name: quantity.told() for name, quantity in measured(result).items()},
    }


def _shake(scene: Any, base: Path) -> dict[str, Any]:
    from masonry_fem.analyses.incremental.demand import shaken  # noqa: PLC0415

    return shaken(scene, base)


TASKS: dict[str, Task] = {"measure": _measure, "shake": _shake}


def _warm(dimension: int, fidelity: str) -> None:
    """Run two blocks, so that libraries and compiled code are loaded."""
    from masonry_fem.analyses.run import solve_scene  # noqa: PLC0415
    from masonry_fem.scene import loads  # noqa: PLC0415

    ones = [1] * dimension
    text = TINY.format(
        dimension=dimension,
        fidelity=fidelity,
        divisions=ones,
        size=ones,
        gravity=[0] * (dimension - 1) + [-9.81],
    )
    solve_scene(loads(text))


def _write(path: Path, row: dict[str, Any]) -> None:
    from masonry_fem.records.told import write  # noqa: PLC0415

    write(path, row)


if __name__ == "__main__":
    serve()
