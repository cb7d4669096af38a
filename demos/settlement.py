"""Settlement under a wall with a window
=====================================

Geometry and material
    Wall of 4.8 m and 2.7 m in running bond, stones of 60 cm and 30 cm, rigid, dry, μ = 0.65, with a window
    under a lintel. It stands on two pieces of ground, which meet below the middle of the window.
Load
    Its weight, 271 kN/m. Then the right piece of ground sinks by 4 cm in 20 steps of a damped march, which
    ends two steps later, at rest.
What to look at
    A stepped crack runs from the gap in the ground to the window's sill: with the bond it shifts by half a
    stone in each course. Its bed joints open by all of the 4 cm, head joints stay closed. The right pier
    sinks upright with its ground; the lintel rotates as a beam on two supports, together with the top
    courses. The sinking ground is relieved: at the end it carries 100 kN/m, the other piece 171; half the
    weight is 136. ``thrust.png`` shows why: an arch above the crack leans on both piers, and the lintel
    stands on two hinges.
Reference
    By limit analysis the sinking ground must carry at least 84.78 kN/m. If joints do not slide, this smallest
    force remains (as with a springing that sinks, validation A6.6). Here they slide, friction in the head
    joints acts against the previous motion, and the force is 18 % larger.
Cost
    2 seconds.

.. image:: /images/settlement.png

.. image:: /images/settlement_thrust.png

.. literalinclude:: settlement.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/settlement.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run, solve
from masonry_fem.analyses.limit import analyse
from masonry_fem.bodies.base import by_block

SCENE = Path(__file__).with_suffix(".toml")
WEIGHT = 271.22688e3  # [N/m]
LEAST = 84.783e3  # that the ground may carry which settles [N/m]


@dataclass(frozen=True, slots=True)
class Settlement:
    """How the wall stands on its two pieces of ground at the end.

    Attributes
    ----------
    outcome : ``equilibrium`` or another. weight : Of the wall [N/m].
    firm, soft : Vertical force of the ground that stays, and of that which settles [N/m].
    bounds : Least and greatest that the latter may carry before it settles, by limit analysis [N/m].
    widest : Widest opening of a joint [m]. turn : Of the lintel, clockwise [rad].
    pier : How far the right pier goes down, least and most of its stones [m].
    """

    outcome: str
    weight: float
    firm: float
    soft: float
    bounds: tuple[float, float]
    widest: float
    turn: float
    pier: tuple[float, float]


def main(*, out: Path | None = None, settlement: float = 0.04) -> Settlement:
    """The wall on ground that settles by ``settlement`` [m]; pictures go to ``out``."""
    scene = load(SCENE, overrides=(f"supports.1.motion.displacement=[0.0, {-settlement}]",))
    low, high = analyse(scene).supports["soft"]["y"]
    result = solve(scene) if out is None else run(scene, out)
    model, state = result.built.model, result.march.state
    moved = {
        model.assembly.blocks[block].name: field
        for group, own in zip(model.groups, state.bodies, strict=True)
        for block, field in zip(group.blocks, by_block(group, group.displacements(own)), strict=True)
    }
    lintel = next(name for name in moved if "lintel" in name)
    corners = model.assembly.solid([b.name for b in model.assembly.blocks].index(lintel)).vertices
    left, right = corners[:, 0].argmin(), corners[:, 0].argmax()
    fall = moved[lintel][left, 1] - moved[lintel][right, 1]
    pier = [-field[:, 1].mean() for name, field in moved.items() if name.startswith("wall.c5.")]
    forces = result.summary.supports
    return Settlement(
        outcome=result.outcome,
        weight=-float(result.summary.applied[1]),
        firm=float(forces["firm"].force[1]),
        soft=float(forces["soft"].force[1]),
        bounds=(low, high),
        widest=float(state.gap.max()),
        turn=float(fall / (corners[right, 0] - corners[left, 0])),
        pier=(float(np.min(pier[-3:])), float(np.max(pier[-3:]))),
    )


if __name__ == "__main__":
    wall = main(out=Path("results/settlement"))
    print(
        f"{wall.outcome}: the ground that settles carries {wall.soft / 1e3:.1f} kN/m of "
        f"{wall.weight / 1e3:.1f} (at least {wall.bounds[0] / 1e3:.1f}); the lintel turns by "
        f"{1e3 * wall.turn:.1f} mrad, the widest opening is {1e3 * wall.widest:.1f} mm"
    )
