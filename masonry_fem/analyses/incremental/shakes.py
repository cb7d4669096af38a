"""Shakes: the runs of an incremental dynamic analysis: a scene under each record at each scale.

shakes = Shaken(Source.of("column.toml"), ["a.AT2"], period=None).shakes("0.2:2:0.2", ())
shakes[0].cell, shakes[0].intensity
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.analyses.cells.cell import MOST, Cell, fingerprint
from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.incremental.records import Intensity, Record, parsed_scales, read_records
from masonry_fem.analyses.run.reopening import begun
from masonry_fem.build import build
from masonry_fem.build.shaking import shaking
from masonry_fem.errors import MasonryError
from masonry_fem.records.remark import gathered
from masonry_fem.results.incremental import ShakenTold
from masonry_fem.scene import check, dumps, specs
from masonry_fem.scene.overrides import apply

KEY = "loads.accelerograms.0"


@dataclass(frozen=True, slots=True)
class Shake:
    """One record at one scale, and the scene that they make.

    Attributes
    ----------
    record : Its name. scale : What it is multiplied by.
    intensity : Of the scaled record [m/s²]. pga : Its greatest acceleration [m/s²].
    cell : What is run.
    """

    record: str
    scale: float
    intensity: float
    pga: float
    cell: Cell

    def told(self, row: Mapping[str, Any]) -> ShakenTold:
        """With what a worker left."""
        return ShakenTold(
            record=self.record, scale=self.scale, intensity=self.intensity, pga=self.pga,
            verdict=row.get("verdict", "undecided"), outcome=row["outcome"], message=row["message"],
            leans=row.get("leans", ""), demands=row.get("demands", {}), swing=row.get("swing", 0.0),
            steps=row.get("steps", 0), cpu=row.get("cpu", 0.0),
        )  # fmt: skip


class Shaken:
    """The scenes that records make of a scene.

    Parameters
    ----------
    source : An analysis in time. given : Accelerograms, and lists of such.
    period : Of the oscillator that tells how intense a record is [s]; None: its greatest acceleration.

    Raises
    ------
    MasonryError : A record cannot be read, or the scene cannot be built or shaken so.
    """

    def __init__(self, source: Source, given: Sequence[str | Path], period: float | None) -> None:
        self._source, self._base = source, source.base
        self._records = read_records(given, self._axes())
        # with a record, as files that the scene names need not be there
        self.scene, _ = self._scaled(self._records[0], 1.0)
        self._refuse()
        with gathered(aloud=False):  # what cannot be built is refused once, not run by run
            begun(self.scene, build(self.scene, self._base), self._base)
        self.intensity = Intensity(period, self.scene.output.spectrum_damping)

    def _axes(self) -> list[str]:
        """Along which the scene is shaken; what is no scene is refused as it is read."""
        try:
            tree = tomllib.loads(self._source.text)
        except (ValueError, RecursionError):
            return ["x"]
        apply(tree, self._source.overrides)
        match tree:
            case {"loads": {"accelerograms": [dict(held), *_]}}:
                return [axis for axis in "xyz" if axis in held] or ["x"]
        return ["x"]

    def _refuse(self) -> None:
        scene, path = self.scene, self._source.name
        self._source.refuse(scene, dict.fromkeys(("stages", "combinations"), "a record shakes one run"))
        if scene.analysis.seeks_equilibrium:
            raise MasonryError(f"{path} is no analysis in time; give [analysis] kind = 'dynamics'")
        if len(scene.loads.accelerograms) > 1:
            raise MasonryError(
                f"{path} has {len(scene.loads.accelerograms)} loads.accelerograms, expected one, whose files "
                "the records take the place of"
            )

    def shakes(self, scales: str | Sequence[float], levels: str | Sequence[float]) -> list[Shake]:
        """All runs, record by record.

        Parameters
        ----------
        scales : What records are multiplied by. levels : In place of these, intensities [m/s²].

        Raises
        ------
        MasonryError : Both are given, or too many, or a record does not move the ground.
        """
        wanted = parsed_scales(scales, "scales") or parsed_scales(levels, "levels")
        if bool(len(scales)) == bool(len(levels)):
            raise MasonryError("give either scales, as 0.2:2:0.2, or levels of intensity [m/s²]")
        count = len(self._records) * len(wanted)
        if count > MOST:
            raise MasonryError(
                f"{len(self._records)} records at {len(wanted)} scales are {count} runs, expected at most "
                f"{MOST}"
            )
        found = []
        for record in self._records:
            scene, _ = self._scaled(record, 1.0)
            ground = shaking(check(scene, base=self._base), self._base)
            assert ground is not None
            unit = self.intensity.of(ground, self._level)
            pga = Intensity(None, 0.0).of(ground, self._level)
            if not unit > 0:
                raise MasonryError(f"record '{record.name}' does not move the ground; leave it out")
            for one in wanted:
                scale = one / unit if len(levels) else one
                intensity = one if len(levels) else one * unit
                scene, settings = self._scaled(record, scale)
                key = f"{fingerprint(scene, self._base)}-shaken"
                cell = Cell((), settings, dumps(scene), key)
                found.append(Shake(record.name, scale, intensity, scale * pga, cell))
        return found

    @property
    def _level(self) -> list[int]:
        """Axes across gravity."""
        pull = self.scene.loads.gravity
        down = self.scene.dimension - 1 if pull is None else int(np.abs(np.array(pull)).argmax())
        return [axis for axis in range(self.scene.dimension) if axis != down]

    def _scaled(self, record: Record, scale: float) -> tuple[specs.Scene, dict[str, str]]:
        # by the same name from wherever the command is called
        files = {axis: os.path.relpath(path.resolve(), self._base) for axis, path in record.files.items()}
        own = [f'{KEY}.{axis}="{name}"' for axis, name in files.items()]
        own.append(f"{KEY}.scale={scale!r}")
        if all(path.suffix.lower() == ".at2" for path in record.files.values()):
            own.append(f'{KEY}.unit="g"')
        return self._source.scene(*own), {"record": record.name, "scale": f"{scale:.6g}"}
