"""Search: what a search for where a structure falls leaves: its summary, its trials and how it falls.

write_search(folder, "threshold", told, ("value", "verdict"), fall)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_fem.host.atomic import write_table
from masonry_fem.march.march import March
from masonry_fem.march.mechanism import Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.recognition import mechanism_of_step
from masonry_fem.march.state import SystemState
from masonry_fem.output.mechanism_picture import draw_mechanism
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.records.told import write


@dataclass(frozen=True, slots=True)
class Fall:
    """How a structure falls.

    Attributes
    ----------
    mechanism : Its parts, hinges and sliding joints.
    model, state : The structure, and its state where that begins.
    """

    mechanism: Mechanism
    model: Model
    state: SystemState

    @classmethod
    def of(cls, ended: March) -> Fall:
        """How it fell in the last step of a march."""
        return cls(mechanism_of_step(ended.last, ended.model), ended.model, ended.last.before)


def write_search(
    directory: Path, name: str, told: Any, columns: Sequence[str], fall: Fall | None, *, pictures: bool
) -> list[Path]:
    """Write what was found, the trials as a table and, where this machine can draw, the mechanism.

    Parameters
    ----------
    directory : Where to. name : Of the summary. told : What was found.
    columns : Attributes of the trials that their table has.
    fall : How the structure falls; None: not known. pictures : Whether to draw the mechanism.
    """
    rows = ([getattr(trial, column) for column in columns] for trial in told.trials)
    paths = [directory / f"{name}.json", write_table(directory / "trials.csv", columns, rows)]
    if pictures and fall is not None and fall.mechanism.parts and can_render():
        scenery = Scenery.of(fall.model, fall.state, title=told.title)
        paths.append(draw_mechanism(scenery, fall.mechanism, directory / "mechanism.png"))
    write(paths[0], told)  # last: until then it says "running"
    return paths
