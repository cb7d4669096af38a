"""Soundness: points and elements of a file that can be computed with at all.

check_points(points, "structures.f.path 'a.vtu'")
check_nodes(elements.nodes, tags, "structures.f.path 'a.vtu'")
"""

from __future__ import annotations

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.solid.pose import FloatArray

SMALLEST, LARGEST = 1e-30, 1e30  # [m]: volumes and moments of inertia neither vanish nor overflow


def check_points(points: FloatArray, title: str) -> None:
    """Refuse points that are no numbers, or so large or small that their volumes are none.

    Parameters
    ----------
    points : Of a file, with its scale [m], shape (n, d). title : What messages call the file.

    Raises
    ------
    GeometryError : Names the first point, or the size.
    """
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        place = ", ".join(f"{x:g}" for x in points[bad[0]])
        raise GeometryError(
            f"{title} has a point that is no number, ({place}), {bad[0] + 1} of {len(points)}, expected "
            "finite x y z; correct the file"
        )
    if not len(points):
        return
    far = float(np.abs(points).max())
    size = float(np.ptp(points, axis=0).max()) if far <= LARGEST else far
    if not size >= SMALLEST or not far <= LARGEST:
        raise GeometryError(
            f"{title} is {size:.2g} m large and reaches to {far:.2g} m, expected {SMALLEST:g} to "
            f"{LARGEST:g} m; correct its coordinates or the structure's scale"
        )
