"""Report page: open the report of a results folder in Chromium, click in it, and tell what that took.

    python -m benchmarks.report_page results/dome        # size, CPU seconds to open, stones named, errors

A hundred clicks go over the model on a grid, one to each heading of the tables. Seconds are CPU time of the
browser beyond what it takes for an empty page, so that they mean the same beside other work.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from html import unescape
from pathlib import Path

PR_SET_CHILD_SUBREAPER = 36  # of Linux: what the browser leaves behind becomes a child of this process
EMPTY = "<!DOCTYPE html><title>empty</title>"
LISTEN = (
    "<script>const failed = []; addEventListener('error', (event) => failed.push(event.message));</script>"
)
CLICK = """<script>setTimeout(() => {
  const canvas = document.getElementById("canvas"), told = document.getElementById("picked");
  const box = canvas.getBoundingClientRect(), named = new Set();
  canvas.setPointerCapture = () => {};  // there is no pointer behind these events
  for (let k = 0; k < 100; k++) {
    const at = { clientX: box.left + (k % 10 + 0.5) / 10 * box.width, bubbles: true,
                 clientY: box.top + (Math.floor(k / 10) + 0.5) / 10 * box.height };
    for (const kind of ["pointerdown", "pointerup"]) canvas.dispatchEvent(new PointerEvent(kind, at));
    if (told.textContent !== "No stone there.") named.add(told.textContent.split("\\n")[0]);
  }
  for (const head of document.querySelectorAll("th[tabindex]")) head.click();
  const found = document.createElement("output");
  found.id = "clicked";
  found.textContent = JSON.stringify({ failed, named: [...named] });
  document.body.append(found);
}, 1000);</script>"""


@dataclass(frozen=True, slots=True)
class Clicked:
    """What came of it.

    Attributes
    ----------
    named : Names of stones that a click told. errors : Of scripts and on the browser's console.
    """

    named: tuple[str, ...]
    errors: tuple[str, ...]


def browser() -> str | None:
    """Chromium's command; None where there is none."""
    return shutil.which("chromium") or shutil.which("google-chrome")


def clicked(command: str, report: Path) -> Clicked:
    """Open a report, and click in it.

    Parameters
    ----------
    command : Of the browser. report : The file, which has a model.
    """
    text = report.read_text(encoding="utf-8")
    text = text.replace("<style>", f"{LISTEN}<style>", 1).replace("</body>", f"{CLICK}</body>", 1)
    page, log = opened(command, text)
    found = re.search(r'<output id="clicked">(.*?)</output>', page)
    said = json.loads(unescape(found[1])) if found else {"failed": ["nothing was clicked"], "named": []}
    errors = [*said["failed"], *(line for line in log.splitlines() if "CONSOLE" in line)]
    return Clicked(tuple(said["named"]), tuple(errors))


def opened(command: str, text: str) -> tuple[str, str]:
    """A page as it is after its scripts, and what the browser logged.

    Parameters
    ----------
    command : Of the browser. text : Of the page.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder) / "page.html"
        page.write_text(text, encoding="utf-8")
        done = subprocess.run(
            [command, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--dump-dom",
             "--enable-unsafe-swiftshader", "--enable-logging=stderr", "--virtual-time-budget=20000",
             f"--user-data-dir={folder}/profile", f"file://{page}"],
            capture_output=True, text=True, timeout=600, check=True, env=os.environ | {"HOME": folder},
        )  # fmt: skip
    return done.stdout, done.stderr


def seconds(act: Callable[[], object]) -> float:
    """CPU time of the processes that are started meanwhile, and of those that these leave behind."""

    def spent() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before = spent()
    act()
    with contextlib.suppress(ChildProcessError):
        while True:
            os.wait()
    return spent() - before


def main(folder: Path) -> None:
    """Print what came of it."""
    command, report = browser(), folder / "report.html"
    if command is None:
        sys.exit("needs chromium or google-chrome in PATH")
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    empty = min(seconds(lambda: opened(command, EMPTY)) for _ in range(2))
    shown = min(seconds(lambda: opened(command, report.read_text(encoding="utf-8"))) for _ in range(2))
    told = clicked(command, report)
    print(
        f"{report}: {report.stat().st_size / 1e6:.1f} MB, opened in {shown - empty:.1f} s of CPU, "
        f"100 clicks: {len(told.named)} stones named, {len(told.errors)} errors"
    )
    for error in told.errors:
        print(error)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
