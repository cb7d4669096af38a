"""Limit analysis of a scene: which loads grow, the three questions, and the answers as numbers and words.

    told = analyse(load("arch.toml"), Path("."), tilt="x")
    told.admissible, told.multiplier, told.supports["arch.springing_left"]["x"]

Gravity stays and every other load of the scene grows, unless it is named dead; a tilt makes all loads of
the scene dead and grows a horizontal acceleration of g. Loads are taken as they are at the end of the
analysis, the blocks where they stand at its start.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.analyses.run.reopening import refuse_start
from masonry_fem.build import Built, build
from masonry_fem.errors import MasonryError
from masonry_fem.limit import Hold, LimitProblem, group_forces, limit_problem
from masonry_fem.march.model import Load, Model
from masonry_fem.results.limit import MOST, answers, supports_of
from masonry_fem.results.limit_analysis import LimitAnalysis
from masonry_fem.scene import check, specs
from masonry_fem.scene.misfit import listed

GRAVITY = 9.81  # of a tilt, where the scene has no gravity [m/s²]


@dataclass(frozen=True, slots=True)
class Growth:
    """Loads that stay and loads that grow, as they are at the end of the analysis.

    Attributes
    ----------
    dead, growing : What they are called.
    staying : Factors of the model's loads that stay, by their names in the model.
    live : Forces of those that grow, by body group.
    end : Time at the end [s]; the load factor in statics.
    """

    dead: tuple[str, ...]
    growing: tuple[str, ...]
    staying: dict[str, float]
    live: list[Any]
    end: float


def analyse(
    scene: specs.Scene, base: str | Path = Path(), *, dead: Sequence[str] = (), tilt: str | None = None
) -> LimitAnalysis:
    """Limit analysis of a scene, its blocks taken as rigid.

    It answers whether the loads can be carried, by which factor they may grow, and between which bounds the
    support forces lie.

    Parameters
    ----------
    scene : What to analyse.
    base : Folder that the paths in the scene are relative to.
    dead : Patterns of the loads that do not grow (``points.0``, ``tractions.*``); gravity never does.
    tilt : Axis along which an acceleration grows (``"x"``, ``"-y"``), the multiplier being its size over g;
        the loads do not grow then.

    Raises
    ------
    MasonryError : The scene cannot be built, a joint has no constant strength, or no load has such a name.
    """
    scene = check(scene, base=base)
    refuse_start(scene, "limit analysis")
    return cross_check(scene, build(scene, Path(base), solved=False), dead=dead, tilt=tilt)


def cross_check(
    scene: specs.Scene, built: Built, *, dead: Sequence[str] = (), tilt: str | None = None
) -> LimitAnalysis:
    """The three questions of a model that is built, on the contact points of the simulation.

    Parameters
    ----------
    scene : What was built. built : The model made of it.
    dead, tilt : As ``analyse`` takes them.

    Raises
    ------
    MasonryError : A joint has no constant strength, or nothing is so named.
    """
    problem, growth = posed(scene, built, dead=dead, tilt=tilt)
    return answers(
        problem,
        tilt,
        title=scene.title,
        dead=growth.dead,
        growing=growth.growing,
        notes=tuple(_notes(scene, built, problem)),
    )


def posed(
    scene: specs.Scene, built: Built, *, dead: Sequence[str] = (), tilt: str | None = None
) -> tuple[LimitProblem, Growth]:
    """The limit problem of a model that is built, and which of its loads grow.

    Parameters
    ----------
    scene : What was built. built : The model made of it.
    dead, tilt : As ``analyse`` takes them.

    Raises
    ------
    MasonryError : A joint has no constant strength, or nothing is so named.
    """
    growth = growth_of(scene, built.model, dead=dead, tilt=tilt)
    staying = group_forces(built.model, growth.staying)
    return limit_problem(built.model, staying, growth.live, holds=_holds(built)), growth


# --- loads ------------------------------------------------------------------------------------


def growth_of(
    scene: specs.Scene, model: Model, *, dead: Sequence[str] = (), tilt: str | None = None
) -> Growth:
    """Which loads of a model grow: all but gravity and those named dead, or a tilt alone.

    Parameters
    ----------
    scene : What was built. model : The model made of it.
    dead, tilt : As ``analyse`` takes them.

    Raises
    ------
    MasonryError : No load or axis is so named, or loads are named dead beside a tilt.
    """
    if tilt is not None and dead:
        raise MasonryError(
            f"{listed(dead)} is named dead beside a tilt or an acceleration, expected none: all loads stay "
            "then; leave it out"
        )
    end = scene.analysis.loading.end
    names = {_name(load): load for load in model.loads}
    growing = [] if tilt is not None else _growing(names, dead)
    live = group_forces(model, {names[name].name: names[name].factor(end) for name in growing})
    return Growth(
        dead=tuple(name for name in names if name not in growing),
        growing=tuple(growing) if tilt is None else (f"tilt {tilt}",),
        staying={load.name: load.factor(end) for name, load in names.items() if name not in growing},
        live=live if tilt is None else _tilted(scene, model, tilt),
        end=end,
    )


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
    axes = list("xy"[: scene.dimension - 1])
    if str(tilt).removeprefix("-") not in axes:
        expected = ", ".join(f"{axis}, -{axis}" for axis in axes)
        raise MasonryError(
            f"a tilt or an acceleration along '{tilt}', expected one of {expected} in a "
            f"{scene.dimension}D scene"
        )
    g = float(np.linalg.norm(scene.loads.gravity or 0.0)) or GRAVITY
    acceleration = np.zeros(scene.dimension)
    acceleration[axes.index(tilt[-1])] = -g if tilt.startswith("-") else g
    return [group.acceleration_force(acceleration) for group in model.groups]


def _holds(built: Built) -> tuple[Hold, ...]:
    """Corners of clamped faces, by held axis: together they hold as the face does."""
    assembly, found = built.stones.assembly, []
    for block, clamps in built.stones.clamps.items():
        solid = assembly.solid(block)
        for clamp in clamps:
            name = f"{assembly.blocks.names[block]}/{solid.names[clamp.face]}"
            for point in solid.face_points(clamp.face):
                found += [Hold(block, point, axis, name) for axis in clamp.components or range(len(point))]
    return tuple(found)


def _notes(scene: specs.Scene, built: Built, problem: LimitProblem) -> Iterable[str]:
    """What was left out or taken otherwise than the scene says."""
    yield from scene.design.loads.notes
    if built.stones.deforming:
        yield "elastic blocks count as rigid"
    if yielding := built.stones.yielding:
        first = built.stones.assembly.blocks.names[yielding[0]]
        yield (
            f"inelastic blocks ({len(yielding)}, first '{first}') count as rigid and do not yield or crack: "
            "what is carried here may crush or split them, and nothing spreads in them; give fill as a load"
        )
    if problem.strength.bounded.any():
        yield "ties bear the force at which they yield however far they stretch, and do not harden or snap"
    if problem.strength.cohesive:
        yield "joints keep their cohesion however far they move"
    idle = int((~problem.active).sum())
    if idle:
        yield f"{idle} contact points stand open and carry nothing"
    if any(support.motion is not None for support in scene.supports):
        yield "motions of supports are left out: the blocks are where they stand at the start"
    supports = len(supports_of(problem))
    if not supports:
        yield "no support holds anything"
    if supports > MOST:
        yield f"intervals of the first {MOST} of {supports} supports"
