"""Memory of many runs in one process: python -m benchmarks.memory --runs 1000.

Solves a small elastic arch again and again, each time with other friction, and prints the memory that the
process holds after each tenth of the runs. It ends with code 1 where the last half of the runs adds more
than 1 %.
"""

from __future__ import annotations

import argparse
import sys

import psutil

import masonry_fem as mf

GROWTH = 0.01


def arch(friction: float) -> mf.Scene:
    """An arch of elastic stones."""
    return mf.Scene(
        materials={"stone": {"density": 2400, "young": "10 GPa"}},
        structures=[
            {"kind": "arch", "name": "arch", "material": "stone", "radius": 1, "thickness": 0.2, "depth": 0.3,
             "voussoirs": 7}
        ],
        mesh={"divisions": [2, 1, 3]},
        joints=[{"friction": friction}],
        loads={"gravity": [0, 0, -9.81]},
    )  # fmt: skip


def held() -> float:
    """Memory that this process holds [MB]."""
    return float(psutil.Process().memory_info().rss / 1e6)


def measured(runs: int) -> list[float]:
    """Memory after each tenth of so many runs [MB]."""
    told = []
    for number in range(1, runs + 1):
        result = mf.solve(arch(0.5 + 0.1 * number / runs))
        assert result.outcome == "equilibrium"
        if number % max(runs // 10, 1) == 0:
            told.append(held())
            print(f"{number:6d} runs  {told[-1]:7.1f} MB", flush=True)
    return told


def main() -> int:
    """Run, and judge."""
    own = argparse.ArgumentParser(description=__doc__)
    own.add_argument("--runs", type=int, default=1000)
    told = measured(own.parse_args().runs)
    growth = told[-1] / told[len(told) // 2] - 1
    print(f"the last half of the runs adds {100 * growth:.2f} %")
    return int(growth > GROWTH)


if __name__ == "__main__":
    sys.exit(main())
