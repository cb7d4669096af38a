"""Tables: what results look like on the console: a verdict in a frame, columns, and rows under headings."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def print_verdict(console: Console, told: Mapping[str, Any], words: str, *, good: bool) -> None:
    """The verdict and the message of a result in a frame that has its title.

    Parameters
    ----------
    console : Where to write.
    told : The result. words : The verdict. good : Whether it is green.
    """
    from rich.panel import Panel  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    style = "green" if good else "red"
    head = Text(words, style=f"bold {style}").append(f"\n{told['message']}", style="default")
    console.print(Panel(head, border_style=style, title=told.get("title") or None, title_align="left"))


def columns(titles: Iterable[str], numbers: Collection[str] = (), *, gap: int = 2) -> Table:
    """A table without lines.

    Parameters
    ----------
    titles : Of its columns. numbers : Titles of those that are set to the right.
    gap : Between columns.
    """
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    table = Table(box=None, pad_edge=False, padding=(0, gap, 0, 0), header_style="dim")
    for title in titles:
        table.add_column(Text(title), justify="right" if title in numbers else "left")
    return table


def print_advice(console: Console, sentences: Iterable[tuple[str, bool]], notes: Iterable[str]) -> None:
    """Sentences behind bullets, and notes.

    Parameters
    ----------
    console : Where to write.
    sentences : Each, and whether its bullet is green. notes : What a reader should know besides.
    """
    from rich.text import Text  # noqa: PLC0415

    for words, good in sentences:
        bullet = Text("• ", style="green" if good else "yellow")
        console.print(bullet.append(words, style="default"))
    for note in notes:
        console.print(Text(f"note: {note}", style="dim"))


def print_rows(
    console: Console, parts: Iterable[Iterable[tuple[str, str, str]]], *, named: bool = True
) -> None:
    """Rows of a heading, a name and a value, with each heading once in a part.

    Parameters
    ----------
    console : Where to write.
    parts : Rows by part. named : Whether there is room for names.
    """
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    if named:
        table.add_column(style="dim", no_wrap=True)
    table.add_column()
    for part in parts:
        section = ""
        for heading, name, value in part:
            told = "" if heading == section else heading
            table.add_row(told, *([name] if named else []), Text(value))
            section = heading
    console.print(table)
