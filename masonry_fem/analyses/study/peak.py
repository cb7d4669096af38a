"""Peak: the greatest size that a number had after any step of a run, and where it had it.

peaks = Peaks(dimension=2)                       # an observer of the march
peaks.told()[0]                                  # of "supports.jack.x", as JSON

Names are ``supports.NAME`` (force) and ``probes.NAME`` (displacement), each with an axis, or without one for
the length of the vector, and ``time``, in statics and on a path the load factor.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from masonry_fem.analyses.study.quantity import AXES, FloatArray, Quantity
from masonry_fem.errors import MasonryError
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step_report import StepReport
from masonry_fem.scene.misfit import listed, nearest

GROUP = "peak"


@dataclass(frozen=True, slots=True)
class Peak:
    """A peak.

    Attributes
    ----------
    of : Name of the number. unit : Of it.
    value : Of greatest size, with its sign. time : End of its step [s]; the load factor in statics.
    probes : Displacements of the named points at that time, (d,) [m].
    """

    of: str
    unit: str
    value: float
    time: float
    probes: Mapping[str, Sequence[float]]

    @property
    def name(self) -> str:
        """As a quantity."""
        return f"{GROUP}.{self.of}"

    @property
    def quantity(self) -> Quantity:
        """What is compared of it."""
        return Quantity((self.value,), (), self.unit)

    def columns(self) -> Iterator[tuple[str, float]]:
        """Its numbers by the heads of their columns."""
        yield self.name, self.value
        yield f"{self.name}.time", self.time
        for probe, moved in self.probes.items():
            for axis, value in zip(AXES[len(moved)], moved, strict=True):
                yield f"{self.name}.probes.{probe}.{axis}", value


class Peaks:
    """Observer of a march that keeps the peaks of its forces, displacements and time.

    Parameters
    ----------
    dimension : Of the structure.
    """

    dense = True

    def __init__(self, dimension: int) -> None:
        self._axes = AXES[dimension]
        self._names: list[str] = []
        self._probes: list[str] = []
        self._values = self._times = self._places = np.zeros(0)

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Take what a step surpasses."""
        d = len(self._axes)
        moved = np.array([np.ravel(one) for one in report.probes.values()]).reshape(-1, d)
        forces = np.array([one[:d] for one in report.support_resultants.values()]).reshape(-1, d)
        values = _numbers(report.time, forces, moved)
        if not self._names:
            self._probes = list(report.probes)
            self._names = list(_names(report, self._axes))
            self._values, self._times = np.zeros(len(values)), np.zeros(len(values))
            self._places = np.zeros((len(values), len(self._probes), d))
            more = np.ones(len(values), dtype=bool)
        else:
            more = np.abs(values) > np.abs(self._values)
        self._values[more], self._times[more], self._places[more] = values[more], report.time, moved

    def told(self) -> list[dict[str, Any]]:
        """All of them as JSON."""
        units = {"time": "s", "probes": "m", "supports": "N" if len(self._axes) == 3 else "N/m"}
        found = []
        for row, of in enumerate(self._names):
            at = dict(zip(self._probes, self._places[row].tolist(), strict=True))
            unit, value, time = units[of.partition(".")[0]], float(self._values[row]), float(self._times[row])
            found.append(asdict(Peak(of, unit, value, time, at)))
        return found


def asked_for(told: Sequence[Mapping[str, Any]], asked: Sequence[str]) -> tuple[Peak, ...]:
    """The peaks that a study asks for, of those that a cell told.

    Parameters
    ----------
    told : What the cell's file has. asked : Their names.

    Raises
    ------
    MasonryError : A name is none of a cell that made steps.
    """
    known = {one["of"]: one for one in told}
    for name in asked if known else ():
        if name not in known:
            raise MasonryError(
                f"--peak {name}: no such number in the history of a cell{nearest(name, known)}; known: "
                f"{listed(known)}"
            )
    return tuple(Peak(**known[name]) for name in asked if name in known)


def _numbers(time: float, *vectors: FloatArray) -> FloatArray:
    """The time, and of each vector its components and its length."""
    whole = [np.hstack([one, np.linalg.norm(one, axis=1)[:, None]]).ravel() for one in vectors]
    return np.concatenate([[time], *whole])


def _names(report: StepReport, axes: Sequence[str]) -> Iterator[str]:
    """Names of these numbers."""
    yield "time"
    for group, named in (("supports", report.support_resultants), ("probes", report.probes)):
        for name in named:
            yield from (f"{group}.{name}.{axis}" for axis in axes)
            yield f"{group}.{name}"
