"""Table: every case in a process of its own, its cost beside the bar it has to meet.

python -m benchmarks.table            # all cases, and benchmarks/RESULTS.md
python -m benchmarks.table --quick    # those that take seconds
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.process import Row, alone
from masonry_fem.results.summarise import versions

HERE = Path(__file__).resolve().parent
COLUMNS = ("case", "contacts", "solves", "error", "CPU", "peak MB", "limit", "verdict")
START_RUNS = 5


@dataclass(frozen=True, slots=True)
class Bar:
    """What a case must reach: its words, and a test of what was measured."""

    text: str
    met: Callable[[Row], bool] = lambda row: True


def solve_below(limit: float) -> Callable[[Row], bool]:
    return lambda row: row["outcome"] == "equilibrium" and row["seconds"]["solve"] < limit


def fallen_below(limit: float, height: float) -> Callable[[Row], bool]:
    return lambda row: (
        row["outcome"] == "finished" and row["fallen"] > height and sum(row["seconds"].values()) < limit
    )


def step_below(limit: float) -> Callable[[Row], bool]:
    return lambda row: row["step_ms"]["median"] <= limit


def built_below(seconds: float, memory: float) -> Callable[[Row], bool]:
    return lambda row: (
        row["seconds"]["assemble"] + row["seconds"]["factorise"] < seconds and row["memory_mb"] < memory
    )


def solved_within(seconds: float, memory: float) -> Callable[[Row], bool]:
    return lambda row: (
        row["outcome"] in {"equilibrium", "finished"}
        and sum(row["seconds"].values()) < seconds
        and row["memory_mb"] < memory
    )


def times_at_most(limit: float) -> Callable[[Row], bool]:
    return lambda row: row["outcome"] in {"equilibrium", "finished"} and row["ratio"] <= limit


def peer(median: float, reaction: str) -> Bar:
    return Bar(f"LMGC90: median {median} ms a step, reactions to {reaction}", step_below(median))


QUICK = {
    "import": Bar("< 0.3 s", lambda row: row["total"] < 0.3),
    "--help": Bar("< 0.3 s", lambda row: row["total"] < 0.3),
    "low wall 4x2x2": Bar("CalculiX .55 s; ≤ 12 solves", lambda row: row["solves"] <= 12),
    "low wall 8x4x4": Bar("solve < 2 s", solve_below(2.0)),
    "rigid arch 31": peer(0.84, "8e-4"),
    "rigid wall 10x10": peer(19, "6e-5"),
    "elastic wall 5x5, statics": Bar("-"),
    "elastic wall 40x40, built": Bar("assemble + factorise < 2 s, < 2 GB", built_below(2.0, 2048)),
}
BARS = QUICK | {
    "rigid wall 20x20": peer(92, "2e-3"),
    "rigid wall 32x32": peer(349, "3e-3"),
    "elastic arch 11, 8x8x8": Bar("solve < 4 s", solve_below(4.0)),
    "elastic arch 21, its fall": Bar("on the ground in < 60 s", fallen_below(60.0, 1.1)),
    "elastic wall 10x10, statics": Bar("prototype 10 s", solve_below(10.0)),
    "elastic wall 20x20, one step": Bar("-"),
    "elastic wall 20x20, to 1e-8": Bar("< 5 s", solved_within(5.0, 8192)),
    "elastic wall 40x40, to 1e-8": Bar("< 25 s", solved_within(25.0, 8192)),
    "elastic wall 40x40 of 8x4x4, to 1e-8": Bar("< 120 s", solved_within(120.0, 8192)),
    "elastic wall 20x20, .2 g, to 1e-8": Bar("-"),
    "elastic wall 40x40, .2 g, to 1e-8": Bar("< 200 s", solved_within(200.0, 8192)),
    "elastic wall 10x10, 20 steps": Bar("≤ 80 ms a step", step_below(80.0)),
    "elastic wall 20x20, 20 steps": Bar("-"),
    "elastic wall 12x12 that rebounds": Bar("-"),
    "elastic wall 16x16 that rebounds": Bar("-"),
    "elastic wall 20x20 of 4x2x2 that rebounds": Bar("-"),
    "one brick in ten yields, statics": Bar("≤ 2 elastic walls", times_at_most(2.0)),
    "bricks that turn, statics": Bar("≤ 1.3 of small rotations", times_at_most(1.3)),
    "weighted wall 58x58, placed": Bar("10 000 interfaces in < 2 s", lambda row: row["place_s"] < 2.0),
    "weighted plane wall 58x58, placed": Bar("10 000 interfaces in < 2 s", lambda row: row["place_s"] < 2.0),
    "weighted vault, 180 unlike stones, placed": Bar("-"),
    "one stone 10x10x10": Bar("-"),
    "one stone 20x20x20": Bar("-"),
    "one stone 20x20x20, one step": Bar("-"),
    "one stone 30x30x30": Bar("< 60 s, < 1 GB", solved_within(60.0, 1000)),
    "NSGS kernel": Bar("≤ 0.5 µs a contact and sweep", lambda row: row.get("median_us", 0.0) <= 0.5),
}
STARTS = {"import": ("-c", "import masonry_fem"), "--help": ("-m", "masonry_fem", "--help")}


def measured(case: str, limit: float) -> Row:
    """A case in a process of its own."""
    if case in STARTS:
        return started(STARTS[case])
    return alone(limit, "benchmarks.cases", case)


def started(arguments: tuple[str, ...]) -> Row:
    """Median CPU time of a fresh interpreter, the interpreter's own start included [s]."""
    taken = []
    for _ in range(START_RUNS):
        before = os.times()
        subprocess.run([sys.executable, *arguments], capture_output=True, check=True, cwd=HERE.parent)
        after = os.times()
        taken.append(
            after.children_user + after.children_system - before.children_user - before.children_system
        )
    return {"outcome": "run", "total": float(np.median(taken))}


