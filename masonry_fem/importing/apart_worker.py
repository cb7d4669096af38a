"""Apart worker: the process that does what ``apart`` asks for.

python -m masonry_fem.importing.apart_worker      # a request on standard input, answers on output
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import pickle
import resource
import sys
import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Any, BinaryIO

import psutil

from masonry_fem.errors import MasonryError
from masonry_fem.importing.apart import TOO_LARGE, Answer
from masonry_fem.records.remark import gathered
from masonry_fem.records.structure import Reading

SLACK = 5.0  # CPU time beyond the limit [s]; normally the caller ends this process first


class _Log(logging.Handler):
    """Keeps log messages."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[tuple[str, int, str]] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append((record.name, record.levelno, record.getMessage()))


def serve() -> None:
    """Answer one request; anything else that is printed is discarded."""
    limits, errands = pickle.load(sys.stdin.buffer)
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as answers:  # programs that are run do not inherit it
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream in (sys.stdin, sys.stdout, sys.stderr):
            os.dup2(nothing, stream.fileno())
        _limit(limits)
        for function, arguments in errands:
            answer = _answer(function, arguments, limits)
            _write(answers, answer)
            if answer.error or answer.fault:
                return


def _limit(limits: Reading) -> None:
    """Bound the memory that is taken from now on and the time, where the system can."""
    room = psutil.Process().memory_info().data + limits.memory  # loaded libraries do not count
    for kind, value in (
        (resource.RLIMIT_DATA, room),
        (resource.RLIMIT_CPU, limits.time + SLACK),
        (resource.RLIMIT_CORE, 0.0),  # crashes are expected here
    ):
        _, most = resource.getrlimit(kind)
        bound = math.ceil(min(value, 2.0**62))
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(kind, (bound if most == resource.RLIM_INFINITY else min(bound, most), most))


def _answer(function: Callable[..., Any], arguments: tuple[Any, ...], limits: Reading) -> Answer:
    log, ours = _Log(), logging.getLogger("masonry_fem")
    ours.setLevel(logging.DEBUG)
    ours.addHandler(log)
    try:
        with gathered(aloud=False) as remarks:  # they are logged where they are made again
            answer = _tried(function, arguments, limits)
    finally:
        ours.removeHandler(log)
    return replace(answer, said=tuple(log.said), remarks=tuple(remarks))


def _tried(function: Callable[..., Any], arguments: tuple[Any, ...], limits: Reading) -> Answer:
    """What a function returns, or how it failed."""
    try:
        return Answer(result=function(*arguments))
    except MasonryError as error:
        return Answer(error=type(error)(*error.args))
    except MemoryError:
        return Answer(fault=TOO_LARGE.format(memory=limits.memory))
    except Exception as error:
        fault = (
            f"could not be read, {type(error).__name__}: {error}; it is damaged or holds what its reader "
            "does not foresee: export it again in the program that wrote it, or report it"
        )
        return Answer(fault=fault, trace=traceback.format_exc())


def _write(answers: BinaryIO, answer: Answer) -> None:
    pickle.dump(answer, answers, protocol=pickle.HIGHEST_PROTOCOL)
    answers.flush()


if __name__ == "__main__":
    serve()
