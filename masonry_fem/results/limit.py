"""Limit analysis: what it says of a problem, as numbers and words.

told = answers(problem)
told.message, told.multiplier, told.supports["arch.springing_left"]["x"]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from msgspec import structs

from masonry_fem.errors import ProblemError
from masonry_fem.limit.problem import LimitProblem
from masonry_fem.limit.questions import (
    Admissible,
    Collapse,
    Interval,
    admissible,
    collapse_multiplier,
    hold_resultant,
    interval,
    support_resultant,
)
from masonry_fem.march.mechanism import Falling, Mechanism, Moving
from masonry_fem.results.limit_analysis import LimitAnalysis, Outside
from masonry_fem.results.summary import Wrench

LEAST = 1e-6  # smaller shares and factors are taken as zero
MOST = 24  # supports, and ties, whose intervals are computed: in 3D each takes a dozen programs
TIE = "force"  # what stands in the place of an axis for a tie
OUTSIDE = 1e-3  # of the loads: elastic blocks lean a little


def answers(problem: LimitProblem, tilt: str | None = None, **others: Any) -> LimitAnalysis:
    """The results of limit analysis of a problem, as they are written to ``summary.json``.

    Without ``tilt`` the loads of the scene are the dead loads and once the live ones; with it the dead ones
    alone.

    Parameters
    ----------
    problem : Blocks, contact points and loads; its live load is the scene's, or that of a tilt.
    tilt : Direction of the tilt in words, None if the live load is the scene's.
    others : What is known of the scene: which loads are ``dead``, which ``growing``, ``notes``.
    """
    present = float(tilt is None)
    carried = admissible(problem, present)
    collapse, missing = _collapse(problem)
    motion = carried.mechanism
    if collapse is not None and collapse.mechanism is not None:
        motion = collapse.mechanism
    thrusts = _thrusts(problem, present) if carried.holds else {}
    ties = _ties(problem, present) if carried.holds else {}
    return LimitAnalysis(
        message=" ".join([_sentence(carried, collapse, motion, tilt), *missing]),
        blocks=len(problem.blocks),
        contacts=int(problem.active.sum()),
        admissible=carried.holds,
        share=carried.share,
        **_multipliers(collapse),
        mechanism=None if motion is None else motion_told(problem, motion),
        supports={
            name: {axis: (_finite(end.low), _finite(end.high)) for axis, end in ends.items()}
            for name, ends in thrusts.items()
        },
        ties={name: (_finite(one[TIE].low), _finite(one[TIE].high)) for name, one in ties.items()} or None,
        inexact=_inexact(thrusts | ties),
        certificate=_certificate(carried, collapse, thrusts | ties),
        **({"dead": (), "growing": (), "notes": ()} | others),
    )


def _collapse(problem: LimitProblem) -> tuple[Collapse | None, list[str]]:
    """How far the loads may grow, and what could not be computed."""
    if not problem.live.any():
        return None, []
    try:
        return collapse_multiplier(problem), []
    except ProblemError as error:
        return None, [f"How far loads may grow is not known: {error}."]


def _multipliers(collapse: Collapse | None) -> dict[str, Any]:
    """Between what factors loads that grow can be carried; none where none grows."""
    if collapse is None:
        return {"multiplier": None, "least_multiplier": None, "unlimited": False}
    return {
        "multiplier": _finite(collapse.multiplier),
        "least_multiplier": _finite(collapse.least),
        "unlimited": math.isinf(collapse.multiplier),
    }


def _sentence(
    carried: Admissible, collapse: Collapse | None, motion: Mechanism | None, tilt: str | None
) -> str:
    """The verdict in words."""
    words = ["The loads can be carried" if carried.holds else "The loads cannot be carried"]
    if not carried.holds and carried.share > LEAST:
        words[0] += f" (only {carried.share:.4g} of them)"
    if motion is not None and motion is carried.mechanism:
        words[0] += f": {motion.sentence()}"
    if collapse is not None:
        words.append(_growth(collapse, tilt))
    if motion is not None and motion is not carried.mechanism:
        words.append(f"At collapse {motion.sentence()}")
    return ". ".join(words) + "."


def _growth(collapse: Collapse, tilt: str | None) -> str:
    """How far the loads may grow."""
    digits = _digits(collapse.gap)
    what, unit = ("Those that grow", "times their value") if tilt is None else (f"A tilt to {tilt}", "g")
    if math.isnan(collapse.multiplier):
        return f"{what} cannot be carried to any degree"
    least = f" from {collapse.least:.{digits}g}" if collapse.least > LEAST else ""
    needs = f", and must have {collapse.least:.{digits}g}" if least else ""
    if math.isinf(collapse.multiplier):
        return f"{what} may grow without limit{f'{least} {unit} on' if least else ''}"
    angle = "" if tilt is None else f", {math.degrees(math.atan(collapse.multiplier)):.4g} degrees"
    return f"{what} may reach {collapse.multiplier:.{digits}g} {unit}{angle}{needs}"


def _digits(error: float) -> int:
    """Digits of a value that its relative error leaves, six at most."""
    return 6 if error < 1e-6 else max(1, int(-math.log10(error)))


def motion_told(problem: LimitProblem, motion: Mechanism) -> Falling:
    """A mechanism, and the velocities of the centres of blocks that move.

    Parameters
    ----------
    problem : Of limit analysis.
    motion : Its mechanism.
    """
    names = problem.model.assembly.blocks.names
    moving = {name for group in motion.groups for name in group}
    rows = zip(motion.blocks.tolist(), motion.centre, motion.velocity, motion.spin, strict=True)
    blocks = tuple(
        Moving(block=names[block], at=at, velocity=velocity, spin=spin)
        for block, at, velocity, spin in rows
        if names[block] in moving
    )
    return structs.replace(motion.told(), blocks=blocks)


def _thrusts(problem: LimitProblem, present: float) -> dict[str, dict[str, Interval]]:
    """Least and greatest force of each support along each axis."""
    axes = "xyz"[: problem.dimension]
    return {
        name: {
            axis: interval(problem, resultant(number), present, carried=True)
            for number, axis in enumerate(axes)
        }
        for name, resultant in list(supports_of(problem).items())[:MOST]
    }


def _ties(problem: LimitProblem, present: float) -> dict[str, dict[str, Interval]]:
    """Least and greatest force of each tie, by name."""
    contacts, found = problem.model.contacts, {}
    for number in np.flatnonzero(contacts.tied & problem.active)[:MOST].tolist():
        resultant = np.zeros(problem.equilibrium.shape[1])
        resultant[number * problem.dimension] = 1.0
        name = problem.model.interfaces[contacts.interface[number]].label
        found[name] = {TIE: interval(problem, resultant, present, carried=True)}
    return found


def _inexact(thrusts: Mapping[str, Mapping[str, Interval]]) -> dict[str, dict[str, float | None]]:
    """Errors of interval ends that are not accurate [N]; None for ends that were not found."""
    found = {
        name: {axis: _finite(end.error) for axis, end in ends.items() if not end.exact}
        for name, ends in thrusts.items()
    }
    return {name: axes for name, axes in found.items() if axes}


def supports_of(problem: LimitProblem) -> dict[str, Callable[[int], np.ndarray]]:
    """Coefficients of the force that each support exerts along an axis, by name."""
    found: dict[str, Callable[[int], np.ndarray]] = {}
    model = problem.model
    touched = set(model.contacts.blocks[problem.active].ravel().tolist())
    for group in model.groups:
        for block in group.blocks.tolist() if group.prescribed else ():
            if block in touched:
                name = model.assembly.blocks.names[block]
                found[name] = partial(support_resultant, problem, block)
    for hold in problem.holds:
        found[hold.name] = partial(hold_resultant, problem, hold.name)
    return found


def _certificate(
    carried: Admissible, collapse: Collapse | None, thrusts: Mapping[str, Mapping[str, Interval]]
) -> dict[str, float | None]:
    """How exact the answers are, by measures that the solvers have no say in; all relative."""
    unbalanced, closing, gap = carried.unbalanced, carried.closing, 0.0
    if collapse is not None:
        unbalanced, closing = max(unbalanced, collapse.unbalanced), max(closing, collapse.closing)
        gap = collapse.gap
    worst = max((end.gap for ends in thrusts.values() for end in ends.values()), default=0.0)
    return {"unbalanced": unbalanced, "closing": closing, "gap": gap, "intervals": _finite(worst)}


def outside(told: LimitAnalysis, forces: Mapping[str, Wrench], applied: np.ndarray) -> tuple[Outside, ...]:
    """Support forces of a simulation that lie outside their intervals from limit analysis.

    There are none in equilibrium, unless the blocks have moved so far that the changed geometry matters.

    Parameters
    ----------
    told : Results of ``answers``.
    forces : Forces on the supports by name, each with ``force`` (d,) [N].
    applied : Sum of the loads, shape (d,) [N]; differences below 1e-3 of it do not count.

    Returns
    -------
    One record for each such force: support, axis and force [N].
    """
    found = []
    for name, axes in told.supports.items():
        for (axis, (low, high)), force in zip(axes.items(), forces[name].force, strict=True):
            slack = OUTSIDE * float(np.linalg.norm(applied))
            slack += told.inexact.get(name, {}).get(axis) or 0.0
            above = high is not None and force > high + slack
            if above or (low is not None and force < low - slack):
                found.append(Outside(support=name, axis=axis, force=float(force)))
    return tuple(found)


def _finite(value: float) -> float | None:
    """The value, or None where it is infinite or there is none."""
    return float(value) if math.isfinite(value) else None
