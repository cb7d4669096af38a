"""Make the map of stability: docs/images/stability_*.png and the table in docs/stability.md.

    python docs/make_stability.py               # measure all, draw, write the table: some minutes
    python docs/make_stability.py --here "stack of rigid cubes"    # one extreme, as JSON

Each extreme of ``stability_map`` is run in a process of its own.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS.parent))

from matplotlib.axes import Axes  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from stability_map import EXTREMES, FIGURES, Extreme  # noqa: E402

from masonry_fem.analyses.run import solve_scene  # noqa: E402
from masonry_fem.errors import MasonryError  # noqa: E402

PAGE, IMAGES = DOCS / "stability.md", DOCS / "images"
MARKS = ("<!-- table: made by docs/make_stability.py, do not edit -->\n", "<!-- end of table -->")
LEAST, MOST = 1e-17, 1e2  # of what is drawn
COLUMNS = 3
LINES = {
    "error": ("known answer", "tab:blue", "o"),
    "natural_map": ("contact laws", "tab:orange", "s"),
    "block_balance": ("balance of blocks", "tab:green", "^"),
}
Row = dict[str, Any]


class Warnings(logging.Handler):
    """What the program warns of from now on, until it is closed."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._told: list[str] = []
        self._logger = logging.getLogger("masonry_fem")
        self._logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Keep what is told."""
        self._told.append(record.getMessage())

    def close(self) -> list[str]:
        """All that was told."""
        self._logger.removeHandler(self)
        super().close()
        return self._told


def measured(extreme: Extreme) -> list[Row]:
    """What came out for each value; all in this process."""
    return [sample(extreme, value) for value in extreme.values]


def sample(extreme: Extreme, value: float) -> Row:
    """Outcome, certificate, warnings and distance from the known answer for one value."""
    warnings = Warnings()
    try:
        result = solve_scene(extreme.scene(value))
    except MasonryError as error:
        return {"value": value, "outcome": "refused", "message": str(error), "warnings": warnings.close()}
    certificate = result.summary.certificate
    known = extreme.error(result, value) if result.outcome in extreme.right else math.nan
    return {
        "value": value,
        "outcome": result.outcome,
        "message": result.message,
        "warnings": warnings.close(),
        "error": known,
        "natural_map": certificate.natural_map,
        "block_balance": certificate.block_balance,
    }


def alone(name: str) -> list[Row]:
    """The same in a process of its own, on one thread."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, __file__, "--here", name],
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr.strip().splitlines()[-1]}")
    print(f"measured {name}", file=sys.stderr)
    rows: list[Row] = json.loads(done.stdout.splitlines()[-1])
    return rows


def holds(extreme: Extreme, row: Row) -> bool:
    """Whether a value has the right outcome and the known answer."""
    return row["outcome"] in extreme.right and row["error"] <= extreme.good


def draw(figure: str, rows: dict[str, list[Row]]) -> Path:
    """One picture with a panel for each extreme."""
    extremes = FIGURES[figure]
    lines = math.ceil(len(extremes) / COLUMNS)
    sheet = Figure(figsize=(4.2 * COLUMNS, 3.0 * lines), layout="constrained")
    FigureCanvasAgg(sheet)
    panels = sheet.subplots(lines, COLUMNS, squeeze=False).ravel()
    for axes, extreme in zip(panels, extremes, strict=False):
        panel(axes, extreme, rows[extreme.name])
    for axes in panels[len(extremes) :]:
        axes.set_visible(False)
    handles, labels = panels[0].get_legend_handles_labels()
    sheet.legend(handles, labels, loc="outside lower center", ncols=5)
    path = IMAGES / f"{figure}.png"
    sheet.savefig(path, dpi=110)
    return path


