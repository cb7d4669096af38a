"""Arch from a mesh file
=====================

Geometry and material
    ``meshes/keystone_arch.msh``, drawn and meshed with gmsh: seven irregular voussoirs, a keystone that
    rises above the others, two piers of two courses, two footings. Span 2 m, thickness 0.3 m, depth
    0.4 m; 15 GPa, 2300 kg/m³, friction 0.6. Each physical volume is a block, the named surface
    ``keystone_top`` a face that takes a load; the footings are supports.
Load
    Its weight and 5 kPa on the keystone.
What to look at
    The meshes of neighbours do not match at the keystone and at the springings and are joined by contact
    alone. The thrust leaves the middle of the piers and opens their joints on the inner side.
Reference
    The stones as drawn weigh 21 857.8 N and the keystone carries 807.2 N: the footings bear 22 665.0 N.
    The thrust is below the friction of the base and the resultant crosses it within the pier.
Cost
    2 seconds to solve, 10 to draw.

.. image:: /images/keystone.png

.. literalinclude:: keystone.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/keystone.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run, solve
from masonry_fem.results.summary import Certificate

SCENE = Path(__file__).with_suffix(".toml")
ANGLES = np.radians([28, 24, 30, 16, 27, 26, 29])  # of the voussoirs, the keystone fourth
INNER, OUTER, KEY_OUTER, DEPTH = 1.0, 1.3, 1.45, 0.4  # [m]
PIERS = 4 * 0.55 * 0.6  # cross-section of their courses [m²]


@dataclass(frozen=True, slots=True)
class Keystone:
    """What the footings carry.

    Attributes
    ----------
    outcome : ``equilibrium``.
    left, right : Forces of the footings [N], shape (3,).
    load, exact_load : Weight and pressure as applied and by hand [N].
    eccentricity : Of the left base's resultant from the pier's middle, over its width, outwards.
    sinking : Of the keystone [m].
    certificate : Error measures.
    """

    outcome: str
    left: np.ndarray
    right: np.ndarray
    load: float
    exact_load: float
    eccentricity: float
    sinking: float
    certificate: Certificate


def main(*, out: Path | None = None, pressure: float = 5e3, friction: float = 0.6) -> Keystone:
    """Load the keystone with ``pressure`` [Pa] and bring the arch to equilibrium."""
    settings = (f"loads.tractions.0.vector=[0.0, 0.0, {-pressure}]", f"joints.0.friction={friction}")
    scene = load(SCENE, overrides=settings)
    base = SCENE.parent
    result = solve(scene, base) if out is None else run(scene, out, base=base)
    summary = result.summary
    footing = summary.supports["arch.footing_left"]
    force, moment = np.array(footing.force), np.array(footing.moment)
    # the resultant crosses the base, z = -1.2 m, at x with M_y = z F_x - x F_z
    base_x = (-1.2 * force[0] - moment[1]) / force[2]
    return Keystone(
        outcome=result.outcome,
        left=force,
        right=np.array(summary.supports["arch.footing_right"].force),
        load=-float(summary.applied[2]),
        exact_load=exact_load(pressure),
        eccentricity=(-1.225 - base_x) / 0.55,
        sinking=-float(summary.probes["keystone"][2]),
        certificate=summary.certificate,
    )


def exact_load(pressure: float) -> float:
    """Weight of the stones as drawn, straight between their corners, and the pressure's resultant [N]."""
    outer = np.full(len(ANGLES), OUTER)
    outer[3] = KEY_OUTER
    arch = float((0.5 * (outer**2 - INNER**2) * np.sin(ANGLES)).sum())
    top = 2 * KEY_OUTER * np.sin(ANGLES[3] / 2) * DEPTH
    return 2300 * 9.81 * DEPTH * (arch + PIERS) + float(top) * pressure


if __name__ == "__main__":
    arch = main(out=Path("results/keystone"))
    print(f"{arch.outcome}; natural map {arch.certificate.natural_map:.1e}")
    print(f"footings carry   {arch.left[2] + arch.right[2]:9.1f} N, load by hand {arch.exact_load:.1f} N")
    print(f"thrust           {arch.left[0]:9.1f} N")
    print(f"base resultant   {arch.eccentricity:9.3f} of the width outside the pier's middle")
    print(f"keystone sinks   {arch.sinking * 1e6:9.2f} um")
