"""Turning: a whole scene turned in space: its stones' shapes and poses, its loads and its motions.

    result = solve_turned(scene, rotation_of(3, 30.0))

Stones are turned once they are meshed, before anything else is made of them. Shapes are turned in their own
frames, too, so that elements are assembled with other coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.build import model as building
from masonry_fem.build.stones import Stones, meshed
from masonry_fem.host.phases import At
from masonry_fem.scene.specs import Loads, Motion, Scene
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose

FloatArray = NDArray[np.float64]


def rotation_of(dimension: int, angle: float, axis: Sequence[float] = (1.0, 2.0, 3.0)) -> FloatArray:
    """By ``angle`` [deg], in 3D about ``axis``."""
    a = np.radians(angle)
    if dimension == 2:
        return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    along = np.array(axis) / np.linalg.norm(axis)
    return Rotation.from_rotvec(a * along).as_matrix()


def solve_turned(scene: Scene, rotation: FloatArray, base: Path = Path()) -> RunResult:
    """The turned scene's result; turn its vectors back to compare them."""
    with turned(rotation):
        return solve_scene(turned_scene(scene, rotation), base)


@contextmanager
def turned(rotation: FloatArray) -> Iterator[None]:
    """All stones that are meshed meanwhile are turned about the origin."""

    def meshed_and_turned(stones: Stones, before: Stones | None = None, at: At | None = None) -> Stones:
        made = meshed(stones, before, at)
        return replace(made, assembly=_assembly(made.assembly, rotation))

    with patch.object(building, "meshed", meshed_and_turned):
        yield


def turned_scene(scene: Scene, rotation: FloatArray) -> Scene:
    """Its vectors turned: loads, motions, probes, starting velocities; structures stay as they are."""

    def vector(value: Any) -> Any:
        return None if value is None else tuple(float(x) for x in rotation @ np.array(value))

    def motion(value: Motion | None) -> Motion | None:
        if value is None:
            return None
        turn = value.rotation
        return msgspec.structs.replace(
            value,
            displacement=vector(value.displacement),
            rotation=vector(turn) if isinstance(turn, tuple) else turn,
            pivot=vector(value.pivot),
        )

    def each(records: tuple[Any, ...], *keys: str) -> tuple[Any, ...]:
        return tuple(
            msgspec.structs.replace(one, **{key: vector(getattr(one, key)) for key in keys})
            for one in records
        )

    loads = scene.loads
    return msgspec.structs.replace(
        scene,
        loads=Loads(
            gravity=vector(loads.gravity),
            gravity_time=loads.gravity_time,
            accelerations=each(loads.accelerations, "vector"),
            tractions=each(loads.tractions, "vector"),
            points=each(loads.points, "vector", "point"),
            lines=each(loads.lines, "vector", "start", "end"),
        ),
        probes=each(scene.probes, "point"),
        initial=each(scene.initial, "velocity"),
        supports=tuple(msgspec.structs.replace(one, motion=motion(one.motion)) for one in scene.supports),
    )


def _assembly(assembly: Assembly, rotation: FloatArray) -> Assembly:
    shapes = tuple(_shape(shape, rotation) for shape in assembly.shapes)
    blocks = tuple(_block(block, rotation) for block in assembly.blocks)
    return Assembly(assembly.dimension, shapes, blocks)


def _shape(shape: Shape, rotation: FloatArray) -> Shape:
    """In a frame turned back against the shape: x = R X becomes the new coordinates of the same stone."""
    mesh = shape.mesh
    arcs = tuple((a, b, tuple(float(x) for x in rotation @ np.array(centre))) for a, b, centre in shape.arcs)
    return replace(
        shape,
        solid=shape.solid.moved(Pose(rotation, np.zeros(len(rotation)))),
        mesh=None if mesh is None else replace(mesh, points=mesh.points @ rotation.T),
        arcs=arcs,
    )


def _block(block: Block, rotation: FloatArray) -> Block:
    """Its pose between turned frames: R P Rᵀ."""
    pose = block.pose
    return replace(
        block,
        pose=Pose(rotation @ pose.rotation @ rotation.T, rotation @ pose.translation),
    )
