"""Utilisation: what a summary says of how much of their strength stones use."""

from __future__ import annotations

import numpy as np

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.strength import Strengths
from masonry_fem.output.utilisation import StoneUtilisation, governed, stone_utilisation
from masonry_fem.records.told import Told

TOP = 5  # stones that a summary names


class StoneTold(Told, frozen=True, kw_only=True):
    """How much of its strength a stone uses; what is not known of rigid stones is left out.

    Attributes
    ----------
    block : Its name.
    local : Mean over the stated share of its volume. error : Estimated error of that.
    p95 : 5 % of its volume have more. greatest : At one point, singular at corners.
    of_mean : Of its mean stress.
    governs : What uses most of its strength: ``tension``, ``compression``, or ``yield`` where it has yielded.
    """

    block: str
    local: float | None = None
    error: float | None = None
    p95: float | None = None
    greatest: float | None = None
    of_mean: float
    governs: str


class Utilisation(Told, frozen=True, kw_only=True):
    """How much of their strength stones use: 1 is all of the design strength.

    Attributes
    ----------
    material_factor : By which strengths were divided.
    share : Of a stone's volume, over which ``local`` is the mean.
    worst : Stones that use most, by ``local``, rigid ones by ``of_mean``.
    over : Number of stones that use more than 1.
    load_factor : By which stresses may grow until the first stone uses 1; None where there is no stress.
    rigid : Number of stones of which only the mean stress is known.
    unchecked : Number of stones whose material has no strength.
    one_sided : Number of stones of which only one of both strengths is known.
    """

    material_factor: float
    share: float
    worst: tuple[StoneTold, ...]
    over: int
    load_factor: float | None = None
    rigid: int
    unchecked: int
    one_sided: int


def utilisation_summary(model: Model, state: SystemState, strengths: Strengths) -> Utilisation:
    """What ``summary.json`` says of utilisations.

    Parameters
    ----------
    model : The structure. state : A state of it.
    strengths : Of its blocks.
    """
    told = stone_utilisation(model, state, strengths)
    ranking = told.ranking
    known = ~np.isnan(ranking)
    free = ~np.isnan(told.volume)
    order = np.argsort(-np.where(known, ranking, -1.0), kind="stable")[: known.sum()].tolist()
    most = float(ranking[order[0]]) if order else 0.0
    one = np.isnan(strengths.tension) ^ np.isnan(strengths.compression)
    return Utilisation(
        material_factor=strengths.material_factor,
        share=strengths.share,
        worst=tuple(_stone(model, told, block) for block in order[:TOP]),
        over=int((ranking[known] > 1).sum()),
        load_factor=1.0 / most if most > 0 else None,
        rigid=int((known & np.isnan(told.local)).sum()),
        unchecked=int((free & ~strengths.known).sum()),
        one_sided=int((free & one).sum()),
    )


def _stone(model: Model, told: StoneUtilisation, block: int) -> StoneTold:
    def known(values: np.ndarray) -> float | None:
        return None if np.isnan(values[block]) else float(values[block])

    return StoneTold(
        block=model.assembly.blocks.names[block],
        local=known(told.local),
        error=known(told.error),
        p95=known(told.p95),
        greatest=known(told.greatest),
        of_mean=float(told.of_mean[block]),
        governs=governed(told)[block],
    )
