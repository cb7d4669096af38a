"""Economy: what a run costs before its first step, and what elastic stones cost beside rigid ones.

python -m benchmarks.economy              # all tables
python -m benchmarks.economy start        # CPU time of a whole rigid run of one step
python -m benchmarks.economy fidelity     # a step of the 20 × 20 wall, rigid and elastic, same contacts
python -m benchmarks.economy reduced      # elastic and reduced stones as they are by default, mean stresses
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.cases import StepTimes, scene
from benchmarks.process import Row, alone
from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    Analysis,
    Dynamics,
    Fidelity,
    Joint,
    Material,
    MeshSettings,
    Scene,
    Statics,
)
from masonry_fem.structures.wall import WallStructure

ANALYSES: dict[str, Analysis] = {
    "statics, one step": Statics(),
    "dynamics, 20 steps of 1 ms": Dynamics(step=1e-3, duration=2e-2, theta=1.0),
}
COMPARED: dict[str, Analysis] = {
    "statics, one step": Statics(),
    "dynamics, 6 steps of 10 ms": Dynamics(step=1e-2, duration=6e-2, theta=1.0),
    "dynamics, 6 steps of 1 ms": Dynamics(step=1e-3, duration=6e-3, theta=1.0),
}
# Fidelity, degree and elements of a brick: uniform strains need no finer mesh than one element.
STONES = (
    ("elastic", "1", "4x2x2"),
    ("reduced", "1", "4x2x2"),
    ("reduced", "1", "1x1x1"),
    ("reduced", "2", "4x2x2"),
)
FIDELITIES: tuple[Fidelity, ...] = ("rigid", "elastic")
STEPPING = ("factorise", "solve", "step", "measure")
SHOWN = 0.02  # of the total: phases that take less are not told
REPEATS = 9
START = """
fidelity = "rigid"
[materials.stone]
density = 2400.0
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.5, 0.25, 0.25]
columns = 4
courses = 5
[loads]
gravity = [0.0, 0.0, -9.81]
[output]
fields = false
pictures = false
"""


def wall(fidelity: Fidelity, analysis: Analysis, size: int = 20) -> Scene:
    """Running bond on the ground, contact at the corners of the joints for stones of either kind."""
    return scene(
        WallStructure(name="wall", material="stone", brick=(0.5, 0.25, 0.25), columns=size, courses=size),
        fidelity=fidelity,
        mesh=MeshSettings(divisions=(4, 2, 2)),
        joints=(Joint(friction=0.6, placement="corners"),),
        analysis=analysis,
    )


def stepped(fidelity: Fidelity, analysis: str) -> Row:
    """Cost of the wall's steps; all in this process."""
    summary = solve_scene(wall(fidelity, ANALYSES[analysis])).summary
    return {
        "contacts": summary.contacts,
        "unknowns": summary.unknowns,
        "outcome": summary.outcome,
        "error": summary.certificate.natural_map,
        "step": sum(summary.seconds.get(phase, 0.0) for phase in STEPPING) / summary.steps,
        "seconds": summary.seconds,
    }


def reduced(fidelity: Fidelity, degree: str, elements: str, analysis: str) -> Row:
    """Cost of a step of the wall, after the first, and its mean stresses."""
    stone = Material(density=2400.0, young=10e9, poisson=0.2, degree=int(degree))
    times = StepTimes()
    given = scene(
        WallStructure(name="wall", material="stone", brick=(0.5, 0.25, 0.25), columns=20, courses=20),
        fidelity=fidelity,
        materials={"stone": stone},
        mesh=MeshSettings(divisions=tuple(map(int, elements.split("x")))),
        analysis=COMPARED[analysis],
    )
    made = solve_scene(given, observers=(times,))
    later = times[1:] or list(times)
    return {
        "contacts": made.summary.contacts,
        "unknowns": made.summary.unknowns,
        "outcome": made.outcome,
        "error": made.summary.certificate.natural_map,
        "step": sum(later) / len(later),
        "means": mean_stresses(made).tolist(),
    }


def mean_stresses(made: RunResult) -> np.ndarray:
    """Of all blocks that deform, the shears times √2 so that norms are those of tensors, (blocks, 6) [Pa]."""
    told = []
    for group, state in zip(made.built.model.groups, made.march.state.bodies, strict=True):
        field = None if group.prescribed else group.stress(state)
        if field is not None:
            share = field.weight / field.weight.sum()
            told.append(np.einsum("bmpi,mp->bi", field.gauss, share) * [1, 1, 1, *(3 * [2**0.5])])
    return np.concatenate(told)


