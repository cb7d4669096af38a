"""Folder: where results go."""

from __future__ import annotations

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
