"""Nodes: the mesh nodes of the finer side that lie in the polygon, its boundary included.

A node's area is the integral of its shape function over the polygon. A node outside whose facets reach into
the polygon is moved to the polygon's nearest point, so that contact ends where the faces do, whatever the
mesh; a corner of the polygon that still has no point nearby gets one. The finer side becomes the candidate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.clipping import depths, locate
from masonry_fem.contact.interpolation import KINDS, weights_on
from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.parts.cover import Cover, Joint
from masonry_fem.contact.placement.parts.cuts import gauss_planes
from masonry_fem.contact.placement.parts.patch import TOLERANCE, Patch, exchanged_all
from masonry_fem.contact.placement.parts.pieces import LINEAR, alike, covering
from masonry_fem.contact.placement.parts.planes import Planes
from masonry_fem.contact.placement.parts.quadrature import rules_of
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.errors import GeometryError
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

SMALLEST = 1e-9  # of the polygon: an area below it is rounding
LOST = 1e-12  # of it: less is none, as of the vertices of quadratic triangles, and not handed on
ORDER = 3  # Gauss points in a direction on facets of second order
SAME = 1e-6  # of the polygon's size: two points nearer than that are one
NEAR = 0.1  # of a facet's size: a corner that is farther from all points gets one of its own


def points(patch: Patch, rule: Rule) -> Spots:
    """Nodes of the finer side; corners where blocks touch at a point or an edge, or where no node is inside.

    Parameters
    ----------
    patch : The interface.
    rule : Not used: this rule has no parameters.

    Raises
    ------
    GeometryError : Neither side has a mesh.
    """
    return together([[patch]], rule)[0][0]


def together(joints: Sequence[Joint], rule: Rule) -> list[list[Spots]]:
    """The same on many joints, patch by patch.

    Parameters
    ----------
    joints : Each one patch.
    rule : Not used: this rule has no parameters.

    Raises
    ------
    GeometryError : Neither side has a mesh, or mesh facets do not cover an interface.
    """
    patches = [patch for (patch,) in joints]
    for patch in patches:
        _ask_for_mesh(patch)
    spots, wide = corners.where_unmeshed(joints, Rule())
    for rows in alike([joints[number] for number in wide], [ORDER] * len(wide)):
        own = [patches[wide[row]] for row in rows]
        for placed in on_patches(own, Planes.of(own)):
            for row, one in placed.spots(np.ones(len(rows), dtype=bool)).items():
                spots[wide[rows[row]]] = [one]
    return spots


def _ask_for_mesh(patch: Patch) -> None:
    if any(side.mesh is not None for side in patch.sides):
        return
    names = "' and '".join(side.surface.name for side in patch.sides)
    raise GeometryError(
        f"placement 'nodes' between blocks {patch.interface.blocks} (shapes '{names}'): "
        "neither has a mesh, expected at least one; make one elastic, or place by 'corners' or 'gauss'"
    )


@dataclass(frozen=True, slots=True)
class AtNodes:
    """c points at the nodes of some patches, patch by patch.

    Attributes
    ----------
    numbers : Of the patches among those that were asked for, shape (k,).
    patches : These, with sides exchanged where the finer mesh is that of the antagonist.
    exchanged : Whether they are.
    planes : Of the patches.
    covers : Facets of both sides; None without a mesh.
    first : First point of each patch and, last, c; shape (k + 1,).
    at : Where points are in the planes, shape (c, d - 1) [m].
    area : Their areas, shape (c,).
    facets : Facets that carry them, rows of the covers, −1 without a mesh, shape (c, 2).
    """

    numbers: IntArray
    patches: Sequence[Patch]
    exchanged: bool
    planes: Planes
    covers: Sequence[Cover | None]
    first: IntArray
    at: FloatArray
    area: FloatArray
    facets: IntArray

    @property
    def patch(self) -> IntArray:
        """Row of the patch of each point, shape (c,)."""
        return np.repeat(np.arange(len(self.patches)), np.diff(self.first))

    def functions(self, side: int) -> tuple[IntArray, FloatArray]:
        """Nodes of one side's facets at the points, rows of its cover, and their functions, (c, n) each."""
        cover = self.covers[side]
        assert cover is not None
        rows = cover.rows[self.facets[:, side]]
        nodes = self.planes.flat(cover.world[rows], self.patch)
        return rows, weights_on(KINDS[cover.kind], nodes, np.arange(len(rows)), self.at)

    def spots(self, wanted: np.ndarray) -> dict[int, Spots]:
        """What the rule gives back on those patches that are wanted, by their numbers."""
        mesh_facets = np.stack(
            [
                self.facets[:, side] if cover is None else cover.facet[self.facets[:, side]]
                for side, cover in enumerate(self.covers)
            ],
            axis=1,
        )
        ranges = zip(
            self.numbers.tolist(),
            self.patches,
            self.first[:-1].tolist(),
            self.first[1:].tolist(),
            strict=True,
        )
        return {
            number: Spots(patch, self.at[a:b], self.area[a:b], mesh_facets[a:b])
            for number, patch, a, b in ranges
            if wanted[number]
        }


