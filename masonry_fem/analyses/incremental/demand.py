"""Demand: what one record at one scale asks of a structure.

shaken(scene, Path("."))["demands"]            # {"lean": 0.12, "probes.top.peak": 0.24, ...}
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.single_run import run_once
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step_report import StepReport
from masonry_fem.output.response import ProbeMotion, response_of
from masonry_fem.scene import specs

FloatArray = NDArray[np.float64]


class _Ways:
    """Observer that keeps how far probes are from where the ground has carried them."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.ways: dict[str, list[FloatArray]] = {}

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Keep a step."""
        shift = 0.0 if model.ground is None else model.ground.shift(report.time)
        self.times.append(report.time)
        for name, way in report.probes.items():
            self.ways.setdefault(name, []).append(np.asarray(way) - shift)


def shaken(scene: specs.Scene, base: Path) -> dict[str, Any]:
    """Run a scene in time until its end, or until a stone has fallen; then no demand is told.

    Parameters
    ----------
    scene : What to run. base : Folder that the paths in it are relative to.
    """
    seen = _Ways()
    ended = run_once(scene, base, [seen], probed=True)
    row: dict[str, Any] = {
        "outcome": ended.outcome,
        "message": ended.message,
        "verdict": ended.verdict,
        "steps": ended.steps,
        "time": seen.times[-1] if seen.times else 0.0,
    }
    if ended.verdict != "stands":
        return row
    worst = max(ended.leans, key=ended.leans.__getitem__)
    demands = {"lean": ended.leans[worst]}
    swing = 0.0
    for name, ways in seen.ways.items():
        motion = np.array(ways)
        told = response_of(ProbeMotion(name, np.array(seen.times), motion, 0 * motion))
        demands[f"probes.{name}.peak"] = told.greatest
        demands[f"probes.{name}.residual"] = float(np.linalg.norm(told.residual))
        swing = max(swing, float(told.swing.max()) / (told.greatest or 1.0))
    return row | {"leans": worst, "demands": demands, "swing": swing}
