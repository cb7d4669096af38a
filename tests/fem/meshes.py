"""Structured meshes of boxes for tests: any kind of cell, straight or distorted, by NumPy alone."""

from itertools import permutations

import numpy as np

from masonry_fem.fem.lagrange import is_simplex, lagrange, linear, order
from masonry_fem.solid.mesh import FACET_OF, Mesh
from masonry_fem.solid.polytope import Polytope

CELLS = ("triangle", "quad", "tetra", "hexahedron", "triangle6", "quad9", "tetra10", "hexahedron27")


def dimension_of(cell):
    return lagrange(cell).nodes.shape[1]


def _simplices(low):
    """Kuhn simplices of one grid cell at integer corner ``low``, counter-clockwise / positive."""
    d = len(low)
    for path in permutations(range(d)):
        corners = [np.array(low)]
        for axis in path:
            step = np.zeros(d, dtype=int)
            step[axis] = 1
            corners.append(corners[-1] + step)
        if np.linalg.det(np.array(corners[1:]) - corners[0]) < 0:
            corners[1], corners[2] = corners[2], corners[1]
        yield np.array(corners, dtype=float)


def box_mesh(cell, counts, low, high, distort=0.0):
    """Mesh of a box; facet_face numbers the faces as ``Polytope.box`` does."""
    d = len(counts)
    corners_of = lagrange(linear(cell)).nodes
    cells = []
    for index in np.ndindex(*counts):
        if is_simplex(cell):
            cells.extend(_simplices(index))
        else:
            cells.append(corners_of + np.array(index, dtype=float))
    functions = lagrange(linear(cell)).values(lagrange(cell).nodes)
    everything = np.concatenate([functions @ corners for corners in cells])
    keys, inverse = np.unique(np.round(2 * everything).astype(int), axis=0, return_inverse=True)
    numbers = inverse.reshape(len(cells), -1)
    grid = keys / 2.0
    low, high = np.array(low, float), np.array(high, float)
    facets, faces = _facets(cell, numbers, grid, np.array(counts), d)
    points = low + grid / np.array(counts) * (high - low)
    if distort:
        points = _distorted(points, low, high, distort, counts, cell, numbers)
    return Mesh(points, cell, numbers, facets, faces)


def _distorted(points, low, high, distort, counts, cell, numbers):
    """Move interior corners about; mid-side nodes follow so that edges stay straight."""
    random = np.random.default_rng(4)
    moved = points + distort * (high - low) / np.array(counts) * random.uniform(-1, 1, points.shape)
    for face in (low, high):
        on = np.isclose(points, face)
        moved[on] = points[on]
    if order(cell) == 2:
        functions = lagrange(linear(cell)).values(lagrange(cell).nodes)
        corners = lagrange(linear(cell)).nodes.shape[0]
        straight = moved.copy()
        for nodes in numbers:
            straight[nodes] = functions @ moved[nodes[:corners]]
        return straight
    return moved


def _facets(cell, numbers, grid, counts, d):
    """Boundary facets with outward normals, by projecting the reference facet on each side."""
    facet = FACET_OF[cell]
    reference = lagrange(facet).nodes
    corners = lagrange(linear(facet)).nodes.shape[0]
    found, faces = [], []
    for axis in range(d):
        for side, value in enumerate((0.0, counts[axis])):
            normal = np.zeros(d)
            normal[axis] = 2 * side - 1
            for nodes in numbers:
                on = nodes[np.abs(grid[nodes, axis] - value) < 1e-9]
                if len(on) != len(reference):
                    continue
                found.append(_ordered(on, grid, reference, corners, normal, facet))
                faces.append(2 * axis + side)
    return np.array(found), np.array(faces)


def _ordered(on, grid, reference, corners, normal, facet):
    """The facet's nodes in VTK order, turned outwards."""
    places = grid[on]
    middle = places.mean(axis=0)
    # corners are those that no second-order node lies between: farthest apart on integer places
    candidates = [node for node in on if (grid[node] == np.round(grid[node])).all()]
    spokes = grid[candidates] - middle
    if len(normal) == 2:
        tangent = np.array([-normal[1], normal[0]])  # solid on the left
        loop = sorted(candidates, key=lambda node: float((grid[node] - middle) @ tangent))
    else:
        first = spokes[0] / np.linalg.norm(spokes[0])
        second = np.cross(normal, first)
        angle = np.arctan2(spokes @ second, spokes @ first)
        loop = [candidates[i] for i in np.argsort(angle)]
    assert len(loop) == corners
    places = lagrange(linear(facet)).values(reference) @ grid[loop]
    distance = np.linalg.norm(places[:, None] - grid[on][None], axis=2)
    assert distance.min(axis=1).max() < 1e-9
    return on[distance.argmin(axis=1)]


def box(low, high):
    return Polytope.box(tuple(low), tuple(high))
