"""Tower under its own weight
==========================

Geometry and material
    Square tower, 8 m wide and 19.2 m high, of 406 elastic ashlars 1.6 × 0.8 × 0.8 m, bonded at the corners;
    a door and eleven slits with lintels. Simplified geometry of the Tour Saint-Laurent. 10 GPa,
    2400 kg/m³, friction 0.6, all joints dry.
Load
    Its weight, 9.55 MN, in one step of true statics.
What to look at
    Vertical stress in the middle plane of the front wall (first picture): it grows with depth and runs around
    the openings; above the sills, where joints open, there is none. Lintels transfer the load to the jambs.
    The door's jambs have the greatest stress.
Reference
    Weight by hand 405.5 m³ · ρ g = 9.547 MN; over the base of 21.76 m² it is 438.7 kPa on average. A prism
    without openings sinks by ρ g H² / 2E = 434 µm at its top; this tower by 478 µm.
Cost
    5 seconds and 0.6 GB to solve, 16 seconds to draw.

.. image:: /images/tower_cut.png
   :width: 48%
.. image:: /images/tower.png
   :width: 48%

.. literalinclude:: tower.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/tower.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from masonry_fem import load, run, solve
from masonry_fem.results.summary import Certificate

SCENE = Path(__file__).with_suffix(".toml")
SPECIFIC_WEIGHT, YOUNG = 2400 * 9.81, 10e9
SIDE, THICKNESS, HEIGHT = 8.0, 0.8, 19.2  # [m]
OPENING = (1.6, 2.4)  # each of twelve [m]
RING = SIDE**2 - (SIDE - 2 * THICKNESS) ** 2  # [m²]
FOOT = RING - OPENING[0] * THICKNESS  # less the door [m²]
WEIGHT = SPECIFIC_WEIGHT * (RING * HEIGHT - 12 * OPENING[0] * OPENING[1] * THICKNESS)  # [N]
SINKING = SPECIFIC_WEIGHT * HEIGHT**2 / (2 * YOUNG)  # of a prism's top [m]


@dataclass(frozen=True, slots=True)
class Tower:
    """The tower at rest.

    Attributes
    ----------
    outcome : ``equilibrium``. weight, ground : As applied, and the ground's reaction [N].
    pressure : Mean on the foot [Pa]. area : Of the foot's joints [m²].
    compression, tension : Greatest principal stresses [Pa] with their blocks.
    sinking : Of the top of the back wall [m].
    certificate : Error measures.
    """

    outcome: str
    weight: float
    ground: float
    pressure: float
    area: float
    compression: tuple[float, str]
    tension: tuple[float, str]
    sinking: float
    certificate: Certificate


def main(*, out: Path | None = None, divisions: tuple[int, int, int] = (2, 1, 1)) -> Tower:
    """Bring the tower to rest."""
    scene = load(SCENE, overrides=(f"mesh.divisions={list(divisions)}",))
    result = solve(scene) if out is None else run(scene, out)
    summary, model = result.summary, result.built.model
    ground = model.assembly.blocks.index(next(one for one in model.assembly.blocks if one.support))
    area = float(sum(one.area for one in model.interfaces if ground in one.blocks))
    force = float(summary.supports["ground"].force[2])
    least, greatest = summary.stress.min_principal, summary.stress.max_principal
    return Tower(
        outcome=result.outcome,
        weight=-float(summary.applied[2]),
        ground=force,
        pressure=force / area,
        area=area,
        compression=(float(least.value), least.block),
        tension=(float(greatest.value), greatest.block),
        sinking=-float(summary.probes["top"][2]),
        certificate=summary.certificate,
    )


if __name__ == "__main__":
    tower = main(out=Path("results/tower"))
    print(f"{tower.outcome}; natural map {tower.certificate.natural_map:.1e}")
    print(f"ground carries {tower.ground / 1e6:.4f} MN, weight by hand {WEIGHT / 1e6:.4f} MN")
    print(f"on the foot    {tower.pressure / 1e3:.1f} kPa on average, by hand {WEIGHT / FOOT / 1e3:.1f} kPa")
    print(f"compression up to {-tower.compression[0] / 1e3:.0f} kPa in {tower.compression[1]}")
    print(f"tension up to     {tower.tension[0] / 1e3:.0f} kPa in {tower.tension[1]}")
    print(f"top sinks by {tower.sinking * 1e6:.0f} um, a prism without openings by {SINKING * 1e6:.0f} um")
