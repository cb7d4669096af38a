"""Problem file: supports, friction and loads of a COMPAS file, beside its blocks, as records of a scene.

    scene = with_conditions(scene, base)        # the scene, completed by its problem files

A ``Problem`` of compas_dem holds a model, boundary conditions by the numbers of its blocks, and one contact
model. What the scene itself says has precedence: its gravity, its joints, and the motion of a block that both
hold. Gravity and accelerations act on everything; if several files give the same, they are taken once.
A structure whose conditions have been taken is replaced by its blocks alone: they are not taken twice.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from masonry_fem.errors import SceneError
from masonry_fem.records.remark import remark
from masonry_fem.records.structure import Structure
from masonry_fem.scene import specs

IGNORED = ("c", "t_c", "k_n", "k_t")  # of a contact model: cohesion, tension, stiffnesses


def with_conditions(scene: specs.Scene, base: Path) -> specs.Scene:
    """The scene with the conditions of its problem files; the same scene where there are none.

    Parameters
    ----------
    scene : The scene.
    base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : A condition cannot be read, is not available in this program, or contradicts another file.
    """
    if scene.dimension != 3:
        return scene  # that such files need 3D is reported when their blocks are read
    own = scene
    for index, structure in enumerate(scene.structures):
        file = structure.problem
        problem = None if file is None else _problem(base / file.path)
        if file is None or problem is None:
            continue
        title = f"structures.{structure.name}.path '{file.path}'"
        try:
            found = _Conditions.of(problem, structure.name, file.scale, title)
        except (KeyError, TypeError, ValueError, AttributeError, IndexError, ArithmeticError) as error:
            raise SceneError(
                f"{title}: its boundary conditions cannot be read ({type(error).__name__}: {error}), "
                "expected those of compas_dem 0.5; save it again, or set conditions = false and give them "
                "in the scene"
            ) from error
        rest = (*scene.structures[:index], structure.blocks_alone(), *scene.structures[index + 1 :])
        scene = found.joined(replace(scene, structures=rest), own, structure, title)
    return scene


def _problem(path: Path) -> dict[str, Any] | None:
    """Content of a problem; None for other files: reading blocks tells those that are no JSON."""
    if path.suffix.lower() != ".json":
        return None
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    inner = _data(record)
    return inner if isinstance(inner, dict) and "model" in inner and "boundary_conditions" in inner else None


def _data(record: Any) -> Any:
    """What a COMPAS record wraps."""
    return record.get("data", record) if isinstance(record, dict) and "dtype" in record else record


@dataclass(frozen=True, slots=True)
class _Conditions:
    """What a problem says of its blocks, as records of a scene."""

    supports: tuple[specs.Support, ...]
    points: tuple[specs.PointForce, ...]
    accelerations: tuple[specs.Acceleration, ...]
    gravity: float | None
    friction: float | None
    passed: tuple[str, ...]

    @classmethod
    def of(cls, problem: dict[str, Any], name: str, scale: float, title: str) -> _Conditions:
        """Read the conditions of structure ``name``; lengths are multiplied by ``scale``."""
        told = _data(problem["boundary_conditions"]) or {}
        held: dict[str, dict[str, Any]] = {}
        for one in told.get("displacements") or ():
            own = held.setdefault(_block(name, one), {})
            own |= {key: one[key] for key in ("translation", "rotation") if one.get(key) is not None}
        friction, passed = _friction(problem)
        return cls(
            supports=tuple(_support(block, own, scale) for block, own in held.items()),
            points=(*_point_loads(told, name, scale, title), *_pressures(told, name, scale)),
            accelerations=tuple(
                specs.Acceleration(vector=tuple(map(float, one))) for one in told.get("body_forces") or ()
            ),
            gravity=float(told.get("g", 9.81)) if told.get("gravity") else None,
            friction=friction,
            passed=passed,
        )

    def joined(self, scene: specs.Scene, own: specs.Scene, structure: Structure, title: str) -> specs.Scene:
        """The scene with these conditions where it has none of its own; says what was taken.

        ``own`` is the scene before any file was read.
        """
        said = [f"{len(self.supports)} supports", f"{len(self.points)} forces"]
        stands = [f"its {key} is passed over" for key in self.passed]
        loads = replace(scene.loads, points=(*scene.loads.points, *self.points))
        if self.accelerations:
            loads = replace(loads, accelerations=self._accelerations(scene, own, title))
            said.append(f"{len(self.accelerations)} accelerations of everything")
        if self.gravity is not None and own.loads.gravity is None:
            loads = replace(loads, gravity=self._gravity(scene, title))
            said.append(f"gravity {self.gravity:g} m/s²")
        elif self.gravity is not None:
            stands.append("gravity is that of the scene")
        joints = scene.joints
        if self.friction is not None and own.joints == (specs.Joint(),):
            between = (structure.name, structure.name)
            joints = (*joints, specs.Joint(friction=self.friction, between=between))
            said.append(f"friction {self.friction:g}")
        elif self.friction is not None:
            stands.append(f"friction is that of the scene's joints, not {self.friction:g}")
        others = "".join(f", {one}" for one in (*stands, "materials are those of the scene"))
        remark(
            "problem_file",
            f"{title} is a problem of compas_dem: {', '.join(said)} are taken from it{others}; "
            "conditions = false takes the blocks alone",
        )
        supports = (*self.supports, *scene.supports)
        return replace(scene, supports=supports, loads=loads, joints=joints)

    def _accelerations(
        self, scene: specs.Scene, own: specs.Scene, title: str
    ) -> tuple[specs.Acceleration, ...]:
        """The scene's own, and those of all files."""
        before = scene.loads.accelerations[len(own.loads.accelerations) :]
        if before and before != self.accelerations:
            raise _denied(title, "accelerations", [one.vector for one in self.accelerations])
        return (*own.loads.accelerations, *self.accelerations)

    def _gravity(self, scene: specs.Scene, title: str) -> tuple[float, ...]:
        """That of all files."""
        assert self.gravity is not None
        gravity = (0.0, 0.0, -self.gravity)
        if scene.loads.gravity not in (None, gravity):
            raise _denied(title, "gravity", gravity)
        return gravity


