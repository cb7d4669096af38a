"""Folder: where results go; one command at a time writes there, and removes what it left there before.

    with Folder(out, "run", title="arch"):        # summary.json says "running", old results are gone
        ...                                       # every file written in it is listed as it is begun

In its folder ``.masonry-fem`` the file ``lock`` is locked meanwhile, by the system, so that no kill can
leave it locked, and one file a command lists what this wrote. What stands in no list is the user's and is
never touched.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Any, Self

from masonry_fem.errors import MasonryError, OutputError
from masonry_fem.host.atomic import PART, announce, unwritten, watchers, write_atomic
from masonry_fem.records.told import Ending, versioned, write

logger = logging.getLogger(__name__)

OWN = ".masonry-fem"
LOCK = f"{OWN}/lock"
RUNNING = "running"
SUMMARY = {"run": "summary.json", "collapse": "collapse.json"} | {
    command: f"{command}.json" for command in ("study", "threshold")
}
LASTING = "cells/"  # of a study or a search for a threshold: a second one goes on with them


class Folder:
    """Results folder of one command.

    Parameters
    ----------
    path : Where; made where it is missing.
    command : Who writes: run, collapse, threshold, study, mesh or view.
    title : Of the scene, for the summary.
    clears : Other commands whose files are removed too, as they are made from this one's.
    keeps : Files, and folders with a ``/`` at their end, that stay: the command goes on with them.

    Raises
    ------
    OutputError : Somebody else writes there, or one may not.
    """

    def __init__(
        self, path: Path, command: str, title: str = "", clears: Sequence[str] = (), keeps: Sequence[str] = ()
    ) -> None:
        self.path, self._command, self._title, self._clears = Path(path), command, title, clears
        self._keeps = keeps
        self._list = self.path / OWN / command
        self._names: set[str] = set()
        self._theirs: dict[Path, list[str]] = {}  # lists of other commands
        self._lock = -1

    def __enter__(self) -> Self:
        """Lock the folder, say that it is being written, and remove what is old."""
        make_folder(self.path)
        make_folder(self.path / OWN)
        announce(self._list)
        announce(self.path / LOCK)
        self._lock = _locked(self.path)
        try:
            self._begin()
        except BaseException:  # old files may remain: the summary keeps saying "running"
            os.close(self._lock)
            raise
        watchers.append(self._enter)
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Let others write there; a summary that still says "running" says what came instead, or goes."""
        watchers.remove(self._enter)
        self._end(error)

    def _end(self, error: BaseException | None) -> None:
        summary = SUMMARY.get(self._command)
        if summary is not None and _outcome(self.path / summary) == RUNNING:
            with contextlib.suppress(OutputError, OSError):  # where there is no room it goes on saying so
                if error is None:  # what is told is written later
                    (self.path / summary).unlink()
                else:
                    write(self.path / summary, ended_by(error, self._command, self._title))
        os.close(self._lock)

    def _begin(self) -> None:
        summary = SUMMARY.get(self._command)
        lists = [self._list, *(self.path / OWN / other for other in self._clears)]
        old = [name for one in lists for name in listed(one)]
        if summary is not None:
            self._names = set(old)
            self._enter(self.path / summary)  # listed from here on, whatever happens
            write(self.path / summary, _running(self._command, self._title))
        stays = {name for name in old if self._stays(name)}
        self._remove(name for name in old if name != summary and name not in stays)
        for other in lists[1:]:
            other.unlink(missing_ok=True)
        self._theirs = self._lists_of_others()
        self._names = stays | ({summary} if summary is not None else set())
        write_atomic(self._list, _lines(self._names))

    def _lists_of_others(self) -> dict[Path, list[str]]:
        others = set((self.path / OWN).iterdir()) - {self._list, self.path / LOCK}
        return {one: listed(one) for one in sorted(others) if not one.name.endswith(PART)}

    def _stays(self, name: str) -> bool:
        return any(name == one or (one.endswith("/") and name.startswith(one)) for one in self._keeps)

    def _remove(self, names: Iterator[str]) -> None:
        """Remove listed files, what was left of them half-written, and folders that are empty then."""
        for name in dict.fromkeys(names):
            path = self.path / name
            for one in (path, path.with_name(path.name + PART)):
                with contextlib.suppress(IsADirectoryError, PermissionError, FileNotFoundError):
                    one.unlink()
            for parent in (path, *path.parents):
                if parent == self.path:
                    break
                with contextlib.suppress(OSError):
                    parent.rmdir()

    def _enter(self, path: Path) -> None:
        """List a file in here before it is begun."""
        if not path.is_relative_to(self.path):
            return
        name = path.relative_to(self.path).as_posix()
        if name in self._names or name.startswith((LASTING, f"{OWN}/")):
            return
        self._names.add(name)
        for other, theirs in self._theirs.items():
            if name in theirs:  # another command's file is overwritten: from now on this command owns it
                theirs.remove(name)
                write_atomic(other, _lines(theirs))
        try:
            with self._list.open("ab", buffering=0) as file:
                file.write(_lines([name]))
        except OSError as error:
            raise unwritten(self._list, error) from error


