"""Console: what a command says, complaints on standard error, and exit codes for scripts."""

from __future__ import annotations

import argparse
import codecs
import logging
import os
import shutil
import sys
import textwrap
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

BAD_INPUT = 1
INTERRUPTED = 130
PIPE_CLOSED = 141
COLLAPSE_CODES = {
    "bracketed": 0,
    "unlimited": 0,
    "undecided": 2,
    "falls at the start": 3,
    "interrupted": INTERRUPTED,
}
THRESHOLD_CODES = {
    "bracketed": 0,
    "undecided": 2,
    "stands at both ends": 2,
    "falls at both ends": 3,
    "interrupted": INTERRUPTED,
}
EXIT_CODES = {"equilibrium": 0, "finished": 0, "no_convergence": 2, "no_equilibrium": 3}
WORDS = (
    ("0", "equilibrium or finished (collapse, threshold: bracketed; limit: the loads can be carried)"),
    ("1", "bad input, or a file that cannot be read or written"),
    (
        "2",
        "no convergence (collapse: undecided; threshold: undecided, or it stands at both ends; --refine-to: "
        "not reached; study: no run solved or decided)",
    ),
    (
        "3",
        "no equilibrium (collapse: falls at the first multiplier; threshold: falls at both ends; limit: the "
        "loads cannot be carried)",
    ),
    ("129, 130, 143", "ended by SIGHUP, Ctrl-C, SIGTERM; files written so far can be read"),
    ("141", "the program that read the output has ended"),
)  # exit codes

NARROW = 72  # columns: narrower tables would cut off figures
PLAIN = {
    "–": "-", "—": "-", "−": "-", "×": "x", "·": ".", "•": "*", "…": "...", "°": " deg", "∞": "inf",
    "≤": "<=", "≥": ">=", "≈": "~", "±": "+-", "→": "->", "√": "sqrt", "µ": "u", "“": '"', "”": '"',
    "‘": "'", "’": "'", "ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "œ": "oe", "ł": "l", "đ": "d",
}  # fmt: skip  # what Unicode does not take apart itself


def speak_readably() -> None:
    """Let output go to any terminal: signs that it lacks become plain, a narrow one wraps lines."""
    codecs.register_error("readable", _plain)
    width = shutil.get_terminal_size().columns
    if "COLUMNS" in os.environ or width < NARROW:
        os.environ["COLUMNS"] = str(max(width, NARROW))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="readable")


def _plain(error: UnicodeError) -> tuple[str, int]:
    """Plain signs in the place of those that an encoding lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(map(_plain_sign, signs)), error.end


def _plain_sign(sign: str) -> str:
    apart = unicodedata.normalize("NFKD", PLAIN.get(sign, sign))
    plain = "".join(part for part in apart if part.isascii())
    if plain or not sign.isprintable():
        return plain or "?"
    # GREEK SMALL LETTER MU: its last word is what one would say
    name = unicodedata.name(sign, "")
    return name.rpartition(" ")[2].lower() if name.startswith("GREEK") else "?"


def complain(sentence: str) -> None:
    """One line on standard error."""
    print(fitted(f"masonry-fem: {sentence}"), file=sys.stderr)


def fitted(text: str) -> str:
    """The text with lines broken between words on a terminal, and whole for files and pipes."""
    if not sys.stderr.isatty():
        return text
    width = shutil.get_terminal_size().columns
    return "\n".join(
        textwrap.fill(line, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
        if len(line) > width
        else line
        for line in text.split("\n")
    )


class Fitted(logging.Formatter):
    """Messages of the log, fitted to the terminal."""

    def format(self, record: logging.LogRecord) -> str:
        """The record as text."""
        return fitted(super().format(record))


def conclude(
    options: argparse.Namespace, told: Any, files: Sequence[Path], show: Callable[[Any], None], code: int
) -> int:
    """Say what a search found, and complain where it found nothing; the exit code again.

    Parameters
    ----------
    options : What was asked: ``json``, ``quiet``.
    told : What was found, with its ``message``. files : That were written.
    show : Prints it for people. code : Exit code; 0 where all is well.
    """
    from masonry_fem.records.told import text  # noqa: PLC0415 - not on the path of --help

    if options.json:
        print(text(told))
    elif not options.quiet:
        show(told)
        print_files(files)
    if code:
        complain(told.message)
    return code


def conclude_run(options: argparse.Namespace, result: Any) -> int:
    """Say how a run ended; its exit code.

    Parameters
    ----------
    options : What was asked: ``quiet``. result : Of the run.
    """
    code = EXIT_CODES.get(result.outcome, BAD_INPUT)
    if not options.quiet:
        from masonry_fem.output.terminal import print_summary  # noqa: PLC0415 - not on the path of --help
        from masonry_fem.records.told import plain  # noqa: PLC0415

        # errors are printed once, at the end, on standard error
        print_summary(plain(result.summary) | ({"message": ""} if code else {}))
        print_files(result.files)
    if code:
        complain(result.message)
    return code


def print_files(files: Sequence[Path]) -> None:
    """Name the files that were written."""
    for file in files:
        print(f"wrote {file}")


def print_table(facts: Mapping[str, Any]) -> None:
    """Names and values in two columns; nested facts indented under theirs."""
    from rich.console import Console  # noqa: PLC0415 - not on the path of --help
    from rich.table import Table  # noqa: PLC0415

    table = Table(box=None, show_header=False, pad_edge=False)
    for name, value in facts.items():
        if isinstance(value, Mapping):
            table.add_row(name.replace("_", " "), "")
            for inner, number in value.items():
                table.add_row(f"  {inner}", _text(number))
        else:
            table.add_row(name.replace("_", " "), _text(value))
    Console().print(table)


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