def on_patches(
    patches: Sequence[Patch],
    planes: Planes,
    known: tuple[Sequence[Cover | None], Sequence[FloatArray | None]] | None = None,
) -> list[AtNodes]:
    """Points at the nodes of the finer side, or at the corners where no node lies in a polygon.

    Parameters
    ----------
    patches : Of some area, with meshes that have facets of one kind on candidates, and on antagonists.
    planes : Theirs.
    known : Facets of both sides of these patches, each a joint of its own, and ∫ N over the polygons for each
        node of each facet, shape (f, n) [m²; m in 2D].
    """
    covers, borne = (_covers(patches), (None, None)) if known is None else known
    some, finer = _finer(planes, covers)
    found = []
    for exchanged in (False, True):
        rows = np.flatnonzero(some & (finer == exchanged))
        if len(rows):
            own = [patches[row] for row in rows.tolist()]
            own = exchanged_all(own) if exchanged else own
            there = Planes.of(own) if exchanged else planes.only(rows)
            whole = not exchanged and len(rows) == len(patches)
            of_own = covers if whole else _covers(own)
            by_facet = _of_rows(covers[exchanged], borne[exchanged], rows)
            found.append(_at_nodes(rows, own, exchanged, there, of_own, by_facet))
    if not some.all():  # meshes too coarse for these overlaps
        rows = np.flatnonzero(~some)
        found.append(_at_corners(rows, [patches[row] for row in rows.tolist()], planes.only(rows)))
    return found


def _of_rows(cover: Cover | None, by_facet: FloatArray | None, rows: IntArray) -> FloatArray | None:
    """What is known of a side's facets, of those of some patches."""
    if cover is None or by_facet is None:
        return None
    return by_facet[np.isin(cover.of_facet, rows)]


def _finer(planes: Planes, covers: Sequence[Cover | None]) -> tuple[np.ndarray, np.ndarray]:
    """Whether nodes lie in each polygon, and whether those of the antagonist are the denser ones, (k,) each.

    Parameters
    ----------
    planes : Of the patches. covers : Facets of both sides.
    """
    k = len(planes.polygon)
    counts, spacing = np.zeros((2, k), dtype=np.int64), np.full((2, k), np.inf)
    for side, cover in enumerate(covers):
        if cover is not None:
            counts[side] = np.add.reduceat(_within(planes, cover), cover.nodes_from[:-1], dtype=np.int64)
            spacing[side] = np.where(counts[side] > 0, _spacing(cover), np.inf)
    return counts.max(axis=0) > 0, spacing[1] < spacing[0] * (1 - 1e-9)


def _covers(patches: Sequence[Patch]) -> list[Cover | None]:
    joints = [[patch] for patch in patches]
    return [Cover.of(joints, side) if patches[0].sides[side].mesh else None for side in (0, 1)]


