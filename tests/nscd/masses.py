"""Masses: thick masonry, bonded in length, thickness and height, whose body matrix is three-dimensional."""

from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from .walls import GRAVITY, rigid_boxes

BRICK = (0.4, 0.2, 0.2)


def bonded_boxes(length, thickness, courses, brick=BRICK):
    """Boxes (low corner, size) of ``length`` x ``thickness`` bricks a course.

    Every other course is shifted by half a brick both ways, so that a brick lies on three; every
    other row of a course by half a brick along it. Parts of bricks fill the ends.
    """
    sides = [_cuts(length, brick[0]), _cuts(thickness, brick[1])]
    boxes = []
    for course in range(courses):
        for row, (front, back) in enumerate(pairwise(sides[1][course % 2])):
            boxes += [
                ((left, front, course * brick[2]), (right - left, back - front, brick[2]))
                for left, right in pairwise(sides[0][(row + course) % 2])
            ]
    return boxes


def _cuts(count, size):
    """Joints of a straight course and of one that is shifted by half a brick."""
    straight = size * np.arange(count + 1)
    return straight, np.r_[0.0, straight[:-1] + size / 2, straight[-1]]


def touching_boxes(boxes):
    """(upper, lower, axis) of boxes that share part of a face, the floor being −1; shape (n, 3)."""
    low = np.array([box[0] for box in boxes])
    size = np.array([box[1] for box in boxes])
    high = low + size
    near = cKDTree(low + size / 2).query_pairs(
        1.01 * float(np.linalg.norm(size.max(axis=0))), output_type="ndarray"
    )
    near = np.concatenate([near, near[:, ::-1]])
    upper, lower = near.T
    gap = np.abs(low[upper] - high[lower])
    overlap = np.minimum(high[upper], high[lower]) - np.maximum(low[upper], low[lower])
    found = []
    for axis in range(3):
        across = np.delete(overlap, axis, axis=1)
        touches = (gap[:, axis] < 1e-9) & (across > 1e-9).all(axis=1)
        found.append(np.column_stack([near[touches], np.full(touches.sum(), axis)]))
    floor = np.flatnonzero(low[:, 2] < 1e-9)
    found.append(np.column_stack([floor, np.full_like(floor, -1), np.full_like(floor, 2)]))
    pairs = np.concatenate(found)
    return pairs[np.lexsort((pairs[:, 2], pairs[:, 1], pairs[:, 0]))]


def rigid_mass(length=4, thickness=4, courses=4, *, friction=0.6, horizontal=0.1, inertia=1.0, step=1.0):
    """A bonded cuboid of rigid bricks under gravity and ``horizontal`` g along x."""
    boxes = bonded_boxes(length, thickness, courses)
    pull = GRAVITY + np.array([9.81 * horizontal, 0, 0])
    return rigid_boxes(
        boxes, touching_boxes(boxes), friction=friction, acceleration=pull, inertia=inertia, step=step
    )
