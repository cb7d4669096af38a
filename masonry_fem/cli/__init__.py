"""Command line ``masonry-fem``: one file per command, each with a few calls into the package.

A command's function ``add(commands, parents)`` adds its parser to ``commands``; ``parents`` has the options
that commands share, and ``EXAMPLES`` of the file stand in its help. Exit codes are explained in
``console``. Heavy libraries are imported within functions, so that ``--help`` does not wait for them.
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path

import masonry_fem
from masonry_fem.cli import (
    check,
    collapse,
    compile,
    completion,
    contact,
    explain,
    export,
    info,
    limit,
    mesh,
    new,
    report,
    resume,
    run,
    study,
    threshold,
    view,
)
from masonry_fem.cli.console import (
    BAD_INPUT,
    INTERRUPTED,
    PIPE_CLOSED,
    WORDS,
    Fitted,
    complain,
    speak_readably,
)
from masonry_fem.cli.grammar import Parser, epilog, parents
from masonry_fem.cli.signals import answered, behind
from masonry_fem.errors import MasonryError
from masonry_fem.host import ranks
from masonry_fem.host.memory import left_at_exit

__all__ = ["main", "parser"]

ROOM = str(Path(masonry_fem.__file__).parent)
COMMANDS = (
    new,
    run,
    resume,
    check,
    limit,
    collapse,
    threshold,
    study,
    mesh,
    view,
    report,
    export,
    contact,
    compile,
    explain,
    completion,
    info,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; errors become one line on standard error."""
    speak_readably()
    left_at_exit()
    # otherwise PETSc would print a crash report when a pipe is closed or the process is ended
    asked = os.environ.get("PETSC_OPTIONS", "").split()
    if "-no_signal_handler" not in asked:
        os.environ["PETSC_OPTIONS"] = " ".join([*asked, "-no_signal_handler"])
    os.environ.setdefault("UCX_DEBUG_SIGNO", "0")  # MPI's transport would take SIGHUP for a wish to debug it
    log = logging.StreamHandler()
    log.setFormatter(Fitted("%(levelname)s: %(message)s"))
    logging.basicConfig(handlers=[log])
    try:
        if ranks.join():
            return 0  # this rank has worked for the one that leads
    except MasonryError as error:
        complain(str(error))
        return BAD_INPUT
    code = BAD_INPUT
    try:
        code = _led(arguments)
    finally:
        ranks.team().end(code)
    return code


def _led(arguments: Sequence[str] | None) -> int:
    """Run one command; its exit code."""
    options = parser().parse_args(arguments)
    if getattr(options, "no_color", False):
        os.environ["NO_COLOR"] = "1"  # what prints asks for it
    told = logging.DEBUG if options.debug else logging.INFO if options.verbose else logging.WARNING
    logging.getLogger("masonry_fem").setLevel(told)
    logging.getLogger("masonry_fem.host.compiled").setLevel(logging.INFO)  # nobody waits without knowing why
    with answered() as received:
        code = _answer(options)
    return 128 + received.number if code == INTERRUPTED else code


def _answer(options: argparse.Namespace) -> int:
    """Run the command; its exit code."""
    try:
        _refuse_ranks(options)
        with _shown(options):
            code: int = options.command(options)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt as error:
        return _interrupted(options, error)
    # the reader of our output has closed it, as in "masonry-fem run ... | head"; rich then ends the program
    except (BrokenPipeError, SystemExit):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python complains at its end
        return PIPE_CLOSED
    except Exception as error:
        if (signal := behind(error)) is not None:
            return _interrupted(options, signal)
        if options.debug:
            raise
        complain(_sentence(error))
    return BAD_INPUT


def _interrupted(options: argparse.Namespace, error: KeyboardInterrupt) -> int:
    """Say that a command was ended from outside; its exit code."""
    out = getattr(options, "out", None)
    kept = f"; what was written so far is in {out}" if out and out.exists() else ""
    complain(f"interrupted{f' by {error}' if str(error) else ''}{kept}")
    return INTERRUPTED


@contextlib.contextmanager
def _shown(options: argparse.Namespace) -> Iterator[None]:
    """Lines on a terminal with what is being done."""
    if getattr(options, "quiet", True) or not sys.stderr.isatty():
        yield
        return
    from masonry_fem.output.display import shown  # noqa: PLC0415 - not on the path of --help

    with shown(True):
        yield


def _refuse_ranks(options: argparse.Namespace) -> None:
    """Refuse a command of which several ranks would do nothing.

    Raises
    ------
    MasonryError : It is one.
    """
    count = ranks.team().size
    if count > 1 and options.command is not run.run_scene:
        raise MasonryError(
            f"started as {count} ranks, but 'run' is the only command whose work is split among ranks; start "
            "this one without mpiexec"
        )


def _sentence(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, MasonryError | OSError):
        return str(error)
    if isinstance(error, MemoryError):
        return (
            "memory is not enough for this scene; 'masonry-fem check' tells what a run needs: "
            "take fewer or larger elements (mesh.size), make blocks rigid, or allow more"
        )
    # a defect of this program, or of a file that was added to it
    what = f"{type(error).__name__}: {error}{_place(error)}"
    return f"unexpected {what}; run again with --debug for the details"


def _place(error: Exception) -> str:
    """The last line that an error came through, libraries left out."""
    if isinstance(error, SyntaxError):
        return ""  # it names its file itself
    for file, line, *_ in reversed(traceback.extract_tb(error.__traceback__)):
        if file.startswith(ROOM) or not file.startswith((sys.prefix, sys.base_prefix, "<")):
            return f" ({file}, line {line})"
    return ""


def parser() -> Parser:
    """The command line's grammar."""
    top = Parser(
        prog="masonry-fem",
        description="Mechanics of block masonry: finite-element stones, true frictional joints.",
        epilog=epilog((), WORDS),
    )
    top.add_argument("--version", action="version", version=f"masonry-fem {masonry_fem.__version__}")
    commands = top.add_subparsers(required=True, metavar="COMMAND")
    shared = parents()
    for command in COMMANDS:
        command.add(commands, shared)
    for own, command in zip(commands.choices.values(), COMMANDS, strict=True):
        said = str(command.__doc__).partition(": ")[2].partition("\n")[0]
        own.description = said[:1].upper() + said[1:]
        own.epilog = epilog(command.EXAMPLES, WORDS)
    return top
