"""Response in dynamics: ``response.csv``, a line for each axis of a probe, and ``spectra.csv``, one a period.

    motions = read_motions(Path("out/history.csv"), ["top"], 2, ground)
    told = {one.name: response_of(one) for one in motions}
    write_response(Path("out/response.csv"), told)

Displacements come from ``history.csv``. They are from the reference, and relative to the ground where
accelerograms move it.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.atomic import write_table
from masonry_fem.march.shaking import Shaking
from masonry_fem.output.history import AXES
from masonry_fem.records.told import Told

if TYPE_CHECKING:
    from masonry_fem.output.spectrum import Spectrum

FloatArray = NDArray[np.float64]

LATE = 0.1  # part of the steps, the last ones, in which the swing is looked for


@dataclass(frozen=True, slots=True)
class ProbeMotion:
    """How a probe went.

    Attributes
    ----------
    name : Of the probe. times : Ends of the steps, shape (n,) [s].
    relative : Displacements relative to the ground, shape (n, d) [m].
    ground : Of the ground in space, shape (n, d) [m].
    """

    name: str
    times: FloatArray
    relative: FloatArray
    ground: FloatArray


class ResponseTold(Told, frozen=True, kw_only=True):
    """Greatest and last displacements of a probe, relative to the ground.

    Attributes
    ----------
    peak : Of greatest size along each axis, with sign, shape (d,) [m]. peak_time : When, shape (d,) [s].
    greatest : Length of the longest displacement [m]. greatest_time : When [s].
    residual : At the end of the last step, shape (d,) [m].
    swing : Largest distance from the residual in the last tenth of the steps, shape (d,) [m].
    """

    peak: FloatArray
    peak_time: FloatArray
    greatest: float
    greatest_time: float
    residual: FloatArray
    swing: FloatArray


class SpectrumPeak(Told, frozen=True, kw_only=True):
    """Where a response spectrum is greatest.

    Attributes
    ----------
    pseudo_acceleration : ω² times the displacement [m/s²]. period : Of the oscillator there [s].
    """

    pseudo_acceleration: float
    period: float


class SpectraTold(Told, frozen=True, kw_only=True):
    """Response spectra, which stand in ``spectra.csv``.

    Attributes
    ----------
    damping : Ratio of the oscillators [-]. peaks : By the names of motions, as in the table.
    """

    damping: float
    peaks: dict[str, SpectrumPeak]

    @classmethod
    def of(cls, spectra: Mapping[str, Spectrum]) -> SpectraTold:
        """Their peaks."""
        peaks = {}
        for name, one in spectra.items():
            place = int(np.nanargmax(one.accelerations))
            top = float(one.accelerations[place])
            peaks[name] = SpectrumPeak(pseudo_acceleration=top, period=float(one.periods[place]))
        return cls(damping=next(iter(spectra.values())).damping, peaks=peaks)


def read_motions(
    path: Path, names: Sequence[str], dimension: int, ground: Shaking | None
) -> list[ProbeMotion]:
    """Motions of probes from a table of steps.

    Parameters
    ----------
    path : A ``history.csv``. names : Of the probes. dimension : Of space, d.
    ground : What shakes it; None where it rests.
    """
    with path.open(encoding="utf-8", newline="") as file:
        titles = next(csv.reader(file), [])
    wanted = ["time", *(f"probes.{name}_{axis}" for name in names for axis in AXES[dimension])]
    columns = [titles.index(title) for title in wanted]
    table = np.loadtxt(
        path, delimiter=",", skiprows=1, usecols=columns, ndmin=2, quotechar='"', encoding="utf-8"
    )
    times, ways = table[:, 0], table[:, 1:].reshape(len(table), len(names), dimension)
    still = np.zeros((len(times), dimension))
    shift = still if ground is None else ground.shift(times)
    unseen = still if ground is None else ground.unseen(times)
    return [
        ProbeMotion(name, times, ways[:, place] - shift, shift + unseen) for place, name in enumerate(names)
    ]


def response_of(motion: ProbeMotion) -> ResponseTold:
    """Its greatest and last displacements."""
    ways, times = motion.relative, motion.times
    place = np.abs(ways).argmax(axis=0)
    length = np.linalg.norm(ways, axis=1)
    late = ways[-max(1, round(LATE * len(ways))) :]
    return ResponseTold(
        peak=np.take_along_axis(ways, place[None], axis=0)[0],
        peak_time=times[place],
        greatest=float(length.max()),
        greatest_time=float(times[length.argmax()]),
        residual=ways[-1],
        swing=np.abs(late - ways[-1]).max(axis=0),
    )


def write_response(path: Path, told: Mapping[str, ResponseTold]) -> Path:
    """Write the table.

    Parameters
    ----------
    path : Of the file. told : Of each probe, by its name.
    """
    titles = ("probe", "axis", "peak [m]", "peak_time [s]", "residual [m]", "swing [m]")
    rows: list[list[Any]] = []
    for name, one in told.items():
        axes = AXES[len(one.peak)]
        numbers = np.column_stack([one.peak, one.peak_time, one.residual, one.swing]).tolist()
        rows += [[name, axis, *row] for axis, row in zip(axes, numbers, strict=True)]
    return write_table(path, titles, rows)


def write_spectra(path: Path, spectra: Mapping[str, Spectrum]) -> Path:
    """Write spectra of the same periods and damping; a cell is empty where a motion does not tell.

    Parameters
    ----------
    path : Of the file. spectra : By the names of their motions.
    """
    first = next(iter(spectra.values()))
    columns = {"period [s]": first.periods}
    for name, one in spectra.items():
        columns[f"{name} displacement [m]"] = one.displacements
        columns[f"{name} pseudo_acceleration [m/s^2]"] = one.accelerations
    return write_table(path, columns, np.column_stack(list(columns.values())).tolist())
