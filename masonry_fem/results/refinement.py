"""Refinement: what ``summary.json`` holds of solutions on finer and finer elements."""

from __future__ import annotations

from masonry_fem.records.told import Told


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
