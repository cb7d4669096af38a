"""Crossing: what 21 places of a load that moves cost beside one.

python -m benchmarks.crossing                  # all scenes: CPU time of runs and of their steps
python -m benchmarks.crossing one NAME PLACES  # one run, as JSON
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.process import Row, alone
from masonry_fem import load, run
from masonry_fem.scene import specs

BRIDGE = Path(__file__).resolve().parents[1] / "demos" / "crossed_bridge.toml"
PLACES = 21
REPEATS = 3
STEPPING = ("factorise", "solve", "step", "detect", "measure")
FILES = ("output.pictures=false", "output.fields=false", "output.interfaces=false")
LAW = "{law='mohr_coulomb', friction_angle=37, cohesion=1e4}"
ALONE = (
    "structures.bridge.filled=false",
    "overrides=[]",
    "supports=[]",
    "loads.moving.0.on='bridge.v*/extrados'",
    "loads.moving.0.vector=[0.0, -10e3]",
)
FINE = ("mesh={element='Q2', divisions=[4, 6]}", "overrides.0.mesh={element='Q2', divisions=[2, 6]}")
SCENES: dict[str, tuple[str, ...]] = {
    "elastic stones and fill": (),
    "the same, 8 times the nodes": FINE,
    "elastic stones, fill that yields": (
        f"materials.soil.inelastic={LAW}",
        "overrides.0.fidelity='inelastic'",
    ),
    "elastic stones alone": ALONE,
    "rigid stones alone": (*ALONE, "fidelity='rigid'"),
}


def one(name: str, places: int) -> Row:
    """A run with as many places, in the middle of the bridge where it is only one."""
    made: specs.Scene = load(BRIDGE, overrides=[*FILES, *SCENES[name], f"analysis.places={max(places, 2)}"])
    if places == 1:
        keys = ["analysis={kind='statics'}", "loads.moving.0.begin=9.0"]
        made = load(BRIDGE, overrides=[*FILES, *SCENES[name], *keys])
    with tempfile.TemporaryDirectory() as folder:
        result = run(made, folder)
    told = result.summary
    steps = sum(told.seconds.get(phase, 0.0) for phase in STEPPING)
    return {"outcome": told.outcome, "steps": told.steps, "seconds": time.process_time(), "stepping": steps}


def main() -> None:
    """Run each scene with both in turns, and print the least times."""
    table = Table("scene", "places", "outcome", "CPU s", "of one", "steps s", "of one")
    for name in SCENES:
        found: dict[int, list[Row]] = {1: [], PLACES: []}
        for _ in range(REPEATS):
            for places, rows in found.items():
                rows.append(alone(600.0, "benchmarks.crossing", "one", name, str(places)))
        least = {
            places: [min(row[key] for row in rows) for key in ("seconds", "stepping")]
            for places, rows in found.items()
        }
        for places, rows in found.items():
            cells = [f"{value:.2f}" for value in least[places]]
            shares = [f"{a / b:.2f}" for a, b in zip(least[places], least[1], strict=True)]
            table.add_row(name, str(places), rows[0]["outcome"], cells[0], shares[0], cells[1], shares[1])
    Console(width=110).print(table)


if __name__ == "__main__":
    if sys.argv[1:2] == ["one"]:
        print(json.dumps(one(sys.argv[2], int(sys.argv[3]))))
    else:
        main()
