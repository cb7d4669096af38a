"""Run scenes from the command line one after the other, in the process that a kernel was asked for.

    python -m tests.kernel_worker FOLDER      # of *.toml, with the command in the first line as a comment

Each scene's results go to a folder of its name beside it, exit codes and what ``limit`` and ``collapse``
print to FOLDER/codes.json, with the kernels that NumPy's and SciPy's libraries have taken. (DOLFINx's wheel
brings a third one, which has more kernels to pick from.)
"""

from __future__ import annotations

import json
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import scipy.linalg  # noqa: F401 - before anything that brings a BLAS of its own
from threadpoolctl import threadpool_info

TAKEN = sorted({one["architecture"] for one in threadpool_info() if one["internal_api"] == "openblas"})


def run(folder: Path) -> dict[str, object]:
    from masonry_fem.cli import main

    told: dict[str, object] = {"kernels": TAKEN}
    for scene in sorted(folder.glob("*.toml")):
        command, *options = scene.read_text(encoding="utf-8").splitlines()[0].removeprefix("#").split()
        if command != "limit":
            options += ["--quiet", "--out", str(scene.with_suffix(""))]
        printed = StringIO()
        with redirect_stdout(printed):
            code = main([command, str(scene), *options])
        told[scene.stem] = {"code": code, "printed": printed.getvalue()}
    return told


if __name__ == "__main__":
    where = Path(sys.argv[1])
    (where / "codes.json").write_text(json.dumps(run(where)), encoding="utf-8")
