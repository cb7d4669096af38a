"""Detection: from posed blocks to the interfaces that they share.

    interfaces = detect(assembly)

Bounding boxes give the pairs of near blocks; among their faces, those that look at each other
within ``angle`` and lie at most ``reach`` apart are projected on their common plane and clipped.
Pairs of convex blocks that touch by no face are searched for a corner or an edge that stands on
a face (``touching``) and for edges that cross (``crossing``), other pairs for corners (``foothold``).
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.boxes import near_pairs
from masonry_fem.contact.clipping import common_parts
from masonry_fem.contact.contacts import Interface, height, local_frames
from masonry_fem.contact.facing import FacePairs, facing, orient
from masonry_fem.contact.foothold import footholds
from masonry_fem.contact.interfaces import Interfaces, among
from masonry_fem.contact.posed import Posed
from masonry_fem.contact.surface import PosedFaces, Surface, pose_faces, surfaces_of, typical_size
from masonry_fem.contact.touching import standing_pairs
from masonry_fem.errors import GeometryError
from masonry_fem.records.remark import first_few, remark
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

SMALLEST = 1e-4  # of the smaller face: a common part below it is a sliver
EDGE = 2e-6  # of a block's size: a common part no wider is a shared edge or corner
REACH = 1e-3  # of a block's size: largest gap that is a contact, unless the scene says otherwise
ROUNDING = 1e-12  # of a block's size: a gap below it is zero
# of the thinner block's depth behind its face: faces that overlap by more look at each other through a block
THROUGH = 0.5
NEARER = 0.1  # of a gap between faces that are inclined: by how much less a corner of theirs may have
SHOWN = 5  # pairs of blocks that a message names
TOGETHER = 1 << 17  # pairs of faces that are cut together, at most: memory


def detect(
    assembly: Assembly,
    *,
    reach: float | None = None,
    overlap: float | None = None,
    angle: float = 5.0,
    support_pairs: bool = False,
    surfaces: tuple[Surface, ...] | None = None,
    tell: bool = True,
    corners: bool = False,
) -> Interfaces:
    """Find the interfaces of an assembly: the common parts of the faces of two blocks.

    Parameters
    ----------
    assembly : Blocks in their reference poses.
    reach : Largest gap of faces in contact [m]; None: 1e-3 of the typical size of a block.
    overlap : Largest overlap of faces in contact [m]; None: as large as ``reach``.
    angle : Largest angle between faces in contact [degrees].
    support_pairs : Whether two supports can be in contact.
    surfaces : Surfaces of the assembly's shapes (``masonry_fem.contact.surface.surfaces_of``); None: they are
        computed.
    tell : Whether to warn of slivers.
    corners : Whether to check corners of blocks that are not convex, which may be nearer than their faces.

    Returns
    -------
    Interfaces
        Ordered by block numbers, then faces. The candidate is the later block, except that a
        support, or a face that carries a tilted one, is the antagonist.

    Raises
    ------
    GeometryError
        ``reach`` is negative, or ``angle`` is not between 0 and 90 degrees.
    """
    _check_limits(reach, angle)
    if len(assembly.blocks) < 2:
        return Interfaces.of((), assembly.dimension)
    surfaces = surfaces_of(assembly) if surfaces is None else surfaces
    size = typical_size(assembly, surfaces)
    far = REACH * size if reach is None else reach
    faces = pose_faces(assembly, surfaces)
    support = assembly.blocks.support
    low = np.minimum.reduceat(faces.points.min(axis=1), faces.first[:-1])
    high = np.maximum.reduceat(faces.points.max(axis=1), faces.first[:-1])
    # boxes that merely touch must be found, whatever the rounding
    pairs = near_pairs(low, high, far + 1e-9 * size)
    if not support_pairs:
        pairs = pairs[~support[pairs].all(axis=1)]
    posed = Posed.of(assembly, surfaces)
    deep = far if overlap is None else overlap
    chosen = orient(facing(faces, pairs, max(far, deep) + 1e-9 * size, angle), posed, faces)
    found, slivers = _cut(chosen, posed, faces, (far, deep), size)
    rest = pairs[~among(pairs, found.pairs)]
    nearer = _nearer(found, footholds(posed, faces, pairs, far, deep, size, rim=True)) if corners else []
    alone = standing_pairs(posed, rest, far, deep, size)
    alone += nearer if corners else footholds(posed, faces, rest, far, deep, size)
    found = Interfaces.joined([found, Interfaces.of(alone, assembly.dimension)])
    if tell:
        _tell_slivers(assembly, found, slivers)
    return found.only(_order(found))


def default_reach(assembly: Assembly) -> float:
    """The reach of ``detect`` where none is given [m]."""
    return REACH * typical_size(assembly, surfaces_of(assembly))


def _check_limits(reach: float | None, angle: float) -> None:
    if reach is not None and not reach >= 0:
        raise GeometryError(
            f"contact reach is {reach} m, expected >= 0; leave it out for 1e-3 of a block's size"
        )
    if not 0 < angle < 90:
        raise GeometryError(
            f"contact angle is {angle} degrees, expected between 0 and 90; 5 suits most scenes"
        )


def _nearer(found: Interfaces, corners: list[Interface]) -> list[Interface]:
    """Corners that come nearer than all faces that their two blocks share."""
    if not corners:
        return []
    own = np.sort([one.blocks for one in corners], axis=1)
    _, pair = np.unique(np.concatenate([found.pairs, own]), axis=0, return_inverse=True)
    least = np.full(len(pair), np.inf)
    np.minimum.at(least, pair[: len(found)], found.nearest)
    face = least[pair[len(found) :]]
    allowed = face - np.where(np.isfinite(face), NEARER * np.abs(face), 0.0)
    return [one for one, most in zip(corners, allowed.tolist(), strict=True) if one.gap[0] < most]


def _tell_slivers(assembly: Assembly, found: Interfaces, slivers: IntArray) -> None:
    """Warn of pairs of blocks that have nothing but slivers in common: they do not touch."""
    thin = np.unique(np.sort(slivers, axis=1), axis=0)
    lost = thin[~among(thin, found.pairs)].tolist()
    if lost:
        names = [f"'{assembly.blocks.names[a]}' and '{assembly.blocks.names[b]}'" for a, b in lost]
        remark(
            "sliver",
            f"{first_few(names, SHOWN, noun='pairs')} have only a sliver in common, less than {SMALLEST:g} "
            "of a face, and are taken not to touch; widen the overlap, or part the blocks",
            *(assembly.blocks.names[one] for pair in lost for one in pair),
        )


def _order(interfaces: Interfaces) -> IntArray:
    """Interfaces by lower block, higher block, their faces, shape (i,); pieces stay in the order found."""
    swapped = (interfaces.blocks[:, 0] > interfaces.blocks[:, 1])[:, None]
    faces = np.where(swapped, interfaces.faces[:, ::-1], interfaces.faces)
    (a, b), (f, g) = interfaces.pairs.T, faces.T
    return np.lexsort((g, f, b, a)).astype(np.int64)


def _cut(
    pairs: FacePairs, posed: Posed, faces: PosedFaces, within: tuple[float, float], size: float
) -> tuple[Interfaces, IntArray]:
    """Interfaces of the face pairs whose common part is large, and ``within`` a gap and an overlap.

    And the blocks of those whose common part is no mere edge, yet too small, shape (s, 2). Of leaves far
    thinner than they are wide each faces hundreds of others: so many pairs are cut one lot after another.
    """
    found = [Interfaces.of((), faces.points.shape[2])]
    slivers = [np.empty((0, 2), dtype=np.int64)]
    for first in range(0, len(pairs), TOGETHER):
        some, thin = _cut_some(pairs.only(slice(first, first + TOGETHER)), posed, faces, within, size)
        found.append(some)
        slivers.append(thin)
    return Interfaces.joined(found), np.concatenate(slivers)


def _cut_some(
    pairs: FacePairs, posed: Posed, faces: PosedFaces, within: tuple[float, float], size: float
) -> tuple[Interfaces, IntArray]:
    """The same of as many pairs as memory holds."""
    c, a = pairs.candidate, pairs.antagonist
    mean = faces.normal[a] - faces.normal[c]
    normal = np.where(pairs.carried[:, None], faces.normal[a], mean / np.linalg.norm(mean, axis=1)[:, None])
    frame, origin = local_frames(normal), faces.points[a, 0]
    rounding = 1e-9 * size
    flat, corners, area = common_parts(
        faces.points, faces.corners, c, a, origin, frame[:, 1:], np.full(len(c), rounding)
    )
    large = area > SMALLEST * np.minimum(faces.area[c], faces.area[a])
    polygon = origin[:, None] + np.einsum("mkp,mpd->mkd", flat, frame[:, 1:])
    along = np.broadcast_to(normal[:, None], polygon.shape)
    of_candidate = height(polygon, along, faces.points[c, :1], faces.normal[c, None])
    of_antagonist = height(polygon, along, faces.points[a, :1], faces.normal[a, None])
    gap = of_candidate - of_antagonist
    gap[np.abs(gap) < ROUNDING * size] = 0.0
    # the common plane lies midway between the faces, or on the face that carries an inclined one
    level = np.where(pairs.carried[:, None], of_antagonist, 0.5 * (of_candidate + of_antagonist))
    polygon += level[:, :, None] * normal[:, None]
    real = np.arange(gap.shape[1]) < corners[:, None]
    nearest = np.where(real, gap, np.inf).min(axis=1)
    # if the reach is as large as a block, the top of one may face the bottom of the other through both blocks
    overlap = np.minimum(within[1], THROUGH * np.minimum(faces.depth[c], faces.depth[a]))
    touching = (nearest <= within[0] + rounding) & (nearest >= -overlap - rounding)
    accepted = large & touching
    sliver = np.flatnonzero(touching & ~large & (area > 0))
    width = area[sliver]
    if polygon.shape[2] == 3:
        width = width / np.linalg.norm(_extent(polygon[sliver], real[sliver]), axis=1)
    sliver = sliver[width > EDGE * size]
    sides, rows = np.stack([c, a], axis=1), np.flatnonzero(accepted)
    both, numbers = faces.block[sides[rows]], faces.face[sides[rows]]
    labels, label = np.unique(posed.shared_labels(both, numbers), return_inverse=True)
    made = Interfaces(
        blocks=both,
        faces=numbers,
        normal=normal[rows],
        area=area[rows],
        tie=np.zeros(len(rows), dtype=bool),
        label=label,
        labels=tuple(labels.tolist()),
        corners=polygon[rows][real[rows]],
        gap=gap[rows][real[rows]],
        first=np.cumsum([0, *corners[rows]]),
    )
    return made, faces.block[sides[sliver]]


def _extent(polygons: FloatArray, real: np.ndarray) -> FloatArray:
    """Sides of the boxes about polygons, shape (m, d); of corners (m, k, d) only the real ones count."""
    shown = real[:, :, None]
    high = np.where(shown, polygons, -np.inf).max(axis=1, initial=-np.inf)
    extent: FloatArray = high - np.where(shown, polygons, np.inf).min(axis=1, initial=np.inf)
    return extent
