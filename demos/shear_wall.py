"""Masonry shear wall
==================

Geometry and material
    The wall J4D of Raijmakers and Vermeltfoort (1992): 0.99 × 1.00 m, 0.1 m thick, 16 courses of 4.5 bricks
    in mortar, between steel beams. Plane stress, bricks of 16.7 GPa in two halves that may separate at 2 MPa
    and 80 J/m². Joints of 82 and 36 MPa/mm with adhesion of 0.25 MPa and 18 J/m² in tension, 0.35 MPa and
    125 J/m² in shear (Monerie and Acary's law), friction 0.75, mortar that crushes at 10.5 MPa: the numbers
    that Lourenço and Rots (1997) give.
Load
    A pressure of 0.30 MPa; then the upper beam is moved sideways by 4 mm, kept level and at its height.
What to look at
    Bed joints open at two opposite corners; stepped cracks run along the diagonal; the bricks on it crack,
    and the force drops. Struts remain that rotate about their ends.
Reference
    In the test about 50 kN at 2 mm. Here 61 to 63 kN at 1.8 mm with elastic bricks, then 41 to 44 kN. This is
    a quarter more, as bricks do not crush here and crushed mortar does not soften. As the beam is kept at its
    height, the wall jams again, up to 56 and 60 kN, and never has less than friction alone bears, 22.3 kN.
    With rigid bricks, whose elasticity is added to the joints, it is 66 kN at 1.6 mm; their struts crush
    later, at 75 kN, and 40 kN remain.
Cost
    145 s of CPU time with elements of half a half brick (0.06 m); on a busy core 230 s with 0.03 m and 230 s
    with rigid bricks, which have more contact points here.

.. image:: /images/shear_wall.png

.. image:: /images/shear_wall_cracked.png

.. literalinclude:: shear_wall.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/shear_wall_cracked.png"

from __future__ import annotations

import csv
import json
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
THICKNESS, LENGTH, PRESSURE, FRICTION = 0.1, 0.99, 0.30e6, 0.75
RESIDUAL = FRICTION * PRESSURE * LENGTH * THICKNESS  # of a wall that is cracked through [N]
FALL = 0.015  # of the greatest force, what must be lost to call it a peak
RIGID = (
    "structures.wall.fidelity=rigid",
    "joints.0.placement=gauss",
    "joints.0.density=2",
    "joints.1.placement=gauss",
    # the bricks' own elasticity, 62.5 mm of E and G, is the joints' then
    "joints.0.mortar.normal_stiffness=62.8e9",
    "joints.0.mortar.tangential_stiffness=27.5e9",
    "supports.0.motion.displacement=[0.0, -8.13e-5]",
)
VARIANTS = {"rigid": RIGID, "coarse": (), "fine": ("mesh.size=0.03",)}
COLOURS = {"rigid": "#8a8f98", "coarse": "#1f5fa8", "fine": "#e07b1a"}


@dataclass(frozen=True, slots=True)
class Curve:
    """What ``history.csv`` of a run tells of the whole wall.

    Attributes
    ----------
    variant : Name of the model. outcome : Of the run. seconds : CPU time.
    shift : Of the upper beam [m], shape (steps,).
    shear, pressing : Horizontal force and vertical force on the floor [N], shape (steps,).
    """

    variant: str
    outcome: str
    seconds: float
    shift: np.ndarray
    shear: np.ndarray
    pressing: np.ndarray

    @property
    def first_fall(self) -> int:
        """Step in which the force has fallen for the first time; the last one where it never does."""
        fallen = np.flatnonzero(self.shear < np.maximum.accumulate(self.shear) - FALL * self.shear.max())
        return int(fallen[0]) if len(fallen) else len(self.shear) - 1

    @property
    def peak(self) -> float:
        """Largest force before it falls for the first time [N]."""
        return float(self.shear[: self.first_fall + 1].max())

    @property
    def least(self) -> float:
        """Least force from then on [N]."""
        return float(self.shear[self.first_fall :].min())


def main(
    *,
    out: Path | None = None,
    variants: tuple[str, ...] = tuple(VARIANTS),
    steps: int = 100,
    end: float = 4e-3,
) -> tuple[Curve, ...]:
    """Shear each of the ``variants`` to ``end`` [m] in ``steps``, of which 4 % press."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        found = tuple(sheared(variant, steps, end, folder / variant, out is not None) for variant in variants)
    if out is not None:
        plot(found, out / "shear_wall.png")
    return found


def sheared(variant: str, steps: int, end: float, folder: Path, pictures: bool) -> Curve:
    """One run, read from what it has written."""
    settings = (
        *VARIANTS[variant],
        f"analysis.load_steps={steps}",
        f"supports.1.motion.displacement=[{end}, 0.0]",
        f"output.pictures={str(pictures).lower()}",
    )
    spent = time.process_time()
    run(load(SCENE, overrides=settings), folder)
    spent = time.process_time() - spent
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def column(name: str) -> np.ndarray:
        return np.array([float(row[name]) for row in rows])

    return Curve(
        variant=variant,
        outcome=summary["outcome"],
        seconds=spent,
        shift=column("probes.beam_x"),
        shear=-THICKNESS * column("support_resultants.floor_fx"),
        pressing=THICKNESS * column("support_resultants.floor_fy"),
    )


def plot(found: tuple[Curve, ...], path: Path) -> Path:
    """Force against displacement."""
    figure = Figure(figsize=(10, 4.2), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    for one in found:
        colour = COLOURS[one.variant]
        left.plot(1e3 * one.shift, one.shear / 1e3, color=colour, lw=1.8, label=one.variant)
        right.plot(1e3 * one.shift, one.pressing / 1e3, color=colour, lw=1.8, label=one.variant)
    left.axhline(RESIDUAL / 1e3, color="#22262b", lw=1.0, ls="--")
    left.annotate("friction alone, μ N", (0.05, RESIDUAL / 1e3 - 3.2), color="#22262b", fontsize=9)
    left.set(xlabel="shift of the beam [mm]", ylabel="horizontal force [kN]", title="Shear")
    right.set(
        xlabel="shift of the beam [mm]", ylabel="vertical force [kN]", title="What the locked beam presses"
    )
    for axes in (left, right):
        axes.set_ylim(bottom=0.0)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, title="bricks", loc="lower right")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    print("bricks   first peak [kN]   at [mm]   least after [kN]   CPU [s]")
    for wall in main(out=Path("results/shear_wall")):
        at = 1e3 * wall.shift[wall.shear[: wall.first_fall + 1].argmax()]
        print(
            f"{wall.variant:8}{wall.peak / 1e3:16.1f}{at:10.2f}{wall.least / 1e3:19.1f}{wall.seconds:10.0f}"
        )
