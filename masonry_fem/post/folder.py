"""Folder: where results go, and how files get there whole."""

from __future__ import annotations

import os
from pathlib import Path

from masonry_fem.errors import MasonryError


def make_folder(out: Path) -> None:
    """Make the folder and those above it.

    Raises
    ------
    MasonryError : Where it is a file, or may not be made.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if isinstance(error, FileExistsError) else error.strerror
        raise MasonryError(f"results folder '{out}' cannot be made: {reason}; choose another one") from error


def write_atomic(path: Path, content: bytes) -> None:
    """Replace a file so that a reader, or an interruption, finds the old or the new one whole."""
    part = path.with_name(path.name + ".part")
    part.write_bytes(content)
    os.replace(part, path)