def _denied(title: str, what: str, found: Any) -> SceneError:
    return SceneError(
        f"{title}: its {what} {found} acts on everything, expected what the problem file before it has; make "
        "them one, or set conditions = false and give loads in the scene"
    )


def _block(name: str, told: dict[str, Any]) -> str:
    """The block that a condition names."""
    return f"{name}.b{int(told['block_index'])}"


def _support(block: str, told: dict[str, Any], scale: float) -> specs.Support:
    """A block that is held, or moved as it is told."""
    moved = [scale * float(x) for x in told.get("translation") or (0.0,) * 3]
    turned = [float(x) for x in told.get("rotation") or (0.0,) * 3]
    if not any(moved) and not any(turned):
        return specs.Support(on=block)
    motion = specs.Motion(displacement=tuple(moved), rotation=tuple(turned) if any(turned) else None)
    return specs.Support(on=block, motion=motion)


def _point_loads(told: dict[str, Any], name: str, scale: float, title: str) -> Iterator[specs.PointForce]:
    """Forces at points."""
    for one in told.get("point_loads") or ():
        if any(one.get("moment") or ()):
            raise SceneError(
                f"{title}: the load on block {one['block_index']} has a moment, expected a force at a point; "
                "give it as two forces in the scene, with conditions = false here"
            )
        at = one.get("point")
        yield specs.PointForce(
            block=_block(name, one),
            vector=tuple(map(float, one["force"])),
            point=None if at is None else tuple(scale * float(x) for x in _data(at)),
        )


def _pressures(told: dict[str, Any], name: str, scale: float) -> Iterator[specs.PointForce]:
    """Resultants of pressures, at the middles of their polygons."""
    for one in told.get("surface_loads") or ():
        corners = [[scale * float(x) for x in _data(point)] for point in _data(one["polygon"])["points"]]
        area, middle = _area(corners)
        size = math.hypot(*area)
        given = one.get("direction")
        along = [x / size for x in area] if given is None else [float(x) for x in _data(given)]
        yield specs.PointForce(
            block=_block(name, one),
            vector=tuple(float(one["magnitude"]) * size * x for x in along),
            point=middle,
        )


def _area(corners: Sequence[Sequence[float]]) -> tuple[list[float], tuple[float, ...]]:
    """Area vector of a plane polygon [m²] and its centroid [m]."""
    first, total, middle = corners[0], [0.0] * 3, [0.0] * 3
    pieces = []
    for a, b in pairwise(corners[1:]):
        u, v = ([x - y for x, y in zip(one, first, strict=True)] for one in (a, b))
        cross = [u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)]
        pieces.append((cross, [sum(xs) / 3 for xs in zip(first, a, b, strict=True)]))
        total = [x + y / 2 for x, y in zip(total, cross, strict=True)]
    size = math.hypot(*total)
    if size == 0:
        raise ValueError(f"a pressure on a polygon of {len(corners)} corners without area")
    for cross, place in pieces:  # some are negative, if the polygon is not convex
        share = sum(x * y for x, y in zip(cross, total, strict=True)) / (2 * size * size)
        middle = [x + share * y for x, y in zip(middle, place, strict=True)]
    return total, tuple(middle)


def _friction(problem: dict[str, Any]) -> tuple[float | None, tuple[str, ...]]:
    """Coefficient of the contact model, and what else it and the joint model say."""
    properties = _data(problem.get("contact_properties")) or {}
    model = _data(properties.get("contact_model")) or {}
    passed = tuple(f"{key} = {model[key]:g}" for key in IGNORED if model.get(key))
    if properties.get("joint_model"):
        passed = (*passed, "joint model")
    if model.get("mu") is not None:
        return float(model["mu"]), passed
    return (None if model.get("phi") is None else math.tan(math.radians(float(model["phi"])))), passed
