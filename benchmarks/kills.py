"""Kills: runs that are ended at random moments, and what is found in their folders afterwards.

python -m benchmarks.kills                 # 50 runs: the table in docs/robustness.md
python -m benchmarks.kills --runs 5 --seed 3

Each folder holds the results of an older run, with other figures, and a file of a user's. A new run begins
there and is killed. Then every file must be readable, none of the older run's may pass for the new one's, the
user's must be as it was, and a third run, to the end, must find no lock and leave nothing half-written.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
ENDED = {signal.SIGKILL: (-9,), signal.SIGTERM: (143, -15), signal.SIGINT: (130, -2)}
NOTE = "notes of a user.txt"
LONG_AGO = 1e9  # when the older run wrote its files [s]
WALL = """
title = "{title}"
dimension = 2
fidelity = "{fidelity}"
mesh = {{ size = 0.25 }}
materials = {{ stone = {{ density = {density}, young = 1e9 }} }}
structures = [
    {{ kind = "wall", name = "w", material = "stone", brick = [0.5, 0.25], columns = 4, courses = 4 }},
]
joints = [{{ friction = 0.6 }}]
loads = {{ gravity = [1.0, -9.81] }}
"""
STEPS = """
analysis = { kind = "dynamics", step = 0.005, duration = 0.25 }
output = { pictures = false, interfaces = true }
"""
PICTURES = "output = { interfaces = true, determinacy = true }"
PLAIN = "output = { pictures = false }"
LAST = """
title = "new"
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2000 } }
structures = [{ kind = "stack", name = "s", material = "stone", size = [1.0, 1.0], count = 1 }]
loads = { gravity = [0.0, -9.81] }
output = { pictures = false }
"""
# what is run: fidelity, rest of the scene, command and options
KINDS = {
    "dynamics, a file a step": ("rigid", STEPS, ("run",)),
    "statics with pictures": ("rigid", PICTURES, ("run",)),
    "elastic, refined": ("elastic", PLAIN, ("run", "--refine-to", "12%")),
    "collapse": ("rigid", PLAIN, ("collapse", "--acceleration", "x")),
}


@dataclass(slots=True)
class Found:
    """What a killed run left."""

    kind: str
    number: signal.Signals
    code: int
    outcome: str
    part: int = 0
    unreadable: list[str] = field(default_factory=list)
    stale: list[str] = field(default_factory=list)
    other: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Prepared:
    """A kind of run, its scene, a small one, results of an older run, and how long the new one takes [s]."""

    kind: str
    command: tuple[str, ...]
    again: tuple[str, ...]
    scene: Path
    last: Path
    old: Path
    seconds: float


def prepare(kind: str, folder: Path) -> Prepared:
    """Make the older run's results, and see how long a run takes."""
    fidelity, more, command = KINDS[kind]
    scenes = []
    for title, density in (("old", 2000), ("new", 2400)):
        scenes.append(folder / f"{title}.toml")
        text = WALL.format(title=title, fidelity=fidelity, density=density) + more
        scenes[-1].write_text(text, encoding="utf-8")
    begun = time.monotonic()
    done = start(command, scenes[0], folder / "old")
    said = done.communicate()[1]
    if done.returncode not in (0, 3):
        raise RuntimeError(f"{kind}: the older run ended with {done.returncode}: {said}")
    for path in (folder / "old").rglob("*"):
        os.utime(path, (LONG_AGO, LONG_AGO))
    (folder / "old" / NOTE).write_text("mine", encoding="utf-8")
    (folder / "last.toml").write_text(LAST, encoding="utf-8")
    seconds = time.monotonic() - begun
    again = command if command[0] == "collapse" else command[:1]
    return Prepared(kind, command, again, scenes[1], folder / "last.toml", folder / "old", seconds)