def started() -> list[float]:
    """CPU times of whole processes that run one step of a small rigid wall, caches warm [s]."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # compiled modules are part of a warm start
    spent = []
    with tempfile.TemporaryDirectory() as folder:
        environment["PYTHONPYCACHEPREFIX"] = str(Path(folder) / "compiled")
        (Path(folder) / "wall.toml").write_text(START)
        command = [sys.executable, "-m", "masonry_fem", "run", "wall.toml", "--quiet"]
        for _ in range(REPEATS + 1):
            before = os.times()
            subprocess.run(command, check=True, cwd=folder, env=environment)
            after = os.times()
            spent.append(sum(after[2:4]) - sum(before[2:4]))
    return sorted(spent[1:])  # the first one warms the caches


def start_table() -> Table:
    """CPU time from the start of the process to the end of a run of one step."""
    spent = started()
    table = Table("rigid wall of 22 bricks, one step", r"CPU \[s]", "bar")
    table.add_row(f"least of {REPEATS} processes", f"{spent[0]:.2f}", "< 1.5")
    table.add_row("median", f"{spent[REPEATS // 2]:.2f}", "")
    return table


def fidelity_table(limit: float) -> Table:
    """What a step takes and where it goes, rigid beside elastic."""
    table = Table(
        "20 × 20 wall", "stones", "contacts", "unknowns", "error", "ms a step", "ratio", r"whole run \[s]"
    )
    for analysis in ANALYSES:
        rows = {f: alone(limit, "benchmarks.economy", "--here", f, analysis) for f in FIDELITIES}
        for fidelity, row in rows.items():
            if "step" not in row:
                table.add_row(analysis, fidelity, "", "", row["outcome"], "", "", "")
                continue
            total = sum(row["seconds"].values())
            parts = {name: value for name, value in row["seconds"].items() if value > SHOWN * total}
            told = ", ".join(f"{name} {value:.2f}" for name, value in parts.items())
            ratio = row["step"] / rows["rigid"]["step"] if "step" in rows["rigid"] else float("nan")
            table.add_row(
                analysis, fidelity, f"{row['contacts']}", f"{row['unknowns']}", f"{row['error']:.0e}",
                f"{1e3 * row['step']:.0f}", f"{ratio:.0f}", f"{total:.1f}: {told}",
            )  # fmt: skip
    return table


def reduced_table(limit: float) -> Table:
    """Elastic stones and reduced ones of degrees 1 and 2: what a step takes, and how far stresses differ."""
    table = Table("20 × 20 wall", "stones", "contacts", "unknowns", "error", "ms a step", "ratio", "stresses")
    for analysis in COMPARED:
        first: Row | None = None
        for fidelity, degree, elements in STONES:
            row = alone(limit, "benchmarks.economy", "--reduced", fidelity, degree, elements, analysis)
            name = f"{fidelity}{'' if fidelity == 'elastic' else f', degree {degree}'}, {elements}"
            if "step" not in row:
                table.add_row(analysis, name, "", "", "", row["outcome"], "", "")
                continue
            first = row if first is None else first
            exact = np.array(first["means"])
            apart = np.linalg.norm(np.array(row["means"]) - exact) / np.linalg.norm(exact)
            table.add_row(
                analysis, name, f"{row['contacts']}", f"{row['unknowns']}", f"{row['error']:.0e}",
                f"{1e3 * row['step']:.0f}",
                f"{first['step'] / row['step']:.1f}", f"{100 * apart:.1f} %",
            )  # fmt: skip
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description="What start-up and elastic stones cost.")
    parser.add_argument(
        "tables", nargs="*", choices=["start", "fidelity", "reduced", []], help="all where none is given"
    )
    parser.add_argument("--here", nargs=2, metavar=("FIDELITY", "ANALYSIS"), help="one case, as JSON")
    parser.add_argument(
        "--reduced", nargs=4, metavar=("FIDELITY", "DEGREE", "ELEMENTS", "ANALYSIS"), help="one, as JSON"
    )
    parser.add_argument("--limit", type=float, default=900.0, help="wall-clock limit of a case [s]")
    given = parser.parse_args()
    if given.here:
        print(json.dumps(stepped(*given.here)))
        return
    if given.reduced:
        print(json.dumps(reduced(*given.reduced)))
        return
    console = Console(width=None if sys.stdout.isatty() else 160)
    if not given.tables or "start" in given.tables:
        console.print(start_table())
    if not given.tables or "fidelity" in given.tables:
        console.print(fidelity_table(given.limit))
    if not given.tables or "reduced" in given.tables:
        console.print(reduced_table(given.limit))


if __name__ == "__main__":
    main()
