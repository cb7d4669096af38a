"""A wall, its courses and its settlement
=======================================

Geometry and material
    Wall of 8 by 8 elastic stones of 60 by 30 cm, dry, μ = 0.65, on two rigid blocks of ground. It is built in
    the stages *two*, *four*, *six* and *eight*, named by the number of courses; new courses are laid on those
    below where these are by then (``new_stones = "moved"``), flush and without stress.
Load
    Its weight in each stage; in the stage *settled* the ground under the right third goes down by 4 cm, in 20
    steps of true statics.
What to look at
    ``settled/overview.png``: the stones that settle part from the others along steps of half a stone. The
    stones that project over the gap lean on the last stone on firm ground, whose stress is thirteen times the
    greatest one before. The stones that have settled carry little but themselves.
Reference
    In each stage the ground bears the weight of what stands, 33.9 kN/m for each course. The stones of the
    lowest course that stand on soft ground go down by 4 cm.
Cost
    10 seconds.

.. image:: /images/built_wall.png

.. literalinclude:: built_wall.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/built_wall.png"

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from masonry_fem import load, run

SCENE = Path(__file__).with_suffix(".toml")
COURSE = 2400 * 9.81 * 8 * 0.6 * 0.3  # weight of a course [N/m]


@dataclass(frozen=True, slots=True)
class BuiltWall:
    """The wall in each stage.

    Attributes
    ----------
    outcomes : By stage.
    weight : What both blocks of ground bear, by stage [N/m]. soft : What the soft one bears of it [N/m].
    pressed : Greatest compression at a Gauss point, by stage [Pa].
    widest : Widest opening at the end [m].
    """

    outcomes: dict[str, str]
    weight: dict[str, float]
    soft: dict[str, float]
    pressed: dict[str, float]
    widest: float


def main(*, out: Path | None = None, load_steps: int = 20) -> BuiltWall:
    """The history of the wall; pictures go to ``out``.

    Parameters
    ----------
    out : Folder for the results; None: nothing stays.
    load_steps : In which the ground settles.
    """
    keys = [f"stages.settled.analysis.load_steps={load_steps}"]
    scene = load(SCENE, overrides=[*keys, *(["output.pictures=false"] if out is None else [])])
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) if out is None else out
        stages = run(scene, folder).summary.stages
        assert stages is not None
        told = {
            one.name: json.loads((folder / one.name / "summary.json").read_text(encoding="utf-8"))
            for one in stages
        }
    up = {name: {key: one["force"][1] for key, one in own["supports"].items()} for name, own in told.items()}
    return BuiltWall(
        outcomes={one.name: one.outcome for one in stages},
        weight={name: sum(own.values()) for name, own in up.items()},
        soft={name: own["soft"] for name, own in up.items()},
        pressed={name: -own["stress"]["min_principal"]["value"] for name, own in told.items()},
        widest=told["settled"]["joints"]["greatest_opening"]["value"],
    )


if __name__ == "__main__":
    wall = main(out=Path("results/built_wall"))
    for stage, weight in wall.weight.items():
        soft, pressed = wall.soft[stage] / 1e3, wall.pressed[stage] / 1e3
        print(
            f"{stage}: {wall.outcomes[stage]}, {weight / 1e3:.1f} kN/m, {soft:.1f} of it on soft ground, ",
            end="",
        )
        print(f"stones are pressed by {pressed:.0f} kPa at most")
    print(f"joints open by {1e3 * wall.widest:.1f} mm")
