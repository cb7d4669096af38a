"""Process: one case of a benchmark in a process of its own, so that CPU time and peak memory are its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
Row = dict[str, Any]


def alone(limit: float, module: str, *arguments: str) -> Row:
    """What ``python -m module arguments`` prints as JSON in its last line, or how it failed.

    Parameters
    ----------
    limit : Wall-clock time after which it is given up [s].
    """
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [sys.executable, "-m", module, *arguments],
            check=False,
            capture_output=True,
            text=True,
            cwd=ROOT,
            timeout=limit,
            env=environment,
        )
    except subprocess.TimeoutExpired:
        return {"outcome": f"not done in {limit:g} s"}
    if done.returncode:
        return {"outcome": done.stderr.strip().splitlines()[-1]}
    row: Row = json.loads(done.stdout.splitlines()[-1])
    return row
