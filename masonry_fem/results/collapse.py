"""Collapse: what ``collapse.json`` holds of a search for a collapse multiplier."""

from __future__ import annotations

from typing import Literal

from masonry_fem.march.mechanism import Falling
from masonry_fem.records.told import Told, versioned


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
