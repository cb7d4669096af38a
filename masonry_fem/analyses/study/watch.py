"""Watch: the progress of a study on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from rich.console import Console


class Watch:
    """A bar on standard error with the number of finished cells.

        with Watch() as watch:
            study(scene, vary, tell=watch.tell)

    Parameters
    ----------
    quiet : Show nothing; so it is, too, if standard error is no terminal.
    console : Where to write; by default standard error.
    """

    def __init__(self, *, quiet: bool = False, console: Console | None = None) -> None:
        self._quiet, self._console = quiet, console
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Self:
        """Show an empty bar."""
        from rich.console import Console  # noqa: PLC0415 - not on the path of --help
        from rich.progress import (  # noqa: PLC0415  # noqa: PLC0415
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        console = self._console or Console(stderr=True)
        if not self._quiet and console.is_terminal:
            columns = (
                TextColumn("cells"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                TextColumn("left"), TimeRemainingColumn(), TextColumn("{task.fields[last]}"),
            )  # fmt: skip
            self._bar = Progress(*columns, console=console, transient=True)
            self._task = self._bar.add_task("", total=None, last="")
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()

    def tell(self, done: int, total: int, last: str) -> None:
        """A cell has ended."""
        if self._bar is not None:
            self._bar.update(self._task, completed=done, total=total, last=last)
