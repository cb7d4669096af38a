"""Paired: the same scenes with two checkouts of the program, in turns, and what each costs.

    python -m benchmarks.paired OLD NEW [--pairs 6] [--only "dome, rigid"]    # two folders

Each run is a process of its own with one thread. What other processes take from a machine meets both
checkouts alike: ratios hold where times do not. The first pair fills both caches of compiled code, Python's
bytecode included, and is left out.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

WALL = """
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.4, 0.2, 0.2]
columns = {columns}
courses = {courses}
"""
DOME = """
[[structures]]
kind = "dome"
name = "dome"
material = "stone"
radius = 5.0
thickness = 0.5
rings = 14
slices = 28
"""
ARCH = """
[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 1.0
thickness = 0.2
depth = 0.3
voussoirs = 11
"""
SCENE = """
dimension = 3
fidelity = "{fidelity}"
mesh = {{ element = "Q1", divisions = {divisions} }}
materials = {{ stone = {{ young = 10e9, poisson = 0.2, density = 2400 }} }}
loads = {{ gravity = [{push}, 0.0, -9.81] }}
analysis = {{ {analysis} }}
solver = {{ {solver} }}
output = {{ pictures = false, fields = false }}
{structure}
[[joints]]
friction = {friction}
{law}
"""
MORTAR = """
[joints.law]
kind = "monerie_acary"
normal_stiffness = 1e12
tangential_stiffness = 4e11
normal_strength = 2e5
tangential_strength = 3e5
normal_energy = 18.0
tangential_energy = 125.0
"""
STATICS = 'kind = "statics"'


def wall(columns: int, courses: int, **others: Any) -> str:
    """A wall in running bond, by default pushed by 0.1 g and rigid."""
    return scene(WALL.format(columns=columns, courses=courses), **{"push": 0.981, **others})


def scene(structure: str, **others: Any) -> str:
    """A structure under gravity, as TOML."""
    usual = {"fidelity": "rigid", "divisions": [1, 1, 1], "push": 0.0, "analysis": STATICS, "solver": "",
             "friction": 0.6, "law": ""}  # fmt: skip
    return SCENE.format(structure=structure, **{**usual, **others})


def steps(step: float, duration: float) -> str:
    """Dynamics."""
    return f'kind = "dynamics", step = {step}, duration = {duration}'


SLIDES = {"push": 2.943, "friction": 0.2}
CASES = {
    "rigid wall 20×10, statics": wall(20, 10),
    "rigid wall 40×20, statics": wall(40, 20),
    "rigid wall 20×10 that slides, 5 steps": wall(20, 10, analysis=steps(0.01, 0.05), **SLIDES),
    "rigid wall 40×20 that slides, 2 steps": wall(40, 20, analysis=steps(0.01, 0.02), **SLIDES),
    "the same, tolerance 1e-8": wall(40, 20, analysis=steps(0.01, 0.02), solver="tolerance = 1e-8", **SLIDES),
    "rigid wall 10×10, 100 steps at rest": wall(10, 10, push=0.0, analysis=steps(0.01, 1.0)),
    "elastic arch of 11 voussoirs, statics": scene(ARCH, fidelity="elastic", divisions=[8, 4, 4]),
    "elastic wall 10×10, statics": wall(10, 10, fidelity="elastic", divisions=[4, 2, 2]),
    "dome, rigid, statics": scene(DOME, friction=0.7),
    "dome, elastic, statics": scene(DOME, friction=0.7, fidelity="elastic"),
    "mortar wall 20×16, 6 load steps": wall(20, 16, law=MORTAR, analysis='kind = "statics", load_steps = 6'),
    "wall 120×80, blocks and contacts found (check)": wall(120, 80),
}

START = "import sys; from masonry_fem.cli import main; sys.exit(main())"  # -m is younger than some checkouts


def run(
    checkout: Path, arguments: Sequence[str], folder: Path, limit: float | None = None
) -> tuple[subprocess.CompletedProcess[bytes], float]:
    """What the program of a checkout makes of a command line, with one thread, and its CPU time [s].

    Parameters
    ----------
    checkout : Its folder. arguments : Of ``masonry-fem``.
    folder : Where it runs.
    limit : Wall-clock time after which it is given up, with ``subprocess.TimeoutExpired`` [s].
    """
    alone = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    # without bytecode every run would compile the program's own sources anew, which no user pays for
    alone |= {"PYTHONPATH": str(checkout), "PYTHONDONTWRITEBYTECODE": ""}
    before = os.times()
    done = subprocess.run(
        [sys.executable, "-c", START, *arguments],
        cwd=folder, env=os.environ | alone, check=False, capture_output=True, timeout=limit,
    )  # fmt: skip
    after = os.times()
    return done, after.children_user + after.children_system - before.children_user - before.children_system


def cost(checkout: Path, text: str, folder: Path, *, check: bool) -> tuple[float, float]:
    """CPU time of a run, and of the solutions in it [s]."""
    scene, out = folder / "scene.toml", folder / "out"
    scene.write_text(text, encoding="utf-8")
    command = ["check", str(scene), "--yes"] if check else ["run", str(scene), "--out", str(out), "--quiet"]
    done, taken = run(checkout, command, folder)
    done.check_returncode()
    if check:
        return taken, 0.0
    return taken, float(json.loads((out / "summary.json").read_text(encoding="utf-8"))["seconds"]["solve"])


def main() -> None:
    parser = argparse.ArgumentParser(description="Compare what scenes cost with two checkouts.")
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--pairs", type=int, default=6)
    parser.add_argument("--only", action="append", help="a case; may be repeated")
    given = parser.parse_args()
    print(
        "| case | before | after | ratio | solutions before | after | ratio |\n|---|---|---|---|---|---|---|"
    )
    for case in given.only or CASES:
        taken: dict[Path, list[tuple[float, float]]] = {given.old: [], given.new: []}
        for pair in range(given.pairs + 1):
            for checkout in (given.old, given.new)[:: 1 if pair % 2 else -1]:
                with tempfile.TemporaryDirectory() as folder:
                    one = cost(checkout.resolve(), CASES[case], Path(folder), check="(check)" in case)
                taken[checkout] += [one] if pair else []
        cells = [case]
        for kind in (0, 1):
            before, after = (median(one[kind] for one in taken[path]) for path in (given.old, given.new))
            cells += [f"{before:.2f} s", f"{after:.2f} s", f"{after / before:.2f}"] if before else [""] * 3
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
