"""View: show a results folder again, in a window or as pictures, without its model."""

from __future__ import annotations

import json
import logging
import os
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from masonry_fem.errors import InstallationError, SceneError
from masonry_fem.host import installation
from masonry_fem.output import fields
from masonry_fem.output.folder import RUNNING, Folder, unfinished
from masonry_fem.output.masks import with_nan
from masonry_fem.output.picture import draw_all
from masonry_fem.output.scenery import Scenery, amplification_of, without_ends
from masonry_fem.output.sheet import STRESS_COLOURS

logger = logging.getLogger(__name__)


def view(directory: str | Path, png: str | Path | None = None) -> list[Path]:
    """Open the last recorded step of a results folder.

    Parameters
    ----------
    directory : Where a run wrote ``blocks.pvd``.
    png : Folder for pictures; without it a window opens, and the call returns when it is closed.

    Returns
    -------
    Paths of the pictures.

    Raises
    ------
    SceneError : The folder holds no field files.
    InstallationError : This machine has no screen, or cannot draw at all.
    """
    directory = Path(directory)
    installation.require_extra("pictures", f"'{directory}' cannot be shown")
    if said := unfinished(directory):
        logger.warning("%s", said)
    scenery = read_scenery(directory)
    if png is not None:
        if lack := installation.why_no_pictures():
            raise InstallationError(lack)
        with Folder(png := Path(png), "view"):
            return draw_all(scenery, png)
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise InstallationError(
            "cannot open a window: there is no display (DISPLAY is not set); use --png to write pictures"
        )
    _show(scenery)
    return []


def read_scenery(directory: str | Path) -> Scenery:
    """What pictures show, from the last step in a results folder."""
    directory = Path(directory)
    blocks = _read(last_file(directory / "blocks.pvd"))
    contacts = None
    if (directory / "contacts.pvd").exists():
        contacts = _read(last_file(directory / "contacts.pvd"))
        contacts.points = contacts.points + contacts.point_data[fields.DISPLACEMENT]
    contacts, ties = without_ends(contacts)
    faces = None
    if (directory / "interfaces.pvd").exists():
        faces = _read(last_file(directory / "interfaces.pvd"))
    return Scenery(
        blocks,
        contacts,
        int(blocks.field_data["dimension"][0]),
        float(blocks.field_data["length"][0]),
        _title(directory),
        faces,
        ties,
    )


def _read(path: Path) -> Any:
    import pyvista as pv  # noqa: PLC0415

    grid = pv.read(path)
    for arrays in (grid.point_data, grid.cell_data):
        with_nan(arrays)
    return grid


def last_file(collection: Path) -> Path:
    """The file of the last time in a ``.pvd`` collection."""
    if not collection.exists():
        raise SceneError(
            f"{collection}: no such file; expected the results folder of a run with output.fields = true"
        )
    entries = ET.parse(collection).findall(".//DataSet")
    if not entries:
        raise SceneError(f"{collection}: the series is empty; run the scene again")
    last = max(entries, key=lambda entry: float(entry.get("timestep", "0")))
    return collection.parent / str(last.get("file"))


def _title(directory: Path) -> str:
    """Of the scene; where its run did not come to its end it says so."""
    try:
        told = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
        title = str(told.get("title") or "") or directory.resolve().name
        outcome = told.get("outcome")
    except (OSError, ValueError, AttributeError):
        return directory.resolve().name
    return f"{title} ({outcome})" if outcome in (RUNNING, "interrupted", "failed") else title


def _show(scenery: Scenery) -> None:
    import pyvista as pv  # noqa: PLC0415

    blocks: Any = scenery.blocks.copy()
    factor = amplification_of(blocks.point_data[fields.DISPLACEMENT], blocks.points)
    blocks.points = blocks.points + factor * blocks.point_data[fields.DISPLACEMENT]
    scalars = fields.VON_MISES if fields.VON_MISES in blocks.point_data else fields.DISPLACEMENT
    plotter = pv.Plotter(title=f"{scenery.title} – displacements × {factor:g}")
    plotter.set_background("white")
    bar = {"title": "von Mises [Pa]" if scalars == fields.VON_MISES else "displacement [m]", "color": "black"}
    plotter.add_mesh(
        blocks, scalars=scalars, cmap=STRESS_COLOURS, show_edges=True, edge_opacity=0.3, scalar_bar_args=bar
    )
    if scenery.dimension == 2:
        plotter.view_xy()
    plotter.add_axes()
    plotter.show()
