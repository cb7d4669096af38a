"""Write ``report.html``: all of a run in one file, which can be handed on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.recorder import Request, StepReport
from masonry_fem.output.report import write_report


def recorder(request: Request) -> Report:
    """The report, made of what the others have written."""
    return Report(request.folder)


class Report:
    """Recorder of ``report.html``."""

    dense = False

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def start(self, model: Model) -> None:
        """Nothing is written before the end."""

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Nor of a step."""

    def close(self, summary: Any) -> list[Path]:
        """Nor before the others have written."""
        return []

    def finish(self) -> list[Path]:
        """Write it."""
        return [write_report(self._folder)]
