"""Study: what a study of settings found, as it is written to ``study.json``."""

from __future__ import annotations

from collections.abc import Mapping

from masonry_fem.records.told import Told, versioned


class Recommendation(Told, frozen=True, kw_only=True):
    """Advice for a quantity.

    Attributes
    ----------
    target : What it is for. accuracy : Asked for, relative.
    settings : What to use; None: nothing of the study is known to do.
    error, bound : Of these settings against the reference, and what the truth is not expected to exceed.
    cheaper : CPU time of the reference, or of the dearest setting, over that of the advice.
    words : The same in words.
    """

    target: str
    accuracy: float
    settings: dict[str, str] | None
    error: float | None
    bound: float | None
    cheaper: float | None
    words: str


class Choice(Told, frozen=True, kw_only=True):
    """Settings that no others surpass in both cost and bound.

    Attributes
    ----------
    settings : Values by key, as written. cpu : CPU time of their cells, all cases together [s].
    error, bound : Against the reference, and what the truth is not expected to exceed, relative.
    """

    settings: Mapping[str, str]
    cpu: float
    error: float
    bound: float


class OrderTold(Told, frozen=True, kw_only=True):
    """How a quantity converges where one key is refined.

    Attributes
    ----------
    case : Values of the keys that make the case. quantity, key : What was watched, what was refined.
    order : Observed order; None where there is none. verdict : The same in words.
    left : What the finest value may be off, relative to the quantity.
    """

    case: dict[str, str]
    quantity: str
    key: str
    order: float | None
    verdict: str
    left: float


class StudyTold(Told, frozen=True, kw_only=True, tag_field="schema", tag=versioned("study")):
    """What ``study.json`` holds.

    Attributes
    ----------
    title : Of the scene. outcome : "finished" or "interrupted".
    varied : Values of each key, as written. reference : What all is compared with, in words.
    accuracy : Asked for, relative. recommendations : One a target.
    orders : Observed orders of convergence. pareto : By target, the settings that no others surpass.
    notes : What a reader should know of the study.
    cells : One record a cell, as in ``study.csv``: settings, outcome, costs [s, MB], values, errors, bounds.
    """

    title: str
    outcome: str
    varied: dict[str, list[str]]
    reference: str
    accuracy: float
    recommendations: tuple[Recommendation, ...]
    orders: tuple[OrderTold, ...]
    pareto: dict[str, tuple[Choice, ...]]
    notes: tuple[str, ...]
    cells: tuple[dict[str, str | int | float | None], ...]
