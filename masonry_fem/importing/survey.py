"""Survey: a wall from the measured faces of its stones.

The wall's plane is fitted to the corners, and the polygons are projected on it, snapped together
(``snapping``) and extruded to the wall's depth. Every change is reported: how far corners were moved, and
what was left
open, cut or dropped.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.foreign import check_points
from masonry_fem.importing.snapping import crosses_itself, snapped
from masonry_fem.importing.survey_reading import Measured, read_survey
from masonry_fem.importing.triangles import area_vector
from masonry_fem.importing.wall_plane import WallPlane
from masonry_fem.records.remark import first_few, remark
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.solid.prism import prism

if TYPE_CHECKING:
    from masonry_fem.structures.survey import SurveyStructure

UPWARDS = np.cos(np.radians(45))  # of a side's normal: beyond it is a top or a bottom
STEEP, FLAT = np.cos(np.radians(60)), np.cos(np.radians(30))  # of a joint's direction: head, bed
LEVELS = 4.0  # tolerances: height within which stones stand on the ground
MARGIN = 0.25  # [m] of the ground beyond the stones, and its thickness
PROJECTING = 5.0  # tolerances off the wall's plane that are worth a warning
SHOWN = 5

logger = logging.getLogger(__name__)


def read(spec: SurveyStructure, dimension: int, base: Path) -> Assembly:
    """Blocks named after the stones, and ``name.ground``.

    Parameters
    ----------
    spec : Record of the survey in the scene.
    dimension : 2 or 3.
    base : Folder that the path is relative to.

    Raises
    ------
    GeometryError : The file is no survey; stones whose sides cross, that overlap, or stand on nothing.
    """
    key = f"structures.{spec.name}.path"
    path = base / spec.path
    if not path.is_file():
        raise GeometryError(
            f"{key}: there is no file '{path}'; correct the path (it is relative to the scene)"
        )
    title = f"{key} '{spec.path}'"
    stones = [Measured(one.name, spec.scale * one.corners) for one in read_survey(path, title, spec.scale)]
    check_points(np.concatenate([stone.corners for stone in stones]), title)
    plane, outlines = _laid(stones, spec, title)
    names = [stone.name for stone in stones]
    if spec.ground:
        outlines, names = [*outlines, _ground(outlines, spec.tolerance)], [*names, "ground"]
    made, report = snapped(outlines, names, spec.tolerance, title)
    report.tell(title, spec.name)
    _check_supports(spec, names)
    kept = [(name, outline) for name, outline in zip(names, made, strict=True) if outline is not None]
    pose = plane.pose if dimension == 3 else Pose.identity(2)
    return Assembly(
        dimension,
        tuple(_shape(f"{spec.name}.{name}", outline, spec.depth, dimension) for name, outline in kept),
        tuple(
            Block(f"{spec.name}.{name}", number, pose, (spec.name,), _is_support(spec, name))
            for number, (name, _) in enumerate(kept)
        ),
    )


def _laid(
    stones: Sequence[Measured], spec: SurveyStructure, title: str
) -> tuple[WallPlane, list[FloatArray]]:
    """The wall's plane and the outlines in it, all counter-clockwise."""
    areas = np.array([area_vector(stone.corners) for stone in stones])
    size = np.array([float(np.ptp(stone.corners, axis=0).max()) for stone in stones])
    thin = np.flatnonzero(np.linalg.norm(areas, axis=1) <= spec.tolerance * size)
    if len(thin):
        raise GeometryError(
            f"{title}, stone '{stones[thin[0]].name}' is thinner than the tolerance ({spec.tolerance:g} m), "
            "expected a polygon around its face; correct its corners"
        )
    points = np.concatenate([stone.corners for stone in stones])
    outward = areas.sum(axis=0) if spec.outward is None else np.array(spec.outward, dtype=float)
    plane = WallPlane.fit(points, outward)
    _tell_plane(plane, stones, spec, title)
    turned = np.flatnonzero(areas @ plane.outward < 0)
    if len(turned):
        remark(
            "turned_stones",
            f"{title}: {len(turned)} stones run clockwise seen from outside and were turned round: "
            f"{_named(stones, turned.tolist())}; name the wall's 'outward' direction where that is wrong",
            *(f"{spec.name}.{stones[row].name}" for row in turned.tolist()),
        )
    outlines = [plane.flat(stone.corners) for stone in stones]
    for row in turned.tolist():
        outlines[row] = outlines[row][::-1]
    for stone, outline in zip(stones, outlines, strict=True):
        if crosses_itself(outline):
            raise GeometryError(
                f"{title}, stone '{stone.name}': its sides cross, expected corners in order around the face; "
                "number them so"
            )
    return plane, outlines