def panel(axes: Axes, extreme: Extreme, rows: list[Row]) -> None:
    """Errors over the quantity that is driven; where an answer is not given, a cross tells so."""
    values = [row["value"] for row in rows]
    for key, (label, colour, marker) in LINES.items():
        heights = [min(max(row.get(key, math.nan), LEAST), MOST) for row in rows]
        axes.plot(values, heights, marker, linestyle="-", lw=0.8, ms=4, color=colour, label=label)
    doubted = [row for row in rows if row["warnings"] and "error" in row]
    heights = [min(max(row["error"], LEAST), MOST) for row in doubted]
    axes.plot(
        [row["value"] for row in doubted], heights, "o", mfc="none", ms=9, color="tab:blue", label="warned of"
    )
    axes.axhline(extreme.good, color="tab:blue", lw=0.8, ls=":", label="reached below")
    missing = [row["value"] for row in rows if row["outcome"] not in extreme.right]
    axes.plot(missing, [1.0] * len(missing), "x", color="tab:red", ms=7, label="no answer, told why")
    axes.set_xscale("log" if extreme.log else "linear")
    axes.set_yscale("log")
    axes.set_ylim(LEAST / 3, MOST)
    axes.set_title(extreme.name, fontsize=10)
    axes.set_xlabel(extreme.quantity, fontsize=9)
    axes.set_ylabel("relative error", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(alpha=0.3)


def table(rows: dict[str, list[Row]]) -> str:
    """A line of Markdown for each extreme: how far it holds, how well, what limits it."""
    lines = [
        "| extreme | known answer | tested | holds | worst error there | beyond | what limits it |",
        "|---|---|---|---|---|---|---|",
    ]
    for extreme in EXTREMES.values():
        told = rows[extreme.name]
        good = [row for row in told if holds(extreme, row)]
        worst = max((row["error"] for row in good), default=math.nan)
        cells = (
            f"{extreme.name}: {extreme.quantity}", extreme.answer, span([row["value"] for row in told]),
            reached(extreme, told), f"{worst:.0e}", beyond(extreme, told), extreme.limit,
        )  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def beyond(extreme: Extreme, rows: list[Row]) -> str:
    """What a user is told where the answer is not reached."""
    told: dict[str, None] = {}
    for row in rows:
        if not holds(extreme, row):
            wrong = row["outcome"] not in extreme.right
            told[
                row["outcome"].replace("_", " ") if wrong else "warned" if row["warnings"] else "**silent**"
            ] = None
    return ", ".join(told) or "–"


def span(values: list[float]) -> str:
    """From where to where."""
    if len(values) < 2:
        return f"{values[0]:g}" if values else "nowhere"
    return f"{min(values):g} to {max(values):g}"


def reached(extreme: Extreme, rows: list[Row]) -> str:
    """Runs of values for which all holds."""
    runs: list[list[float]] = [[]]
    for row in rows:
        if holds(extreme, row):
            runs[-1].append(row["value"])
        elif runs[-1]:
            runs.append([])
    found = [span(run) for run in runs if run]
    return "all" if sum(map(len, runs)) == len(rows) else " and ".join(found) or "nowhere"


def main() -> None:
    """Measure, draw and write."""
    parser = argparse.ArgumentParser(description="Make the map of stability.")
    parser.add_argument("--here", metavar="NAME", help="one extreme in this process, as JSON")
    parser.add_argument(
        "--rows", type=Path, metavar="FILE.json", help="use what was measured, and keep it there"
    )
    given = parser.parse_args()
    if given.here:
        print(json.dumps(measured(EXTREMES[given.here])))
        return
    rows = json.loads(given.rows.read_text()) if given.rows and given.rows.exists() else {}
    left = [name for name in EXTREMES if name not in rows]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows |= dict(zip(left, pool.map(alone, left), strict=True))
    if given.rows:
        given.rows.write_text(json.dumps(rows, indent=1))
    for figure in FIGURES:
        print(f"wrote {draw(figure, rows)}")
    start, end = MARKS
    text = PAGE.read_text()
    head, _, rest = text.partition(start)
    _, _, tail = rest.partition(end)
    PAGE.write_text(head + start + table(rows) + end + tail)
    print(f"wrote {PAGE}")


if __name__ == "__main__":
    main()
