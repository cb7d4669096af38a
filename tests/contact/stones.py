"""Random convex stones, and pairs of them that touch in a known way."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from masonry_fem.contact.crossing import edges_of
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.contact.blocks import turning


@dataclass(frozen=True)
class Touch:
    """Two stones, the normal from the first to the second, where they touch, and how far apart.

    ``flattest`` is the least angle of the features' faces to the plane of contact [degrees].
    """

    assembly: Assembly
    normal: np.ndarray
    point: np.ndarray
    flattest: float


def hull(points):
    """The convex hull of points, with triangular faces."""
    found = ConvexHull(points)
    used, loops = np.unique(found.simplices), []
    for loop, plane in zip(found.simplices, found.equations, strict=True):
        a, b, c = points[loop]
        outward = np.cross(b - a, c - a) @ plane[:3] > 0
        loops.append(tuple(np.searchsorted(used, loop if outward else loop[::-1]).tolist()))
    return Polytope(points[used], tuple(loops))


def stone(random, corners=14):
    """A stone of about a metre by 0.8 by 0.6 m with corners on an ellipsoid."""
    points = random.normal(size=(corners, 3))
    return hull(points / np.linalg.norm(points, axis=1)[:, None] * [0.5, 0.4, 0.3])


def outline(random, corners=9):
    """A random convex polygon in the plane, counter-clockwise."""
    points = random.normal(size=(corners, 2))
    points *= random.uniform(0.3, 1) / np.linalg.norm(points, axis=1)[:, None]
    return points[ConvexHull(points).vertices]


def prism(loop, depth):
    """A prism over a polygon, from height 0 to ``depth``."""
    k = len(loop)
    vertices = np.concatenate([np.c_[loop, np.zeros(k)], np.c_[loop, np.full(k, depth)]])
    sides = tuple((i, (i + 1) % k, (i + 1) % k + k, i + k) for i in range(k))
    return Polytope(vertices, (tuple(range(k))[::-1], tuple(range(k, 2 * k)), *sides))


def two_stones(first, second, rotation, translation):
    return Assembly(
        3,
        (Shape("a", first), Shape("b", second)),
        (Block("a", 0, Pose.identity(3)), Block("b", 1, Pose(rotation, translation))),
    )


def bring(start, end):
    """The shortest rotation that brings one direction onto another."""
    axis = np.cross(start, end)
    return turning(np.arctan2(np.linalg.norm(axis), start @ end), axis)


def on_corner(random, gap):
    """A corner of the second stone above a face of the first."""
    lower, upper = stone(random), stone(random)
    face, corner = random.integers(len(lower.faces)), random.integers(len(upper.vertices))
    normal = lower.normal(face)
    point = random.dirichlet([2.0, 2.0, 2.0]) @ lower.face_points(face)
    around = np.array([upper.normal(f) for f, loop in enumerate(upper.faces) if corner in loop])
    rotation = turning(random.uniform(0, 6), normal) @ bring(around.mean(axis=0), -normal)
    flattest = np.degrees(np.arccos(np.clip(-(around @ rotation.T) @ normal, -1, 1))).min()
    translation = point + gap * normal - rotation @ upper.vertices[corner]
    return Touch(two_stones(lower, upper, rotation, translation), normal, point, flattest)


def on_edges(random, gap):
    """An edge of the second stone across an edge of the first, 30 to 90 degrees from it."""
    lower, upper = stone(random), stone(random)
    below, above = _edge_point(random, lower), _edge_point(random, upper)
    normal = below[1]
    rotation = bring(above[1], -normal)
    along = rotation @ above[2]
    turn = np.arctan2(np.cross(along, below[2]) @ normal, along @ below[2])
    rotation = turning(turn + np.radians(random.uniform(30, 90)), normal) @ rotation
    translation = below[0] + gap * normal - rotation @ above[0]
    assembly = two_stones(lower, upper, rotation, translation)
    return Touch(assembly, normal, below[0], min(below[3], above[3]))


def _edge_point(random, solid):
    """A point on an edge, a direction between the normals beside it, the edge's, and its sharpness."""
    edges = edges_of(solid)
    a, b, f, g = edges[random.integers(len(edges))]
    share, part = random.uniform(0.25, 0.75), random.uniform(0.35, 0.65)
    point = (1 - share) * solid.vertices[a] + share * solid.vertices[b]
    out = (1 - part) * solid.normal(f) + part * solid.normal(g)
    out /= np.linalg.norm(out)
    sharp = np.degrees(np.arccos([out @ solid.normal(f), out @ solid.normal(g)])).min()
    along = solid.vertices[b] - solid.vertices[a]
    return point, out, along / np.linalg.norm(along), sharp


def common_area(first, second):
    """Area of the common part of two convex polygons, and the radius of its largest circle (< 0: apart)."""
    sides = np.concatenate([ConvexHull(first).equations, ConvexHull(second).equations])
    best = linprog(
        [0, 0, -1],
        A_ub=np.c_[sides[:, :2], np.ones(len(sides))],
        b_ub=-sides[:, 2],
        bounds=[(None, None), (None, None), (None, 10)],
    )
    radius = best.x[2]
    if radius <= 1e-9:
        return 0.0, radius
    return ConvexHull(HalfspaceIntersection(sides, best.x[:2]).intersections).volume, radius
