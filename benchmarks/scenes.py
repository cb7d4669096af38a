"""Scenes: scene files with two checkouts of the program, how they end and what they cost.

    python -m benchmarks.scenes OLD NEW demos/*.toml      # OLD and NEW are folders
    python -m benchmarks.scenes OLD NEW FOLDER/*.toml --limit 600

A file that both checkouts have under that name (a demo, say) is run from each of them, any other from where
it is. Runs have one thread and draw no pictures. Each is made twice, in turns, and the cheaper counts: the
first may have to compile. An error is the larger of natural map and balance of a block, as the program says.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from benchmarks.paired import run

ENDED = {0: "ends", 1: "refused", 2: "no convergence", 3: "no equilibrium"}  # where no summary says more


@dataclass(frozen=True, slots=True)
class Run:
    """How a scene ended, the larger of natural map and balance of a block, and its CPU time [s]."""

    outcome: str
    error: str
    seconds: float


def ended(checkout: Path, scene: Path, limit: float) -> Run:
    """A scene file with a checkout, in a process of its own.

    Parameters
    ----------
    checkout : Its folder.
    scene : The file.
    limit : Wall-clock time after which it is given up [s].
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        command = ["run", str(scene), "--out", str(out), "--quiet", "--set", "output.pictures=false"]
        try:
            done, seconds = run(checkout, command, Path(folder), limit)
        except subprocess.TimeoutExpired:
            return Run(f"not done in {limit:g} s", "", limit)
        outcome, error = ENDED.get(done.returncode, f"exit code {done.returncode}"), ""
        if (summary := out / "summary.json").exists():
            told = json.loads(summary.read_text(encoding="utf-8"))
            outcome = told.get("outcome", outcome)
            measures = told.get("certificate") or {}
            numbers = [measures[name] for name in ("natural_map", "block_balance") if name in measures]
            error = f"{max(numbers):.0e}" if numbers else ""
        return Run(outcome, error, seconds)


def main() -> None:
    parser = argparse.ArgumentParser(
        description="How scene files end with two checkouts, and what they cost."
    )
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--limit", type=float, default=300.0, help="wall-clock time a run [s]")
    parser.add_argument("--runs", type=int, default=2, help="with each checkout")
    given = parser.parse_args()
    print("| scene | before | after | error before | after | CPU before | after | ratio |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in given.scenes:
        both = [given.old.resolve(), given.new.resolve()]
        shared = all((checkout / scene).exists() for checkout in both)
        files = [checkout / scene if shared else scene.resolve() for checkout in both]
        pairs = list(zip(both, files, strict=True)) * given.runs
        runs = [ended(*pair, given.limit) for pair in pairs]
        old, new = (min(runs[i::2], key=lambda made: made.seconds) for i in (0, 1))
        ratio = f"{new.seconds / old.seconds:.2f}"
        cells = [scene.stem, old.outcome, new.outcome, old.error, new.error]
        cells += [f"{old.seconds:.1f} s", f"{new.seconds:.1f} s", ratio]
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
