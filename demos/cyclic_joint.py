"""Joint in cyclic shear
======================

Geometry and material
    Two bricks of 0.2 × 0.05 m, plane, one metre deep, with a joint of mortar between them: a layer of
    82 and 36 MPa/mm in series with adhesion of 0.25 MPa and 18 J/m² in tension, 0.35 MPa and 125 J/m² in
    shear, friction 0.75 (the joints of the shear wall J4D).
Load
    A constant pressure of 0.1, 0.3 or 0.5 MPa, and two jaws without friction that move the upper brick
    to and fro by 2 mm, twice: the direct shear test of Atkinson and others (1989).
What to look at
    The first slide has a peak, as high as cohesion and friction together, and dissipates the fracture energy.
    From then on the loops are rectangles of ± μ σ: no strength comes back, unloading is as stiff as the
    mortar, and each loop dissipates the same heat.
Reference
    Peak c + μ σ = 0.725 MPa, plateau μ σ = 0.375 MPa under 0.5 MPa. A loop's area is
    4 μ σ (A − μ σ/k_T) = 2984.375 J/m² with the amplitude A = 2 mm; the energy balance has the same as
    friction, to 0.02 %. The damage of the first slide is 125 J/m²: 125.33 in 400 steps, 125.08 in 800.
Cost
    3 seconds for each pressure with 400 steps.

.. image:: /images/cyclic_joint.png

.. literalinclude:: cyclic_joint.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/cyclic_joint.png"

from __future__ import annotations

import csv
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
LENGTH, FRICTION, COHESION, SHEAR_STIFFNESS = 0.2, 0.75, 0.35e6, 36e9
TURNS = (0.25, 0.65)  # load factors at which a loop begins and ends
COLOURS = ("#1f5fa8", "#e07b1a", "#1b7f5c")


@dataclass(frozen=True, slots=True)
class Loops:
    """What ``history.csv`` and ``summary.json`` of a run tell, per area of the joint.

    Attributes
    ----------
    pressure : σ [Pa]. outcome : Of the run.
    slide, shear : Displacement of the upper brick [m] and shear stress [Pa], shape (steps + 1,).
    rubbed, damaged : Lost to friction and to damage so far [J/m²], shape (steps + 1,).
    peak, plateau : Greatest shear stress at first, and from the first turn on [Pa].
    area : Of the loop between the turns, force against slide [J/m²].
    lost : In that loop, by the ledger [J/m²]. energy_error : Imbalance of the ledger.
    """

    pressure: float
    outcome: str
    slide: np.ndarray
    shear: np.ndarray
    rubbed: np.ndarray
    damaged: np.ndarray
    peak: float
    plateau: float
    area: float
    lost: float
    energy_error: float

    @property
    def exact_area(self) -> float:
        """Of the loop by the formula [J/m²]."""
        plateau = FRICTION * self.pressure
        return 4 * plateau * (float(self.slide.max()) - plateau / SHEAR_STIFFNESS)


def main(
    *, out: Path | None = None, pressures: tuple[float, ...] = (0.1e6, 0.3e6, 0.5e6), steps: int = 400
) -> tuple[Loops, ...]:
    """Shear the joint under each of the ``pressures`` [Pa], in ``steps`` (a multiple of 20)."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        found = tuple(
            sheared(pressure, steps, folder / f"{pressure / 1e3:.0f}_kPa") for pressure in pressures
        )
    if out is not None:
        plot(found, out / "cyclic_joint.png")
    return found


def sheared(pressure: float, steps: int, folder: Path) -> Loops:
    """One test, read from what the run has written."""
    settings = (
        f"loads.tractions.0.vector=[0.0, {-pressure}]",
        f"analysis.load_steps={steps}",
        "output.pictures=false",
    )
    run(load(SCENE, overrides=settings), folder)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def column(name: str) -> np.ndarray:
        return np.array([0.0, *(float(row[name]) for row in rows)])

    time, slide = column("time"), column("probes.high_x")
    shear = -column("support_resultants.low_fx") / LENGTH
    rubbed = np.cumsum(column("friction_dissipation")) / LENGTH
    damaged = np.cumsum(column("joint_dissipation")) / LENGTH
    begin, end = (int(np.abs(time - turn).argmin()) for turn in TURNS)
    loop = slice(begin, end + 1)
    return Loops(
        pressure=pressure,
        outcome=summary["outcome"],
        slide=slide,
        shear=shear,
        rubbed=rubbed,
        damaged=damaged,
        peak=float(shear.max()),
        plateau=float(np.abs(shear[begin:]).max()),
        area=float(np.trapezoid(shear[loop], slide[loop])),
        lost=float((rubbed + damaged)[end] - (rubbed + damaged)[begin]),
        energy_error=summary["certificate"]["energy_balance"],
    )


def plot(found: tuple[Loops, ...], path: Path) -> Path:
    """Loops, and where their energy went."""
    figure = Figure(figsize=(10, 4.2), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    for one, colour in zip(found, COLOURS, strict=False):
        name = f"{one.pressure / 1e6:g} MPa"
        travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(one.slide)))])
        left.plot(1e3 * one.slide, one.shear / 1e6, color=colour, lw=1.8, label=name)
        right.plot(1e3 * travelled, one.rubbed, color=colour, lw=1.8, label=f"friction, {name}")
    right.plot(1e3 * travelled, one.damaged, color="#22262b", lw=1.2, ls="--", label=f"damage, {name}")
    left.set(xlabel="slide [mm]", ylabel="shear stress [MPa]", title="Shear to and fro")
    low, high = left.get_ylim()
    left.set_ylim(low, high + 0.16 * (high - low))
    left.legend(frameon=False, loc="upper right", title="pressure", ncols=3)
    right.set(xlabel="path slid [mm]", ylabel="energy lost [J/m²]", title="Where the energy goes")
    right.legend(frameon=False)
    for axes in (left, right):
        axes.axhline(0.0, color="#c8ccd2", lw=0.8, zorder=0)
        axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    print("pressure   peak  plateau [MPa]   loop: area  exact  lost [J/m²]   damage [J/m²]")
    for test in main(out=Path("results/cyclic_joint")):
        print(
            f"{test.pressure / 1e6:8.1f}{test.peak / 1e6:7.3f}{test.plateau / 1e6:9.3f}"
            f"{test.area:18.3f}{test.exact_area:11.3f}{test.lost:10.3f}{test.damaged[-1]:14.3f}"
        )
