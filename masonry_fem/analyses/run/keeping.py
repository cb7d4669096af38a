"""Keeping: when a run writes a checkpoint.

keeper = Keeper.of(scene, base, out, recorders, remarks)      # None where the scene asks for none
keeper.begin()
march(..., keeper=keeper)
keeper.end("finished")
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Self

from masonry_fem.march.standing import Standing
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, write_checkpoint
from masonry_fem.output.recorder import Recorders
from masonry_fem.records.remark import Remark
from masonry_fem.scene import dumps, specs
from masonry_fem.scene.writing import moved


class Keeper:
    """Writes checkpoints of a run.

    Parameters
    ----------
    scene : What is run, as TOML, with paths relative to the results folder.
    path : Of the checkpoint.
    recorders : Whose memory is saved, too.
    remarks : Made so far; grows.
    steps : Steps between two checkpoints; None: not by steps.
    interval : Time between two of them [s]; None: not by time.
    """

    def __init__(
        self, scene: str, path: Path, recorders: Recorders, remarks: Sequence[Remark], steps: int | None,
        interval: float | None,
    ) -> None:  # fmt: skip
        self.path, self._scene, self._recorders, self._remarks = path, scene, recorders, remarks
        self._steps, self._interval = steps, interval
        self._last = time.monotonic()
        self._end: Checkpoint | None = None

    @classmethod
    def of(
        cls, scene: specs.Scene, base: Path, out: Path, recorders: Recorders, remarks: Sequence[Remark]
    ) -> Self | None:
        """As a scene asks for; None where it asks for none.

        Parameters
        ----------
        scene : What is run, as it was given. base : Folder that its paths are relative to.
        out : Results folder.
        recorders : Of the run. remarks : Made so far; grows.
        """
        asked = scene.output
        if asked.checkpoint_steps is None and asked.checkpoint_time is None:
            return None
        text = dumps(moved(scene, base, out))
        return cls(text, out / CHECKPOINT, recorders, remarks, asked.checkpoint_steps, asked.checkpoint_time)

    def begin(self) -> None:
        """Write that no step is made yet."""
        write_checkpoint(self.path, self._checkpoint(None))

    def between(self, standing: Standing) -> None:
        """Write what a march knows between two steps, where it is time."""
        due = self._steps is not None and standing.done % self._steps == 0
        if due or (self._interval is not None and time.monotonic() - self._last >= self._interval):
            write_checkpoint(self.path, self._checkpoint(standing))
            self._last = time.monotonic()

    def reached(self, standing: Standing | None) -> None:
        """Keep what a march knows at its end: it is written once all else is, as a kill may come before."""
        self._end = None if standing is None else self._checkpoint(standing)

    def end(self, outcome: str) -> Path:
        """Write where the run ended, if more steps can be made from there."""
        if self._end is not None:
            write_checkpoint(self.path, replace(self._end, outcome=outcome))
        return self.path

    def _checkpoint(self, standing: Standing | None) -> Checkpoint:
        saved = {} if standing is None else self._recorders.saved()
        return Checkpoint(self._scene, "", standing, saved, tuple(self._remarks))