def _spacing(cover: Cover) -> FloatArray:
    """Mean area of one side's faces that a node stands for, shape (k,)."""
    area = np.add.reduceat(cover.areas(np.arange(len(cover.facet))), cover.facets_from[:-1])
    spacing: FloatArray = area / np.diff(cover.nodes_from)
    return spacing


def _within(planes: Planes, cover: Cover) -> np.ndarray:
    """Which nodes of one side lie in the polygons or on their boundaries, shape (n,)."""
    at = planes.flat(cover.world, cover.joint)
    return _held(planes.polygon, planes.count, -TOLERANCE * planes.size, cover.nodes_from, at)  # type: ignore[no-any-return]


@compiled
def _held(
    polygon: FloatArray, count: IntArray, least: FloatArray, first: IntArray, at: FloatArray
) -> np.ndarray:
    """Which points are ``least`` deep in their polygons, those of polygon k from ``first[k]`` on."""
    held = np.zeros(len(at), dtype=np.bool_)
    for k in range(len(polygon)):
        own = depths(polygon[k, : count[k]], at[first[k] : first[k + 1]])
        for i in range(len(own)):
            held[first[k] + i] = own[i] >= least[k]
    return held


def _at_corners(numbers: IntArray, patches: Sequence[Patch], planes: Planes) -> AtNodes:
    """Points at the corners of polygons."""
    spots = [corners.points(patch, Rule()) for patch in patches]
    first = np.concatenate([[0], np.cumsum([len(one.area) for one in spots])])
    at = np.concatenate([one.points for one in spots])
    covers = _covers(patches)
    facets = [_carriers(planes, side, cover, first, at) for side, cover in enumerate(covers)]
    area = np.concatenate([one.area for one in spots])
    return AtNodes(numbers, patches, False, planes, covers, first, at, area, np.stack(facets, axis=1))


def _at_nodes(
    numbers: IntArray,
    patches: Sequence[Patch],
    exchanged: bool,
    planes: Planes,
    covers: Sequence[Cover | None],
    by_facet: FloatArray | None,
) -> AtNodes:
    """Points at the nodes of the candidates.

    Parameters
    ----------
    numbers, patches, exchanged, planes, covers : As of ``AtNodes``.
    by_facet : ∫ N over the polygons for each node of each facet of the candidates, (f, n), where it is known.
    """
    own = covers[0]
    assert own is not None
    by_facet = _borne(patches, planes, own) if by_facet is None else by_facet
    middle = own.own[own.vertices].mean(axis=1)
    at, area, node, first = _spread(
        planes.polygon,
        planes.count,
        np.array([patch.interface.area for patch in patches]),
        planes.size,
        NEAR * _spacing(own) ** (1 / planes.polygon.shape[2]),
        own.nodes_from,
        own.facets_from,
        own.rows,
        planes.flat(own.world, own.joint),
        own.own,
        middle,
        _within(planes, own),
        by_facet,
    )
    facets = np.stack(
        [_carriers(planes, side, cover, first, at) for side, cover in enumerate(covers)], axis=1
    )
    facets[node >= 0, 0] = own.carrier[node[node >= 0]]
    return AtNodes(numbers, patches, exchanged, planes, covers, first, at, area, facets)


def _borne(patches: Sequence[Patch], planes: Planes, cover: Cover) -> FloatArray:
    """∫ N over the polygons for each node of each facet of the candidates, shape (f, n) [m²; m in 2D]."""
    facets = cover.world[cover.vertices], np.empty((0, 2, cover.world.shape[1]))
    ranges = cover.of_patch, np.full((len(patches), 2), -1)
    order = ORDER if cover.kind in LINEAR else ORDER - 1
    rules = rules_of(2 if cover.kind == "triangle" else 4, order)
    patch, at, weight, rows = gauss_planes(planes, facets, ranges, rules, False)
    weight = weight * covering(patches, patch, weight)[patch]
    kind, facet, n = KINDS[cover.kind], rows[:, 0], cover.rows.shape[1]
    nodes = planes.flat(cover.world[cover.rows], cover.of_facet)
    share = weight[:, None] * weights_on(kind, nodes, facet, at)
    place = facet[:, None] * n + np.arange(n)
    return np.bincount(place.ravel(), share.ravel(), cover.rows.size).reshape(cover.rows.shape)


