"""Speed against accuracy
======================

Geometry and material
    Portal of nine voussoirs, 25 cm thick and 2 m in span, on piers of two courses, 60 cm wide; limestone of
    10 GPa and 2400 kg/m³; dry joints with friction 0.6. A plane metre of it.
Load
    Its weight and 3 % of it sideways, in one step of true statics.
What to look at
    The study runs meshes of 20, 10, 5 and 2.5 cm, two tolerances of the contact solver, rigid and elastic
    stones: 16 settings. ``pareto.png``: error against CPU time. Rigid stones give the forces on the ground to
    1.2 % and their thrust to 10 %; elements of 10 cm give the thrust to 1 % at half the cost of 2.5 cm, and
    the latter give the displacement of the crown to 3 %. The tolerance hardly affects error or cost.
Reference
    A run with quadratic elements of 1.25 cm: errors of recommended settings do not exceed their bounds.
Cost
    20 seconds of CPU.

.. image:: /images/portal_study.png

.. literalinclude:: portal_study.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/portal_study.png"

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from masonry_fem import load, solve, study
from masonry_fem.analyses.study.comparison import distance
from masonry_fem.analyses.study.quantity import measured

SCENE = Path(__file__).with_suffix(".toml")
SIZES = (0.2, 0.1, 0.05, 0.025)
TOLERANCES = (1e-3, 1e-8)


@dataclass(frozen=True, slots=True)
class PortalStudy:
    """What the study advises for the thrust.

    Attributes
    ----------
    cells : Settings run. words : The advice. settings : What to use.
    bound : What the error of these is not expected to exceed. error : What it is; None: not asked for.
    cheaper : CPU time of the finest cell over theirs.
    """

    cells: int
    words: str
    settings: dict[str, str] | None
    bound: float | None
    error: float | None
    cheaper: float | None


def main(
    *,
    out: Path | None = None,
    sizes: Sequence[float] = SIZES,
    accuracy: float = 0.01,
    truth: float | None = None,
) -> PortalStudy:
    """Study the portal; ``truth`` is the size of quadratic elements to compare the advice with [m]."""
    vary = {"mesh.size": sizes, "solver.tolerance": TOLERANCES, "fidelity": ["rigid", "elastic"]}
    with tempfile.TemporaryDirectory() as scratch:
        made = study(SCENE, vary, out=out or Path(scratch), accuracy=accuracy)
        if out is not None:
            made.write()
    advice = next(one for one in made.recommendations if one.target == "thrust")
    error = None
    if truth is not None and advice.settings is not None:
        exact = measured(solve(load(SCENE, [f"mesh.size={truth}", "mesh.element=Q2"])))
        row = next(row for row in made.rows if row.cell.settings == advice.settings)
        names = [name for name in exact if name.startswith("thrust.")]
        error = max(distance(row.quantities[name], exact[name]) for name in names)
    return PortalStudy(len(made.rows), advice.words, advice.settings, advice.bound, error, advice.cheaper)


if __name__ == "__main__":
    found = main(out=Path("results/portal_study"), truth=0.0125)
    print(f"{found.cells} settings: {found.words}")
    print(f"true error of the thrust {100 * (found.error or 0.0):.2f} %")