def make_folder(out: Path) -> None:
    """Make the folder and those above it.

    Raises
    ------
    OutputError : Where it is a file, or may not be made.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "it is a file" if isinstance(error, FileExistsError) else error.strerror
        raise OutputError(f"results folder '{out}' cannot be made: {reason}; choose another one") from error


def refuse_busy(out: Path) -> None:
    """Refuse a folder that another process writes to.

    Raises
    ------
    OutputError : One does.
    """
    writer = writer_of(out)
    if writer:
        raise _busy(out, writer)


def writer_of(out: Path) -> str:
    """Number of the process that writes to a folder now; empty where none does."""
    try:
        lock = os.open(out / LOCK, os.O_RDONLY)
    except OSError:
        return ""
    try:
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return _pid(lock)
    except OSError:
        return ""
    finally:
        os.close(lock)
    return ""


def unfinished(out: Path, summary: str = "summary.json") -> str:
    """A sentence if the command that writes to a folder is still running or was killed; else empty.

    Parameters
    ----------
    out : The folder.
    summary : Name of the command's summary in it.
    """
    if _outcome(out / summary) != RUNNING:
        return ""
    writer = writer_of(out)
    if writer:
        return f"{out}: process {writer} is still writing; what is there so far is not the end"
    cure = f"'masonry-fem resume {out}' goes on" if (out / "checkpoint.npz").exists() else "run it again"
    return f"{out}: what wrote there was killed before its end; what is there is not the end, {cure}"


def listed(path: Path) -> list[str]:
    """Names in a list of files; those that would lead out of the folder do not count."""
    try:
        text = path.read_text(encoding="utf-8", errors="surrogateescape")
    except OSError:
        return []
    names = [PurePosixPath(line) for line in text.splitlines() if line]
    return [str(name) for name in names if not name.is_absolute() and ".." not in name.parts]


def _locked(out: Path) -> int:
    path = out / LOCK
    try:
        lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise unwritten(path, error) from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        writer = _pid(lock)
        os.close(lock)
        raise _busy(out, writer) from None
    except OSError:
        logger.warning("%s: its file system has no locks; see to it that nothing else writes there", out)
    with contextlib.suppress(OSError):  # the number is for messages only
        os.ftruncate(lock, 0)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)
    return lock


def _pid(lock: int) -> str:
    return os.pread(lock, 32, 0).decode(errors="replace").strip() or "unknown"


def _busy(out: Path, writer: str) -> OutputError:
    return OutputError(
        f"results folder '{out}' is being written by process {writer}; wait for its end, "
        "or choose another folder with --out"
    )


def ended_by(error: BaseException, command: str, title: str, so_far: str = "") -> Ending:
    """What the summary says of a command that did not come to its end.

    Parameters
    ----------
    error : What ended it.
    command : Its name.
    title : Of the scene.
    so_far : What there is of its results, in words.
    """
    outcome, said = "failed", f"unexpected {type(error).__name__}: {error}"
    if isinstance(error, KeyboardInterrupt):
        outcome, said = "interrupted", "Ended from outside before it was done"
    elif isinstance(error, MasonryError):
        said = str(error)
    message = "; ".join(filter(None, (said, so_far)))
    return Ending(schema=versioned(command), title=title, outcome=outcome, message=f"{message}.")


@contextlib.contextmanager
def telling_end(out: Path, title: str, so_far: Callable[[], str]) -> Iterator[None]:
    """Runs one after another: what ends them early is told in the summary above them.

    Parameters
    ----------
    out : Folder of the summary. title : Of the scene.
    so_far : Tells what there is of the results, in words.
    """
    try:
        yield
    except BaseException as error:
        with contextlib.suppress(Exception):
            write(out / "summary.json", ended_by(error, "run", title, so_far()))
        raise


def _lines(names: Iterable[str]) -> bytes:
    return "".join(f"{name}\n" for name in names).encode(errors="surrogateescape")


def _outcome(summary: Path) -> Any:
    """What a summary says; None where there is none."""
    try:
        told = json.loads(summary.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return told.get("outcome") if isinstance(told, dict) else None


def _running(command: str, title: str) -> Ending:
    """What the summary says until the end."""
    message = "Not done: the files here are of a run under way, or of one that was killed."
    return Ending(schema=versioned(command), title=title, outcome=RUNNING, message=message, pid=os.getpid())
