"""Apart: work on foreign files in a process of its own, within limits of time and memory.

    made = done_apart([Errand(title, build_structure, (spec, 3, base, settings))], scene.reading)

Readers of foreign files are large libraries that may crash on damaged files, and programs for gmsh may never
end. Neither affects the caller, who gets either data or an error that names the file.
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_fem.errors import GeometryError, MasonryError
from masonry_fem.records.remark import Remark, remark
from masonry_fem.records.structure import Reading

logger = logging.getLogger(__name__)

ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
TOO_LARGE = "needs more memory than reading.memory = {memory:.3g} bytes allow; raise that, or make it smaller"
TOO_LONG = "was not done within reading.time = {time:g} s; raise that, or make it smaller"


@dataclass(frozen=True, slots=True)
class Errand:
    """A piece of work.

    Attributes
    ----------
    title : The file, for messages. function : Of a module, so that another process finds it.
    arguments : What can be pickled.
    """

    title: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """What an errand came to.

    Attributes
    ----------
    said : Its log: logger, level and message. remarks : Those that it made.
    result : What the function returned. error : Or the user's error that it raised.
    fault : Or that it did not foresee, in words; "" for none. trace : Where.
    """

    said: tuple[tuple[str, int, str], ...] = ()
    remarks: tuple[Remark, ...] = ()
    result: Any = None
    error: MasonryError | None = None
    fault: str = ""
    trace: str = ""


def done_apart(errands: Sequence[Errand], limits: Reading) -> list[Any]:
    """What the errands return, in their order; one process does them all.

    Parameters
    ----------
    errands : What to call, and the title of the file that errors name.
    limits : Wall-clock time and memory for all of them.

    Raises
    ------
    MasonryError : The error of the first errand that failed, or that the process crashed or exceeded a limit.
    """
    answers, end = _answers(errands, limits)
    for errand, answer in zip(errands, answers, strict=False):
        for name, level, message in answer.said:
            logging.getLogger(name).log(level, "%s", message)
        for one in answer.remarks:
            remark(one.code, one.sentence, *one.blocks)
        if answer.error is not None:
            raise answer.error
        if answer.fault:
            logger.debug("%s", answer.trace)
            raise GeometryError(f"{errand.title} {answer.fault}")
    if len(answers) < len(errands):
        raise GeometryError(f"{errands[len(answers)].title} {end}")
    return [answer.result for answer in answers]


def _answers(errands: Sequence[Errand], limits: Reading) -> tuple[list[Answer], str]:
    """Answers as far as there are any, and why there are no more."""
    request = pickle.dumps((limits, [(one.function, one.arguments) for one in errands]))
    with tempfile.TemporaryDirectory(prefix="masonry-fem-") as folder:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "masonry_fem.importing.apart_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,  # so that it can be ended together with all that it started
            cwd=folder,
            env=_environment(folder),
        )
        try:
            told, said = process.communicate(request, timeout=limits.time)
            end = _end(process.returncode, said.decode(errors="replace"), limits)
        except subprocess.TimeoutExpired:
            _kill(process)
            told, _ = process.communicate()
            end = TOO_LONG.format(time=limits.time)
        finally:
            _kill(process)
    return _loaded(told), end


def _environment(folder: str) -> dict[str, str]:
    package = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))
    return os.environ | ONE_THREAD | {"PYTHONPATH": path, "TMPDIR": folder}


def _kill(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(
        ProcessLookupError, PermissionError
    ):  # macOS raises PermissionError if it has ended
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _loaded(told: bytes) -> list[Answer]:
    """The answers that were written to their ends."""
    stream, answers = io.BytesIO(told), []
    with contextlib.suppress(EOFError, pickle.UnpicklingError):
        while True:
            answers.append(pickle.load(stream))
    return answers


def _end(code: int, said: str, limits: Reading) -> str:
    """Why a process ended before it was done."""
    if code == -signal.SIGXCPU:
        return TOO_LONG.format(time=limits.time)
    last = [f", {line}" for line in said.strip().splitlines()[-1:]]
    how = signal.Signals(-code).name if code < 0 else "".join([f"exit code {code}", *last])
    return (
        f"crashed its reader ({how}): it is damaged, or needs more memory than reading.memory = "
        f"{limits.memory:.3g} bytes allow; open it in the program that wrote it and export it again"
    )
