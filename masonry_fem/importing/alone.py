"""Alone: a file for gmsh in a folder of its own, checked to be what its ending says.

gmsh decides by the content what kind of file it reads, and takes whatever it does not know for a program.
Besides, if there is a ``wall.msh.opt`` beside ``wall.msh``, it runs this, too. So gmsh is shown nothing but
the file itself.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from masonry_fem.errors import GeometryError
from masonry_fem.importing import DRAWINGS, PROGRAMS

BEGINNINGS = {
    ".msh": b"$MeshFormat",
    ".unv": b"    -1",
    ".med": b"\x89HDF\r\n",
    **dict.fromkeys(DRAWINGS, b"ISO-10303-21"),
}


@contextmanager
def alone(path: Path, title: str) -> Iterator[Path]:
    """A place from which gmsh can safely open the file.

    It holds a copy; for a program (``.geo``), a line that includes the program from where it is.

    Parameters
    ----------
    path : The file.
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : The file does not begin as files with its ending do.
    """
    kind = path.suffix.lower()
    with TemporaryDirectory(prefix="masonry-fem-") as folder:
        place = Path(folder) / f"file{kind}"
        if kind in PROGRAMS:
            _include(path.resolve(), place, title)
        else:
            _check_beginning(path, title, BEGINNINGS[kind])
            shutil.copyfile(path, place)
        try:
            yield place
        except GeometryError as error:
            raise GeometryError(str(error).replace(str(place), path.name)) from error


def _include(path: Path, place: Path, title: str) -> None:
    """A program that includes the one at ``path``, which so finds the files that it includes itself."""
    if '"' in str(path) or "\\" in str(path) or not str(path).isprintable():
        raise GeometryError(
            f"{title} stands at {str(path)!r}, expected a path without quotation marks, backslashes and "
            "control characters; move it"
        )
    place.write_text(f'Include "{path}";\n', encoding="utf-8")


def _check_beginning(path: Path, title: str, expected: bytes) -> None:
    with path.open("rb") as file:
        found = file.read(len(expected))
    if found != expected:
        said, wanted = (one.decode(errors="replace") for one in (found, expected))
        raise GeometryError(
            f"{title} begins with {said!r}, expected {wanted!r} as in every {path.suffix} file; export it "
            "again, or give it the ending of what it is"
        )
