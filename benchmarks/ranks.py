"""Ranks: what each of several ranks does of an elastic wall, and what they send each other.

    python -m benchmarks.ranks                        # 40×40 bricks on one and two ranks
    python -m benchmarks.ranks --size 20 --ranks 1 2 4
    python -m benchmarks.ranks --times 2              # each twice in the same processes, the second is told
    python -m benchmarks.ranks --size 70 --weak       # as many bricks a rank: 70×70 on one, 99×99 on two

One rank does the same as several, with all of the wall for its part. CPU times count what MPI waits for other
ranks: where cores are shared, the rows ``exchange`` and ``handed`` are mostly that. The second time hardly
any memory is new to a process: a virtual machine whose host has to find it takes up to 3 s for a gigabyte.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

from benchmarks.paired import wall
from benchmarks.process import ROOT, Row
from masonry_fem.analyses.run import solve_scene
from masonry_fem.host import ranks
from masonry_fem.records.told import plain
from masonry_fem.scene import loads


def worked(size: int, times: int) -> None:
    """Solve a wall on the ranks that this process is one of; the leader prints what came out last."""
    if ranks.join(fewest=1):
        return
    text = wall(size, size, push=0.0, fidelity="elastic", divisions=[4, 2, 2], solver="tolerance = 1e-8")
    before: Row = {}
    code = 1
    try:
        for _ in range(times):
            summary = plain(solve_scene(loads(text)).summary)
            spent = summary["ranks"]["work"]
            summary["ranks"]["work"] = {kind: _since(before.get(kind), work) for kind, work in spent.items()}
            before = spent
        code = 0
    finally:  # the others wait for the leader, whatever happens
        ranks.team().end(code)
    print(json.dumps(summary))


def _since(before: Row | None, work: Row) -> Row:
    """What ranks have spent on one kind of work beyond what they had before."""
    if before is None:
        return work
    return {
        name: [now - then for now, then in zip(values, before[name], strict=True)]
        for name, values in work.items()
    }


def started(size: int, count: int, times: int) -> Row:
    """The summary of a wall on so many ranks."""
    beside = Path(sys.executable).parent / "mpiexec"
    command = [str(beside) if beside.exists() else "mpiexec", "-n", str(count)]
    alone = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    options = "--worker", "--size", str(size), "--times", str(times)
    done = subprocess.run(
        [*command, sys.executable, "-m", "benchmarks.ranks", *options],
        check=True, cwd=ROOT, env=os.environ | alone, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    row: Row = json.loads(done.stdout.splitlines()[-1])
    return row


def main() -> None:
    """Print a table for each number of ranks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=40)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--weak", action="store_true", help="walls grow with the number of ranks")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        worked(options.size, options.times)
        return
    rows = []
    for count in options.ranks:
        size = round(options.size * count**0.5) if options.weak else options.size
        told = started(size, count, options.times)
        rows.append((size, count, told))
        error = told["certificate"]["natural_map"]
        print(f"\n{told['contacts']} contacts, {count} ranks: {told['outcome']}, natural map {error:.1e}, ")
        print(f"solve {told['seconds']['solve']:.2f} s of CPU on the rank that leads\n")
        print("| work | CPU of each rank [s] | received [MB] | messages |\n|---|---|---|---|")
        for kind, work in told["ranks"]["work"].items():
            cells = (
                ", ".join(f"{value:.2f}" for value in work["seconds"]),
                ", ".join(f"{value:.1f}" for value in work["received"]),
                max(work["times"]),
            )
            print(f"| {kind} | {' | '.join(map(str, cells))} |")
    print("\n| bricks | ranks | contacts a rank | Newton steps | linear systems | solve [s] |")
    print("|---|---|---|---|---|---|")
    for size, count, told in rows:
        steps, systems = told["solver"]["iterations"], told["solver"]["linear_solves"]
        each, seconds = round(told["contacts"] / count), told["seconds"]["solve"]
        print(f"| {size}×{size} | {count} | {each} | {steps} | {systems} | {seconds:.2f} |")


if __name__ == "__main__":
    main()
