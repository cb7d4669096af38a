"""Arch on springings that part
============================

Geometry and material
    Semicircle of 20 elastic voussoirs, 10 GPa, mean radius R = 3 m, thickness 0.15 R, dry, μ = 0.8.
Load
    Weight. Then the springings part in true statics, in 40 load steps that are shorter near the end,
    until nothing balances any more.
What to look at
    Stones turn with the parts of the arch that they belong to, each in a frame of its own. Three hinges
    form: at the crown, where the joint opens below, and at both haunches, where it opens above. The
    thrust begins near its least value and grows as the crown sinks and the line of thrust flattens. In
    the last state that stands the line of thrust has come to the outer edge of the springings, and the
    mechanism shows how the arch goes on from there. The stones are squeezed where they turn on each
    other.
Reference
    Rigid voussoirs that do not slide fall at a spread of 0.1079 R: the closed chain of three hinges,
    with the haunch hinges in the ninth joints from the springings, at 54° from the crown. Elastic ones
    of this size fall within a few per cent of it.
Cost
    10 seconds.

.. image:: /images/spreading_arch.png

.. image:: /images/spreading_arch_mechanism.png

.. literalinclude:: spreading_arch.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/spreading_arch.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run, solve

SCENE = Path(__file__).with_suffix(".toml")
RADIUS, SPREAD = 3.0, 0.12  # mean radius [m]; greatest spread of the scene, of the radius
EXACT = 0.1079  # spread at which rigid voussoirs fall, of the radius
TIMES, SHARES = (0.0, 0.5, 1.0), (0.0, 0.7, 1.0)  # of the supports' motion


@dataclass(frozen=True, slots=True)
class Spreading:
    """How far the springings may part.

    Attributes
    ----------
    outcome : ``no_equilibrium`` where it falls.
    stands, falls : Last spread that it stands and first that it does not, of the radius.
    thrust : Horizontal force of the left springing where it stands last [N/m].
    hinges : Names of the joints that are hinges of the mechanism.
    """

    outcome: str
    stands: float
    falls: float
    thrust: float
    hinges: tuple[str, ...]


def main(*, out: Path | None = None, divisions: tuple[int, int] = (4, 6), steps: int = 40) -> Spreading:
    """The arch with so many elements in a voussoir; pictures go to ``out``."""
    changes = (f"mesh.divisions={list(divisions)}", f"analysis.load_steps={steps}")
    scene = load(SCENE, overrides=changes)
    result = solve(scene) if out is None else run(scene, out)
    end = result.march.last
    before, after = (float(np.interp(one.time, TIMES, SHARES)) * SPREAD for one in (end.before, end.after))
    mechanism = result.summary.mechanism
    joints = () if mechanism is None else mechanism.joints
    return Spreading(
        outcome=result.outcome,
        stands=before,
        falls=after,
        thrust=float(result.summary.supports["arch.springing_left"].force[0]),
        hinges=tuple(" / ".join(one.between) for one in joints if one.how == "hinge"),
    )


if __name__ == "__main__":
    arch = main(out=Path("results/spreading_arch"))
    print(
        f"{arch.outcome}: the arch stands at a spread of {arch.stands:.4f} R and falls at {arch.falls:.4f} R "
        f"(rigid: {EXACT} R); hinges {', '.join(arch.hinges)}"
    )
