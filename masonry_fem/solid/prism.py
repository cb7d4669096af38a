"""Prism: a polygon in 2D; in 3D the solid that the polygon sweeps along y."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray


def prism(
    outline: FloatArray,
    names: Sequence[str],
    labels: Sequence[str],
    depth: float,
    dimension: int,
    sides: str = "",
) -> Polytope:
    """The polygon of an outline in 2D, the prism over it in 3D.

    Parameters
    ----------
    outline : Corners in counter-clockwise order, shape (n, 2) [m]; x and z in 3D.
    names, labels : Face name and joint label of each edge; edge i joins corners i and i + 1.
    depth : Length of the prism along y, from 0 [m]; not used in 2D.
    dimension : 2 or 3.
    sides : Joint label of the faces ``front`` and ``back``.
    """
    n = len(outline)
    following = [(i + 1) % n for i in range(n)]
    if dimension == 2:
        return Polytope(outline, tuple(zip(range(n), following, strict=True)), tuple(names), tuple(labels))
    front = np.column_stack([outline[:, 0], np.zeros(n), outline[:, 1]])
    vertices = np.concatenate([front, front + np.array([0.0, depth, 0.0])])
    around = [(i, i + n, j + n, j) for i, j in enumerate(following)]
    # seen from the front (against y) the outline runs counter-clockwise
    loops = [*around, tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1))]
    return Polytope(vertices, tuple(loops), (*names, "front", "back"), (*labels, sides, sides))
