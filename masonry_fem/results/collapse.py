"""CollapseFiles: what a search for a collapse multiplier leaves in its folder.

write_collapse(folder, told, model, state, mechanism)     # collapse.json, trials.csv, mechanism.png
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from masonry_fem.host.atomic import write_table
from masonry_fem.march.mechanism import Falling, Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.mechanism_picture import draw_mechanism
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.records.told import Told, versioned, write


class Trial(Told, frozen=True, kw_only=True):
    """One attempt.

    Attributes
    ----------
    multiplier : Of what grows. verdict : ``stands``, ``falls`` or ``undecided``.
    outcome, message : How its march ended, and the sentence for it.
    steps : Made. seconds : CPU time [s].
    """

    multiplier: float
    verdict: Literal["stands", "falls", "undecided"]
    outcome: str
    message: str
    steps: int
    seconds: float


class CollapseTold(Told, frozen=True, kw_only=True, tag_field="schema", tag=versioned("collapse")):
    """What ``collapse.json`` holds of a search for a collapse multiplier.

    Attributes
    ----------
    title : Of the scene. action : What grows, in words. unit : Of the multiplier ("g", "times", "tan").
    outcome : ``bracketed`` to the tolerance, ``undecided`` where trials were not, ``unlimited``, ``falls at
        the start``, ``interrupted``. message : The same as a sentence.
    stands, falls : Greatest multiplier that stood, least that fell; None: none did.
    limit_multiplier : Of limit analysis, an upper bound; None: not known.
    mechanism : How the structure moves at the least fall. trials : In their order.
    notes : What was taken otherwise than the scene says, and doubts.
    """

    title: str
    action: str
    unit: str
    outcome: Literal["bracketed", "undecided", "unlimited", "falls at the start", "interrupted"]
    message: str
    stands: float | None
    falls: float | None
    limit_multiplier: float | None
    mechanism: Falling | None
    trials: tuple[Trial, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """The verdict, and a line a trial."""
        lines = [f"{one.multiplier:>12.6g}  {one.verdict:<9}  {one.steps:>5} steps" for one in self.trials]
        return "\n".join([f"{self.outcome}: {self.message}", *lines])


def write_collapse(
    directory: Path,
    told: CollapseTold,
    model: Model,
    state: SystemState | None,
    mechanism: Mechanism | None,
    *,
    pictures: bool = True,
) -> list[Path]:
    """Write what was found, the trials as a table and, where this machine can draw, the mechanism.

    Parameters
    ----------
    directory : Where to.
    told : What was found.
    model : The structure.
    state : Where the mechanism begins; None: not known.
    mechanism : How the structure moves at the least fall; None: not known.
    pictures : Whether to draw the mechanism.
    """
    columns = ("multiplier", "verdict", "outcome", "steps", "seconds")
    rows = ([getattr(trial, name) for name in columns] for trial in told.trials)
    paths = [directory / "collapse.json", write_table(directory / "trials.csv", columns, rows)]
    if pictures and mechanism is not None and mechanism.parts and state is not None and can_render():
        scenery = Scenery.of(model, state, title=told.title)
        paths.append(draw_mechanism(scenery, mechanism, directory / "mechanism.png"))
    write(paths[0], told)  # last: until then it says "running"
    return paths
