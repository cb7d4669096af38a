"""Stone that is split
===================

Geometry and material
    A prism of sandstone, H = 20 cm wide and high, between two steel strips of b = 4 cm; plane strain. It
    cracks by the law ``brittle_damage``: tensile strength 3.7 MPa, fracture energy 110 J/m².
Load
    The force P on the upper strip grows by 1 MN/m in 1.5 ms. Dynamics in steps of 10 µs, θ = 1: a crack
    that runs sets more energy free than it takes, so that no state of rest follows the peak.
What to look at
    The strips squeeze the stone and pull its middle apart. Cracks begin at 1.38 MN/m; at 1.48 MN/m the
    stone splits, and within some 130 µs it has parted in two halves. Below the strips remains a core.
Reference
    A disc of diameter H under line loads has the tension 2 P/(π H) along its middle line, and would
    split at 1.16 MN/m. Strips spread the load, and rigid ones press most with their edges: the stone
    cracks later, here with 15 elements along H.
Cost
    20 seconds.

.. image:: /images/split_stone.png

.. literalinclude:: split_stone.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/split_stone.png"

from __future__ import annotations

import csv
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
HEIGHT, STRENGTH = 0.2, 3.7e6
DISC = np.pi * HEIGHT * STRENGTH / 2  # splits a disc under line loads [N/m]


@dataclass(frozen=True, slots=True)
class Splitting:
    """When the stone cracks.

    Attributes
    ----------
    outcome : ``finished``.
    first, greatest : Force of the floor's strip when the first element cracks, and the greatest one [N/m].
    wider : How much wider the stone is at the end [m].
    taken : Energy that the cracks took [J/m]. damage : Greatest damage.
    """

    outcome: str
    first: float
    greatest: float
    wider: float
    taken: float
    damage: float


def main(*, out: Path | None = None, cells: int = 15, step: float = 1e-5) -> Splitting:
    """The stone with so many elements along its height, in steps of ``step`` [s]; pictures go to ``out``."""
    changes = (
        f"structures.stone.mesh.divisions=[{cells}, {cells}]",
        f"analysis.step={step}",
        f"output.pictures={str(out is not None).lower()}",
    )
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        result = run(load(SCENE, overrides=changes), folder)
        with (folder / "history.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    force, taken, right, left = (
        np.array([float(row[name]) for row in rows])
        for name in ("support_resultants.below_fy", "material_dissipation", "probes.right_x", "probes.left_x")
    )
    return Splitting(
        outcome=result.outcome,
        first=float(force[np.argmax(taken > 0)]),
        greatest=float(force.max()),
        wider=float(right[-1] - left[-1]),
        taken=float(taken.sum()),
        damage=max(one.greatest for one in result.summary.stress.yielded),
    )


if __name__ == "__main__":
    stone = main(out=Path("results/split_stone"))
    print(
        f"{stone.outcome}: the stone cracks at {stone.first / 1e6:.2f} MN/m (a disc at {DISC / 1e6:.2f}); "
        f"its cracks take {stone.taken:.0f} J/m, and it is {1e3 * stone.wider:.2f} mm wider"
    )
