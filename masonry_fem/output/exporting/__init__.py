"""Exporting: a step of a results folder, or all of them, as a file for another program.

    export(Path("results/arch"), Path("arch.json"))

The ending tells the format; each is a file here with a function ``write(recorded, place, path)``.
"""

from __future__ import annotations

import logging
from importlib import import_module
from pathlib import Path

from masonry_fem.errors import SceneError
from masonry_fem.host import installation
from masonry_fem.output.folder import unfinished
from masonry_fem.output.viewing.recorded import Recorded

logger = logging.getLogger(__name__)

FORMATS = {  # modules
    ".json": "compas",
    ".xdmf": "xdmf",
    ".csv": "stones",
    ".glb": "gltf",
    ".vtm": "multiblock",
}


def export(directory: Path, path: Path, step: int | None = None) -> list[Path]:
    """Write a file for another program.

    Parameters
    ----------
    directory : Results folder of a run. path : The file; its ending tells the format.
    step : Recorded step, counted from 1; None for the last. XDMF has all steps.

    Returns
    -------
    Paths of the files written.

    Raises
    ------
    SceneError : The folder has no field files, or the ending is not known.
    """
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise SceneError(f"'{path}' ends in '{path.suffix}', expected one of {', '.join(FORMATS)}")
    installation.require_extra("pictures", f"'{directory}' cannot be exported")
    if said := unfinished(directory):
        logger.warning("%s", said)
    recorded = Recorded.of(directory)
    write = import_module(f"{__name__}.{FORMATS[ending]}").write
    made: list[Path] = write(recorded, recorded.number(step), path)
    return made
