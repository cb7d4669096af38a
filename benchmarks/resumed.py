"""Resumed: runs that are killed at random moments and go on, until they are done, against runs that are not.

python -m benchmarks.resumed               # 50 kills: the table in docs/histories.md
python -m benchmarks.resumed --kills 5 --seed 3

Each run is killed by SIGKILL, which no program can answer, resumed, killed again and so on. What it leaves in
the end must be, byte for byte, what a run leaves that is not killed; only what it took may differ. Searches
(thresholds, studies of records) go on by the same command.
"""

from __future__ import annotations

import argparse
import csv
import json
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HEAD = """
dimension = 2
fidelity = "{fidelity}"
mesh = {{ size = 0.1 }}
materials = {{ stone = {{ density = 2400.0, {stone} }} }}
loads.gravity = [0.0, -9.81]
loads.accelerations = [{{ vector = [1.5, 0.0] }}]
structures = [
    {{ kind = "wall", name = "w", material = "stone", brick = [0.5, 0.25], columns = 5, courses = 6 }},
]
output = {{ pictures = false, interfaces = true, checkpoint_steps = 3 }}
"""
DRY = "joints = [{ friction = 0.5 }]\n"
GLUED = """
[[joints]]
friction = 0.5

[joints.law]
kind = "bilinear"
normal_stiffness = 1e11
tangential_stiffness = 1e11
normal_strength = 4e3
tangential_strength = 6e3
normal_energy = 2.0
tangential_energy = 5.0
"""
STATICS = 'analysis = { kind = "statics", load_steps = 40 }\n'
FEWER = STATICS.replace("40", "12")
DYNAMICS = 'analysis = { kind = "dynamics", step = 2e-3, duration = 0.16, theta = 0.7 }\n'
BRIEF = DYNAMICS.replace("0.16", "0.04")
REDETECT = 'contact = { update = "redetect", every = 2 }\n'
STORY = """
stages = [
  { name = "built", without = ["w.c5.*", "w.c6.*"], analysis = { kind = "statics", load_steps = 6 } },
  { name = "shaken" },
  { name = "softer", joints = [{ friction = 0.4 }] },
]
"""
CASES = """
combinations = [
  { name = "own", factors = { gravity = 1.35 } },
  { name = "push", factors = { gravity = 1.0, push = 1.1 } },
  { name = "back", factors = { gravity = 1.0, push = -1.1 } },
]
"""
PLAIN = "young = 1e9"
WARMING = PLAIN + ", thermal_expansion = 8e-6"
HEAT = """
stages = [
  { name = "built" },
  { name = "warm", loads = { gravity = [0.0, -9.81], temperatures = [{ on = "w.c3.*", change = 20.0 }] } },
  { name = "cold", loads = { gravity = [0.0, -9.81] } },
]
"""
YIELDING = PLAIN + ', inelastic = { law = "mohr_coulomb", friction_angle = 35, cohesion = 1.2e4 }'
WEAK = (
    "materials.stone = { density = 2400.0, young = 6e8, "
    'inelastic = { law = "mohr_coulomb", friction_angle = 30, cohesion = 9e3 } }'
)
DECAY = f"""
stages = [
  {{ name = "built", analysis = {{ kind = "statics", load_steps = 3 }} }},
  {{ name = "decayed", {WEAK}, analysis = {{ kind = "statics", load_steps = 9 }} }},
  {{ name = "shaken" }},
]
"""
BAR = """
[[ties]]
name = "bar"
points = [{ block = "w.c6.b1", point = [0.1, 1.4] }, { block = "w.c1.b5", point = [2.2, 0.1] }]
section = 1e-4
young = 2e11
pretension = 50.0
yield_stress = 2e7
"""
TOP = 'probes = [{ name = "top", block = "w.c6.b1", point = [0.2, 1.5] }]\n'
SHAKEN = 'loads.accelerograms = [{ x = "record.csv", acts = "ground" }]\n'
INERTIA = SHAKEN.replace("ground", "inertia")
TABLE = (0.0, 0.0), (0.03, 6.0), (0.07, -8.0), (0.12, 0.0)  # of the record


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of run.

    Attributes
    ----------
    fidelity : Of its stones. text : Of its scene, after ``HEAD``.
    command, options : Words before and after the scene's name, with ``{place}`` for its folder.
    stone : What else the stone has beside its density.
    """

    fidelity: str
    text: str
    command: str = "run"
    options: tuple[str, ...] = ()
    stone: str = PLAIN

    @property
    def resumes(self) -> bool:
        """Whether it goes on by ``resume``, and not by the same command."""
        return self.command == "run"


KINDS = {
    "rigid, dynamics, redetected": Kind("rigid", DYNAMICS + REDETECT + DRY),
    "rigid, statics": Kind("rigid", STATICS + DRY),
    "elastic, statics": Kind("elastic", STATICS + DRY),
    "elastic, dynamics": Kind("elastic", DYNAMICS + DRY),
    "inelastic, statics": Kind("inelastic", FEWER + DRY, stone=YIELDING),
    "inelastic, dynamics": Kind("inelastic", BRIEF + DRY, stone=YIELDING),
    "cohesive, statics": Kind("elastic", FEWER + GLUED),
    "cohesive, dynamics": Kind("rigid", DYNAMICS + GLUED),
    "tied, statics": Kind("elastic", STATICS + DRY + BAR),
    "shaken ground": Kind("rigid", DYNAMICS + DRY + SHAKEN),
    "stages": Kind("rigid", DYNAMICS + DRY + STORY),
    "stages, elastic, warmed": Kind("elastic", FEWER + DRY + HEAT, stone=WARMING),
    "stages, inelastic": Kind("inelastic", BRIEF + DRY + STORY, stone=YIELDING),
    "stages, redetected": Kind("rigid", BRIEF + REDETECT + DRY + STORY),
    "stages, mortar lost": Kind("elastic", FEWER + STORY + GLUED),
    "stages, decayed": Kind("inelastic", BRIEF + DRY + DECAY, stone=YIELDING),
    "combinations": Kind("elastic", FEWER + DRY + CASES),
    "threshold": Kind(
        "rigid", FEWER + DRY, "threshold",
        ("joints.0.friction", "--between", "0.05", "0.6", "--tolerance", "0.001", "--no-limit"),
    ),
    "records": Kind(
        "rigid", DYNAMICS + DRY + TOP + INERTIA, "study",
        ("--records", "{place}/record.csv", "--scales", "0.5:2:0.5", "--workers", "1"),
    ),
}  # fmt: skip
SPENT = ("seconds", "peak_memory_mb", "versions", "factorisations", "cpu", "start", "wall")
COLUMNS = ("seconds", "cpu [s]")  # of tables: what it took, too


@dataclass(slots=True)
class Found:
    """What came of a kind of run: kills, those before the first checkpoint, and files that differ."""

    kind: str
    kills: int = 0
    early: int = 0
    runs: int = 0
    other: tuple[str, ...] = ()


def start(*words: str) -> subprocess.Popen[bytes]:
    line = [sys.executable, "-m", "masonry_fem", *words, "--quiet"]
    return subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def left(folder: Path) -> dict[str, object]:
    """What stands in a folder, by the files' names."""
    files = [path for path in folder.rglob("*") if path.is_file() and ".masonry-fem" not in path.parts]
    return {
        path.relative_to(folder).as_posix(): _told(path)
        for path in files
        if path.name not in ("checkpoint.npz", "worker.log")
    }


