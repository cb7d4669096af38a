"""From accelerograms to what the ground does: loads on the mass, or motions of supports."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.bodies.support import Clamp, Motion
from masonry_fem.build.stones import Stones
from masonry_fem.march.shaking import Component, GroundMotion, Shaking, corrected
from masonry_fem.records.remark import remark
from masonry_fem.scene import specs
from masonry_fem.scene.accelerogram import read_accelerogram

DEGREES = {"constant": 0, "linear": 1, "quadratic": 2}
DRIFTS = 0.02  # of the greatest velocity: what the ground may keep in the end without a word


def shaking(scene: specs.Scene, base: Path) -> Shaking | None:
    """What shakes the ground of a scene; None where nothing does.

    Parameters
    ----------
    scene : The scene.
    base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : A file is no accelerogram.
    """
    found = []
    for index, one in enumerate(scene.loads.accelerograms):
        for number, axis in enumerate("xyz"[: scene.dimension]):
            name = getattr(one, axis)
            if name is not None:
                times, values = read_accelerogram(base / name, axis, one.unit)
                record = GroundMotion(times, values)
                if one.baseline != "none":
                    record = corrected(record, DEGREES[one.baseline])
                times = record.times - record.times[0] + one.start
                record = GroundMotion(times, one.scale * record.values)
                _doubt(scene, record, f"loads.accelerograms.{index}.{axis} ({name})", one.acts)
                found.append(Component(number, record, one.acts == "ground"))
    return Shaking(tuple(found), scene.dimension) if found else None


def shaken(stones: Stones, ground: Shaking | None) -> Stones:
    """The stones with supports and clamped faces that move with the ground, beside motions of their own.

    Parameters
    ----------
    stones : Of the scene.
    ground : What shakes it.
    """
    if ground is None or not ground.moves:
        return stones
    motion = {block: _moved(stones.motion.get(block), ground) for block in stones.of(None)}
    clamps = {
        block: tuple(Clamp(one.face, one.components, _moved(one.motion, ground)) for one in held)
        for block, held in stones.clamps.items()
    }
    return replace(stones, motion=motion, clamps=clamps)


def _moved(own: Motion | None, ground: Shaking) -> Motion:
    """A motion carried by the ground."""
    if own is None:
        return Motion(displacement=ground.shift)
    way = own.displacement
    if way is None:
        return replace(own, displacement=ground.shift)
    return replace(own, displacement=partial(_carried, way, ground))


def _carried(way: Callable[[float], FloatArray], ground: Shaking, time: float) -> FloatArray:
    return np.asarray(way(time)) + ground.shift(time)


def _doubt(scene: specs.Scene, record: GroundMotion, name: str, acts: str) -> None:
    """Say where a record is not what a march makes of it."""
    step = float(np.diff(record.times).min())
    taken = getattr(scene.analysis, "step", step)
    if taken > step * (1 + 1e-9):
        remark(
            "coarse_record",
            f"{name} has a value every {step:g} s, and analysis.step is {taken:g} s: peaks between steps are "
            f"missed; expected at most {step:g} s",
        )
    end, most = float(record.velocities[-1]), float(np.abs(record.velocities).max())
    if acts == "ground" and abs(end) > DRIFTS * most:
        remark(
            "drifting_ground",
            f"{name} leaves the ground with {end:.3g} m/s, where its greatest velocity is {most:.3g} m/s: it "
            "drifts on; expected none at the end, see loads.accelerograms.baseline",
        )