def verdict(row: Row, bar: Bar) -> str:
    """``met`` or ``missed``; a case that was not measured says why."""
    if "seconds" not in row and "total" not in row and "median_us" not in row:
        return str(row["outcome"])
    if bar.text == "-":
        return str(row["outcome"])
    return ("met" if bar.met(row) else "missed") + ("" if row["outcome"] == "run" else f" ({row['outcome']})")


def cost(row: Row) -> str:
    """CPU time in words."""
    if "total" in row:
        return f"{row['total']:.3f} s"
    if "median_us" in row:
        return f"median {row['median_us']:.2f}, worst {row['worst_us']:.2f} µs"
    if "ratio" in row:
        return f"steps {row['ratio']:.2f} times as dear, at most {row['worst']:.2f}"
    if "step_ms" in row:
        step = row["step_ms"]
        return (
            f"ms a step: median {step['median']:.1f}, mean {step['mean']:.1f}, max {step['max']:.0f}, "
            f"first {row['first_step_ms']:.0f}; |R/W−1| {row['reaction_error']:.0e}, speed {row['speed']:.0e}"
        )
    phases = {name: value for name, value in row.get("seconds", {}).items() if value >= 0.005}
    return ", ".join(f"{name} {value:.2f}" for name, value in phases.items())


def cells(case: str, row: Row, bar: Bar) -> tuple[str, ...]:
    error = f"{row['error']:.0e}" if "error" in row else ""
    memory = f"{row['memory_mb']:.0f}" if "memory_mb" in row else ""
    counts = (str(row.get("contacts", "")), str(row.get("solves", "")))
    return (case, *counts, error, cost(row), memory, bar.text, verdict(row, bar))


def processor() -> str:
    """Name of the CPU."""
    path = Path("/proc/cpuinfo")
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def markdown(rows: list[tuple[str, ...]]) -> str:
    """The table as a page, with where and when it was measured."""
    used = ", ".join(f"{name} {version}" for name, version in versions().items())
    lines = [
        "# What it costs",
        "",
        f"{datetime.now(UTC):%Y-%m-%d}, {processor()}, {os.cpu_count()} cores, load at the end "
        f"{os.getloadavg()[0]:.1f}; {used}.",
        "CPU seconds, one thread; each case in a process of its own. Made by `python -m benchmarks.table`. "
        "What the columns are stands [below](#how-to-read-this-page).",
        "",
        "| " + " | ".join(COLUMNS) + " |",
        "|" + "---|" * len(COLUMNS),
    ]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description="Time the cases and compare them with their bars.")
    parser.add_argument("--quick", action="store_true", help="only the cases that take seconds")
    parser.add_argument("--limit", type=float, default=600.0, help="wall-clock limit of a case [s]")
    given = parser.parse_args()
    bars = QUICK if given.quick else BARS
    console, rows = Console(width=None if sys.stdout.isatty() else 150), []
    for case, bar in bars.items():
        console.print(f"[dim]{case}[/dim]")
        rows.append(cells(case, measured(case, given.limit), bar))
    table = Table(*COLUMNS)
    for row in rows:
        table.add_row(*row)
    console.print(table)
    if not given.quick:
        page = HERE / "RESULTS.md"
        _, heading, others = page.read_text(encoding="utf-8").partition("\n## ")  # what else was measured
        page.write_text(markdown(rows) + heading + others, encoding="utf-8")


if __name__ == "__main__":
    main()
