"""Walls of dry stones in shear
============================

Geometry and material
    Walls of granite, 1.00 × 1.20 m and 0.2 m thick: eight courses of sawn stones of 20 × 15 cm without
    mortar. Plane stress, stones of 20.2 GPa, friction 0.65. Dry joints close under pressure; one closure
    serves all walls. It is fitted to moduli of such walls pressed by 0.5, 0.875 and 1.25 MPa; its stiffness
    in shear, 4 % of that under pressure, to the first stiffnesses below.
Load
    40, 100, 175 or 250 kN on a beam that may turn; then a horizontal force at the beam's half height, in
    steps of 2.8 % of the load until no balance is left. Where the contact solver does not find which points
    stick and which slide, a step is halved.
What to look at
    At first the whole wall is in contact. Then joints open at the heel and along a stepped diagonal, the
    curve bends, and the wall turns over its toe. ``dry_walls.png`` has the curves and measured points.
Reference
    Tests of Vasconcelos (2005) and Vasconcelos and Lourenço (2009), from the collection of Vanin et al.
    (2017). Peaks: 16.3, 39.4, 66.5 and 90.2 kN in the mean; here the last balance and the first step without
    one are 15.7 and 16.8, 36.4 and 39.2, 63.7 and 68.6, 91.0 and 98.0 kN. First stiffness: 10.7, 16.1, 21.5
    and 22.1 kN/mm in the mean, where single tests under 100 kN differ fourfold; here 12.7, 15.6, 19.6, 23.9.
    From half of the peak on, the tested walls move one and a half to three times as far.
Cost
    Seven minutes of CPU time.

.. image:: /images/dry_walls.png

.. literalinclude:: dry_walls.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/dry_walls.png"

from __future__ import annotations

import csv
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
POINTS = Path(__file__).with_suffix(".csv")  # some of each measured envelope
THICKNESS = 0.2
# vertical load [kN] to the means of the measured peaks [kN] and first stiffnesses [kN/mm]
MEASURED = {40: (16.3, 10.7), 100: (39.4, 16.1), 175: (66.5, 21.5), 250: (90.2, 22.1)}
SHARE = 0.42  # last horizontal force over the load: more than any wall bears
COLOURS = {40: "#8a8f98", 100: "#1f5fa8", 175: "#e07b1a", 250: "#a1282c"}


@dataclass(frozen=True, slots=True)
class Curve:
    """How a wall gives way to the horizontal force.

    Attributes
    ----------
    load : Vertical [kN].
    shift : Of the beam since the horizontal force began [mm], shape (steps,).
    force : Horizontal [kN], shape (steps,).
    """

    load: float
    shift: np.ndarray
    force: np.ndarray

    @property
    def stiffness(self) -> float:
        """Of the first step with a horizontal force [kN/mm]."""
        return float(self.force[1] / self.shift[1])

    @property
    def peak(self) -> float:
        """Greatest force that was balanced [kN]."""
        return float(self.force.max())


def main(
    *, out: Path | None = None, loads: Sequence[float] = tuple(MEASURED), step: float = 0.028
) -> tuple[Curve, ...]:
    """Push a wall under each of the ``loads`` [kN], in steps of that share of the load."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        found = []
        count = round(SHARE / step)
        for vertical in loads:
            found.append(pushed(vertical, count + 1, folder / f"{vertical:g}_kN", share=count * step))
    if out is not None:
        plot(found, out / "dry_walls.png")
    return tuple(found)


def pushed(
    vertical: float, steps: int, folder: Path, changes: Sequence[str] = (), share: float = SHARE
) -> Curve:
    """One wall, read from what its run has written; ``share``: last horizontal force over the vertical."""
    line = 1e3 * vertical / THICKNESS  # [N/m]
    settings = (
        f"loads.points.0.vector=[0.0, {-line}]",
        f"loads.points.1.vector=[{share * line}, 0.0]",
        "loads.points.1.time={ kind = 'table', points = [[0.0, 0.0], [%r, 0.0], [1.0, 1.0]] }" % (1 / steps),
        f"analysis.load_steps={steps}",
        "output.pictures=false",
        *changes,
    )
    run(load(SCENE, overrides=settings), folder)
    with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["outcome"] in {"converged", "inexact"}]
    shift, force = (
        np.array([float(row[name]) for row in rows])
        for name in ("probes.top_x", "support_resultants.wall.ground_fx")
    )
    return Curve(vertical, 1e3 * (shift - shift[0]), -1e-3 * THICKNESS * force)


def measured() -> dict[float, np.ndarray]:
    """Points of the measured envelopes by vertical load [kN], shapes (points, 2) [mm, kN]."""
    with POINTS.open(newline="", encoding="utf-8") as file:
        rows = [
            [float(row[key]) for key in ("load_kN", "displacement_mm", "force_kN")]
            for row in csv.DictReader(file)
        ]
    table = np.array(rows)
    return {load: table[table[:, 0] == load, 1:] for load in np.unique(table[:, 0])}


def plot(found: Sequence[Curve], path: Path) -> Path:
    """Force against displacement: all of it, and how it begins."""
    figure = Figure(figsize=(10, 4.4), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    tested = measured()
    for axes, end, title in zip(
        figure.subplots(1, 2), (12.5, 3.0), ("All of it", "The beginning"), strict=True
    ):
        for one in found:
            colour = COLOURS.get(int(one.load), "#22262b")
            axes.plot(one.shift, one.force, color=colour, lw=1.8, label=f"{one.load:g} kN")
            if one.load in tested:
                axes.plot(*tested[one.load].T, "o", color=colour, ms=3.5)
        axes.set(
            xlim=(0.0, end),
            xlabel="displacement of the beam [mm]",
            ylabel="horizontal force [kN]",
            title=title,
        )
        axes.set_ylim(bottom=0.0)
        axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, title="vertical load (points: measured)", loc="upper left")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    print("load [kN]   peak [kN]   measured   first stiffness [kN/mm]   measured")
    for wall in main(out=Path("results/dry_walls")):
        peak, stiffness = MEASURED[int(wall.load)]
        print(f"{wall.load:9g}{wall.peak:12.1f}{peak:11.1f}{wall.stiffness:26.1f}{stiffness:11.1f}")
