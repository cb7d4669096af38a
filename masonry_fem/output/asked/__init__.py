"""Outputs that a scene asks for, one file each: its name is the key in ``[output]``, ``recorder`` makes it.

    for recorder in recorders(request): ...      # those whose keys are true

The first line of a file's docstring is the meaning of its key. A file is loaded only where its output is
asked for; nothing else lists it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from masonry_fem.errors import ExtensionError
from masonry_fem.records import discovery

if TYPE_CHECKING:
    from masonry_fem.output.recorder import Recorder, Request


def names() -> tuple[str, ...]:
    """What ``[output]`` may ask for, by the names of the files."""
    return discovery.names(__path__)


def meaning(key: str) -> str:
    """The first line of its file's docstring, without its full stop."""
    file = find_spec(f"{__name__}.{key}")
    assert file is not None
    told = ast.get_docstring(ast.parse(Path(str(file.origin)).read_text(encoding="utf-8")))
    return (told or "").partition("\n")[0].rstrip(".")


def recorders(request: Request) -> Iterator[Recorder]:
    """What is asked for, in the order of the files.

    Raises
    ------
    ExtensionError : A file that is asked for has no function ``recorder``, or what that makes is no recorder.
    """
    for key in names():
        if getattr(request.asked, key):
            signature = "recorder(request: Request) -> Recorder"
            make = discovery.function(f"{__name__}.{key}", signature, f"makes the output '{key}'")
            made = make(request)
            lacking = [owed for owed in ("dense", "start", "record", "close") if not hasattr(made, owed)]
            if lacking:
                raise ExtensionError(
                    f"{make.__code__.co_filename}: recorder gives a {type(made).__name__}, which lacks "
                    f"{', '.join(lacking)}, expected all that Recorder asks for "
                    "(masonry_fem/output/recorder.py); write it"
                )
            yield made
