"""Skin: the surface of one block as polygons, before it is known to be closed.

    skin = Skin("key", points, loops, names=("crown",) * 6)
    shape = shape_of(skin, "structures.arch.path 'arch.stl'")

Corners that coincide are merged, the surface is checked (closed, consistently oriented, of positive volume),
and neighbouring polygons of the same plane and name become one face of the solid.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from masonry_fem.errors import GeometryError
from masonry_fem.importing.foreign import LARGEST, SMALLEST, check_points
from masonry_fem.importing.outline import outline
from masonry_fem.importing.sewing import bodies_of
from masonry_fem.importing.triangles import area_vector, triangles_of
from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

COINCIDENT = 1e-6  # of a block's size: corners that are nearer to each other coincide
THIN = 1e-9  # of its bounding box: smaller volumes count as zero
FLAT = (
    2e-5  # sine of the angle between faces of one plane: single precision in files makes them differ so much
)
UNNAMED = "joint"

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Skin:
    """Polygons that bound a block.

    Attributes
    ----------
    name : The block's, without that of its structure.
    points : Corners [m], shape (n, 3); several may stand in one place.
    loops : Polygons, counter-clockwise seen from outside.
    names : Of the polygons ("" for none); () where none has one. Also the joint labels of the faces.
    support : Whether the file says that the block is held.
    doubles : Polygons that the file has a second time, the same way round; they are left out.
    """

    name: str
    points: FloatArray
    loops: tuple[tuple[int, ...], ...]
    names: tuple[str, ...] = ()
    support: bool = False
    doubles: int = 0

    def part(self, name: str, rows: list[int]) -> Skin:
        """Some of the polygons with the corners that they use, as a skin of its own.

        Parameters
        ----------
        name : The part's.
        rows : Which polygons.
        """
        used = np.unique([vertex for row in rows for vertex in self.loops[row]])
        place = {int(vertex): at for at, vertex in enumerate(used)}
        return replace(
            self,
            name=name,
            points=self.points[used],
            loops=tuple(tuple(place[vertex] for vertex in self.loops[row]) for row in rows),
            names=tuple(self.names[row] for row in rows) if self.names else (),
        )


def rows_by[Key](keys: Iterable[Key]) -> dict[Key, list[int]]:
    """Where each key stands in a sequence, in the order in which they first appear."""
    rows: dict[Key, list[int]] = {}
    for row, key in enumerate(keys):
        rows.setdefault(key, []).append(row)
    return rows


def once(skin: Skin) -> Skin:
    """The skin without polygons that stand in it a second time, the same way round."""
    _, loops = _welded(skin)
    seen: dict[tuple[int, ...], int] = {}
    for row, loop in enumerate(loops):
        seen.setdefault(_from_least(loop), row)
    if len(seen) == len(loops):
        return skin
    rows = list(seen.values())
    return replace(
        skin,
        loops=tuple(skin.loops[row] for row in rows),
        names=tuple(skin.names[row] for row in rows) if skin.names else (),
        doubles=skin.doubles + len(loops) - len(rows),
    )


def _from_least(loop: tuple[int, ...]) -> tuple[int, ...]:
    """The same loop, begun at its least corner."""
    first = loop.index(min(loop)) if loop else 0
    return loop[first:] + loop[:first]


def parts_of(skin: Skin, mark: str) -> list[Skin]:
    """The connected bodies of a surface, each as a skin of its own.

    Parameters
    ----------
    skin : The surface.
    mark : Goes between the skin's name and the number of the body. If it is not empty, a single body keeps
        its name.
    """
    if not np.isfinite(skin.points).all():
        return [skin]  # which ``shape_of`` refuses
    skin = once(skin)
    corner, loops = _welded(skin)
    bodies = rows_by(bodies_of(_places(skin, corner), loops).tolist()).values()
    if len(bodies) == 1 and mark:
        return [skin]
    parts = [skin.part(f"{skin.name}{mark}{count}", rows) for count, rows in enumerate(bodies, start=1)]
    return parts[:1] + [replace(part, doubles=0) for part in parts[1:]]  # they are told once


def shape_of(skin: Skin, structure: str, file: str) -> Shape:
    """The solid that a skin bounds.

    Parameters
    ----------
    skin : The surface.
    structure : Name of the structure, with which the shape's name begins.
    file : Name of the file in messages.

    Raises
    ------
    GeometryError : The surface is open, intersects itself, is oriented inconsistently, or bounds no volume.
    """
    title = f"{file}, block '{skin.name}'"
    check_points(skin.points, title)
    corner, loops = _welded(skin)
    points = _places(skin, corner)
    named = [
        (loop, name)
        for loop, name in zip(
            (_without_repeats(loop) for loop in loops), skin.names or ("",) * len(loops), strict=True
        )
        if len(loop) > 2
    ]
    if len(named) < 4:
        raise GeometryError(
            f"{title} has {len(named)} faces that are no mere lines, expected a closed surface of 4 or more; "
            "export the whole solid"
        )
    corners, names = _triangulated(points, named)
    _check_closed(corners, points, title)
    volume = _volume(points, corners)
    if abs(volume) <= THIN * float(np.prod(np.maximum(np.ptp(points, axis=0), 1e-300))):
        raise GeometryError(
            f"{title} bounds a volume of {volume:.3g} m³, expected more than none; close the surface about "
            "a solid"
        )
    if volume < 0:
        logger.info("%s is turned inside out; its faces were turned round", title)
        corners = corners[:, ::-1]
    solid, _ = outline(points, "tetra", corners, names, UNNAMED, conforming=True, flat=FLAT)
    return Shape(f"{structure}.{skin.name}", solid)


def _welded(skin: Skin) -> tuple[IntArray, list[tuple[int, ...]]]:
    """Number of the place of each corner, and the loops by these."""
    size = float(np.ptp(skin.points, axis=0).max()) if len(skin.points) else 0.0
    if not SMALLEST <= size <= LARGEST:  # an error that the caller reports
        return np.arange(len(skin.points)), list(skin.loops)
    pairs = cKDTree(skin.points).query_pairs(COINCIDENT * size, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(skin.points),) * 2)
    _, part = connected_components(links, directed=False)
    return part.astype(np.int64), [tuple(int(part[vertex]) for vertex in loop) for loop in skin.loops]


def _places(skin: Skin, corner: IntArray) -> FloatArray:
    """Where the welded corners are: at the first of those that coincide."""
    points = np.zeros((int(corner.max()) + 1, 3))
    points[corner[::-1]] = skin.points[::-1]
    return points


def _without_repeats(loop: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(vertex for at, vertex in enumerate(loop) if vertex != loop[at - 1])


def _triangulated(points: FloatArray, named: list[tuple[tuple[int, ...], str]]) -> tuple[IntArray, list[str]]:
    """Triangles of all polygons, shape (t, 3), and their names; those without area are left out."""
    size = float(np.ptp(points, axis=0).max())
    corners, names = [], []
    for loop, name in named:
        if np.linalg.norm(area_vector(points[list(loop)])) <= COINCIDENT**2 * size**2:
            continue
        cut = triangles_of(points, loop)
        corners += cut
        names += [name] * len(cut)
    return np.array(corners, dtype=np.int64).reshape(-1, 3), names


def _check_closed(corners: IntArray, points: FloatArray, title: str) -> None:
    """Each side of a triangle must be that of one other one, which runs along it the other way."""
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    directed = Counter(map(tuple, sides.tolist()))
    undirected = Counter(tuple(sorted(side)) for side in sides.tolist())

    def at(side: tuple[int, ...]) -> str:
        x, y, z = points[list(side)].mean(axis=0)
        return f"({x:.4g}, {y:.4g}, {z:.4g})"

    crowded = [side for side, count in undirected.items() if count > 2]
    if crowded:
        raise GeometryError(
            f"{title}: more than two faces meet in {len(crowded)} edges, the first at {at(crowded[0])}, "
            "expected two; remove double or inner faces, and part blocks that share an edge"
        )
    open_edges = [side for side, count in undirected.items() if count == 1]
    if open_edges:
        raise GeometryError(
            f"{title} is not closed: {len(open_edges)} edges have one face, the first at "
            f"{at(open_edges[0])}, expected two; fill the holes, and split faces where corners "
            "stand on their edges"
        )
    twisted = [side for side, count in directed.items() if count > 1]
    if twisted:
        raise GeometryError(
            f"{title}: the faces on the two sides of {len(twisted)} edges, the first at {at(twisted[0])}, "
            "are turned against each other, expected all normals outwards; make the normals consistent"
        )


def _volume(points: FloatArray, corners: IntArray) -> float:
    return float(np.linalg.det(points[corners] - points.mean(axis=0)).sum() / 6)
