"""Low wall: dynamics against statics
==================================

Geometry and material
    Five courses of bricks 0.5 × 0.25 × 0.25 m in running bond, 2 m long, half bricks at the ends of the
    second and fourth course; 10 GPa, 2400 kg/m³, friction 0.6 in bed and head joints and on the floor.
Load
    Its weight, 14 715 N, applied at once.
What to look at
    The vertical resultant on the ground in time. With θ = 1/2 the sudden weight causes waves, and the
    resultant oscillates up to nearly twice the weight; θ = 1 damps some of this; if velocities are set to
    zero after each step, the resultant approaches the weight from below. True statics gives the answer in one
    solution. ``von_mises.png``: the stress grows with depth and is greatest at the base, where the floor's
    friction prevents the wall from spreading; head joints open at the top.
Reference
    Statics: 14 715 N; top_mid sinks by 1.7733 µm and top_end moves out by 0.1568 µm on this mesh (an
    independent code). A column under sudden gravity swings between 0 and twice its weight with the
    period 4H/c = 2.4 ms.
Cost
    2 seconds for the statics and 10 to draw it, 15 for the three marches, on bricks of 2 × 1 × 1 elements.

.. image:: /images/low_wall_ground.png
   :width: 70%
.. image:: /images/low_wall.png

.. literalinclude:: low_wall.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/low_wall.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, run, solve

SCENE = Path(__file__).with_suffix(".toml")
MARCHES = {
    "dynamics, θ = 1/2": "{{kind='dynamics', step={step}, duration={duration}, theta=0.5}}",
    "dynamics, θ = 1": "{{kind='dynamics', step={step}, duration={duration}, theta=1.0}}",
    "velocities zeroed": (
        "{{kind='equilibrium', strategy='brutal_damping', step={step}, theta=1.0, max_steps={steps}}}"
    ),
}
COLOURS = ("#1f5fa8", "#e07b1a", "#1b7f5c")


class Ground:
    """Observer that keeps time [s] and vertical force of the ground on the wall [N]."""

    def __init__(self) -> None:
        self.rows: list[tuple[float, float]] = [(0.0, 0.0)]

    def record(self, model: Any, state: Any, report: Any) -> None:
        """Called after each step."""
        self.rows.append((report.time, report.support_resultants["wall.ground"][2]))


@dataclass(frozen=True, slots=True)
class LowWall:
    """The wall in statics and the ground's force in the marches.

    Attributes
    ----------
    outcome, weight : Of the statics; the weight [N].
    ground : Its vertical reaction in statics [N].
    top_mid_sinks, top_end_moves : Displacements [m].
    von_mises : Greatest at a Gauss point [Pa].
    marches : Name to (time [s], force [N]), shape (steps + 1, 2).
    amplification : Greatest force over the weight, by march. final : The last one over the weight.
    """

    outcome: str
    weight: float
    ground: float
    top_mid_sinks: float
    top_end_moves: float
    von_mises: float
    marches: dict[str, np.ndarray]
    amplification: dict[str, float]
    final: dict[str, float]


def main(
    *,
    out: Path | None = None,
    size: float = 0.125,
    march_size: float = 0.25,
    step: float = 1e-4,
    duration: float = 8e-3,
) -> LowWall:
    """Solve the statics on elements of ``size`` [m], then march on elements of ``march_size`` [m]."""
    scene = load(SCENE, overrides=(f"mesh.size={size}",))
    result = solve(scene) if out is None else run(scene, out)
    summary = result.summary
    weight = -float(summary.applied[2])
    marches = {}
    for name, plan in MARCHES.items():
        words = plan.format(step=step, duration=duration, steps=round(duration / step))
        seen = Ground()
        # 1e-9 of the forces shows in no figure
        changes = (f"mesh.size={march_size}", f"analysis={words}", "solver.tolerance=1e-9")
        scene = load(SCENE, overrides=changes)
        solve(scene, observers=(seen,))
        marches[name] = np.array(seen.rows)
    found = LowWall(
        outcome=result.outcome,
        weight=weight,
        ground=float(summary.supports["wall.ground"].force[2]),
        top_mid_sinks=-float(summary.probes["top_mid"][2]),
        top_end_moves=float(summary.probes["top_end"][0]),
        von_mises=summary.stress.max_von_mises.value,
        marches=marches,
        amplification={name: float(rows[:, 1].max()) / weight for name, rows in marches.items()},
        final={name: float(rows[-1, 1]) / weight for name, rows in marches.items()},
    )
    if out is not None:
        plot(found, out / "ground.png")
    return found


def plot(found: LowWall, path: Path) -> Path:
    """Resultant on the ground in time."""
    figure = Figure(figsize=(9, 4.6), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.axhline(found.weight / 1e3, color="#33383f", lw=1.2, ls="--", label="true statics: the weight")
    for (name, rows), colour in zip(found.marches.items(), COLOURS, strict=True):
        label = f"{name}: at most {found.amplification[name]:.2f} × the weight"
        axes.plot(1e3 * rows[:, 0], rows[:, 1] / 1e3, color=colour, lw=1.7, label=label)
    last = next(iter(found.marches.values()))[-1, 0]
    axes.set(xlim=(0, 1e3 * last), ylim=(0, 2.6 * found.weight / 1e3))
    axes.set(xlabel="time [ms]", ylabel="vertical force on the ground [kN]")
    axes.set_title("Low wall whose weight appears at once")
    axes.legend(frameon=False, loc="upper right", ncols=2)
    axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    wall = main(out=Path("results/low_wall"))
    print(f"statics: {wall.outcome}, the ground carries {wall.ground:.3f} N of {wall.weight:.3f} N")
    print(f"top_mid sinks {wall.top_mid_sinks * 1e6:.4f} um, top_end moves {wall.top_end_moves * 1e6:.4f} um")
    print(f"greatest von Mises stress {wall.von_mises / 1e3:.2f} kPa")
    print("ground over weight      greatest  at the end")
    for march, greatest in wall.amplification.items():
        print(f"{march:22}{greatest:10.3f}{wall.final[march]:12.3f}")
