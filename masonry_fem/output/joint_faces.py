"""Joint faces: the common faces of blocks as plane figures: middle, axes, sides, moments of area.

    faces = JointFaces.of(model)
    faces.centroid[k], faces.axes[k], faces.extent[k], faces.sides[k]

Axes are those of the smallest rectangle about a face that has a side on one of its edges, so that
an oblong face has its length and its width as axes. In 2D a face is a length and has one axis.
All facets that two faces have in common are one joint, whose face is their outline in their mean plane.
They stand in the reference configuration; ``interfaces`` moves them along with the blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from masonry_fem.contact.contacts import local_frames
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.contact.posed import poses
from masonry_fem.contact.smooth import FLAT, round_joints, smooth_faces
from masonry_fem.march.model import Model
from masonry_fem.output.polygon_moments import polygon_moments
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.polytope import Polytope

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]
Names = NDArray[np.str_]

BESIDE = 1e-3  # of a face's size: a block's face that is no farther from the end of a joint bounds it

SLANTWISE = 0.2  # a face may bound a joint if the cosine between its normal and the axis is larger


@dataclass(frozen=True, slots=True)
class Facets:
    """The model's i interfaces, of which joints are made up.

    Attributes
    ----------
    polygon : Corners, padded with the last one, shape (i, k, d) [m].
    corners : How many are real, shape (i,).
    joint : Of which joint each is, shape (i,).
    """

    polygon: FloatArray
    corners: IntArray
    joint: IntArray


@dataclass(frozen=True, slots=True)
class JointFaces:
    """j joints; a = 1 axis in 2D, 2 in 3D.

    Attributes
    ----------
    facets : Of which they are made up.
    first : The first facet of each, shape (j,).
    plane : Whether facets are flat enough together for a section with eccentricities, shape (j,).
    corners : How many corners are real, shape (j,).
    normal : Towards the candidate, shape (i, d).
    axes : Unit vectors in the face; normal and axes are right-handed, shape (i, a, d).
    centroid : shape (i, d) [m].
    flat : Corners from the centroid along the axes, shape (i, k, a) [m].
    extent : Ends of the face along the axes from its centroid, low and high, shape (i, a, 2) [m].
    area : Measure of the face [m²; m in 2D], shape (i,); 0 where a corner or an edge stands.
    second : Second moments of area about the centroid, shape (i, a, a) [m⁴; m³ in 2D].
    sides : Names of the blocks' faces at these ends ("" where none bounds it), shape (j, a, 2).
    """

    facets: Facets
    first: IntArray
    plane: Mask
    corners: IntArray
    normal: FloatArray
    axes: FloatArray
    centroid: FloatArray
    flat: FloatArray
    extent: FloatArray
    area: FloatArray
    second: FloatArray
    sides: Names

    @classmethod
    def of(cls, model: Model) -> JointFaces:
        """The faces of a model's joints."""
        d, interfaces = model.assembly.dimension, model.interfaces
        solids = [shape.solid for shape in model.assembly.shapes]
        normals = [np.array([solid.normal(face) for face in range(len(solid.faces))]) for solid in solids]
        smooth = [smooth_faces(solid, own) for solid, own in zip(solids, normals, strict=True)]
        joint = round_joints(model.assembly, interfaces, smooth)
        facets = Facets(*_padded(interfaces.corners, interfaces.first), joint)
        first = np.unique(joint, return_index=True)[1]
        normal, area, plane = _mean_planes(interfaces, joint, first)
        polygon, corners = _outlines(interfaces, facets, first, normal)
        tangents = local_frames(normal)[:, 1:]
        middle = polygon.mean(axis=1)
        raw = np.einsum("ikd,iad->ika", polygon - middle[:, None], tangents)
        axes = tangents if d == 2 else _flush_axes(raw, tangents)
        raw = np.einsum("ikd,iad->ika", polygon - middle[:, None], axes)
        off, second = _moments(raw, corners)
        centroid = middle + np.einsum("ia,iad->id", off, axes)
        flat = raw - off[:, None]
        extent = np.stack([flat.min(axis=1), flat.max(axis=1)], axis=2)
        ends = _ends(flat, extent, centroid, axes)
        size = np.ptp(extent, axis=2)
        planes = _Planes.of(solids, normals)
        sides = planes.bounding(
            model.assembly, interfaces.blocks[first], interfaces.faces[first], ends, axes, size
        )
        return cls(facets, first, plane, corners, normal, axes, centroid, flat, extent, area, second, sides)

    @property
    def size(self) -> FloatArray:
        """Length of each face along its axes, shape (i, a) [m]."""
        size: FloatArray = self.extent[:, :, 1] - self.extent[:, :, 0]
        return size


