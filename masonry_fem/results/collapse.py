"""CollapseFiles: what a search for a collapse multiplier leaves in its folder.

write_collapse(folder, told, model, state, mechanism)     # collapse.json, trials.csv, mechanism.png
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.mechanism_picture import draw_mechanism
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.results.blocks import write_summary


def write_collapse(
    directory: Path,
    told: Mapping[str, Any],
    model: Model,
    state: SystemState | None,
    mechanism: Mechanism | None,
    *,
    pictures: bool = True,
) -> list[Path]:
    """Write what is told, its trials as a table and, where this machine can draw, the mechanism."""
    columns = ("multiplier", "verdict", "outcome", "steps", "seconds")
    text = io.StringIO()
    table = csv.writer(text)
    table.writerow(columns)
    table.writerows([trial[name] for name in columns] for trial in told["trials"])
    paths = [directory / "collapse.json", directory / "trials.csv"]
    write_atomic(paths[1], text.getvalue().encode())
    if pictures and mechanism is not None and mechanism.parts and state is not None and can_render():
        scenery = Scenery.of(model, state, title=str(told.get("title") or ""))
        paths.append(draw_mechanism(scenery, mechanism, directory / "mechanism.png"))
    write_summary(paths[0], told)  # last: until then it says "running"
    return paths
