"""What changes in time: factors of loads, motions of supports and clamped faces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.bodies.support import Motion
from masonry_fem.march.shaking import Shaking
from masonry_fem.scene import specs
from masonry_fem.scene.checks import records
from masonry_fem.scene.time_function import Piecewise, Pulses, evaluator


def time_factor(
    scene: specs.Scene, function: specs.TimeFunction | None, base: Path
) -> Callable[[float], float]:
    """The factor of a load as a function of time.

    Parameters
    ----------
    scene : The scene.
    function : What the load says; None for the load factor in statics and 1 otherwise.
    base : Folder that the scene's paths are relative to.

    Raises
    ------
    SceneError : The file of a record cannot be read.
    """
    if function is not None:
        return evaluator(function, base)
    if scene.analysis.ramp < scene.analysis.end and not scene.analysis.inertia:
        return ramp(scene)
    if not scene.analysis.inertia:
        return _itself
    return _one


def motion_of(scene: specs.Scene, motion: specs.Motion, base: Path) -> Motion:
    """A motion as functions of time.

    Parameters
    ----------
    scene : The scene; without a time function of its own the motion grows linearly over the analysis.
    motion : The record.
    base : Folder that the scene's paths are relative to.
    """
    factor = ramp(scene) if motion.time is None else time_factor(scene, motion.time, base)
    return Motion(
        displacement=None if motion.displacement is None else _scaled(motion.displacement, factor),
        rotation=None if motion.rotation is None else _scaled(motion.rotation, factor),
        pivot=None if motion.pivot is None else np.array(motion.pivot, dtype=float),
    )


def ramp(scene: specs.Scene) -> Callable[[float], float]:
    """From 0 to 1 over the load factor, the duration, or the first tenth of the allowed steps."""
    end = scene.analysis.ramp
    return partial(_up_to, end)


def fade(scene: specs.Scene) -> Callable[[float], float]:
    """From 1 to 0 while ``ramp`` goes from 0 to 1."""
    return partial(_down_until, scene.analysis.ramp)


def last_change(scene: specs.Scene, base: Path, ground: Shaking | None = None) -> float:
    """Time after which loads and supports no longer change, oscillations apart [s].

    Parameters
    ----------
    scene : The scene.
    base : Folder that its paths are relative to.
    ground : What shakes it.
    """
    functions = [
        evaluator(record, base)
        for _, record in records(scene)
        if isinstance(record, specs.Table | specs.Record | specs.Pulse)
    ]
    shaken = () if ground is None else ground.components
    ends = [float(one.record.times[-1]) for one in shaken]
    ends += [function.end for function in functions if isinstance(function, Piecewise | Pulses)]
    ends += [_gone(one) for one in scene.loads.moving if one.speed]
    return max([*ends, *_ramps(scene)], default=0.0)


def _ramps(scene: specs.Scene) -> list[float]:
    """Time by which motions and temperatures without a function of time have come to their ends; or none."""
    times = [one.motion.time for one in scene.supports if one.motion is not None]
    times += [one.time for one in scene.loads.temperatures]
    return [scene.analysis.ramp] if None in times else []


def _gone(load: specs.MovingLoad) -> float:
    """Time at which the last axle of a load has left its path [s]."""
    way = float(np.linalg.norm(np.diff(np.array(load.path), axis=0), axis=1).sum())
    behind = max(load.axles) + (0.0 if load.spread is None else load.spread / 2)
    return max((way + behind - load.begin) / load.speed, 0.0)


def _scaled(
    value: tuple[float, ...] | float, factor: Callable[[float], float]
) -> Callable[[float], FloatArray]:
    vector = np.array(value, dtype=float)
    return partial(_times, vector, factor)


# functions with a name of their own: results are pickled with the loads in them


def _itself(load_factor: float) -> float:
    return load_factor


def _one(time: float) -> float:
    return 1.0


def _up_to(end: float, time: float) -> float:
    return min(time / end, 1.0)


def _down_until(end: float, time: float) -> float:
    return 1.0 - _up_to(end, time)


def _times(vector: FloatArray, factor: Callable[[float], float], time: float) -> FloatArray:
    return np.asarray(factor(time) * vector)
