"""Keeping: when a run writes a checkpoint.

keeper = Keeper.of(scene, base, out, recorders, remarks)      # None where the scene asks for none
keeper.begin()
march(..., keep_standing=keeper)
keeper.end("finished", made.standing)
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from masonry_fem.march.standing import Standing
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, write_checkpoint
from masonry_fem.output.recorder import Recorders
from masonry_fem.records.remark import Remark
from masonry_fem.scene import dumps, specs
from masonry_fem.scene.moved import moved


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
        self._write("", None)

    def __call__(self, standing: Standing) -> None:
        """Write what a march knows between two steps, where it is time."""
        due = self._steps is not None and standing.done % self._steps == 0
        if due or (self._interval is not None and time.monotonic() - self._last >= self._interval):
            self._write("", standing)

    def end(self, outcome: str, standing: Standing | None) -> Path:
        """Write where the run ended, if more steps can be made from there."""
        if standing is not None:
            self._write(outcome, standing)
        return self.path

    def _write(self, outcome: str, standing: Standing | None) -> None:
        saved = {} if standing is None else self._recorders.saved()
        write_checkpoint(self.path, Checkpoint(self._scene, outcome, standing, saved, tuple(self._remarks)))
        self._last = time.monotonic()
