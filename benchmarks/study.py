"""Study: what large studies cost, and whether the true error of what they recommend is below what was asked.

python -m benchmarks.study                # the low wall (A10.4) and an arch of 21 voussoirs (A3.3), fresh
python -m benchmarks.study --truth        # and the errors against runs with quadratic elements, some minutes
python -m benchmarks.study --picture DIR  # and the pictures, study_wall.png and study_arch.png
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from masonry_fem.analyses.study import Study, study
from masonry_fem.analyses.study.comparison import distance
from masonry_fem.analyses.study.quantity import pick
from masonry_fem.analyses.study.recommendation import percent, recommend, settled
from masonry_fem.analyses.study.table import print_study

DEMOS = Path(__file__).resolve().parents[1] / "demos"
SETTINGS = ("solver.tolerance=1e-3,1e-6,1e-9", "fidelity=rigid,elastic")
ASKED = (0.05, 0.02, 0.01, 0.005)
BAR = 600.0  # wall-clock time of a study on two cores [s]


@dataclass(frozen=True, slots=True)
class Case:
    """A study: its scene, what is set, the meshes varied, and a mesh that tells the truth."""

    scene: str
    meshes: str
    truth: str
    overrides: tuple[str, ...] = ()


CASES = {
    "wall": Case(
        "low_wall.toml",
        "mesh.divisions=[2,1,1],[4,2,2],[6,3,3],[8,4,4],[12,6,6]",
        "mesh.divisions=[8,4,4]",
    ),
    "arch": Case(
        "arch.toml",
        "mesh.divisions=[1,1,2],[2,1,4],[4,2,8],[8,4,16]",
        "mesh.divisions=[8,4,16]",
        ("structures.arch.voussoirs=21", 'probes.crown.block="arch.v11"'),
    ),
}


def measured(case: Case, folder: Path) -> tuple[Study, float, float]:
    """A study, its wall-clock time and the CPU time of all its processes [s]."""
    before, start = _used(), time.monotonic()
    vary = [case.meshes, *SETTINGS]
    made = study(DEMOS / case.scene, vary, overrides=case.overrides, out=folder, fresh=True)
    return made, time.monotonic() - start, _used() - before


def truths(case: Case, made: Study, folder: Path) -> Table:
    """What is recommended, its bound and its true error."""
    overrides = [*case.overrides, "mesh.element=Q2"]
    (exact,) = study(DEMOS / case.scene, [case.truth], overrides=overrides, out=folder).rows
    table = Table("quantity", "asked", "recommended", "times cheaper", "bound", "true error")
    for aim in made.targets:
        for asked in ASKED:
            advice = recommend(aim, made.comparisons, made.vary, asked)
            if advice.settings is None or advice.bound is None:
                continue
            row = next(row for row in made.rows if row.cell.settings == advice.settings)
            off = max(distance(pick(row.quantities, name), exact.quantities[name]) for name in aim.names)
            times = "" if advice.cheaper is None else f"{advice.cheaper:.3g}"
            verdict = percent(off) if off <= asked else f"[red]{percent(off)}[/red]"
            table.add_row(
                aim.label, percent(asked), settled(advice.settings), times, percent(advice.bound), verdict
            )
    return table


def _used() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--truth", action="store_true", help="compare with quadratic elements")
    parser.add_argument("--picture", type=Path, help="folder for the pictures")
    parser.add_argument("--cases", default=",".join(CASES), help="wall, arch or both")
    given = parser.parse_args()
    console = Console(width=160)
    with tempfile.TemporaryDirectory() as scratch:
        for name in given.cases.split(","):
            folder = Path(scratch) / name
            made, wall, cpu = measured(CASES[name], folder)
            print_study(made, console)
            verdict = "met" if wall < BAR else "missed"
            console.print(
                f"{name}: {len(made.rows)} cells in {wall:.0f} s, {cpu:.0f} s of CPU; "
                f"bar {BAR:.0f} s on two cores: {verdict}"
            )
            if given.truth:
                console.print(truths(CASES[name], made, Path(scratch) / "truth"))
            if given.picture:
                *_, picture = made.write(folder)
                picture.replace(given.picture / f"study_{name}.png")


if __name__ == "__main__":
    main()
