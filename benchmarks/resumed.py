"""Resumed: runs that are killed at random moments and go on, until they are done, against runs that are not.

python -m benchmarks.resumed               # 50 kills: the table in docs/histories.md
python -m benchmarks.resumed --kills 5 --seed 3

Each run is killed by SIGKILL, which no program can answer, resumed, killed again and so on. What it leaves in
the end must be, byte for byte, what a run leaves that is not killed; only what it took may differ.
"""

from __future__ import annotations

import argparse
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
materials = {{ stone = {{ density = 2400.0, young = 1e9 }} }}
loads = {{ gravity = [0.0, -9.81], accelerations = [{{ vector = [1.5, 0.0] }}] }}
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
REDETECT = 'contact = { update = "redetect", every = 2 }\n'
KINDS = {
    "rigid, dynamics, redetected": ("rigid", DYNAMICS + REDETECT, DRY),
    "elastic, statics": ("elastic", STATICS, DRY),
    "elastic, dynamics": ("elastic", DYNAMICS, DRY),
    "cohesive, statics": ("elastic", FEWER, GLUED),
}
SPENT = ("seconds", "peak_memory_mb", "versions", "factorisations")


@dataclass(slots=True)
class Found:
    """What came of a kind of run: kills, those before the first checkpoint, and files that differ."""

    kind: str
    kills: int = 0
    early: int = 0
    runs: int = 0
    other: tuple[str, ...] = ()


def start(*words: str) -> subprocess.Popen[bytes]:
    line = [sys.executable, "-m", "masonry_fem.cli", *words, "--quiet"]
    return subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def left(folder: Path) -> dict[str, object]:
    """What stands in a folder, by the files' names."""
    files = [path for path in folder.rglob("*") if path.is_file() and ".masonry-fem" not in path.parts]
    found: dict[str, object] = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in files
        if path.name not in ("summary.json", "checkpoint.npz")
    }
    told = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return found | {"summary.json": {key: value for key, value in told.items() if key not in SPENT}}


def killed(kind: str, count: int, draw: np.random.Generator, place: Path) -> Found:
    """Kill runs of a kind so many times, and let each go on to its end."""
    fidelity, steps, joints = KINDS[kind]
    scene, whole = place / "scene.toml", place / "whole"
    scene.write_text(HEAD.format(fidelity=fidelity) + steps + joints, encoding="utf-8")
    for _ in range(2):  # the first one may compile
        begun = time.monotonic()
        if start("run", str(scene), "--out", str(whole)).wait() not in (0, 3):
            raise RuntimeError(f"{kind}: the run that is not killed failed")
    span, wanted, found = time.monotonic() - begun, left(whole), Found(kind)
    while found.kills < count:
        out = place / f"killed {found.runs}"
        found.runs += 1
        words = ("run", str(scene), "--out", str(out))
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
            if (out / "checkpoint.npz").exists():
                words = ("resume", str(out))
            else:
                found.early += 1
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
    options = parser.parse_args()
    print(table(resumed(options.kills, options.seed)))
