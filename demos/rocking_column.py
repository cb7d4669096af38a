"""Column that rocks
=================

Geometry and material
    A column of 0.5 m × 2 m on a floor, elastic, 10 GPa, that does not slide.
Load
    It is tilted to half the angle at which it would stand on its edge, and let go. Dynamics for 2.2 s in
    steps of 1 ms, θ = 1; impacts do not rebound.
What to look at
    The column turns about its left edge, hits the floor, goes on about its right edge, and loses a part
    of its speed in each impact. It rises as Housner's block does to 2 % in the first swing; each impact
    and the vibrations that it leaves add to that. θ = 1 damps them within a few steps.
Reference
    Housner (1963): a rigid block is upright after 0.4938 s and keeps 0.9118 of its angular velocity,
    with which it tilts to 0.387 of the angle at which it stands on its edge.
Cost
    30 seconds.

.. image:: /images/rocking_column.png

.. literalinclude:: rocking_column.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/rocking_column.png"

from __future__ import annotations

import csv
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
WIDTH, HEIGHT, GRAVITY = 0.5, 2.0, 9.81
EDGE = float(np.arctan(WIDTH / HEIGHT))  # tilt at which it stands on its edge [rad]
KEPT = 1 - 1.5 * np.sin(EDGE) ** 2  # of the angular velocity, in an impact
FREQUENCY = float(np.sqrt(0.75 * GRAVITY / (0.5 * np.hypot(WIDTH, HEIGHT))))  # Housner's p [1/s]


@dataclass(frozen=True, slots=True)
class Rocking:
    """How the column rocks.

    Attributes
    ----------
    time : Of the steps [s], shape (n,). tilt : Of the column, over that on its edge, shape (n,).
    upright : When it is upright for the first time [s]. rise : Its greatest tilt after that, over that on
        its edge.
    exact_upright, exact_rise : The same of Housner's block.
    """

    time: np.ndarray
    tilt: np.ndarray
    upright: float
    rise: float
    exact_upright: float
    exact_rise: float


def main(*, out: Path | None = None, step: float = 1e-3, duration: float = 2.2) -> Rocking:
    """Let the column go, in steps of ``step`` [s]; pictures go to ``out``."""
    changes = [f"analysis.step={step}", f"analysis.duration={duration}"]
    changes += [f"output.pictures={str(out is not None).lower()}", "output.every=1000000"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        run(load(SCENE, overrides=changes), folder)
        with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    time = np.array([float(row["time"]) for row in rows])
    foot, head = (
        start + np.array([[float(row[f"probes.{name}_{axis}"]) for axis in "xy"] for row in rows])
        for name, start in (("foot", (0.0, 0.0)), ("head", (-0.244358, 1.985016)))
    )
    way = head - foot
    tilt = np.arctan2(-way[:, 0], way[:, 1]) / EDGE
    at = int(np.argmax(tilt <= 0))
    exact = housner(np.append(time, 10.0))
    exact_upright = exact[0]
    found = Rocking(
        time, tilt, float(np.interp(0.0, -tilt[at - 1 : at + 1], time[at - 1 : at + 1])),
        float(-tilt[at:].min()), exact_upright, exact[1],
    )  # fmt: skip
    if out is not None:
        plot(found, exact[2], out / "rocking_column.png")
    return found


def housner(time: np.ndarray) -> tuple[float, float, np.ndarray]:
    """When the rigid block is upright [s], how far it tilts then, and its tilt at ``time``, over EDGE."""

    def falling(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -(FREQUENCY**2) * np.sin(EDGE - state[0])]

    def down(_: float, state: np.ndarray) -> float:
        return float(state[0])

    down.terminal, down.direction = True, -1
    start, state, sign = 0.0, [EDGE / 2, 0.0], 1.0
    tilt, first, rise = np.zeros(len(time)), 0.0, 0.0
    while start < time[-2]:
        # until the next impact: |tilt| as of a block on one edge
        arc = solve_ivp(falling, (start, start + 5.0), state, events=down, rtol=1e-10, dense_output=True)
        end = float(arc.t[-1])
        inside = (time >= start) & (time <= end)
        tilt[inside] = sign * arc.sol(time[inside])[0]
        if sign > 0 and first == 0.0:
            first = end
        elif rise == 0.0:
            rise = float(arc.sol(np.linspace(start, end, 4000))[0].max())
        start, state, sign = end, [0.0, KEPT * -float(arc.y[1, -1])], -sign
    return first, rise / EDGE, tilt / EDGE


def plot(found: Rocking, exact: np.ndarray, path: Path) -> Path:
    """Tilt against time, beside Housner's."""
    figure = Figure(figsize=(9, 4.2), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.plot(found.time, exact[:-1], color="#9aa2ab", lw=3.5, label="rigid block (Housner)")
    axes.plot(found.time, found.tilt, color="#1f5fa8", lw=1.6, label="elastic stone, θ = 1")
    axes.axhline(0.0, color="#22262b", lw=0.8)
    axes.set(xlabel="time [s]", ylabel="tilt / tilt on its edge", title="Column that rocks")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    column = main(out=Path("results/rocking_column"))
    print(
        f"upright after {column.upright:.4f} s (rigid {column.exact_upright:.4f}), then tilted to "
        f"{column.rise:.3f} of what it stands (rigid {column.exact_rise:.3f})"
    )
