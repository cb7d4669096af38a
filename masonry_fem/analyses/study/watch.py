"""Watch: the progress of a study on the console."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Self

from masonry_fem.host.phases import At, phase


class Watch:
    """Tells of the cells of a study as of a phase.

    with Watch() as watch:
        study(scene, vary, tell=watch.tell)
    """

    def __init__(self) -> None:
        self._phase: AbstractContextManager[At] = phase("cells")

    def __enter__(self) -> Self:
        """The study begins."""
        self._at = self._phase.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        """It has ended."""
        self._phase.__exit__(None, None, None)

    def tell(self, done: int, total: int, last: str) -> None:
        """A cell has ended."""
        self._at(done, f"{done}/{total} {last}", total)
