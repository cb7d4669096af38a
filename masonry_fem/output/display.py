"""Display: a terminal's lines with what is being done, how much of it, and for how much longer.

    with Display() as display, heard(display):
        run(scene, out)

Each phase that takes more than a second has a line on standard error; all go when it ends. Where standard
error is no terminal nothing is shown.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Self

from masonry_fem.host.phases import heard, listener

if TYPE_CHECKING:
    from rich.console import Console

    from masonry_fem.host.phases import At

DELAY = 1.0  # seconds of a phase until its line is shown
WIDTH = 16  # columns of a bar


@contextmanager
def shown(wanted: bool) -> Iterator[None]:
    """Show phases on standard error, if it is a terminal and nobody listens to them yet.

    Parameters
    ----------
    wanted : Whether to.
    """
    if not wanted or listener() is not None:
        yield
        return
    with Display() as display, heard(display):
        yield


class Display:
    """Shows phases; a ``Listener``.

    Parameters
    ----------
    console : Where to write; by default standard error.
    delay : Seconds of a phase until its line is shown.
    """

    def __init__(self, console: Console | None = None, delay: float = DELAY) -> None:
        self._console, self._delay = console, delay
        self._lock = threading.RLock()
        self._open: dict[At, Any] = {}
        self._bars: Any = None
        self._timer: threading.Timer | None = None
        self._live = False

    def __enter__(self) -> Self:
        """Be ready."""
        from rich.console import Console  # noqa: PLC0415 - not on the path of --help

        console = self._console or Console(stderr=True)
        if console.is_terminal:
            self._bars = _bars(console, self._delay)
        return self

    def __exit__(self, *_: object) -> None:
        """Take all lines away."""
        with self._lock:
            self._open.clear()
            self._rest()

    def begin(self, what: str, total: float | None) -> At:
        """A phase has begun.

        Parameters
        ----------
        what : Is done. total : How much of it there is; None: not known.
        """
        if self._bars is None:
            return _unseen
        task = self._bars.add_task(what, total=total, note="")

        def at(done: float, note: str = "", total: float | None = None) -> None:
            self._bars.update(task, completed=done, note=note, total=total)

        with self._lock:
            self._open[at] = task
            if not self._live and self._timer is None:
                self._timer = threading.Timer(self._delay, self._show)
                self._timer.daemon = True
                self._timer.start()
        return at

    def end(self, at: At) -> None:
        """The phase has ended that ``begin`` gave this for."""
        with self._lock:
            task = self._open.pop(at, None)
            if task is None:
                return
            if not self._open:  # what is printed next shall not get into the lines
                self._rest()
            self._bars.remove_task(task)

    def _show(self) -> None:
        with self._lock:
            self._timer = None
            if self._open and not self._live:
                self._live = True
                self._bars.start()

    def _rest(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._live:
            self._live = False
            self._bars.stop()


def _bars(console: Console, delay: float) -> Any:
    """Lines of all phases that are older than ``delay``."""
    from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn  # noqa: PLC0415
    from rich.table import Column  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    class Time(ProgressColumn):
        """How long it has taken, and about how long what is left would at that speed."""

        def render(self, task: Any) -> Text:
            spent = task.elapsed or 0.0
            words = span(spent)
            if task.total and 0 < task.completed < task.total:
                took = task.fields.get("took") or spent
                left = took / task.completed * (task.total - task.completed) - (spent - took)
                words += f", about {span(max(left, 0.0))} left"
            return Text(words)

    class Bars(Progress):
        """Lines of what takes long; the last time something was done counts for what is left."""

        def update(self, task_id: Any, **changes: Any) -> None:
            super().update(task_id, took=self._tasks[task_id].elapsed, **changes)

        def make_tasks_table(self, tasks: Any) -> Any:
            return super().make_tasks_table([task for task in tasks if (task.elapsed or 0.0) >= delay])

    columns = (  # where it is narrow the note has a second line, nothing else
        TextColumn("{task.description}", markup=False),
        BarColumn(WIDTH, table_column=Column(no_wrap=True)),
        Time(Column(no_wrap=True)),
        TextColumn("{task.fields[note]}", markup=False, table_column=Column()),
    )
    return Bars(*columns, console=console, transient=True, redirect_stdout=False)


def _unseen(done: float, note: str = "", total: float | None = None) -> None:
    pass


def span(seconds: float) -> str:
    """A time in words: ``8 s``, ``3 min 20 s``, ``2 h 5 min``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
