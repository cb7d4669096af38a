"""Meshio reading: files of meshio's formats, its failures as errors of ours."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

from masonry_fem.errors import GeometryError


def quietly_read(path: Path, title: str) -> Any:
    """The ``meshio.Mesh`` of a file.

    Raises
    ------
    GeometryError : meshio cannot read it.
    """
    import meshio  # noqa: PLC0415  foreign files are rare

    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers raise whatever a damaged file brings about
        first = [*str(error).strip().splitlines(), type(error).__name__][0]
        raise GeometryError(
            f"{title}: meshio cannot read it ({first}); open the file in the "
            "program that wrote it and export it again"
        ) from error
