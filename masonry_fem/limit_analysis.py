"""Limit analysis of a scene: which loads grow, the three questions, and the answers as numbers and words.

    told = analyse(load("arch.toml"), Path("."), tilt="x")
    told["admissible"], told["multiplier"], told["supports"]["arch.springing_left"]["x"]

Gravity stays and every other load of the scene grows, unless it is named dead; a tilt makes all loads of
the scene dead and grows a horizontal acceleration of g. Loads are taken as they are at the end of the
analysis, the blocks where they stand at its start.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.build import Built, build
from masonry_fem.dynamics.model import Load, Model
from masonry_fem.errors import MasonryError, ProblemError
from masonry_fem.limit import (
    Admissible,
    Collapse,
    Hold,
    Interval,
    LimitProblem,
    Mechanism,
    admissible,
    collapse_multiplier,
    group_forces,
    hold_resultant,
    interval,
    limit_problem,
    support_resultant,
)
from masonry_fem.scene import check, specs
from masonry_fem.scene.misfit import listed

GRAVITY = 9.81  # of a tilt, where the scene has no gravity [m/s²]
LEAST = 1e-6  # share or factor that is told
MOST = 24  # supports whose forces' intervals are told: each takes a dozen programs in space
OUTSIDE = 1e-3  # of the loads: elastic blocks lean a little


def analyse(
    scene: specs.Scene, base: Path = Path(), *, dead: Sequence[str] = (), tilt: str | None = None
) -> dict[str, Any]:
    """Build a scene and ask the three questions of its blocks.

    Parameters
    ----------
    scene : What to analyse. base : Folder that the paths in it are relative to.
    dead : Patterns of loads that do not grow (``points.0``, ``tractions.*``); gravity never does.
    tilt : Axis along which an acceleration of g grows, a sign before it turns it; loads are dead then.

    Raises
    ------
    MasonryError : The scene cannot be built, a joint has no constant strength, or nothing is so named.
    """
    scene = check(scene, base=base)
    return cross_check(scene, build(scene, base), dead=dead, tilt=tilt)


def cross_check(
    scene: specs.Scene, built: Built, *, dead: Sequence[str] = (), tilt: str | None = None
) -> dict[str, Any]:
    """The three questions of a model that is built, on the contact points of the simulation."""
    model, end = built.model, _end(scene.analysis)
    names = {_name(load): load for load in model.loads}
    growing = [] if tilt is not None else _growing(names, dead)
    staying = {load.name: load.factor(end) for name, load in names.items() if name not in growing}
    live = group_forces(model, {names[name].name: names[name].factor(end) for name in growing})
    if tilt is not None:
        live = _tilted(scene, model, tilt)
    problem = limit_problem(model, group_forces(model, staying), live, holds=_holds(built))
    summary = {
        "title": scene.title,
        "dead": [name for name in names if name not in growing],
        "growing": growing if tilt is None else [f"tilt {tilt}"],
    }
    return summary | _answers(scene, built, problem, tilt)


def _answers(scene: specs.Scene, built: Built, problem: LimitProblem, tilt: str | None) -> dict[str, Any]:
    """Everything that is told of a problem whose live load is the scene's, or a tilt's."""
    present = float(tilt is None)  # factor of the live load in the scene as it is
    carried = admissible(problem, present)
    collapse = collapse_multiplier(problem) if problem.live.any() else None
    motion = carried.mechanism
    if collapse is not None and collapse.mechanism is not None:
        motion = collapse.mechanism
    return {
        "message": _sentence(carried, collapse, tilt),
        "blocks": len(problem.blocks),
        "contacts": int(problem.active.sum()),
        "admissible": carried.holds,
        "share": carried.share,
        **_multipliers(collapse),
        "mechanism": None if motion is None else _motion(problem, motion),
        "supports": _thrusts(problem, present) if carried.holds else {},
        "certificate": _certificate(carried, collapse),
        "notes": list(_notes(scene, built, problem)),
    }


# --- loads ------------------------------------------------------------------------------------


def _end(analysis: specs.Analysis) -> float:
    """Time at the end of an analysis [s]; the load factor in statics."""
    if isinstance(analysis, specs.Statics):
        return 1.0
    if isinstance(analysis, specs.Dynamics):
        return analysis.duration
    return analysis.step * analysis.max_steps


def _name(load: Load) -> str:
    """Name of a load as a user writes it: ``gravity``, ``points.0``."""
    return load.name.removeprefix("loads.")


def _growing(names: Iterable[str], dead: Sequence[str]) -> list[str]:
    """Loads that grow: all but gravity and those named dead."""
    found = [name for name in names if name != "gravity"]
    for pattern in dead:
        if not any(fnmatchcase(name, pattern) for name in names):
            raise MasonryError(
                f"--dead '{pattern}' names no load of the scene, expected some of {listed(names)}"
            )
    return [name for name in found if not any(fnmatchcase(name, pattern) for pattern in dead)]


def _tilted(scene: specs.Scene, model: Model, tilt: str) -> list[Any]:
    """Force of an acceleration of g along an axis, by body group."""
    axes = "xy"[: scene.dimension - 1]
    if tilt.removeprefix("-") not in axes or len(tilt) > 2:
        expected = ", ".join(f"{axis}, -{axis}" for axis in axes)
        raise MasonryError(f"--tilt is '{tilt}', expected one of {expected} in a {scene.dimension}D scene")
    g = GRAVITY if scene.loads.gravity is None else float(np.linalg.norm(scene.loads.gravity))
    acceleration = np.zeros(scene.dimension)
    acceleration[axes.index(tilt[-1])] = -g if tilt.startswith("-") else g
    return [group.acceleration_force(acceleration) for group in model.groups]


def _holds(built: Built) -> tuple[Hold, ...]:
    """Corners of clamped faces, by held axis: together they hold as the face does."""
    assembly, found = built.stones.assembly, []
    for block, clamps in built.stones.clamps.items():
        solid = assembly.solid(block)
        for clamp in clamps:
            name = f"{assembly.blocks[block].name}/{solid.names[clamp.face]}"
            for point in solid.face_points(clamp.face):
                found += [Hold(block, point, axis, name) for axis in clamp.components]
    return tuple(found)


# --- answers ----------------------------------------------------------------------------------


def _multipliers(collapse: Collapse | None) -> dict[str, Any]:
    if collapse is None:
        return {"multiplier": None, "least_multiplier": None, "unlimited": False}
    return {
        "multiplier": _finite(collapse.multiplier),
        "least_multiplier": _finite(collapse.least),
        "unlimited": math.isinf(collapse.multiplier),
    }


def _sentence(carried: Admissible, collapse: Collapse | None, tilt: str | None) -> str:
    """The verdict in words."""
    words = ["The loads can be carried" if carried.holds else "The loads cannot be carried"]
    if not carried.holds and carried.share > LEAST:
        words[0] += f" (only {carried.share:.4g} of them)"
    if collapse is not None:
        words.append(_growth(collapse, tilt))
    motion = carried.mechanism
    if collapse is not None and collapse.mechanism is not None:
        motion = collapse.mechanism
    if motion is not None:
        words.append(f"At collapse {motion.sentence()}")
    return ". ".join(words) + "."


def _growth(collapse: Collapse, tilt: str | None) -> str:
    """How far the loads may grow."""
    what, unit = ("Those that grow", "times their value") if tilt is None else (f"A tilt to {tilt}", "g")
    if math.isnan(collapse.multiplier):
        return f"{what} cannot be carried to any degree"
    least = f" from {collapse.least:.6g}" if collapse.least > LEAST else ""
    needs = f", and must have {collapse.least:.6g}" if least else ""
    if math.isinf(collapse.multiplier):
        return f"{what} may grow without limit{f'{least} {unit} on' if least else ''}"
    angle = "" if tilt is None else f", {math.degrees(math.atan(collapse.multiplier)):.4g} degrees"
    return f"{what} may reach {collapse.multiplier:.6g} {unit}{angle}{needs}"


def _motion(problem: LimitProblem, motion: Mechanism) -> dict[str, Any]:
    """Sentence, velocities of the centres of blocks that move, and joints, of a mechanism."""
    names = [block.name for block in problem.model.assembly.blocks]
    moving = {name for group in motion.groups for name in group}
    rows = zip(motion.blocks.tolist(), motion.centre, motion.velocity, motion.spin, strict=True)
    return {
        "sentence": motion.sentence(),
        "groups": [list(group) for group in motion.groups],
        "blocks": [
            {"block": names[block], "at": at, "velocity": velocity, "spin": spin}
            for block, at, velocity, spin in rows
            if names[block] in moving
        ],
        "joints": [{"between": list(joint.blocks), "how": joint.how} for joint in motion.joints],
    }


def _thrusts(problem: LimitProblem, present: float) -> dict[str, dict[str, list[float | None]]]:
    """Least and greatest force of each support along each axis [N]; None where nothing bounds it."""
    axes, count = "xyz"[: problem.dimension], range(problem.dimension)
    return {
        name: _intervals(problem, [resultant(axis) for axis in count], axes, present)
        for name, resultant in list(_supports(problem).items())[:MOST]
    }


def _supports(problem: LimitProblem) -> dict[str, Callable[[int], np.ndarray]]:
    """By name of what holds the blocks: coefficients of its force along an axis."""
    found: dict[str, Callable[[int], np.ndarray]] = {}
    model = problem.model
    touched = set(model.contacts.blocks[problem.active].ravel().tolist())
    for group in model.groups:
        for block in group.blocks.tolist() if group.prescribed else ():
            if block in touched:
                name = model.assembly.blocks[block].name
                found[name] = partial(support_resultant, problem, block)
    for hold in problem.holds:
        found[hold.name] = partial(hold_resultant, problem, hold.name)
    return found


def _intervals(
    problem: LimitProblem, rows: Sequence[np.ndarray], axes: str, present: float
) -> dict[str, list[float | None]]:
    ends: list[Interval] = [interval(problem, row, present, carried=True) for row in rows]
    return {axis: [_finite(end.low), _finite(end.high)] for axis, end in zip(axes, ends, strict=True)}


def _certificate(carried: Admissible, collapse: Collapse | None) -> dict[str, float]:
    """How exact the answers are, by measures that the solvers have no say in; all relative."""
    unbalanced, closing, gap = carried.unbalanced, carried.closing, 0.0
    if collapse is not None:
        unbalanced, closing = max(unbalanced, collapse.unbalanced), max(closing, collapse.closing)
        gap = collapse.gap
    return {"unbalanced": unbalanced, "closing": closing, "gap": gap}


def _notes(scene: specs.Scene, built: Built, problem: LimitProblem) -> Iterable[str]:
    """What was left out or taken otherwise than the scene says."""
    if "elastic" in built.stones.role:
        yield "elastic blocks count as rigid"
    if problem.strength.cohesive:
        yield "joints keep their cohesion however far they move"
    idle = int((~problem.active).sum())
    if idle:
        yield f"{idle} contact points stand open and carry nothing"
    if any(support.motion is not None for support in scene.supports):
        yield "motions of supports are left out: the blocks are where they stand at the start"
    supports = len(_supports(problem))
    if not supports:
        yield "no support holds anything"
    if supports > MOST:
        yield f"intervals of the first {MOST} of {supports} supports"


def _finite(value: float) -> float | None:
    """The value, or None where it is infinite or there is none."""
    return float(value) if math.isfinite(value) else None


def reported(scene: specs.Scene, built: Built) -> dict[str, Any]:
    """What a run's summary says; an answer that could not be found says why."""
    try:
        told = cross_check(scene, built)
    except ProblemError as error:
        return {"message": str(error)}
    return {name: value for name, value in told.items() if name != "title"}


def outside(told: Mapping[str, Any], forces: Mapping[str, Any], applied: np.ndarray) -> list[dict[str, Any]]:
    """Forces of a simulation's supports that lie outside their intervals: support, axis and force [N].

    None does in an equilibrium, unless the blocks have moved so far that their shape counts.
    """
    slack = OUTSIDE * float(np.linalg.norm(applied))
    found = []
    for name, axes in told.get("supports", {}).items():
        for (axis, (low, high)), force in zip(axes.items(), forces[name]["force"], strict=True):
            above = high is not None and force > high + slack
            if above or (low is not None and force < low - slack):
                found.append({"support": name, "axis": axis, "force": float(force)})
    return found
