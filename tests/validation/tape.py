"""Tape: an observer that keeps what each step reports, for histories against closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.build import Built, build
from masonry_fem.march.march import March, march
from masonry_fem.march.state import SystemState
from masonry_fem.march.step_report import StepReport
from masonry_fem.scene import check
from masonry_fem.scene.specs import Scene


class Tape:
    """Reports of all steps, and what all contacts together press."""

    def __init__(self) -> None:
        self.reports: list[StepReport] = []
        self._pressing: list[float] = []

    def record(self, model: Any, state: SystemState, report: StepReport) -> None:
        self.reports.append(report)
        self._pressing.append(float(state.reaction[:, 0].sum()))

    @property
    def time(self) -> np.ndarray:
        return np.array([report.time for report in self.reports])

    @property
    def energy(self) -> np.ndarray:
        return np.array([report.kinetic_energy + report.strain_energy for report in self.reports])

    @property
    def pressing(self) -> np.ndarray:
        """Sum of the normal reactions of all contacts, mean over each step [N]."""
        return np.array(self._pressing)

    def reaction(self, support: str, axis: int) -> np.ndarray:
        """Force that a support gives along an axis, mean over each step."""
        return np.array([report.support_resultants[support][axis] for report in self.reports])

    def probe(self, name: str, axis: int) -> np.ndarray:
        return np.array([report.probes[name][axis] for report in self.reports])


def taped(**fields: Any) -> tuple[Tape, March, Built]:
    """March a scene given by its fields."""
    scene, tape = check(Scene(**fields)), Tape()
    built = build(scene, Path())
    plan, settings = scene.analysis, scene.solver.settings
    return tape, march(built.model, plan, settings, bodies=built.bodies, observers=(tape,)), built
