"""Wall whose stones may crack
===========================

Geometry and material
    A wall of sandstone, 1.00 × 0.90 m and 0.2 m thick: nine courses of sawn stones of 20 × 10 cm without
    mortar, friction 0.62. Plane stress. Stones of 15.5 GPa are elastic until they come near to their
    strength (fidelity ``auto``), and then crack by the law ``brittle_damage``. Joints close under pressure.
Load
    100 kN, and then 30 kN, on a beam that may turn. A jack pushes the beam by 10 mm at its half height.
What to look at
    The wall opens along a stepped diagonal and turns over its toe. Under 100 kN the lowest stone at the toe
    bears most of the load on two corners, and is bent: it cracks at 49 kN, through all of its height. The
    force still grows to 51.0 kN at 6.1 mm, and then falls slowly, as the wall leans. Other stones use up to
    three quarters of their strength. Under 30 kN no stone uses more than half of it.
Reference
    Two tests each of Lourenço et al. (2005), from the collection of Vanin et al. (2017). Under 100 kN: peaks
    of 41.5 kN at 10.1 mm and 48.2 kN at 7.0 mm, in the mean 44.9 kN, of which the computed one is 14 % more.
    Under 30 kN: computed 16.2 kN at 7.9 mm; the first wall bore 17.1 kN at 7.4 mm, then less, and at 25 mm
    21.5 kN, the second one 22.7 kN at 8.8 mm, where no more than 17.5 kN balance about the toe. Not measured,
    and assumed: the tensile strength, 3 MPa, its fracture energy, 100 J/m², Poisson's ratio, and the
    stiffness of joints in shear. ``docs/strength.md`` has what other strengths and energies give.
Cost
    Three minutes of CPU time, and one for the lighter load.

.. image:: /images/cracking_wall.png

.. image:: /images/cracking_wall_damage.png

.. image:: /images/cracking_wall_30.png

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

from masonry_fem import load as load_scene
from masonry_fem import run

SCENE = Path(__file__).with_suffix(".toml")
LENGTH, HEIGHT, THICKNESS, ARM = 1.0, 1.1, 0.2, 1.0  # of the wall with its beam, and of the jack [m]
DENSITY, G = 2300.0, 9.81
# tests by vertical load [kN], and displacements [mm] and forces [kN] of their peaks
WALLS = {
    100: {"SW.100.1": (10.1, 41.5), "SW.100.2": (7.0, 48.2)},
    30: {"SW.30.1": (25.1, 21.5), "SW.30.2": (8.8, 22.7)},
}
SHOWN = {100: 12.0, 30: 28.0}  # displacements in the pictures [mm]
COLOURS = ("#e07b1a", "#2a8a4a")


@dataclass(frozen=True, slots=True)
class Pushed:
    """How the wall gives way.

    Attributes
    ----------
    load : Vertical [kN]. outcome : ``equilibrium`` or another.
    top : Displacement of the beam [mm], shape (steps,). force : Of the jack [kN], shape (steps,).
    cracked : Names of the stones that have cracked.
    """

    load: int
    outcome: str
    top: np.ndarray
    force: np.ndarray
    cracked: tuple[str, ...]

    @property
    def peak(self) -> tuple[float, float]:
        """Displacement [mm] and greatest force [kN]."""
        most = int(self.force.argmax())
        return float(self.top[most]), float(self.force[most])


def main(
    *, out: Path | None = None, loads: Sequence[int] = tuple(WALLS), changes: Sequence[str] = ()
) -> tuple[Pushed, ...]:
    """Push the wall under each of the ``loads`` [kN], with ``changes`` of its scene; pictures to ``out``."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        found = []
        for load in loads:
            own = folder / f"SW.{load}"
            found.append(pushed(load, own, (f"output.pictures={str(out is not None).lower()}", *changes)))
            if out is not None:
                plot(found[-1], own / "wall.png")
    return tuple(found)


def pushed(load: int, folder: Path, changes: Sequence[str] = ()) -> Pushed:
    """One wall, read from what its run has written."""
    vertical = f"loads.points.0.vector=[0.0, {-1e3 * load / THICKNESS}]"
    result = run(load_scene(SCENE, overrides=(vertical, *changes)), folder)
    with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    top, force = (
        np.array([float(row[name]) for row in rows])
        for name in ("probes.top_x", "support_resultants.jack_fx")
    )
    told = result.summary.stress
    cracked = () if told is None else tuple(one.block for one in told.yielded if one.measure == "damage")
    return Pushed(load, result.outcome, 1e3 * top, 1e-3 * THICKNESS * force, cracked)


def balance(load: float) -> float:
    """Horizontal force [kN] that the vertical ``load`` [kN] and all weight balance about the toe."""
    weight = 1e-3 * DENSITY * G * LENGTH * HEIGHT * THICKNESS
    return (load + weight) * LENGTH / 2 / ARM


def measured(load: int) -> dict[str, np.ndarray]:
    """Displacements [mm] and forces [kN] of the tests, (points, 2), where their files are at hand.

    They are searched for in ``data/walls`` of the folder that MASONRY_FEM_SHARED names.
    """
    folder = Path(os.environ.get("MASONRY_FEM_SHARED", "shared")) / "data" / "walls"
    files = {name: folder / f"envelope_{name}.csv" for name in WALLS[load]}
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
    curves = measured(found.load)
    for (name, (at, most)), colour in zip(WALLS[found.load].items(), COLOURS, strict=True):
        if name in curves:
            axes.plot(*curves[name].T, ".", color=colour, ms=4)
        axes.plot(at, most, "*", color=colour, ms=13, label=f"test {name}: peak of {most:g} kN")
    axes.plot(
        found.top, found.force, color="#1f5fa8", lw=2, label=f"computed: peak of {found.peak[1]:.1f} kN"
    )
    axes.axhline(
        balance(found.load), color="#22262b", lw=1.0, ls="--",
        label=f"balance about the toe: {balance(found.load):.1f} kN",
    )  # fmt: skip
    axes.set(
        xlim=(0.0, SHOWN[found.load]), xlabel="displacement of the beam [mm]", ylabel="horizontal force [kN]",
        title=f"Wall of dry sandstone under {found.load} kN",
    )  # fmt: skip
    axes.set_ylim(bottom=0.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    return path


if __name__ == "__main__":
    for wall in main(out=Path("results/cracking_wall")):
        print(
            f"{wall.load} kN, {wall.outcome}: peak of {wall.peak[1]:.1f} kN at {wall.peak[0]:.1f} mm, "
            f"cracked: {', '.join(wall.cracked) or 'none'}; tests: "
            + ", ".join(f"{force} kN at {at} mm" for at, force in WALLS[wall.load].values())
        )
