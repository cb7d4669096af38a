"""An arch on slender piers and its tie
====================================

Geometry and material
    Half a circle of 13 elastic stones, span 4 m, 36 cm thick, on piers 60 cm wide and 3.6 m high, dry,
    μ = 0.7. A bar of iron of 8 cm² for each metre of depth joins the piers 30 cm below the springings.
Load
    Its weight, 142 kN/m.
What to look at
    Without the bar the arch pushes its piers over. With it the bar bears nearly all of the thrust: 7.86 kN/m,
    and the ground 0.60. Tightened before (``pretension``) it bears more, and the piers lean inwards.
Reference
    Limit analysis: without the bar the loads cannot be carried; with it the bar bears 1.01 to 19.9 kN/m.
Cost
    3 seconds.

.. image:: /images/tied_arch.png

.. image:: /images/tied_arch_thrust.png

.. literalinclude:: tied_arch.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/tied_arch.png"

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from msgspec import structs

from masonry_fem import load, run, solve
from masonry_fem.analyses.limit import analyse

SCENE = Path(__file__).with_suffix(".toml")


@dataclass(frozen=True, slots=True)
class TiedArch:
    """How the arch stands.

    Attributes
    ----------
    outcome : With its tie. untied : Without.
    force : Of the tie [N/m].
    bounds : Its least and greatest force by limit analysis [N/m].
    thrust : What the ground gives against the rest of the thrust [N/m].
    """

    outcome: str
    untied: bool
    force: float
    bounds: tuple[float, float]
    thrust: float


def main(*, out: Path | None = None, pretension: float = 0.0) -> TiedArch:
    """The arch with its tie, and what limit analysis says of both; pictures go to ``out``.

    Parameters
    ----------
    out : Folder for the results; None: nothing is written.
    pretension : Of the tie while the arch is where it was drawn [N/m].
    """
    scene = load(SCENE, overrides=[f"ties.bar.pretension={pretension}"])
    result = solve(scene) if out is None else run(scene, out)
    return TiedArch(
        outcome=result.outcome,
        untied=analyse(structs.replace(scene, ties=())).admissible,
        force=result.summary.ties["bar"].force,
        bounds=analyse(scene).ties["bar"],
        thrust=float(result.summary.supports["portal.ground_left"].force[0]),
    )


if __name__ == "__main__":
    arch = main(out=Path("results/tied_arch"))
    print(f"without its tie it can be carried: {arch.untied}; with it: {arch.outcome}")
    print(f"tie {arch.force / 1e3:.2f} kN/m, by limit analysis {arch.bounds[0] / 1e3:.2f} to ", end="")
    print(f"{arch.bounds[1] / 1e3:.2f} kN/m; the ground bears {arch.thrust / 1e3:.2f}")
