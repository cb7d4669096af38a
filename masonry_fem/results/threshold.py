"""Threshold: what ``threshold.json`` holds of a search for the threshold of a key."""

from __future__ import annotations

from typing import Literal

from masonry_fem.march.mechanism import Falling
from masonry_fem.records.told import Told, versioned

Outcome = Literal["bracketed", "undecided", "stands at both ends", "falls at both ends", "interrupted"]


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
