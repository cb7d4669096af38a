"""From load records to force patterns by body group."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.bodies.base import BodyGroup, FloatArray
from masonry_fem.build.selection import select_blocks
from masonry_fem.build.stones import Stones, faces_of
from masonry_fem.build.supports import time_factor
from masonry_fem.build.track import TrackFaces, lines_across, track_of
from masonry_fem.errors import SceneError
from masonry_fem.march.model import Load
from masonry_fem.march.moving import Travel
from masonry_fem.march.shaking import Shaking
from masonry_fem.scene import specs
from masonry_fem.scene.selector import only, split_face
from masonry_fem.solid.submerged import Submerged

ACROSS = 8  # lines, side by side, of a load that moves with a width
LINE_POINTS = 20  # equal pieces of a line force, each at its middle


class Patterns:
    """Makes force patterns: arrays for the groups that a load acts on, None for the others."""

    def __init__(self, stones: Stones, groups: tuple[BodyGroup, ...]) -> None:
        self.stones, self.groups = stones, groups
        self.place: dict[int, tuple[int, int]] = {}
        for index, group in enumerate(groups):
            bodies = zip(repeat(index), range(len(group.blocks)))
            self.place |= zip(group.blocks.tolist(), bodies, strict=True)

    def acceleration(self, vector: FloatArray) -> tuple[FloatArray | None, ...]:
        """Body force on everything that is free to move."""
        return tuple(None if group.prescribed else group.acceleration_force(vector) for group in self.groups)

    def traction(self, load: specs.Traction, key: str) -> tuple[FloatArray | None, ...]:
        """Traction on all matching faces of all matching blocks."""
        blocks, face = split_face(load.on)
        if face is None:
            raise SceneError(f"{key}.on is '{load.on}', expected 'blocks/face', e.g. 'wall.c5.*/top'")
        total: list[FloatArray | None] = [None] * len(self.groups)
        for block in self._free(blocks, f"{key}.on"):
            group, body = self.place[block]
            for number in faces_of(self.stones.assembly, block, face, f"{key}.on"):
                _add(total, group, self.groups[group].traction_force(body, number, np.array(load.vector)))
        return tuple(total)

    def pressure(self, load: specs.PressureLoad, key: str) -> tuple[FloatArray | None, ...]:
        """Pressure on all matching faces of all matching blocks, against their normals in the reference."""
        blocks, face = split_face(load.on)
        assert face is not None  # selectors of faces name one
        factor = None if load.level is None else Submerged(load.level, load.pressure, load.unit_weight)
        total: list[FloatArray | None] = [None] * len(self.groups)
        for block in self._free(blocks, f"{key}.on"):
            group, body = self.place[block]
            own = self.stones.assembly.blocks[block]
            solid = self.stones.assembly.shapes[own.shape].solid
            for number in faces_of(self.stones.assembly, block, face, f"{key}.on"):
                inwards = -(own.pose.rotation @ solid.normal(number))
                traction = inwards if factor is not None else load.pressure * inwards
                _add(total, group, self.groups[group].traction_force(body, number, traction, factor))
        return tuple(total)

    def point(self, load: specs.PointForce, key: str) -> tuple[FloatArray | None, ...]:
        """A force at a point of a block, or at its centroid."""
        where = None if load.point is None else np.array(load.point)
        return self._forces(load.block, [where], np.array(load.vector), key)

    def line(self, load: specs.LineForce, key: str) -> tuple[FloatArray | None, ...]:
        """A force along a line, as one at the middle of each of its equal pieces."""
        start, end = np.array(load.start), np.array(load.end)
        at = (np.arange(LINE_POINTS) + 0.5) / LINE_POINTS
        share = np.array(load.vector) * np.linalg.norm(end - start) / LINE_POINTS
        return self._forces(load.block, [start + s * (end - start) for s in at], share, key)

    def faces(self, on: str, key: str) -> TrackFaces:
        """The matching faces of all matching blocks."""
        blocks, face = split_face(on)
        assert face is not None  # selectors of faces name one
        found = []
        for block in self._free(blocks, key):
            own = self.stones.assembly.blocks[block]
            solid = self.stones.assembly.shapes[own.shape].solid
            for number in faces_of(self.stones.assembly, block, face, key):
                found.append((*self.place[block], own.pose.to_world(solid.face_points(number))))
        return TrackFaces.of(found)

    def _forces(
        self, block: str, points: Sequence[FloatArray | None], force: FloatArray, key: str
    ) -> tuple[FloatArray | None, ...]:
        """The same force at each of the points of one block (None: its centroid)."""
        total: list[FloatArray | None] = [None] * len(self.groups)
        what = f"{key}.block"
        group, body = self.place[
            only(self._free(block, what), block, self.stones.assembly.blocks.names, what)
        ]
        for point in points:
            _add(total, group, self.groups[group].point_force(body, point, force))
        return tuple(total)

    def _free(self, selector: str, key: str) -> list[int]:
        chosen = select_blocks(selector, self.stones.assembly.blocks, key)
        held = [block for block in chosen if self.stones.fidelity[block] is None]
        if held and len(held) == len(chosen):
            name = self.stones.assembly.blocks.names[held[0]]
            raise SceneError(
                f"{key}: '{name}' is a support, so a load on it does nothing; choose a free block"
            )
        return [block for block in chosen if block not in set(held)]


def _add(total: list[FloatArray | None], group: int, force: FloatArray) -> None:
    present = total[group]
    total[group] = force if present is None else present + force


PATTERNS: dict[str, Callable[[Patterns, Any, str], tuple[FloatArray | None, ...]]] = {
    "tractions": Patterns.traction, "pressures": Patterns.pressure, "points": Patterns.point,
    "lines": Patterns.line,
}  # fmt: skip


def loads(
    scene: specs.Scene,
    stones: Stones,
    groups: tuple[BodyGroup, ...],
    base: Path,
    ground: Shaking | None = None,
) -> tuple[Load, ...]:
    """All loads of a scene.

    Parameters
    ----------
    scene : The scene.
    stones : Its blocks.
    groups : Its bodies.
    base : Folder that its paths are relative to.
    ground : What shakes it.

    Raises
    ------
    SceneError : A selector selects nothing, or what a load cannot act on.
    """
    patterns = Patterns(stones, groups)
    made = list(_inertial(scene, patterns, base, ground))
    for kind, pattern in PATTERNS.items():
        for index, load in enumerate(getattr(scene.loads, kind)):
            key = f"loads.{kind}.{index}"
            factor = time_factor(scene, load.time, base)
            made.append(Load(key, pattern(patterns, load, key), factor, follows=kind == "pressures"))
    for index, moving in enumerate(scene.loads.moving):
        key = f"loads.moving.{index}"
        travel = _travel(patterns, moving, _place(scene, moving), key)
        forces = travel.forces(groups, travel.place(0.0))
        made.append(Load(key, forces, time_factor(scene, moving.time, base), travel))
    return tuple(_factored(load, scene.design.loads) for load in made)


def _inertial(scene: specs.Scene, patterns: Patterns, base: Path, ground: Shaking | None) -> Iterator[Load]:
    """What acts on all mass: gravity, other accelerations, and those of a ground that stays."""
    wanted = scene.loads
    if wanted.gravity is not None:
        factor = time_factor(scene, wanted.gravity_time, base)
        yield Load("gravity", patterns.acceleration(np.array(wanted.gravity)), factor)
    for index, body_force in enumerate(wanted.accelerations):
        factor = time_factor(scene, body_force.time, base)
        yield Load(f"accelerations.{index}", patterns.acceleration(np.array(body_force.vector)), factor)
    for index, one in enumerate(() if ground is None else ground.components):
        if not one.moves:
            force = patterns.acceleration(-np.eye(scene.dimension)[one.axis])
            yield Load(f"accelerograms.{index}", force, one.record.acceleration)


def _factored(load: Load, factors: specs.LoadFactors) -> Load:
    """A load times the partial factor of its kind."""
    factor: float = getattr(factors, load.name.removeprefix("loads.").partition(".")[0])
    if factor == 1.0:
        return load
    forces = tuple(None if force is None else factor * force for force in load.forces)
    return replace(load, forces=forces, travel=None if load.travel is None else load.travel.scaled(factor))


def _travel(patterns: Patterns, load: specs.MovingLoad, place: Callable[[float], float], key: str) -> Travel:
    """How a load moves over the faces that it meets."""
    path, force = np.array(load.path), np.array(load.vector)
    across = [0.0] if load.width is None else list(lines_across(load.width, ACROSS))
    track = track_of(patterns.faces(load.on, f"{key}.on"), path, force, np.array(across))
    behind = np.array(load.axles)
    spread = 0.0 if load.spread is None else load.spread
    half = 0.5 * spread + behind.max()
    way = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    if not ((track.end > load.begin - half) & (track.start < way + half)).any():
        raise SceneError(
            f"{key}.path goes over none of the faces of {key}.on = '{load.on}', as seen along {key}.vector = "
            f"{list(load.vector)}; let it, or name other faces"
        )
    return Travel(track, path, force, behind, spread, place)


def _place(scene: specs.Scene, load: specs.MovingLoad) -> Callable[[float], float]:
    """How far along its path a load is at a time."""
    if scene.analysis.inertia:
        return partial(_at_speed, load.begin, load.speed)
    way = float(np.linalg.norm(np.diff(np.array(load.path), axis=0), axis=1).sum())
    return partial(_between, scene.analysis.travelled, load.begin, way)


def _at_speed(begin: float, speed: float, time: float) -> float:
    return begin + speed * time


def _between(travelled: Callable[[float], float], begin: float, way: float, time: float) -> float:
    return begin + travelled(time) * (way - begin)
