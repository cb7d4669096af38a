"""Stress block: pressure distributions that carry a normal force at a centre of pressure without tension.

    linear = linear_block(faces, centre)       # pressure grows linearly from the neutral line
    plastic = plastic_block(faces, centre)     # uniform pressure on the largest part centred there

Both are per unit of force: multiply ``pressure`` by N. If the centre of pressure lies in the kern, the linear
block covers the whole face (Navier's formula); otherwise the neutral line cuts the face. In 2D the linear
block then has the pressure 2/(3(B/2 − e)) on a length 3(B/2 − e), and the plastic one 1/(B − 2e). In 3D,
with an
eccentricity in both directions, both neutral lines are found by Newton's method for all joints at once. NumPy
only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.joint_faces import JointFaces
from masonry_fem.output.polygon_moments import polygon_moments

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

STEPS, HALVINGS = 40, 20
TOLERANCE = 1e-10  # on force and moment, relative
EDGE = 1e-6  # of a face's width: a centre of pressure that near its outline presses a line


@dataclass(frozen=True, slots=True)
class Block:
    """Pressure of a joint for unit force.

    Both are NaN if the face has no area or the centre of pressure lies outside it; if it lies on the
    outline, the pressure is infinite and the area 0.

    Attributes
    ----------
    pressure : Greatest pressure, shape (i,) [1/m²; 1/m in 2D].
    area : Compressed area, shape (i,) [m²; m in 2D].
    """

    pressure: FloatArray
    area: FloatArray


def kern_share(faces: JointFaces, centre: FloatArray) -> FloatArray:
    """Eccentricity relative to the kern: 0 in the centroid, 1 on the rim of the kern, shape (i,).

    The kern of a rectangle is a rhombus whose diagonals are its middle thirds; that of a line its middle
    third. NaN if the face has no area.

    Parameters
    ----------
    faces : Faces of i joints.
    centre : Centres of pressure, from the centroid along the axes of the face, shape (i, a) [m].
    """
    stress = _navier(faces, centre)
    least = np.where(_real(faces), stress, np.inf).min(axis=1, initial=np.inf)
    share: FloatArray = np.where(faces.area > 0, 1.0 - least, np.nan)
    return share


def linear_block(faces: JointFaces, centre: FloatArray) -> Block:
    """Linear pressure without tension.

    Parameters
    ----------
    faces : Faces of i joints.
    centre : Centres of pressure, from the centroid along the axes of the face, shape (i, a) [m].
    """
    inside, edge = _position(faces, centre)
    if faces.flat.shape[2] == 1:
        width, e = faces.size[:, 0], np.abs(centre[:, 0])
        whole = e <= width / 6
        pressed = np.where(whole, width, 3 * (0.5 * width - e))
        top = np.where(whole, (1 + 6 * e / _positive(width)) / _positive(width), 2 / _positive(pressed))
        return _told(top, pressed, inside, edge)
    solve = inside & ~edge
    top, pressed = np.zeros(len(centre)), np.zeros(len(centre))
    whole = solve & (kern_share(faces, centre) <= 1)
    top[whole] = _navier(faces, centre)[whole].max(axis=1) / faces.area[whole]
    pressed[whole] = faces.area[whole]
    cut = solve & ~whole
    scale = faces.size[cut]
    corners, at = faces.flat[cut] / scale[:, None], centre[cut] / scale
    values = _linear(corners, at)
    area, _, _ = polygon_moments(corners, values)
    shrink = scale.prod(axis=1)
    top[cut], pressed[cut] = values.max(axis=1, initial=0.0) / shrink, area * shrink
    return _told(top, pressed, inside, edge)


def plastic_block(faces: JointFaces, centre: FloatArray) -> Block:
    """Uniform pressure on the part of the face that a straight line cuts off with its centroid at ``centre``.

    Parameters
    ----------
    faces : Faces of i joints.
    centre : Centres of pressure, from the centroid along the axes of the face, shape (i, a) [m].
    """
    inside, edge = _position(faces, centre)
    if faces.flat.shape[2] == 1:
        pressed = faces.size[:, 0] - 2 * np.abs(centre[:, 0])
        return _told(1 / _positive(pressed), pressed, inside, edge)
    pressed = faces.area.copy()
    scale = np.where(faces.size > 0, faces.size, 1.0)
    off = np.linalg.norm(centre / scale, axis=1) > 1e-9
    cut = inside & ~edge & off
    corners = (faces.flat[cut] - centre[cut][:, None]) / scale[cut][:, None]
    pressed[cut] = _largest(corners, centre[cut] / scale[cut]) * scale[cut].prod(axis=1)
    return _told(1 / _positive(pressed), pressed, inside, edge)


def _told(top: FloatArray, pressed: FloatArray, inside: Mask, edge: Mask) -> Block:
    return Block(
        np.where(edge, np.inf, np.where(inside, top, np.nan)),
        np.where(edge, 0.0, np.where(inside, pressed, np.nan)),
    )


def _positive(values: FloatArray) -> FloatArray:
    return np.where(values > 0, values, 1.0)


def _real(faces: JointFaces) -> Mask:
    real: Mask = np.arange(faces.flat.shape[1]) < faces.corners[:, None]
    return real


def _navier(faces: JointFaces, centre: FloatArray) -> FloatArray:
    """Linear stress with tension at the corners, over its mean, shape (i, k)."""
    solid = faces.area > 0
    a = faces.flat.shape[2]
    second = np.where(solid[:, None, None], faces.second, np.eye(a))
    slope = np.linalg.solve(second, faces.area[:, None, None] * centre[:, :, None])[:, :, 0]
    stress: FloatArray = 1.0 + np.einsum("ika,ia->ik", faces.flat, slope)
    return stress


def _position(faces: JointFaces, centre: FloatArray) -> tuple[Mask, Mask]:
    """Where the centre of pressure lies in the face, and where it lies on its outline, shape (i,)."""
    depth, solid = outline_distance(faces, centre), faces.area > 0
    width = np.where(faces.size > 0, faces.size, np.inf).min(axis=1, initial=np.inf)
    width = np.where(np.isfinite(width), width, 1.0)
    inside = solid & (depth >= -EDGE * width)
    return inside, inside & (depth <= EDGE * width)


def outline_distance(faces: JointFaces, points: FloatArray) -> FloatArray:
    """Distance of points (i, a) in the faces to their outline, negative outside, shape (i,) [m]."""
    if faces.flat.shape[2] == 1:
        ends = faces.extent[:, 0]
        nearest: FloatArray = np.minimum(points[:, 0] - ends[:, 0], ends[:, 1] - points[:, 0])
        return nearest
    normals, reach = outline(faces)
    ahead = reach - np.einsum("ika,ia->ik", normals, points)
    distance: FloatArray = ahead.min(axis=1, initial=np.inf)
    return distance


def outline(faces: JointFaces) -> tuple[FloatArray, FloatArray]:
    """Outward unit normals of the edges in the face's axes (i, k, 2) and their distances (i, k) [m].

    Edges without length have an infinite one. In 2D the normals are the two directions of the axis.
    """
    if faces.flat.shape[2] == 1:
        ends = np.broadcast_to(np.array([[-1.0], [1.0]]), (len(faces.area), 2, 1))
        return ends, np.stack([-faces.extent[:, 0, 0], faces.extent[:, 0, 1]], axis=1)
    edge = np.roll(faces.flat, -1, axis=1) - faces.flat
    length = np.linalg.norm(edge, axis=2)
    real = length > 1e-9 * length.max(axis=1, initial=0.0)[:, None]
    normals = np.stack([edge[:, :, 1], -edge[:, :, 0]], axis=2) / np.where(real, length, 1.0)[:, :, None]
    reach = np.where(real, np.einsum("ika,ika->ik", normals, faces.flat), np.inf)
    return normals, reach


def _linear(corners: FloatArray, at: FloatArray) -> FloatArray:
    """Values at the corners (i, k) of the plane whose positive part has unit force at ``at`` (i, 2).

    They minimise the convex ∫ ½ max(0, σ)² − σ(at); σ = c · (1, y).
    """
    load = np.concatenate([np.ones((len(at), 1)), at], axis=1)
    unit = np.concatenate([np.ones((*corners.shape[:2], 1)), corners], axis=2)

    def energy(c: FloatArray, rows: IntArray) -> FloatArray:
        matrix = _matrix(*polygon_moments(corners[rows], np.einsum("ikp,ip->ik", unit[rows], c)))
        own = 0.5 * np.einsum("ip,ipq,iq->i", c, matrix, c)
        half: FloatArray = own - np.einsum("ip,ip->i", c, load[rows])
        return half

    def newton(c: FloatArray, rows: IntArray) -> tuple[FloatArray, Mask]:
        matrix = _matrix(*polygon_moments(corners[rows], np.einsum("ikp,ip->ik", unit[rows], c)))
        residual = load[rows] - np.einsum("ipq,iq->ip", matrix, c)
        ridge = 1e-14 * np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        change = np.linalg.solve(matrix + ridge, residual[:, :, None])[:, :, 0]
        return change, np.abs(residual).max(axis=1, initial=0.0) <= TOLERANCE

    whole = _matrix(*polygon_moments(corners))
    solution = _minimum(energy, newton, np.linalg.solve(whole, load[:, :, None])[:, :, 0])
    values: FloatArray = np.einsum("ikp,ip->ik", unit, solution)
    return values


def _matrix(area: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """∫ (1, y)(1, y)ᵀ, shape (i, 3, 3)."""
    matrix = np.empty((len(area), 3, 3))
    matrix[:, 0, 0], matrix[:, 0, 1:], matrix[:, 1:, 0], matrix[:, 1:, 1:] = area, first, first, second
    return matrix


def _largest(corners: FloatArray, centre: FloatArray) -> FloatArray:
    """Area of the largest part of a polygon with the centroid 0, where its own is −``centre``, (i,).

    It is where 1 + λ·y is positive for the λ that minimises the convex ∫ max(0, 1 + λ·y).
    """

    def measure(slope: FloatArray, rows: IntArray) -> FloatArray:
        area, first, _ = polygon_moments(corners[rows], _heights(corners[rows], slope))
        total: FloatArray = area + np.einsum("ia,ia->i", first, slope)
        return total

    def newton(slope: FloatArray, rows: IntArray) -> tuple[FloatArray, Mask]:
        values = _heights(corners[rows], slope)
        area, first, _ = polygon_moments(corners[rows], values)
        matrix = _cut_line(corners[rows], values) / np.linalg.norm(slope, axis=1)[:, None, None]
        ridge = 1e-12 * np.maximum(np.trace(matrix, axis1=1, axis2=2), area)[:, None, None] * np.eye(2)
        change = np.linalg.solve(matrix + ridge, -first[:, :, None])[:, :, 0]
        # a line beside the polygon tells the direction only
        far = np.linalg.norm(change, axis=1) / np.linalg.norm(slope, axis=1)
        return change / np.maximum(far, 1.0)[:, None], np.linalg.norm(first, axis=1) <= TOLERANCE * area

    outwards = centre / np.linalg.norm(centre, axis=1)[:, None]
    reach = np.einsum("ika,ia->ik", corners, outwards).max(axis=1)
    # right for a rectangle with the centre on an axis
    slope = _minimum(measure, newton, outwards / reach[:, None])
    area, _, _ = polygon_moments(corners, _heights(corners, slope))
    return area


def _heights(corners: FloatArray, slope: FloatArray) -> FloatArray:
    heights: FloatArray = 1 + np.einsum("ika,ia->ik", corners, slope)
    return heights


def _cut_line(corners: FloatArray, values: FloatArray) -> FloatArray:
    """∫ y yᵀ along the line on which the values are 0, within the polygon, shape (i, 2, 2)."""
    after = np.roll(values, -1, axis=1)
    crossing = (values >= 0) != (after >= 0)
    share = np.where(crossing, values, 0.0) / np.where(crossing, values - after, 1.0)
    cut = corners + share[:, :, None] * (np.roll(corners, -1, axis=1) - corners)
    rows = np.arange(len(cut))
    last = crossing.shape[1] - 1 - crossing[:, ::-1].argmax(axis=1)
    a, b = cut[rows, crossing.argmax(axis=1)], cut[rows, last]
    length = np.where(crossing.any(axis=1), np.linalg.norm(b - a, axis=1), 0.0)
    s = a + b
    total = (
        a[:, :, None] * a[:, None, :] + b[:, :, None] * b[:, None, :] + s[:, :, None] * s[:, None, :]
    ) / 6
    integral: FloatArray = length[:, None, None] * total
    return integral


def _minimum(
    function: Callable[[FloatArray, IntArray], FloatArray],
    newton: Callable[[FloatArray, IntArray], tuple[FloatArray, Mask]],
    at: FloatArray,
) -> FloatArray:
    """Minima of convex functions, one per joint; Newton steps that overshoot are halved.

    Both are told the joints (rows) that they are asked for; ``newton`` says which have arrived.
    """
    at, left = at.copy(), np.arange(len(at))
    for _ in range(STEPS):
        change, arrived = newton(at[left], left)
        left, change = left[~arrived], change[~arrived]
        if not left.size:
            break
        before, trying = function(at[left], left), np.arange(len(left))
        start, share = at[left], np.ones(len(left))
        for _ in range(HALVINGS):
            rows = left[trying]
            after = function(start[trying] + share[trying, None] * change[trying], rows)
            trying = trying[after > before[trying] + 1e-13 * np.abs(before[trying])]
            if not trying.size:
                break
            share[trying] *= 0.5
        at[left] = start + share[:, None] * change
    return at
