"""Wall whose stones may crack
===========================

Geometry and material
    A wall of sandstone, 1.00 × 0.90 m and 0.2 m thick: nine courses of sawn stones of 20 × 10 cm without
    mortar, friction 0.62. Plane stress. Stones of 15.5 GPa are elastic until they come near to their
    strength (fidelity ``auto``), and then crack by the law ``brittle_damage``. Joints close under pressure.
Load
    100 kN on a beam that may turn. A jack pushes the beam by 10 mm at its half height.
What to look at
    The wall opens along a stepped diagonal and turns over its toe. The lowest stone at the toe bears most of
    the load on two corners, and is bent: it cracks at 49 kN, through all of its height. The force still
    grows to 51.0 kN at 6.1 mm, and then falls slowly, as the wall leans. Other stones use up to three
    quarters of their strength.
Reference
    Two tests of Lourenço et al. (2005), from the collection of Vanin et al. (2017): peaks of 41.5 kN at
    10.1 mm and 48.2 kN at 7.0 mm, in the mean 44.9 kN, of which the computed one is 14 % more. Not measured,
    and assumed: the tensile strength, 3 MPa, its fracture energy, 100 J/m², Poisson's ratio, and the
    stiffness of joints in shear. ``docs/strength.md`` has what other strengths and energies give.
Cost
    Three minutes of CPU time.

.. image:: /images/cracking_wall.png

.. image:: /images/cracking_wall_damage.png

.. literalinclude:: cracking_wall.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/cracking_wall_damage.png"

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
THICKNESS = 0.2  # [m]
PEAKS = {"SW.100.1": (10.1, 41.5), "SW.100.2": (7.0, 48.2)}  # measured: displacement [mm], force [kN]
COLOURS = {"SW.100.1": "#e07b1a", "SW.100.2": "#2a8a4a"}


@dataclass(frozen=True, slots=True)
class Pushed:
    """How the wall gives way.

    Attributes
    ----------
    outcome : ``equilibrium`` or another.
    top : Displacement of the beam [mm], shape (steps,). force : Of the jack [kN], shape (steps,).
    cracked : Names of the stones that have cracked.
    """

    outcome: str
    top: np.ndarray
    force: np.ndarray
    cracked: tuple[str, ...]

    @property
    def peak(self) -> tuple[float, float]:
        """Displacement [mm] and greatest force [kN]."""
        most = int(self.force.argmax())
        return float(self.top[most]), float(self.force[most])


def main(*, out: Path | None = None, changes: Sequence[str] = ()) -> Pushed:
    """Push the wall, with ``changes`` of its scene; pictures go to ``out``."""
    settings = (f"output.pictures={str(out is not None).lower()}", *changes)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        result = run(load(SCENE, overrides=settings), folder)
        with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    top, force = (
        np.array([float(row[name]) for row in rows])
        for name in ("probes.top_x", "support_resultants.jack_fx")
    )
    told = result.summary.stress
    cracked = () if told is None else tuple(one.block for one in told.yielded if one.measure == "damage")
    found = Pushed(result.outcome, 1e3 * top, 1e-3 * THICKNESS * force, cracked)
    if out is not None:
        plot(found, out / "cracking_wall.png")
    return found


def measured() -> dict[str, np.ndarray]:
    """Displacements [mm] and forces [kN] of the tests, (points, 2), where their files are at hand.

    They are searched for in ``data/walls`` of the folder that MASONRY_FEM_SHARED names.
    """
    folder = Path(os.environ.get("MASONRY_FEM_SHARED", "shared")) / "data" / "walls"
    files = {name: folder / f"envelope_{name}.csv" for name in PEAKS}
    return {
        name: np.loadtxt(file, delimiter=",", skiprows=1, usecols=(0, 1))
        for name, file in files.items()
        if file.is_file()
    }


def plot(found: Pushed, path: Path) -> Path:
    """Force against displacement, with the peaks of the tests, and their curves where they are at hand."""
    figure = Figure(figsize=(7, 4.4), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for name, points in measured().items():
        axes.plot(*points.T, ".", color=COLOURS[name], ms=4)
    for name, (at, most) in PEAKS.items():
        axes.plot(at, most, "*", color=COLOURS[name], ms=13, label=f"test {name}: peak of {most:g} kN")
    axes.plot(
        found.top, found.force, color="#1f5fa8", lw=2, label=f"computed: peak of {found.peak[1]:.1f} kN"
    )
    axes.set(
        xlim=(0.0, 12.0), xlabel="displacement of the beam [mm]", ylabel="horizontal force [kN]",
        title="Wall of dry sandstone under 100 kN",
    )  # fmt: skip
    axes.set_ylim(bottom=0.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    wall = main(out=Path("results/cracking_wall"))
    print(
        f"{wall.outcome}: peak of {wall.peak[1]:.1f} kN at {wall.peak[0]:.1f} mm, cracked: "
        f"{', '.join(wall.cracked) or 'none'}; tests: "
        + ", ".join(f"{force} kN at {at} mm" for at, force in PEAKS.values())
    )
