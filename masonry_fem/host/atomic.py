"""Atomic: files that are written completely or not at all, however a program ends.

write_atomic(path, content)        # a reader finds the old file or the new one, never a part of it

While a file is being written it is called NAME.part. What is ``durable`` stands on the disk itself before it
takes the place of the old file, and its name does before the call returns: a power cut leaves the one or the
other whole. ``watchers`` are told of each file before it is begun; a
results folder keeps its list of files in this way, so that the next run can remove them.
"""

from __future__ import annotations

import contextlib
import csv
import errno
import io
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from masonry_fem.errors import OutputError

PART = ".part"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
UNSETTLED = (errno.EINVAL, errno.ENOTSUP, errno.EROFS)  # of file systems that do not tell
FORBIDDEN = (errno.EACCES, errno.EPERM, errno.EROFS)

watchers: list[Callable[[Path], None]] = []


def announce(path: Path) -> None:
    """Tell the watchers that a file is about to be written."""
    for watcher in list(watchers):
        watcher(path)


def write_atomic(path: Path, content: bytes, *, durable: bool = False) -> None:
    """Replace a file so that a reader finds the old or the new one whole, even after an interruption.

    Parameters
    ----------
    path : The file; missing folders are made.
    content : All of its bytes.
    durable : Even after a power cut; takes as long as the disk does.

    Raises
    ------
    OutputError : The disk is full, or the place may not be written to.
    """
    part = path.with_name(path.name + PART)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        announce(path)
        try:
            part.write_bytes(content)
            if durable:
                settle(part)
            os.replace(part, path)
            if durable:
                settle(path.parent)
        except BaseException:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
            raise
    except (OSError, UnicodeEncodeError) as error:
        raise unwritten(path, error) from error


def settle(path: Path) -> None:
    """Wait until a file, or the names in a folder, stand on the disk itself."""
    file = os.open(path, os.O_RDONLY)
    try:
        os.fsync(file)
    except OSError as error:
        if error.errno not in UNSETTLED:
            raise
    finally:
        os.close(file)


def write_table(path: Path, titles: Iterable[str], rows: Iterable[Iterable[Any]]) -> Path:
    """Write a table as CSV in the same way; what is no number (nan) leaves its cell empty.

    Parameters
    ----------
    path : The file, which is returned.
    titles : Of the columns. rows : Their values, line by line.

    Raises
    ------
    OutputError : The disk is full, or the place may not be written to.
    """
    import numpy as np  # noqa: PLC0415 - the command line reads this file

    head = list(titles)
    cells = np.fromiter(chain.from_iterable(rows), dtype=object)
    cells[cells != cells] = ""  # noqa: PLR0124 - nan is what differs from itself
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(head)
    table.writerows(cells.reshape(-1, len(head)).tolist())
    write_atomic(path, text.getvalue().encode())
    return path


def write_records(
    path: Path, records: Iterable[Mapping[str, Any]], first: Sequence[str] = (), end: str = "\n"
) -> Path:
    """Write a table as CSV in the same way, a line a record; what a record lacks leaves its cell empty.

    Parameters
    ----------
    path : The file, which is returned.
    records : Values by the titles of their columns.
    first : Titles of the first columns; the others follow as they come. end : Of each line.

    Raises
    ------
    OutputError : The disk is full, or the place may not be written to.
    """
    rows = list(records)
    text = io.StringIO()
    table = csv.DictWriter(
        text, list(dict.fromkeys([*first, *chain.from_iterable(rows)])), restval="", lineterminator=end
    )
    table.writeheader()
    table.writerows(rows)
    write_atomic(path, text.getvalue().encode())
    return path


def unwritten(path: Path, error: OSError | UnicodeEncodeError) -> OutputError:
    """The error to raise for a file that could not be written, with the reason and what helps.

    Parameters
    ----------
    path : The file.
    error : What the operating system, or the encoding of the name, raised.
    """
    if isinstance(error, UnicodeEncodeError):
        reason, cure = "its name has letters that this locale lacks", "set LC_ALL=C.UTF-8"
    elif error.errno in FULL:
        reason, cure = error.strerror or "no space", "free some space, or choose another place"
    elif error.errno in FORBIDDEN:
        reason, cure = error.strerror or "not allowed", "choose a place that you may write to"
    else:
        reason, cure = error.strerror or str(error), "choose another place"
    return OutputError(f"{path} cannot be written: {reason}; {cure}")
