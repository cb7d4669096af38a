"""Bouncing block
==============

Geometry and material
    A rigid cube of 0.5 m, let go 1 m above the ground.
Load
    Its weight; Newton's restitution e = 0.8 in the velocity form.
What to look at
    The height in time (``history.csv``): each apex is e² times the one before, the impacts accumulate
    at a finite time (Zeno), and the time-stepping scheme passes this time without difficulty.
Reference
    First impact at √(2H/g) = 0.4515 s, second apex e² H = 0.64 m, at rest at
    √(2H/g) (1 + e)/(1 − e) = 4.0637 s.
Cost
    10 seconds for 4500 steps.

.. image:: /images/bouncing.png
   :width: 70%

.. literalinclude:: bouncing.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/bouncing.png"

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, solve

SCENE = Path(__file__).with_suffix(".toml")
G, HEIGHT = 9.81, 1.0


class Track:
    """Observer that keeps the height [m] of the block and its speed [m/s] at each time [s]."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float, float]] = [(0.0, HEIGHT, 0.0)]

    def record(self, model: Any, state: Any, report: Any) -> None:
        """Called after each step."""
        self.rows.append((report.time, HEIGHT + report.probes["block"][2], report.speed))


@dataclass(frozen=True, slots=True)
class Bouncing:
    """Times [s] and heights [m], found and exact.

    Attributes
    ----------
    impact, exact_impact : First impact, in the middle of its step. apex, exact_apex : Height after it.
    rest, exact_rest : End of all motion; inf where the run was too short.
    track : Time, height and speed of each step, shape (steps + 1, 3).
    """

    impact: float
    exact_impact: float
    apex: float
    exact_apex: float
    rest: float
    exact_rest: float
    track: np.ndarray


def main(
    *, out: Path | None = None, restitution: float = 0.8, step: float = 1e-3, duration: float = 4.5
) -> Bouncing:
    """Drop the block, find the first impact, the second apex and the time of rest."""
    settings = (
        f"joints.0.restitution={restitution}",
        f"analysis.step={step}",
        f"analysis.duration={duration}",
    )
    seen = Track()
    solve(load(SCENE, overrides=settings), observers=(seen,))
    track = np.array(seen.rows)
    time, height, speed = track.T
    hit = int(np.argmin(np.diff(speed) > 0))  # the speed grows until the first impact
    fall = math.sqrt(2 * HEIGHT / G)
    moving = np.flatnonzero(speed > 2 * G * step)
    found = Bouncing(
        impact=float(time[hit : hit + 2].mean()),
        exact_impact=fall,
        apex=float(height[hit + 1 :].max()),
        exact_apex=restitution**2 * HEIGHT,
        rest=float(time[moving[-1] + 1]) if moving[-1] + 1 < len(time) else math.inf,
        exact_rest=fall * (1 + restitution) / (1 - restitution),
        track=track,
    )
    if out is not None:
        plot(found, out / "bouncing.png", restitution)
    return found


def plot(found: Bouncing, path: Path, restitution: float) -> Path:
    """Picture the height in time with the exact apexes."""
    figure = Figure(figsize=(9, 4), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    time, height, _ = found.track.T
    axes.plot(time, height, color="#1f5fa8", lw=1.6, label="computed")
    bounce = np.arange(1, 12)
    rise = found.exact_impact * restitution**bounce
    apex = found.exact_impact + 2 * np.cumsum(rise) - rise
    axes.plot(apex, HEIGHT * restitution ** (2 * bounce), "o", ms=5, mfc="none", color="#c8352b",
              label="exact apexes $e^{2k} H$")  # fmt: skip
    axes.axvline(found.exact_rest, color="#5d6670", ls="--", lw=1)
    axes.annotate(f"rest, exact {found.exact_rest:.3f} s", (found.exact_rest, 0.6), rotation=90,
                  ha="right", va="center", color="#5d6670")  # fmt: skip
    axes.set(xlabel="time [s]", ylabel="height of the base [m]", xlim=(0, time[-1]), ylim=(0, None),
             title=f"Block dropped from {HEIGHT:g} m, restitution {restitution:g}")  # fmt: skip
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    found = main(out=Path("results/bouncing"))
    print("                 computed     exact")
    print(f"first impact   {found.impact:10.4f}{found.exact_impact:10.4f} s")
    print(f"second apex    {found.apex:10.4f}{found.exact_apex:10.4f} m")
    print(f"at rest        {found.rest:10.4f}{found.exact_rest:10.4f} s")
