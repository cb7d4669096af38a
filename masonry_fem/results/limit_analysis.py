"""Limit analysis: what a summary, or ``limit --json``, holds of it; ``limit`` finds it."""

from __future__ import annotations

from masonry_fem.march.mechanism import Falling
from masonry_fem.records.told import Told, versioned


class Outside(Told, frozen=True, kw_only=True):
    """Force of a simulation's support that lies outside its interval.

    Attributes
    ----------
    support : Its name. axis : Component.
    force : The force [N].
    """

    support: str
    axis: str
    force: float


class LimitAnalysis(Told, frozen=True, kw_only=True, tag_field="schema", tag=versioned("limit")):
    """Results of limit analysis of the undeformed structure.

    Attributes
    ----------
    title : Title of the scene.
    message : All of this in sentences.
    dead, growing : Names of the loads that stay and of those that grow.
    blocks, contacts : Their numbers.
    admissible : Whether the loads of the scene can be carried.
    share : Share of the loads that can be carried.
    multiplier : Greatest factor on the growing loads with which they can be carried; None: none grow, none
        can be carried, or they are ``unlimited``.
    least_multiplier : Least such factor, above 0 where the dead loads need the growing ones; None: there is
        none.
    unlimited : Whether the loads may grow without bound.
    mechanism : How the blocks move at collapse, or under loads that cannot be carried.
    supports : Least and greatest force [N] by support and axis; None: no bound.
    ties : Least and greatest force [N] by tie; None: there are none, or the loads cannot be carried.
    inexact : Error of those ends of these intervals that are less exact than the rest [N]; None: not found.
    certificate : Relative errors of the optimisation problems that were solved.
    notes : Where the analysis differs from what the scene says.
    outside : Support forces of the simulation that lie outside these intervals.
    """

    title: str | None = None
    message: str
    dead: tuple[str, ...]
    growing: tuple[str, ...]
    blocks: int
    contacts: int
    admissible: bool
    share: float
    multiplier: float | None
    least_multiplier: float | None
    unlimited: bool
    mechanism: Falling | None
    supports: dict[str, dict[str, tuple[float | None, float | None]]]
    ties: dict[str, tuple[float | None, float | None]] | None = None
    inexact: dict[str, dict[str, float | None]]
    certificate: dict[str, float | None]
    notes: tuple[str, ...]
    outside: tuple[Outside, ...] | None = None
