"""Console: what a command says, complaints on standard error."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


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
