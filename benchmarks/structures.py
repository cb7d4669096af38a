"""Structures: the gallery's large ones brought to rest, with their certificate, CPU time and memory.

python -m benchmarks.structures              # all of them, each in a process of its own
python -m benchmarks.structures "tower"      # some of them, by their beginnings
python -m benchmarks.structures --markdown   # the table of docs/gallery.md on the screen
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.cases import scene
from benchmarks.process import Row, alone
from masonry_fem.analyses.run import solve_scene
from masonry_fem.results.summarise import peak_memory
from masonry_fem.scene import check, load
from masonry_fem.scene.specs import MeshSettings, Opening, Scene, Statics
from masonry_fem.structures.wall import WallStructure

HERE = Path(__file__).resolve().parent
DEMOS = HERE.parent / "demos"
COLUMNS = ("structure", "stones", "contacts", "unknowns", "outcome", "error", "balance", "CPU [s]", "peak MB")
SHOWN = 0.05  # phases of less CPU time are not told [s]


def demo(name: str, *changes: str) -> Callable[[], Scene]:
    """The scene of a demo, changed."""
    return lambda: load(DEMOS / f"{name}.toml", overrides=changes)


def facade(divisions: tuple[int, int, int]) -> Scene:
    """Façade of 16 × 8.1 m in courses of 0.45 m: two doors and four windows with lintels."""
    doors = tuple(Opening(position=(at, 0.0), size=(1.5, 2.7)) for at in (3.0, 11.5))
    windows = tuple(Opening(position=(at, 4.5), size=(1.5, 1.8)) for at in (2.0, 5.5, 9.0, 12.5))
    wall = WallStructure(
        name="facade",
        material="stone",
        brick=(0.8, 0.4, 0.45),
        columns=20,
        courses=18,
        openings=(*doors, *windows),
    )
    return scene(wall, mesh=MeshSettings(divisions=divisions), analysis=Statics())


CASES: dict[str, Callable[[], Scene]] = {
    "dome, 2 × 2 × 2 elements": demo("dome_section"),
    "dome, staggered, 2 × 1 × 1": demo(
        "dome_section", "structures.dome.staggered=true", "mesh.divisions=[2, 1, 1]"
    ),
    "dome, staggered, 2 × 2 × 2": demo("dome_section", "structures.dome.staggered=true"),
    "dome on piers, brittle": demo("dome_on_piers"),
    "surveyed window bay": demo("window_bay"),
    "façade, 2 × 1 × 1": lambda: facade((2, 1, 1)),
    "façade, 4 × 2 × 2": lambda: facade((4, 2, 2)),
    "tower, 2 × 1 × 1": demo("tower"),
    "tower, 2 × 2 × 2": demo("tower", "mesh.divisions=[2, 2, 2]"),
    "portal and flyers": demo("flying_buttresses"),
    "rubble, rigid": demo("rubble_wall"),
}


def solved(case: str) -> Row:
    """Bring a structure to rest; all in this process."""
    made = CASES[case]()
    result = solve_scene(check(made, base=DEMOS), DEMOS)
    summary = result.summary
    return {
        "stones": summary.blocks - len(summary.supports),
        "contacts": summary.contacts,
        "unknowns": summary.unknowns,
        "outcome": result.outcome,
        "error": summary.certificate.natural_map,
        "balance": summary.certificate.global_balance,
        "seconds": summary.seconds,
        "memory_mb": peak_memory(),
    }


def measured(case: str, limit: float) -> Row:
    """The same in a process of its own."""
    return alone(limit, "benchmarks.structures", "--here", case)


def cells(case: str, row: Row) -> tuple[str, ...]:
    """A line of the table."""
    if "seconds" not in row:
        return (case, "", "", "", row["outcome"], "", "", "", "")
    phases = {name: value for name, value in row["seconds"].items() if value >= SHOWN and name != "import"}
    told = ", ".join(f"{name} {value:.1f}" for name, value in phases.items())
    numbers = (f"{row[key]:,}".replace(",", " ") for key in ("stones", "contacts", "unknowns"))
    errors = (f"{row[key]:.0e}" for key in ("error", "balance"))
    total = sum(row["seconds"].values())
    return (case, *numbers, row["outcome"], *errors, f"{total:.1f}: {told}", f"{row['memory_mb']:.0f}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Bring the gallery's large structures to rest.")
    parser.add_argument("cases", nargs="*", help="beginnings of their names; all where none is given")
    parser.add_argument("--here", metavar="CASE", help="one case in this process, as JSON")
    parser.add_argument("--markdown", action="store_true", help="the table as Markdown")
    parser.add_argument("--limit", type=float, default=900.0, help="wall-clock limit of a case [s]")
    given = parser.parse_args()
    if given.here:
        print(json.dumps(solved(given.here)))
        return
    chosen = [case for case in CASES if not given.cases or case.startswith(tuple(given.cases))]
    rows = [cells(case, measured(case, given.limit)) for case in chosen]
    if given.markdown:
        for line in (COLUMNS, ("---",) * len(COLUMNS), *rows):
            print("| " + " | ".join(line) + " |")
        return
    table = Table(*COLUMNS)
    for row in rows:
        table.add_row(*row)
    Console(width=None if sys.stdout.isatty() else 170).print(table)


if __name__ == "__main__":
    main()
