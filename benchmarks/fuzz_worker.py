"""Fuzz worker: commands of masonry-fem one after another in one process, which the fuzzer may kill.

    python -m benchmarks.fuzz_worker    # a case a line of JSON on standard input, a report a line on output

Files are read in this process, not in one of their own: starting that takes longer than all else. A case that
kills the worker or does not end is run again by the fuzzer as users run it.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any

from masonry_fem import cli
from masonry_fem.importing import apart

MEMORY = 3e9  # of a case [bytes]
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGES = {
    "os.mkdir",
    "os.remove",
    "os.rename",
    "os.rmdir",
    "os.truncate",
    "os.symlink",
    "os.link",
    "shutil.rmtree",
}
WITHIN = {"os.mkdir", "os.remove", "os.rmdir"}  # whose last argument is an open folder, or -1
CACHES = ("/__pycache__", "/.cache/", "/.config/matplotlib", "/dev/")


class Watch:
    """Notes what Python writes outside of the folders that it may."""

    def __init__(self) -> None:
        self.allowed: tuple[str, ...] = ()
        self.strays: set[str] = set()
        sys.addaudithook(self.see)

    def see(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Take down a change of the file system."""
        opened = event == "open" and isinstance(arguments[2], int) and arguments[2] & WRITING
        if self.allowed and (opened or event in CHANGES):
            self.judge(arguments[0], arguments[-1] if event in WITHIN else -1)

    def judge(self, path: Any, folder: int) -> None:
        """A stray, unless it is where it may be; ``folder`` is open where the path starts there."""
        if not isinstance(path, str | bytes | os.PathLike):
            return
        start = os.getcwd() if folder < 0 else os.readlink(f"/proc/self/fd/{folder}")
        place = os.path.normpath(os.path.join(start, os.fsdecode(path)))
        if not place.startswith(self.allowed) and not any(cache in place for cache in CACHES):
            self.strays.add(place)


def serve() -> None:
    """Answer cases until the input ends."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_DATA, (int(MEMORY), int(MEMORY)))
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    apart.done_apart = lambda errands, limits: [one.function(*one.arguments) for one in errands]
    watch = Watch()
    with tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), 2)
        for line in sys.stdin:
            said.seek(0)
            said.truncate()
            report = _run(json.loads(line), watch)
            sys.stderr.flush()
            said.seek(0)
            report["said"] = said.read().decode(errors="replace")[-20_000:]
            print(json.dumps(report), file=answers)


def _run(case: dict[str, Any], watch: Watch) -> dict[str, Any]:
    folder = Path(case["folder"])
    watch.strays, start = set(), time.process_time()
    watch.allowed = tuple(
        str(one) for one in (folder / "out", folder / "tmp", tempfile.gettempdir() + "/masonry-fem-")
    )
    before = set(folder.rglob("*"))
    code: Any = None
    os.chdir(folder)
    try:
        code = cli.main(case["arguments"])
    except SystemExit as error:
        code = error.code
    except BaseException:
        traceback.print_exc()
    finally:
        watch.allowed = ()
        os.chdir("/")
    strays = watch.strays | {
        str(one) for one in set(folder.rglob("*")) - before if "out" not in one.relative_to(folder).parts
    }
    return {"code": code, "seconds": time.process_time() - start, "strays": sorted(strays)}


if __name__ == "__main__":
    serve()