def start(command: tuple[str, ...], scene: Path, out: Path) -> subprocess.Popen[str]:
    line = [sys.executable, "-m", "masonry_fem", command[0], str(scene), "--out", str(out)]
    return subprocess.Popen(
        [*line, *command[1:], "--quiet"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def outcome(made: Prepared, out: Path) -> tuple[str, str]:
    """Title and outcome that the summary of a folder tells."""
    summary = out / ("collapse.json" if made.command[0] == "collapse" else "summary.json")
    told = json.loads(summary.read_text(encoding="utf-8"))
    return told["title"], told["outcome"]


def kill_one(made: Prepared, number: signal.Signals, moment: float, taken: bool, folder: Path) -> Found:
    """Kill a run and look at what is there.

    ``moment`` is a share of the time that it takes, from its start or from when it has ``taken`` its folder.
    """
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(made.old, out)
    process = start(made.command, made.scene, out)
    try:
        while taken and process.poll() is None and outcome(made, out) != ("new", "running"):
            time.sleep(0.01)
        process.wait(moment * made.seconds)
    except subprocess.TimeoutExpired:
        process.send_signal(number)
    said = process.communicate(timeout=120)[1]
    found = look(made, number, out)
    found.code = process.returncode
    if process.returncode not in (*ENDED[number], 0, 3):
        found.other.append(f"exit code {process.returncode}: {said}")
    if "Traceback" in said and process.returncode not in ENDED[number][-1:]:
        found.other.append(said)
    again = start(made.again, made.last, out)
    said = again.communicate(timeout=300)[1]
    last = look(made, number, out)
    if again.returncode not in (0, 3) or last.part or last.unreadable or last.stale:
        found.other.append(f"the run after it: {again.returncode} {said} {last}")
    return found


def look(made: Prepared, number: signal.Signals, out: Path) -> Found:
    """Read every file of a folder, and find those of the older run that pass for new ones."""
    title, said = outcome(made, out)
    found = Found(made.kind, number, 0, said if title == "new" else "not begun")
    for path in sorted(out.rglob("*")):
        name = path.relative_to(out).as_posix()
        if not path.is_file() or name.startswith(".masonry-fem/"):
            continue
        if path.suffix == ".part":
            found.part += 1
            continue
        try:
            read(path)
        except Exception as error:
            found.unreadable.append(f"{name}: {type(error).__name__}: {error}")
        old = path.stat().st_mtime == LONG_AGO
        if name != NOTE and old != (title == "old") and said != "running":
            found.stale.append(name)
    if not (out / NOTE).exists() or (out / NOTE).read_text(encoding="utf-8") != "mine":
        found.other.append("the user's file is gone or changed")
    return found


def read(path: Path) -> None:
    """Read a file by what its name says it is."""
    if path.suffix == ".json":
        json.loads(path.read_text(encoding="utf-8"))
    elif path.suffix == ".toml":
        tomllib.loads(path.read_text(encoding="utf-8"))
    elif path.suffix == ".csv":
        text = path.read_text(encoding="utf-8")
        rows = list(csv.reader(text.splitlines()))
        if text and (not text.endswith("\n") or {len(row) for row in rows} != {len(rows[0])}):
            raise ValueError("a line is not whole")
    elif path.suffix == ".pvd":
        files = [path.parent / str(entry.get("file")) for entry in ET.parse(path).findall(".//DataSet")]
        missing = [str(file) for file in files if not file.exists()]
        if missing:
            raise ValueError(f"names {missing}")
    elif path.suffix == ".vtu":
        import meshio  # noqa: PLC0415
        import pyvista  # noqa: PLC0415

        if len(meshio.read(path).points) != pyvista.read(path).n_points:
            raise ValueError("two readers differ")
    elif path.suffix == ".png":
        from matplotlib.image import imread  # noqa: PLC0415

        imread(path)
    elif path.suffix == ".npz":
        with np.load(path) as arrays:
            _ = [arrays[name] for name in arrays.files]


def kills(runs: int, seed: int, kinds: tuple[str, ...] = tuple(KINDS), workers: int = 2) -> list[Found]:
    """Kill so many runs, kind after kind and signal after signal, at random moments."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # in a background job: inherited by runs
        signal.signal(signal.SIGINT, signal.default_int_handler)
    moments = np.random.default_rng(seed).uniform(0.0, 1.0, runs)
    with tempfile.TemporaryDirectory() as place:
        made = []
        for number, kind in enumerate(kinds):
            folder = Path(place) / str(number)
            folder.mkdir()
            made.append(prepare(kind, folder))

        def kill(number: int) -> Found:
            one, ended = made[number % len(made)], SIGNALS[number // len(made) % len(SIGNALS)]
            taken = number // 12 % 4 != 0  # a quarter at any time, the others while they write
            moment = float(moments[number]) * (0.5 if taken else 1.1)
            found = kill_one(one, ended, moment, taken, Path(place) / f"killed {number}")
            print(number, found, flush=True)
            return found

        with ThreadPoolExecutor(workers) as crew:
            return list(crew.map(kill, range(runs)))


def table(found: list[Found]) -> str:
    """The table in docs."""
    ends = ("not begun", "running", "interrupted")
    head = ("runs of", "killed", *ends, "done", "unreadable", "stale", "other")
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for kind in [*dict.fromkeys(one.kind for one in found), "all"]:
        rows = [one for one in found if kind in (one.kind, "all")]
        count = Counter(one.outcome for one in rows)
        early = [count.pop(name, 0) for name in ends]
        faults = [sum(len(getattr(one, name)) for one in rows) for name in ("unreadable", "stale", "other")]
        cells = [kind, len(rows), *early, count.total(), *faults]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--seed", type=int, default=15)
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells have their background jobs ignore it
    print(table(kills(options.runs, options.seed)))