def _carriers(planes: Planes, side: int, cover: Cover | None, first: IntArray, at: FloatArray) -> IntArray:
    """Facets of one side that carry points, rows of its cover, −1 without a mesh, shape (c,).

    Parameters
    ----------
    planes : Of the patches. side : Which side. cover : Its facets.
    first : First point of each patch and, last, c; shape (k + 1,).
    at : Where points are in the planes, shape (c, d - 1) [m].
    """
    if cover is None:
        return np.full(len(at), -1)
    flat = planes.flat(cover.world[cover.vertices], cover.of_facet)
    # a candidate's facets look against the normal
    facets = np.ascontiguousarray(flat[:, ::-1] if side == 0 else flat)
    return _located(facets, cover.facets_from, np.ascontiguousarray(at), first)  # type: ignore[no-any-return]


@compiled
def _located(facets: FloatArray, facets_from: IntArray, at: FloatArray, first: IntArray) -> IntArray:
    """Facets that hold points; patch k has points from ``first[k]`` on, facets from ``facets_from[k]`` on."""
    found = np.empty(len(at), dtype=np.int64)
    for k in range(len(first) - 1):
        own = facets[facets_from[k] : facets_from[k + 1]]
        held = locate(own, at[first[k] : first[k + 1]], 1e-9 * np.abs(own).max())
        for i in range(len(held)):
            found[first[k] + i] = facets_from[k] + held[i]
    return found


