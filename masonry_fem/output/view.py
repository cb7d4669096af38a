"""View: show a results folder again, in a window, in the browser, as pictures, a movie or a glTF model."""

from __future__ import annotations

import logging
import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_fem.errors import InstallationError, SceneError
from masonry_fem.host import installation
from masonry_fem.output import fields
from masonry_fem.output.folder import Folder, unfinished
from masonry_fem.output.picture import draw_all
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery, without_ends
from masonry_fem.output.viewing.look import Look, Section, checked_field, suited_factor
from masonry_fem.output.viewing.recorded import Recorded, entries_of, read_grid, title_in

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Wishes:
    """What of the results is shown, and where to.

    Attributes
    ----------
    png : Folder for pictures. movie : File for a movie, which shows ``movie_of``. gltf : File for a model.
    browser : Whether to serve a page, at ``port`` (0: a free one).
    step : Counted from 1; None for the last. field : What is coloured; None for what matters most.
    amplification : Of displacements; None to choose one. section : Such as ``y=0.25``.
    apart : How far blocks are pulled apart, as a share of their distances from the middle.
    """

    png: Path | None = None
    movie: Path | None = None
    movie_of: str | None = None
    gltf: Path | None = None
    browser: bool = False
    port: int = 0
    step: int | None = None
    field: str | None = None
    amplification: float | None = None
    section: str | None = None
    apart: float = 0.0


def view(directory: str | Path, png: str | Path | None = None, wishes: Wishes | None = None) -> list[Path]:
    """Open the recorded steps of a results folder, or write what is wanted of them.

    Parameters
    ----------
    directory : Where a run wrote ``blocks.pvd``.
    png : Folder for pictures of the last step; as in ``wishes``.
    wishes : What to write; where it names no file, a window opens, and the call returns when it is closed.

    Returns
    -------
    Paths of the files written.

    Raises
    ------
    SceneError : The folder holds no field files, or not the step or field that is wanted.
    InstallationError : This machine has no screen, cannot draw at all, or lacks what a file needs.
    """
    directory = Path(directory)
    wishes = wishes or Wishes(png=None if png is None else Path(png))
    installation.require_extra("pictures", f"'{directory}' cannot be shown")
    if said := unfinished(directory):
        logger.warning("%s", said)
    if wishes.png is not None:
        return _pictures(directory, wishes.png)
    recorded = Recorded.of(directory)
    if wishes.gltf is None and wishes.movie is None:
        _require_screen(directory, wishes)
    look, place = _look(recorded, wishes), recorded.number(wishes.step)
    made = []
    if wishes.gltf is not None:
        from masonry_fem.output.viewing.gltf import write_gltf  # noqa: PLC0415

        made.append(write_gltf(recorded, place, look, wishes.gltf))
    if wishes.movie is not None:
        from masonry_fem.output.viewing.movie import write_movie  # noqa: PLC0415

        _require_drawing()
        made.append(write_movie(recorded, wishes.movie, wishes.movie_of, look))
    if not made:
        _show(recorded, look, place, wishes)
    return made


def _pictures(directory: Path, png: Path) -> list[Path]:
    scenery = read_scenery(directory)
    _require_drawing()
    with Folder(png, "view"):
        return draw_all(scenery, png)


def _require_drawing() -> None:
    if lack := installation.why_no_pictures():
        raise InstallationError(lack)


def _require_screen(directory: Path, wishes: Wishes) -> None:
    """Refuse where there is neither a screen for a window nor what a page in the browser needs."""
    if wishes.browser:
        installation.require_extra("browser", f"'{directory}' cannot be shown in the browser")
        _require_drawing()
    elif sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise InstallationError(
            "cannot open a window: there is no display (DISPLAY is not set); use --png to write pictures, or "
            "--browser to see it in a browser"
        )


def _look(recorded: Recorded, wishes: Wishes) -> Look:
    """What is shown, as far as it is not said: what suits the steps."""
    blocks = recorded.blocks(-1)
    factor = suited_factor([blocks]) if wishes.amplification is None else wishes.amplification
    if factor < 0:
        raise SceneError(f"--amplification is {factor:g}, expected 0 or more")
    if not 0 <= wishes.apart < math.inf:
        raise SceneError(f"--apart is {wishes.apart:g}, expected 0 or more, such as 0.3")
    section = None if wishes.section is None else Section.read(wishes.section)
    if section is not None:
        section.keep(blocks)  # refuses a plane beside the structure
    return Look(checked_field(blocks, wishes.field), factor, section, wishes.apart)


def read_scenery(directory: str | Path) -> Scenery:
    """What pictures show, from the last step in a results folder."""
    directory = Path(directory)
    blocks = read_grid(last_file(directory / "blocks.pvd"))
    contacts = None
    if (directory / "contacts.pvd").exists():
        contacts = read_grid(last_file(directory / "contacts.pvd")).copy()
        contacts.points = contacts.points + contacts.point_data[fields.DISPLACEMENT]
    contacts, ties = without_ends(contacts)
    faces = None
    if (directory / "interfaces.pvd").exists():
        faces = read_grid(last_file(directory / "interfaces.pvd"))
    return Scenery(
        blocks,
        contacts,
        int(blocks.field_data["dimension"][0]),
        float(blocks.field_data["length"][0]),
        title_in(directory),
        faces,
        ties,
    )


def last_file(collection: Path) -> Path:
    """The file of the last time in a ``.pvd`` collection."""
    return list(entries_of(collection).values())[-1]


def _show(recorded: Recorded, look: Look, place: int, wishes: Wishes) -> None:
    """In a window or in the browser, until it is closed."""
    showing = showing_of(recorded, look, place, off_screen=wishes.browser)
    if wishes.browser:
        from masonry_fem.output.viewing.browser import open_page  # noqa: PLC0415

        open_page(showing, wishes.port)
    else:
        from masonry_fem.output.viewing.window import open_window  # noqa: PLC0415

        open_window(showing)


def showing_of(recorded: Recorded, look: Look, place: int = -1, *, off_screen: bool = True) -> Any:
    """A plotter that shows a step.

    Parameters
    ----------
    recorded : The steps. look : What is shown. place : Of the step, from 0 on.
    off_screen : Whether it draws without a window.
    """
    can_render()  # chooses VTK's window, which is fixed when it is first loaded
    import pyvista as pv  # noqa: PLC0415

    from masonry_fem.output.viewing.showing import Showing  # noqa: PLC0415

    plotter = pv.Plotter(title=recorded.title, off_screen=off_screen, window_size=[1280, 800])
    return Showing(recorded, plotter, look, place)
