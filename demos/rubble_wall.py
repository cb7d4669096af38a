"""Rubble wall
===========

Geometry and material
    Free-standing wall 2.4 × 0.5 × 1.5 m of 120 rubble stones without mortar (*blocage*): cells about random
    points, 1.8 times as long as high, one or two in the thickness. The seed makes the same wall again.
    Rigid stones, 2200 kg/m³.
Load
    Its weight, 38.8 kN; then an acceleration across, as by tilting the ground.
What to look at
    The role of friction if no bed is level. With 0.6 the wall is nearly as good as one block; with 0.4 it
    bears less acceleration; with 0.3 almost none, as stones at an end are about to slide out; with 0.2 it
    falls apart under its weight (first picture: after 0.5 s), beginning at the ends, where no other stones
    hold it. If it is tilted too far, the rough wall overturns as one block and leaves stones of its base
    behind (second picture: at 1.1 times the load that it bears, after 0.7 s).
Reference
    One block tips at thickness / height = 0.3333 g. By limit analysis the wall bears 0.3305 g where friction
    is 0.6, 0.2782 g at 0.4 and 0.0071 g at 0.3; at 0.2 it cannot stand. Statics agrees: the wall
    rests at 0.98 of each and falls at 1.02; where friction is 0.2 it falls by its weight.
Cost
    45 seconds for all four; 40 for the fall and two minutes for the turn, with their pictures.

.. image:: /images/rubble_wall.png
   :width: 48%
.. image:: /images/rubble_wall_tilted.png
   :width: 48%

.. literalinclude:: rubble_wall.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/rubble_wall.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from masonry_fem import load, run, solve
from masonry_fem.analyses.limit import analyse

SCENE = Path(__file__).with_suffix(".toml")
SIZE = (2.4, 0.5, 1.5)  # [m]
WEIGHT = 2200 * 9.81 * SIZE[0] * SIZE[1] * SIZE[2]  # [N]
ONE_BLOCK = SIZE[1] / SIZE[2]  # acceleration across that tips it, over g
FALL = (
    "title='Rubble wall of little friction, after 0.5 s'",
    "joints.0.friction=0.2",
    "analysis={kind='dynamics', step=1e-2, duration=0.5, theta=1.0}",
    "solver.tolerance=1e-5",
    "output={amplification=1.0, fields=false}",
)
TURN = (
    "analysis={kind='dynamics', step=2e-2, duration=0.7, theta=1.0}",
    "solver.tolerance=2e-5",
    "output={amplification=1.0, fields=false}",
)


@dataclass(frozen=True, slots=True)
class Rubble:
    """The wall with one friction.

    Attributes
    ----------
    friction : μ. outcome : Of statics under its weight.
    moving : Number of stones that fall. ground : Vertical reaction [N].
    admitted : Whether limit analysis admits its weight.
    tilt : Acceleration across that it bears by limit analysis, over g; 0 where not even its weight.
    below, beyond : Outcomes of statics with 0.98 and 1.02 of it; empty where there is none.
    natural_map : Error of the contact laws.
    """

    friction: float
    outcome: str
    moving: int
    ground: float
    admitted: bool
    tilt: float
    below: str
    beyond: str
    natural_map: float


def main(
    *,
    out: Path | None = None,
    stones: int = 120,
    seed: int = 1,
    frictions: tuple[float, ...] = (0.6, 0.4, 0.3, 0.2),
) -> list[Rubble]:
    """Statics and limit analysis for each friction; the fall is pictured in ``out/falls``."""
    size = (f"structures.rubble.stones={stones}", f"structures.rubble.seed={seed}")
    walls = [_read(friction, size) for friction in frictions]
    if out is not None:
        run(load(SCENE, overrides=(*size, *FALL)), out / "falls")
        title = f"title='Rubble wall at 1.1 × {walls[0].tilt:.4f} g across, after 0.7 s'"
        across = _across(1.1 * walls[0].tilt)
        run(load(SCENE, overrides=(*size, *TURN, across, title)), out / "tilted")
    return walls


def _across(factor: float) -> str:
    """The load of an acceleration across of so many g."""
    return f"loads.accelerations=[{{vector=[0.0, {factor * 9.81}, 0.0]}}]"


def _read(friction: float, size: tuple[str, ...]) -> Rubble:
    changes = (*size, f"joints.0.friction={friction}")
    scene = load(SCENE, overrides=changes)
    summary = solve(scene).summary
    told = analyse(scene, tilt="y")
    below = beyond = ""
    if told.admissible:
        below, beyond = (
            solve(load(SCENE, overrides=(*changes, _across(share * told.multiplier)))).outcome
            for share in (0.98, 1.02)
        )
    return Rubble(
        friction=friction,
        outcome=summary.outcome,
        moving=len(summary.moving),
        ground=float(summary.supports["rubble.ground"].force[2]),
        admitted=bool(told.admissible),
        tilt=float(told.multiplier) if told.admissible else 0.0,
        below=below,
        beyond=beyond,
        natural_map=float(summary.certificate.natural_map),
    )


if __name__ == "__main__":
    print(f"weight {WEIGHT / 1e3:.3f} kN; one block tips at {ONE_BLOCK:.4f} g")
    for wall in main(out=Path("results/rubble_wall")):
        words = (
            f"bears {wall.tilt:.4f} g across: {wall.below}, {wall.beyond}"
            if wall.admitted
            else f"{wall.moving} stones fall"
        )
        print(f"friction {wall.friction:3.1f}  {wall.outcome:15s} {words}")
