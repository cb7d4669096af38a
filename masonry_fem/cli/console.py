"""Console: what a command says, complaints on standard error."""

from __future__ import annotations

import codecs
import os
import shutil
import sys
import unicodedata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

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
    print(f"masonry-fem: {sentence}", file=sys.stderr)


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
