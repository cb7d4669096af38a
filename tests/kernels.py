"""Kernel: the machine code that OpenBLAS picks for the processor it runs on; another rounds otherwise.

    python -m tests.kernels           # which of them run here, and which not, with the reason
    python -m tests.kernels --other   # the name of one that is not what this processor gets by itself

The environment variable OPENBLAS_CORETYPE asks for one, of NumPy's and SciPy's libraries alike. Nothing keeps
it from asking for instructions that the processor has not: whether a kernel runs is tried in a process.

OpenBLAS 0.3.34 cuts products into larger parts on AMD's Zen 4 and 5 (a second-level cache of 1 MB, AVX-512),
those of a kernel that was asked for, too: Haswell's and Zen's then write beyond their buffer, and crash where
more than some 380 terms are summed (OpenMathLib/OpenBLAS, issues 6013, 6021, 6026). Told of a smaller one it
leaves them as they are: who asks for a kernel gives both variables.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cache

VARIABLE = "OPENBLAS_CORETYPE"
CACHE, SMALL = "OPENBLAS_L2_SIZE", "512"  # [kB]
NAMES = ("Haswell", "SkylakeX", "Zen", "Sandybridge")

_TRY = """
import json
import numpy as np
import scipy.linalg
from threadpoolctl import threadpool_info

matrix = np.random.default_rng(1).standard_normal((700, 700))
np.linalg.solve(matrix, matrix @ matrix)
scipy.linalg.lu_factor(matrix)
scipy.linalg.eigh(matrix @ matrix.T)
libraries = [one for one in threadpool_info() if one["user_api"] == "blas"]
print(json.dumps([[one["internal_api"], one.get("architecture")] for one in libraries]))
"""


@dataclass(frozen=True, slots=True)
class Kernel:
    """What asking for a kernel gives.

    Attributes
    ----------
    asked : Its name; None: whatever the processor gets by itself.
    taken : The kernel that both libraries run; None where there is none.
    reason : Why it cannot be had; empty where it can.
    """

    asked: str | None
    taken: str | None
    reason: str = ""


def environment(name: str | None) -> dict[str, str]:
    """Of a process that runs a kernel."""
    kept = {key: value for key, value in os.environ.items() if key != VARIABLE}
    return kept if name is None else {CACHE: SMALL, **kept, VARIABLE: name}


@cache
def kernel(name: str | None) -> Kernel:
    """What asking for a kernel gives here; None asks for nothing."""
    tried = subprocess.run(
        [sys.executable, "-c", _TRY], env=environment(name), capture_output=True, text=True, check=False
    )
    if tried.returncode:
        return Kernel(name, None, f"this processor cannot run {name} (exit code {tried.returncode})")
    libraries = json.loads(tried.stdout)
    if not libraries or any(library != "openblas" for library, _ in libraries):
        found = ", ".join(sorted({library for library, _ in libraries})) or "none"
        return Kernel(name, None, f"the BLAS is {found}, not OpenBLAS")
    taken = {architecture for _, architecture in libraries}
    if len(taken) > 1:
        return Kernel(name, None, f"NumPy and SciPy take different ones: {', '.join(sorted(taken))}")
    return Kernel(name, taken.pop())


def different() -> list[Kernel]:
    """One for each set of machine code that can be had here, the processor's own first."""
    found: dict[str, Kernel] = {}
    for name in (None, *NAMES):
        one = kernel(name)
        if one.taken is not None:
            found.setdefault(one.taken, one)
    return list(found.values())


def main() -> int:
    """Tell what can be had; with ``--other`` one name alone, of another kernel than the processor's own."""
    if "--other" in sys.argv[1:]:
        others = [one.asked for one in different()[1:]]
        print(others[0] if others else "")
        return 0
    print(f"own: {kernel(None).taken or kernel(None).reason}")
    for name in NAMES:
        one = kernel(name)
        by = "" if one.taken == name else f": this OpenBLAS has {one.taken} in its place"
        print(f"{name}: {one.reason or 'runs' + by}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