def _padded(corners: FloatArray, first: IntArray) -> tuple[FloatArray, IntArray]:
    """Corners with the last one repeated, (i, k, d), and how many are real.

    Parameters
    ----------
    corners : Of all polygons, one after another. first : First corner of each and, last, their number.
    """
    count: IntArray = np.diff(first).astype(np.int64)
    place = np.minimum(np.arange(count.max(initial=1)), count[:, None] - 1)
    padded: FloatArray = corners[first[:-1, None] + place]
    return padded, count


def _mean_planes(
    interfaces: Interfaces, joint: IntArray, first: IntArray
) -> tuple[FloatArray, FloatArray, Mask]:
    """Mean normals towards the candidates of first facets, areas, and where facets are flat together."""
    candidate, measure = interfaces.blocks[:, 0], interfaces.area
    same = candidate == candidate[first][joint]
    own = np.where(same[:, None], interfaces.normal, -interfaces.normal)
    total = np.stack([np.bincount(joint, measure * x, len(first)) for x in own.T], axis=1)
    size = np.linalg.norm(total, axis=1)
    alone = (np.bincount(joint, minlength=len(first)) == 1) | (size == 0)
    normal = np.where(alone[:, None], own[first], total / np.where(alone, 1.0, size)[:, None])
    least = np.ones(len(first))
    np.minimum.at(least, joint, np.einsum("id,id->i", own, normal[joint]))
    area = np.bincount(joint, measure, len(first))
    return normal, area, least > FLAT


def _outlines(
    interfaces: Interfaces, facets: Facets, first: IntArray, normal: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Outlines of all joints, padded as facets are, and their numbers of corners."""
    joint, count = facets.joint, np.bincount(facets.joint)
    own, known = facets.polygon[first], facets.corners[first]
    several = count[joint] > 1
    if not several.any():
        return own, known
    by_joint = np.flatnonzero(several)[np.argsort(joint[several], kind="stable")]
    made = np.flatnonzero(count > 1)
    groups = np.split(by_joint, np.cumsum(count[made])[:-1])
    outlines = [_outline(interfaces, rows, normal[k]) for k, rows in zip(made.tolist(), groups, strict=True)]
    polygon, known[made] = _padded(np.concatenate(outlines), np.cumsum([0, *map(len, outlines)]))
    whole = np.empty((len(first), max(polygon.shape[1], own.shape[1]), own.shape[2]))
    for rows, part in ((slice(None), own), (made, polygon)):
        whole[rows, : part.shape[1]] = part
        whole[rows, part.shape[1] :] = part[:, -1:]
    return whole, known


def _outline(interfaces: Interfaces, rows: IntArray, normal: FloatArray) -> FloatArray:
    """Corners of what several facets cover together in their mean plane, filled where it is hollow."""
    bounds = zip(interfaces.first[rows].tolist(), interfaces.first[rows + 1].tolist(), strict=True)
    points = np.concatenate([interfaces.corners[begin:end] for begin, end in bounds])
    tangents, middle = local_frames(normal[None])[0, 1:], points.mean(axis=0)
    flat = (points - middle) @ tangents.T
    around = [flat.argmin(), flat.argmax()] if len(tangents) == 1 else ConvexHull(flat).vertices
    corners: FloatArray = middle + flat[around] @ tangents
    return corners


def _flush_axes(flat: FloatArray, tangents: FloatArray) -> FloatArray:
    """Axes along the sides of the smallest rectangle that has a polygon's edge in a side, (i, 2, 3)."""
    edge = np.roll(flat, -1, axis=1) - flat
    length = np.linalg.norm(edge, axis=2)
    real = length > 1e-9 * length.max(axis=1, initial=0.0)[:, None]
    along = np.where(real[:, :, None], edge, [1.0, 0.0]) / np.where(real, length, 1.0)[:, :, None]
    across = np.stack([-along[:, :, 1], along[:, :, 0]], axis=2)
    spans = [np.ptp(np.einsum("ika,ima->ikm", axis, flat), axis=2) for axis in (along, across)]
    # of equally good rectangles (for a square, any edge gives one) take the one along the contact frame
    tilt = np.minimum(np.abs(along[:, :, 0]), np.abs(along[:, :, 1]))
    box = spans[0] * spans[1]
    box = box * (1 + 1e-6 * tilt) + np.where(real, 0.0, np.inf)
    # edges without area, points: their own direction, or that of the frame
    best = np.where(real.any(axis=1), box.argmin(axis=1), 0)
    chosen = np.take_along_axis(along, best[:, None, None], axis=1)[:, 0]
    turned = np.stack([-chosen[:, 1], chosen[:, 0]], axis=1)
    # of the four directions the one nearest to the frame's first comes first
    first = np.where((np.abs(chosen[:, :1]) >= np.abs(turned[:, :1]) * (1 - 1e-9)), chosen, turned)
    first *= np.where(first[:, :1] < 0, -1.0, 1.0)
    plane = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=1)], axis=1)
    axes: FloatArray = np.einsum("iab,ibd->iad", plane, tangents)
    return axes


