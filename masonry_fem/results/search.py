"""Search: what a search for where a structure falls leaves: its summary, its trials and how it falls.

write_search(folder, "threshold", told, ("value", "verdict"), fall)

``CollapseTold`` and ``ThresholdTold`` are what ``collapse.json`` and ``threshold.json`` hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from masonry_fem.host.atomic import write_table
from masonry_fem.march.march import March
from masonry_fem.march.mechanism import Falling, Mechanism
from masonry_fem.march.model import Model
from masonry_fem.march.recognition import mechanism_of_step
from masonry_fem.march.state import SystemState
from masonry_fem.output.mechanism_picture import draw_mechanism
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.records.told import Told, versioned, write

Outcome = Literal["bracketed", "undecided", "stands at both ends", "falls at both ends", "interrupted"]


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


class Tried(Told, frozen=True, kw_only=True):
    """A value that was tried.

    Attributes
    ----------
    value : Of the key. by : ``simulation`` or ``limit analysis``.
    verdict : ``stands``, ``falls`` or ``undecided``.
    outcome, message : How its run ended, and the sentence for it.
    steps : Made. seconds : CPU time [s].
    """

    value: float
    by: Literal["simulation", "limit analysis"]
    verdict: Literal["stands", "falls", "undecided"]
    outcome: str
    message: str
    steps: int
    seconds: float


class Range(Told, frozen=True, kw_only=True):
    """What one way of asking says of the threshold.

    Attributes
    ----------
    outcome : ``bracketed`` to the tolerance, ``undecided`` where trials were not, ``stands at both ends``,
        ``falls at both ends``, ``interrupted``.
    stands, falls : Values nearest to each other at which it stands and falls; None: none does.
    mechanism : How it falls at the latter; None: not known.
    """

    outcome: Outcome
    stands: float | None
    falls: float | None
    mechanism: Falling | None


class ThresholdTold(Told, frozen=True, kw_only=True, tag_field="schema", tag=versioned("threshold")):
    """What ``threshold.json`` holds of a search for the value of a key at which a scene stands no more.

    Attributes
    ----------
    title : Of the scene. key : Dotted key. unit : Of its values, "" for that of the scene file.
    along : Direction that values are sizes along; empty where the key is a number.
    outcome, message : Of the simulation, and both ranges as a sentence.
    simulation : What runs of the scene say.
    limit_analysis : What limit analysis says; None: it has no answer.
    trials : In their order, those of limit analysis first.
    notes : What was taken otherwise than the scene says, and doubts.
    """

    title: str
    key: str
    unit: str
    along: tuple[float, ...]
    outcome: Outcome
    message: str
    simulation: Range
    limit_analysis: Range | None
    trials: tuple[Tried, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """The verdict, and a line a trial."""
        lines = [f"{one.value:>12.6g}  {one.verdict:<9}  {one.by}" for one in self.trials]
        return "\n".join([f"{self.outcome}: {self.message}", *lines])