@compiled
def _spread(
    polygon: FloatArray,
    count: IntArray,
    whole: FloatArray,
    size: FloatArray,
    near: FloatArray,
    nodes_from: IntArray,
    facets_from: IntArray,
    rows: IntArray,
    at: FloatArray,
    own: FloatArray,
    middle: FloatArray,
    within: np.ndarray,
    by_facet: FloatArray,
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Points at the nodes within polygons, and where the nodes beyond come to stand along their edges.

    Parameters
    ----------
    polygon, count : Corners, padded, shape (k, n, p) [m], and how many are real, shape (k,).
    whole, size, near : Area, extent, and how near a point a corner needs none of its own, shape (k,) each.
    nodes_from, facets_from : First node and facet of each patch, shape (k + 1,).
    rows : Nodes of the facets, shape (f, n).
    at, own : Where nodes are in the planes, shape (n, p), and in the frames of the shapes, (n, d) [m].
    middle : Means of the vertices of facets in the frames of the shapes, shape (f, d) [m].
    within : Whether nodes are in the polygons, shape (n,).
    by_facet : ∫ N of each node of each facet, shape (f, n).

    Returns
    -------
    Places (c, p) and areas (c,); nodes that they are at, −1 along edges, (c,); first of each patch (k + 1,).
    """
    room = len(at) + count.sum()
    placed, areas = np.empty((room, at.shape[1])), np.empty(room)
    node, first = np.full(room, -1), np.zeros(len(polygon) + 1, dtype=np.int64)
    total = 0
    for k in range(len(polygon)):
        start, end, low, high = nodes_from[k], nodes_from[k + 1], facets_from[k], facets_from[k + 1]
        area, beyond = _shared(
            rows[low:high], by_facet[low:high], within, own, middle[low:high], start, end, whole[k]
        )
        begin = total
        for i in range(start, end):
            if within[i]:
                placed[total], areas[total], node[total] = at[i], area[i - start], i
                total += 1
        corners_of = polygon[k, : count[k]]
        for i in beyond:
            foot = _foot(corners_of, at[i])
            nearest, away = _nearest(placed, begin, total, foot)
            if away <= SAME * size[k]:
                areas[nearest] += area[i - start]
            else:
                placed[total], areas[total] = foot, area[i - start]
                total += 1
        if len(beyond):
            for corner in corners_of:
                nearest, away = _nearest(placed, begin, total, corner)
                if away > near[k]:
                    areas[nearest] *= 0.5
                    placed[total], areas[total] = corner, areas[nearest]
                    total += 1
        first[k + 1] = total
    return placed[:total], areas[:total], node[:total], first


@compiled
def _shared(
    rows: IntArray,
    by_facet: FloatArray,
    within: np.ndarray,
    own: FloatArray,
    middle: FloatArray,
    start: int,
    end: int,
    whole: float,
) -> tuple[FloatArray, IntArray]:
    """Areas of the nodes ``start`` to ``end`` of a patch, (n,), and those outside that bear some of it.

    Areas of nodes that bear nothing go in equal parts to those that do on the same facet. A facet without any
    gives to the nearest that does. The parameters are those of ``_spread``.
    """
    area = np.zeros(end - start)
    for f in range(len(rows)):
        for n in range(rows.shape[1]):
            area[rows[f, n] - start] += by_facet[f, n]
    bears = within[start:end] | (area > SMALLEST * whole)
    beyond = start + np.flatnonzero(bears & ~within[start:end])
    lost, most = np.zeros(len(rows)), 0.0
    for f in range(len(rows)):
        for n in range(rows.shape[1]):
            if not bears[rows[f, n] - start]:
                lost[f] += by_facet[f, n]
        most = max(most, abs(lost[f]))
    area *= bears
    if most > LOST * whole:
        for f in range(len(rows)):
            if lost[f] != 0:
                _hand_on(lost[f], rows[f] - start, bears, own[start:end], middle[f], area)
    return np.where(np.abs(area) > LOST * whole, area, 0.0), beyond


@compiled
def _hand_on(
    lost: float, nodes: IntArray, bears: np.ndarray, own: FloatArray, middle: FloatArray, area: FloatArray
) -> None:
    """Give what a facet's nodes lose to those of them that bear, else to the nearest node that does.

    Parameters
    ----------
    lost : The area [m²; m in 2D]. nodes : Of the facet, shape (n,).
    bears, own, area : Whether nodes of the patch bear, where they are, and their areas, changed in place.
    middle : Of the facet, shape (d,) [m].
    """
    takers = bears[nodes].sum()
    for i in nodes:
        if bears[i]:
            area[i] += lost / takers
    if takers == 0:
        bearing = np.flatnonzero(bears)
        nearest, _ = _nearest(own[bearing], 0, len(bearing), middle)
        area[bearing[nearest]] += lost


@compiled
def _nearest(placed: FloatArray, start: int, end: int, point: FloatArray) -> tuple[int, float]:
    """Which of the points ``start`` to ``end`` is nearest to another one, and how far it is."""
    best, nearest = np.inf, start
    for i in range(start, end):
        away = np.sqrt(((placed[i] - point) ** 2).sum())
        if away < best:
            best, nearest = away, i
    return nearest, best


@compiled
def _foot(polygon: FloatArray, point: FloatArray) -> FloatArray:
    """The point of a polygon's boundary nearest to one outside, shape (p,)."""
    if polygon.shape[1] == 1:
        return np.minimum(np.maximum(point, polygon.min()), polygon.max())
    best, found = np.inf, point.copy()
    for i in range(len(polygon)):
        along = polygon[(i + 1) % len(polygon)] - polygon[i]
        square = (along**2).sum()
        share = ((point - polygon[i]) * along).sum() / (square if square > 0 else 1.0)
        foot = polygon[i] + min(max(share, 0.0), 1.0) * along
        away = np.sqrt(((point - foot) ** 2).sum())
        if away < best:
            best, found = away, foot
    return found