def _moments(flat: FloatArray, corners: IntArray) -> tuple[FloatArray, FloatArray]:
    """Centroid (i, a) and second moments about it (i, a, a) of faces given by their corners."""
    count, _, a = flat.shape
    real = np.arange(flat.shape[1]) < corners[:, None]
    mean = (flat * real[:, :, None]).sum(axis=1) / corners[:, None]
    if a == 1:
        length = flat.max(axis=1) - flat.min(axis=1)
        return mean, (length**3 / 12)[:, :, None]
    area, first, second = polygon_moments(flat)
    solid = area > 1e-12 * np.square(flat).sum(axis=2).max(axis=1, initial=0.0)
    centroid = np.where(solid[:, None], first / np.where(solid, area, 1.0)[:, None], mean)
    about = second - area[:, None, None] * centroid[:, :, None] * centroid[:, None, :]
    return centroid, np.where(solid[:, None, None], about, np.zeros((count, a, a)))


@dataclass(frozen=True, slots=True)
class _Planes:
    """Planes of the faces of s shapes, padded to the most faces f that one has.

    Attributes
    ----------
    normal : Outward, 0 where there is no face, shape (s, f, d).
    distance : From the origin, shape (s, f) [m].
    names : "" where a face has none, shape (s, f).
    """

    normal: FloatArray
    distance: FloatArray
    names: Names

    @classmethod
    def of(cls, solids: Sequence[Polytope], normals: Sequence[FloatArray]) -> _Planes:
        """Those of some solids, whose faces' normals are given, each of shape (f, d)."""
        shape = len(solids), max(map(len, normals))
        normal, distance = np.zeros((*shape, normals[0].shape[1])), np.zeros(shape)
        names = np.full(shape, "", dtype=object)
        for number, (solid, own) in enumerate(zip(solids, normals, strict=True)):
            on = np.array([solid.vertices[loop[0]] for loop in solid.faces])
            normal[number, : len(own)] = own
            distance[number, : len(own)] = np.einsum("fd,fd->f", own, on)
            names[number, : len(own)] = solid.names
        return cls(normal, distance, names.astype(str))

    def bounding(
        self, assembly: Assembly, blocks: IntArray, faces: IntArray, ends: FloatArray, axes: FloatArray,
        size: FloatArray,
    ) -> Names:  # fmt: skip
        """Names of the faces of one of both blocks that pass through the ends of joints, shape (j, a, 2).

        Parameters
        ----------
        assembly : The blocks.
        blocks, faces : Of the joints' sides, shape (j, 2).
        ends : Of the joints along their axes, shape (j, a, 2, d) [m].
        axes, size : Of the joints, shapes (j, a, d) and (j, a).
        """
        shape, rotation, translation = poses(assembly)
        outwards = np.stack([-axes, axes], axis=2)
        found = np.full(ends.shape[:3], "", dtype=self.names.dtype)
        for block, own in zip(blocks.T[::-1], faces.T[::-1], strict=True):  # the candidate's take precedence
            kind, turn = shape[block], rotation[block]
            here = np.einsum("jaed,jdi->jaei", ends - translation[block][:, None, None], turn)
            normal = self.normal[kind]
            away = np.einsum("jaei,jfi->jaef", here, normal) - self.distance[kind][:, None, None]
            facing = np.einsum("jaei,jfi->jaef", np.einsum("jaed,jdi->jaei", outwards, turn), normal)
            bounds = (np.abs(away) <= BESIDE * size[:, :, None, None]) & (facing >= SLANTWISE)
            bounds &= (np.arange(facing.shape[3]) != own[:, None])[:, None, None]
            best = np.where(bounds, facing, 0.0).argmax(axis=3)
            name = self.names[kind[:, None, None], best]
            there = np.take_along_axis(bounds, best[..., None], axis=3)[..., 0] & (name != "")
            found[there] = name[there]
        return found


def _ends(flat: FloatArray, extent: FloatArray, centroid: FloatArray, axes: FloatArray) -> FloatArray:
    """Middles of the outermost corners at both ends of each axis, shape (i, a, 2, d) [m]."""
    reach = extent[:, None]  # (i, 1, a, 2)
    width = np.maximum(np.ptp(extent, axis=2), 0.0)[:, None, :, None]
    there = (np.abs(flat[:, :, :, None] - reach) <= 1e-6 * width).astype(float)  # (i, k, a, 2)
    middle = np.einsum("ikae,ikb->iaeb", there, flat) / there.sum(axis=1)[:, :, :, None]
    ends: FloatArray = centroid[:, None, None] + np.einsum("iaeb,ibd->iaed", middle, axes)
    return ends
