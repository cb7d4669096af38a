"""Foreign files: reading with meshio, and points of a file that can be computed with at all.

mesh = quietly_read(path, "structures.f.path 'a.vtu'")
check_points(points, "structures.f.path 'a.vtu'")

Whatever meshio's readers raise or print becomes a GeometryError that names the file.
"""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

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


def quietly_read(path: Path, title: str) -> Any:
    """The ``meshio.Mesh`` of a file; what meshio prints is discarded.

    Parameters
    ----------
    path : The file.
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : meshio cannot read the file, or cells refer to points that do not exist.
    """
    import meshio  # noqa: PLC0415  foreign files are rare

    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers raise whatever a damaged file brings about
        first = [*str(error).strip().splitlines(), type(error).__name__][0]
        raise GeometryError(
            f"{title}: meshio cannot read it ({first}); open the file in the "
            "program that wrote it and export it again"
        ) from error
    _check_corners(mesh, title)
    return mesh


def _check_corners(mesh: Any, title: str) -> None:
    """Refuse cells with corners that the file does not have."""
    for block in mesh.cells:
        rows = block.data if isinstance(block.data, np.ndarray) else [np.asarray(row) for row in block.data]
        corners = np.concatenate([np.ravel(row) for row in rows]) if len(rows) else np.zeros(0)
        known = (corners >= 0) & (corners < len(mesh.points)) & (corners == np.round(corners))
        if not known.all():
            raise GeometryError(
                f"{title}: a {block.type} has the corner {corners[~known][0]}, expected the number of one of "
                f"the {len(mesh.points)} points, from 0 on; export the file again"
            )
