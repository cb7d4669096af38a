"""Dome that cracks
================

Geometry and material
    Hemisphere of 5 m and 0.5 m: nine rings of 16 elastic stones and a crown stone, 10 GPa and 20 kN/m³. Beds
    are dry; mortar holds the meridian joints up to a strength, then nothing does. The base is on rollers, and
    an iron chain of 200 cm² (``[[ties]]``) runs through the stones of the lowest ring, whose joints are dry.
Load
    Its weight, 1.52 MN, in one step of true statics.
What to look at
    A shell under its weight has tension along its parallels below 51.8° from the crown, at most γ R = 100
    kPa. Mortar of 130 kPa bears this without a chain. Mortar of 50 kPa cracks from the base upwards: in
    ``deformed.png`` (× 10 000) the dome opens into lunes below an uncracked cap, and ``damage.png`` shows
    each broken point. The chain then takes the thrust of the lunes. Without mortar and chain the
    dome collapses.
Reference
    The cracks end between 51.8° and the next joint. By limit analysis the thrust of a cracked dome on a base
    that yields is at least .0195 γ R³ = 48.7 kN per radian, which is the tension of the chain. This chain
    bears 52.5 kN. A chain ten times softer, without any mortar, bears 46.8 kN: with chords in place of arcs,
    stones of 22.5° need 4 % less than a round dome.
Cost
    7 seconds for all three, 20 to draw one.

.. image:: /images/dome.png

.. literalinclude:: dome.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/dome.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from masonry_fem import load, run, solve
from masonry_fem.analyses.run import RunResult
from masonry_fem.scene import specs

SCENE = Path(__file__).with_suffix(".toml")
PRESSED = 51.83  # [deg] from the crown: above, the parallels of a shell press
LEAST = 0.019469 * 20e3 * 5.0**3  # pull in the chain by limit analysis [N]


@dataclass(frozen=True, slots=True)
class Dome:
    """One dome.

    Attributes
    ----------
    name, outcome : Of the variant; ``equilibrium`` or ``no_equilibrium``.
    cracks : Angles from the crown of the points of meridian joints that are broken and open [deg].
    opening : Widest of them [m]. chain : Force of the chain, in the mean of its parts; 0 without one [N].
    sinking : Of the crown [m]. moving : Number of blocks that move where it falls.
    """

    name: str
    outcome: str
    cracks: np.ndarray
    opening: float
    chain: float
    sinking: float
    moving: int


def main(*, out: Path | None = None, rings: int = 9, slices: int = 16) -> list[Dome]:
    """The three variants; pictures of the second go to ``out``."""
    sizes = (f"structures.dome.rings={rings}", f"structures.dome.slices={slices}")
    weak = load(SCENE, overrides=sizes)
    points = tuple(specs.TiePoint(block=f"dome.r1.s{number}") for number in range(1, slices + 1))
    weak = replace(weak, ties=(replace(weak.ties[0], points=points),))
    strong = load(SCENE, overrides=(*sizes, "joints.2.law.normal_strength='130 kPa'"))
    dry, rollers, mortar = strong.joints[:3]
    scenes = {
        "strong mortar": replace(strong, joints=(dry, rollers, mortar), ties=()),
        "weak mortar, chain": weak,
        "dry, no chain": replace(weak, joints=(dry, rollers), ties=()),
    }
    domes = []
    for name, scene in scenes.items():
        result = solve(scene) if out is None or scene is not weak else run(scene, out)
        domes.append(_read(name, result))
    return domes


def _read(name: str, result: RunResult) -> Dome:
    model, state = result.built.model, result.march.state
    ties = result.summary.ties or {}
    meridian = np.array([one.label == "meridian" for one in model.interfaces])[model.contacts.interface]
    broken = meridian & state.joints.broken & (state.gap > 0)
    x, y, z = state.points.T
    angle = np.degrees(np.arctan2(np.hypot(x, y), z))
    return Dome(
        name=name,
        outcome=result.outcome,
        cracks=np.sort(angle[broken]),
        opening=float(state.gap[meridian].max()),
        chain=float(np.mean([one.force for one in ties.values()])) if ties else 0.0,
        sinking=-float(result.summary.probes["crown"][2]),
        moving=len(result.march.moving),
    )


if __name__ == "__main__":
    for dome in main(out=Path("results/dome")):
        cracks = f"cracked to {dome.cracks[0]:.1f} deg from the crown" if len(dome.cracks) else "whole"
        print(f"{dome.name:18s} {dome.outcome:15s} {cracks if dome.moving == 0 else 'falls'}")
        if dome.outcome == "equilibrium":
            print(
                f"{'':18s} crown sinks {dome.sinking * 1e6:.0f} um, cracks open {dome.opening * 1e6:.1f} um, "
                f"the chain bears {dome.chain / 1e3:.1f} kN (least {LEAST / 1e3:.1f} kN)"
            )
