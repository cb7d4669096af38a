"""Discretisation: what ``summary.json`` holds of the errors of elements, contact points and time steps.

And of solutions on finer and finer elements, which bring the first of these down.
"""

from __future__ import annotations

from masonry_fem.records.told import Told


class TimeError(Told, frozen=True, kw_only=True):
    """What time steps of a finite length did to the energy, relative to the largest energy of the march.

    Attributes
    ----------
    dissipated : Lost to the time integration.
    imbalance : Appeared or lost without a name.
    note : What these two do not show.
    """

    dissipated: float
    imbalance: float
    note: str | None = None


class ContactError(Told, frozen=True, kw_only=True):
    """Relative changes where the analysis is made again with other contact points.

    Attributes
    ----------
    points, points_again : Numbers of contact points, and of those of the second analysis.
    outcome_again : Its outcome, where this is another.
    note : Why there is nothing to compare.
    supports, probes : Greatest change of a support's force, of a probe's displacement.
    stress, block_stress : Change of the stress in the mean over the volume, of the blocks' mean stresses.
    seconds : CPU time of the second analysis [s].
    """

    points: int | None = None
    points_again: int | None = None
    outcome_again: str | None = None
    note: str | None = None
    supports: float | None = None
    probes: float | None = None
    stress: float | None = None
    block_stress: float | None = None
    seconds: float | None = None


class Errors(Told, frozen=True, kw_only=True):
    """What elements, contact points and steps leave open; what does not apply is None.

    Attributes
    ----------
    stress : Of the elements: estimated, relative, in the energy norm.
    contact : Of the contact points.
    time : Of the time steps.
    """

    stress: float | None = None
    contact: ContactError | None = None
    time: TimeError | None = None


class Round(Told, frozen=True, kw_only=True):
    """One solution of a refinement.

    Attributes
    ----------
    round : From 1. unknowns : Of displacement and contact. meshes : Distinct ones, ``made`` of them new.
    error : Estimated, relative, in the energy norm. refined : Blocks that get finer elements next.
    seconds : CPU time [s].
    """

    round: int
    unknowns: int
    meshes: int
    made: int
    error: float
    refined: int
    seconds: float


class RefinementTold(Told, frozen=True, kw_only=True):
    """How the error of the stress was brought down.

    Attributes
    ----------
    target : Relative error asked for.
    reached : Whether it was reached. message : The same in a sentence.
    rounds : Each solution on the way.
    """

    target: float
    reached: bool
    message: str
    rounds: tuple[Round, ...]
