"""Incremental: what an incremental dynamic analysis found, as it is written to ``incremental.json``."""

from __future__ import annotations

from typing import Literal

from masonry_fem.records.told import Told, versioned


class ShakenTold(Told, frozen=True, kw_only=True):
    """A run of one record at one scale.

    Attributes
    ----------
    record : Its name. scale : What its accelerations were multiplied by.
    intensity : Of the scaled record [m/s²]. pga : Its greatest acceleration [m/s²].
    verdict : ``stands``; ``falls`` where a stone has fallen; ``undecided`` where the run has no end.
    outcome, message : Of the run, and the same as a sentence.
    leans : The stone that leaned most.
    demands : By name [rad, m]; empty where it does not stand.
    swing : How far probes still went in the last tenth of the steps, over their greatest way.
    steps : Made. cpu : CPU time [s].
    """

    record: str
    scale: float
    intensity: float
    pga: float
    verdict: Literal["stands", "falls", "undecided"]
    outcome: str
    message: str
    leans: str = ""
    demands: dict[str, float]
    swing: float = 0.0
    steps: int = 0
    cpu: float = 0.0


class Capacity(Told, frozen=True, kw_only=True):
    """Where a record begins to pass a limit.

    Attributes
    ----------
    record : Its name.
    stands : Greatest intensity below the first that passes the limit [m/s²]; 0: none.
    passes : The first that does [m/s²]; None: none.
    again : Number of greater intensities that do not.
    """

    record: str
    stands: float
    passes: float | None
    again: int


class FragilityTold(Told, frozen=True, kw_only=True):
    """A lognormal distribution of the intensity at which a limit is passed.

    Attributes
    ----------
    state : The limit: ``falls``, or a demand and its greatest value.
    outcome : ``fitted``; ``step`` where one intensity parts the records that pass it; ``never passed``; ``not
        determined``.
    records : Number of records: the sample. passed : How many of them pass the limit somewhere.
    median : Intensity at which half of the records pass it [m/s²]; None: not known.
    dispersion : Standard deviation of its logarithm; None: not known.
    median_range, dispersion_range : Ranges at ``confidence`` by the likelihood ratio; ends that are not
        bounded are null. Of a step the intensities between which it lies.
    confidence : Of these ranges.
    capacities : One a record.
    words : The same as a sentence.
    """

    state: str
    outcome: Literal["fitted", "step", "never passed", "not determined"]
    records: int
    passed: int
    median: float | None
    dispersion: float | None
    median_range: tuple[float, float] | None
    dispersion_range: tuple[float, float] | None
    confidence: float
    capacities: tuple[Capacity, ...]
    words: str


class IncrementalTold(Told, frozen=True, kw_only=True, tag_field="schema", tag=versioned("incremental")):
    """What ``incremental.json`` holds of a scene under many records at many scales.

    Attributes
    ----------
    title : Of the scene. outcome : ``finished`` or ``interrupted``.
    intensity : How records are measured: ``PGA``, or ``Sa`` with period and damping ratio.
    runs : By record and scale. missing : Number of runs that were not made.
    fragilities : Of falling first, then of the limits that were asked for.
    notes : What a reader should know.
    """

    title: str
    outcome: Literal["finished", "interrupted"]
    intensity: str
    runs: tuple[ShakenTold, ...]
    missing: int
    fragilities: tuple[FragilityTold, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """A line a limit."""
        return "\n".join(one.words for one in self.fragilities)