def _told(path: Path) -> object:
    """What a file says, without what the run took."""
    if path.suffix == ".json":
        return _unspent(json.loads(path.read_text(encoding="utf-8")))
    if path.suffix == ".csv":
        rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        kept = [number for number, title in enumerate(rows[0] if rows else ()) if title not in COLUMNS]
        return [[row[number] for number in kept] for row in rows]
    return path.read_bytes()


def _unspent(told: object) -> object:
    """The same without the keys of ``SPENT``."""
    if isinstance(told, dict):
        return {key: _unspent(value) for key, value in told.items() if key not in SPENT}
    return [_unspent(value) for value in told] if isinstance(told, list) else told


def killed(kind: str, count: int, draw: np.random.Generator, place: Path) -> Found:
    """Kill runs of a kind so many times, and let each go on to its end."""
    own, scene = KINDS[kind], place / "scene.toml"
    options = [word.format(place=place) for word in own.options]
    head = HEAD.format(fidelity=own.fidelity, stone=own.stone)
    if CASES in own.text:
        head = head.replace("vector = [1.5, 0.0] ", 'vector = [1.5, 0.0], case = "push" ')
    scene.write_text(head + own.text, encoding="utf-8")
    np.savetxt(place / "record.csv", TABLE, delimiter=",")
    wanted, span = {}, 0.0
    for number in range(2):  # the first one may compile
        begun, out = time.monotonic(), place / f"whole {number}"
        if start(own.command, str(scene), *options, "--out", str(out)).wait() not in (0, 3):
            raise RuntimeError(f"{kind}: the run that is not killed failed")
        span, wanted = time.monotonic() - begun, left(out)
    found = Found(kind)
    while found.kills < count:
        out = place / f"killed {found.runs}"
        found.runs += 1
        first = own.command, str(scene), *options, "--out", str(out)
        words = first
        while True:
            process = start(*words)
            if found.kills < count:
                try:
                    process.wait(float(draw.uniform(0.2, 1.0)) * span)
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGKILL)
                    found.kills += 1
            if process.wait() != -signal.SIGKILL:
                break
            kept = any(out.rglob("checkpoint.npz" if own.resumes else "cells/*.json"))
            words = ("resume", str(out)) if own.resumes and kept else first
            found.early += not kept
        same = left(out)
        names = [name for name in wanted.keys() | same.keys() if wanted.get(name) != same.get(name)]
        found.other += tuple(sorted(names))
        print(found, flush=True)
    return found


def table(found: list[Found]) -> str:
    """The table in docs."""
    head = ("runs of", "kills", "before the first checkpoint", "runs", "files that differ")
    lines = [f"| {' | '.join(head)} |", "|" + "---|" * len(head)]
    for one in found:
        cells = (one.kind, one.kills, one.early, one.runs, len(one.other))
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def resumed(kills: int, seed: int, kinds: tuple[str, ...] = tuple(KINDS)) -> list[Found]:
    """So many kills, shared by the kinds."""
    draw, found = np.random.default_rng(seed), []
    for number, kind in enumerate(kinds):
        count = (kills + number) // len(kinds)
        with tempfile.TemporaryDirectory() as place:
            found.append(killed(kind, count, draw, Path(place)))
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=20)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=tuple(KINDS), metavar="KIND")
    options = parser.parse_args()
    print(table(resumed(options.kills, options.seed, tuple(options.kinds))))
