"""Dry-stone arch
==============

Geometry and material
    Semicircular arch of 11 equal voussoirs: mean radius 1 m, thickness 0.2 m, depth 0.3 m; limestone of
    10 GPa, 2400 kg/m³, strengths of 40 and 3 MPa; dry joints with friction 0.6; springings on fixed supports.
Load
    Its weight, 4.43 kN, in one step of true statics.
What to look at
    ``overview.png``: the deformed shape × 30 000. The crown sinks; its joints open at the intrados and those
    of the haunches at the extrados, and the resultants pass through the parts that stay closed.
    ``principal_stresses.png``: crosses at the block centres, with compression along the arc and almost none
    across it. ``thrust.png`` and ``interfaces.csv``: where the thrust leaves the middle third.
    ``report.html``: all of it in one file; what share of its strength each stone uses.
Reference
    Limit analysis of the same stones: the thrust of any equilibrium lies in [665.7, 1130.3] N.
    The elastic arch has one value in this interval, 0.196 of the weight.
Cost
    2 seconds to solve, 10 to draw.

.. image:: /images/arch.png
.. image:: /images/arch_principal_stresses.png
.. image:: /images/arch_thrust.png

.. literalinclude:: arch.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/arch.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run, solve
from masonry_fem.results.summary import Certificate

SCENE = Path(__file__).with_suffix(".toml")
THRUSTS = (665.7, 1130.3)  # [N], of rigid voussoirs of the same size


@dataclass(frozen=True, slots=True)
class Arch:
    """Reactions [N], stresses [Pa] and displacements [m] of the arch.

    Attributes
    ----------
    outcome : ``equilibrium``.
    thrust : Horizontal force of a springing. vertical : Both vertical forces, shape (2,).
    weight : What they carry.
    compression, tension : Extreme principal mean stresses of a voussoir among the most stressed.
    sinking : Of the crown, downwards.
    certificate : Error measures.
    linear_solves : Of the contact solver.
    """

    outcome: str
    thrust: float
    vertical: np.ndarray
    weight: float
    compression: float
    tension: float
    sinking: float
    certificate: Certificate
    linear_solves: int


def main(
    *, out: Path | None = None, divisions: tuple[int, int, int] = (6, 3, 8), friction: float = 0.6
) -> Arch:
    """Bring the arch to equilibrium."""
    settings = (f"mesh.divisions={list(divisions)}", f"joints.0.friction={friction}")
    scene = load(SCENE, overrides=settings)
    result = solve(scene) if out is None else run(scene, out)
    summary = result.summary
    left, right = (np.array(summary.supports[f"arch.springing_{s}"].force) for s in ("left", "right"))
    principal = np.array([block.principal for block in summary.stress.blocks])
    return Arch(
        outcome=result.outcome,
        thrust=float(np.abs(left[0])),
        vertical=np.array([left[2], right[2]]),
        weight=-float(summary.applied[2]),
        compression=float(principal.min()),
        tension=float(principal.max()),
        sinking=-float(summary.probes["crown"][2]),
        certificate=summary.certificate,
        linear_solves=summary.solver.linear_solves,
    )


if __name__ == "__main__":
    arch = main(out=Path("results/arch"))
    print(f"{arch.outcome} in {arch.linear_solves} linear solves")
    print(f"thrust             {arch.thrust:9.1f} N, limit analysis allows {THRUSTS[0]} to {THRUSTS[1]} N")
    print(
        f"vertical reactions {arch.vertical[0]:9.1f} and {arch.vertical[1]:.1f} N, weight {arch.weight:.1f} N"
    )
    print(f"mean stresses      {arch.compression / 1e3:9.1f} to {arch.tension / 1e3:.1f} kPa")
    print(f"crown sinks        {arch.sinking * 1e6:9.2f} um")
    print(f"natural map        {arch.certificate.natural_map:9.1e}")