def _tell_plane(plane: WallPlane, stones: Sequence[Measured], spec: SurveyStructure, title: str) -> None:
    """Say how far the corners lie from the plane that they are laid into."""
    away = [float(np.abs(plane.height(stone.corners)).max()) for stone in stones]
    heights = plane.height(np.concatenate([stone.corners for stone in stones]))
    logger.info(
        "%s: %d stones, %.2g mm off the wall's plane in the mean square, at most %.2g mm",
        title, len(stones), 1e3 * float(np.sqrt(np.mean(heights**2))), 1e3 * max(away),
    )  # fmt: skip
    far = [row for row in np.argsort(away)[::-1].tolist() if away[row] > PROJECTING * spec.tolerance]
    if far:
        remark(
            "projecting_stones",
            f"{title}: {len(far)} stones lie up to {away[far[0]]:.3g} m off the wall's plane and were laid "
            f"into it: {_named(stones, far)}; survey a wall in each file, or take projecting stones out",
            *(f"{spec.name}.{stones[row].name}" for row in far),
        )


def _named(stones: Sequence[Measured], rows: Sequence[int]) -> str:
    return first_few((f"'{stones[row].name}'" for row in rows), SHOWN)


def _ground(outlines: Sequence[FloatArray], tolerance: float) -> FloatArray:
    """Level rectangle below the lowest stones, its top at the median of their feet."""
    corners = np.concatenate(outlines)
    feet = [outline[np.argsort(outline[:, 1])[:2], 1].mean() for outline in outlines]
    level = float(np.median([foot for foot in feet if foot <= min(feet) + LEVELS * tolerance]))
    left, right = corners[:, 0].min() - MARGIN, corners[:, 0].max() + MARGIN
    low = level - MARGIN
    return np.array([[left, low], [right, low], [right, level], [left, level]])


def _shape(name: str, outline: FloatArray, depth: float, dimension: int) -> Shape:
    """A stone, its sides named and labelled by where they look."""
    sides = np.roll(outline, -1, axis=0) - outline
    along = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    names = [
        ("top" if x < 0 else "bottom") if abs(x) >= UPWARDS else ("right" if z > 0 else "left")
        for x, z in along
    ]
    labels = ["bed" if abs(x) >= FLAT else "head" if abs(x) <= STEEP else "inclined" for x, _ in along]
    return Shape(name, prism(outline, names, labels, depth, dimension))


def _is_support(spec: SurveyStructure, name: str) -> bool:
    return (spec.ground and name == "ground") or any(_matches(spec, name, one) for one in spec.supports)


def _matches(spec: SurveyStructure, name: str, pattern: str) -> bool:
    return fnmatchcase(name, pattern) or fnmatchcase(f"{spec.name}.{name}", pattern)


def _check_supports(spec: SurveyStructure, names: Sequence[str]) -> None:
    for index, pattern in enumerate(spec.supports):
        if not any(_matches(spec, name, pattern) for name in names):
            raise GeometryError(
                f"structures.{spec.name}.supports.{index} = '{pattern}' selects no stone of the survey; "
                f"there are {', '.join(names[:8])}"
            )
