"""A lorry on a bridge
===================

Geometry and material
    Arch bridge of 21 elastic stones, span 8 m, rise 2 m, thickness 45 cm, dry, μ = 0.6, under elastic fill
    that reaches 40 cm above the crown, and goes on behind both ends.
Load
    Its weight, and a lorry of three axles of 40 kN for each metre of width, 1.3 and 4.5 m behind the first
    one, each spread over 40 cm of the road. It crosses slowly: 37 places, half a metre from each other.
What to look at
    ``places.png``, made from ``places.csv``: how reactions, stresses and the place of the thrust in the
    joints change on the way; ``envelope.csv``: the extremes, and where they are met. The second picture
    shows the bridge with the lorry at the place where a stone is used most. Where the lorry has gone the
    bridge is not quite as it was before: joints have slid under it.
Reference
    Balance at each place: the supports bear the weight, and the axles that are on the bridge.
Cost
    10 seconds.

.. image:: /images/crossed_bridge_places.png

.. image:: /images/crossed_bridge.png

.. literalinclude:: crossed_bridge.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/crossed_bridge.png"

from __future__ import annotations

import csv
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")


@dataclass(frozen=True, slots=True)
class CrossedBridge:
    """How the bridge bears the lorry.

    Attributes
    ----------
    outcome : Of the crossing.
    place : Of the first axle, shape (places,) [m].
    upward : What all supports bear, shape (places,) [N/m].
    thrust : Horizontal force of the left abutment, shape (places,) [N/m].
    utilisation : Greatest of a stone, shape (places,).
    edge_share : Nearest that the thrust comes to the edge of a joint of the arch, where it is 1, (places,).
    worst : Where a stone is used most [m].
    """

    outcome: str
    place: np.ndarray
    upward: np.ndarray
    thrust: np.ndarray
    utilisation: np.ndarray
    edge_share: np.ndarray
    worst: float


def main(*, out: Path | None = None, places: int = 37) -> CrossedBridge:
    """Let the lorry cross; pictures go to ``out``, those of the worst place to its folder ``worst``.

    Parameters
    ----------
    out : Folder for the results; None: nothing stays.
    places : How many there are on the way.
    """
    keys = [f"analysis.places={places}", "output.fields=false", "output.pictures=['places']"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        scene = load(SCENE, overrides=[*keys, *(["output.pictures=false"] if out is None else [])])
        result = run(scene, folder)
        with (folder / "places.csv").open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    told = result.summary.places
    assert told is not None
    assert told.utilisation is not None
    worst = told.utilisation.place
    if out is not None:  # the same way, up to there
        (first, _) = scene.loads.moving[0].path
        reached = round(worst / 18.0 * (places - 1)) + 1
        short = f"loads.moving.0.path=[{list(first)}, [{first[0] + worst}, {first[1]}]]"
        run(load(SCENE, overrides=[short, f"analysis.places={reached}"]), out / "worst")
    column = {name: np.array([float(row[name]) for row in rows]) for name in rows[0] if name.endswith("]")}
    return CrossedBridge(
        outcome=result.outcome,
        place=column["place [m]"],
        upward=sum(values for name, values in column.items() if name.endswith("force_y [N/m]")),
        thrust=column["bridge.abutment_left force_x [N/m]"],
        utilisation=column["utilisation [-]"],
        edge_share=column["radial edge_share [-]"],
        worst=worst,
    )


if __name__ == "__main__":
    bridge = main(out=Path("results/crossed_bridge"))
    low, high = bridge.thrust.min() / 1e3, bridge.thrust.max() / 1e3
    print(f"{bridge.outcome}: thrust {low:.1f} to {high:.1f} kN/m, ", end="")
    print(f"stones use at most {bridge.utilisation.max():.3f} of their strength, at {bridge.worst:.2f} m")
