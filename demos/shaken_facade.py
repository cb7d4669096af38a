"""Façade under a record
=====================

Geometry and material
    A façade of 6 m × 5.5 m, 50 cm thick, of rigid pieces, dry on each other, with a gate of 1.6 m × 2.2 m.
    Two side walls stand behind it, not bonded with it, which do not move against the ground. Two bars of
    24 mm go through its uppermost piece and along the side walls. μ = 0.6.
Load
    Six seconds of an earthquake across the façade, 6 m/s², made like that of the column
    (``shaken_column.py``), for a ground of 0.8 Hz. Steps of 10 ms, θ = ½. Only impacts, which do not rebound,
    and friction damp the motion.
What to look at
    With its bars the façade moves by some millimetres and comes back; they bear up to 68 kN each, and yield
    at 109 kN. Without them it rocks outwards, as the side walls hold it only from behind, and falls into the
    street after 4 s.
Reference
    A stiff wall of 0.5 m × 5.5 m lifts at g · 0.5/5.5 = 0.89 m/s².
Cost
    90 seconds.

.. image:: /images/shaken_facade.png

.. image:: /images/shaken_facade_fallen.png

.. image:: /images/shaken_facade_response.png

.. literalinclude:: shaken_facade.toml
   :language: toml
"""

# sphinx_gallery_thumbnail_path = "images/shaken_facade_fallen.png"

from __future__ import annotations

import runpy
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from masonry_fem import load, run
from masonry_fem.analyses.single_run import run_once
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step_report import StepReport
from masonry_fem.output.mechanism_picture import draw_mechanism
from masonry_fem.output.scenery import Scenery

SCENE = Path(__file__).with_suffix(".toml")
RECORD = "shaken_facade.csv"  # beside the scene is the one of the demo's own peak
record = runpy.run_path(str(Path(__file__).with_name("shaken_column.py")))["record"]


@dataclass(frozen=True, slots=True)
class Facade:
    """What the record did.

    Attributes
    ----------
    tied : Greatest distance of the top from where it stood, with the bars [m].
    force : Greatest force of a bar [N].
    verdict : Without them. message : The same as a sentence.
    """

    tied: float
    force: float
    verdict: str
    message: str


def main(*, out: Path | None = None, peak: float = 6.0, duration: float = 6.0) -> Facade:
    """Shake the façade with its bars, and without them.

    Parameters
    ----------
    out : Folder for the results; None: nothing stays.
    peak : Greatest acceleration of the record [m/s²]. duration : Of the march with the bars [s].
    """
    with tempfile.TemporaryDirectory() as place:
        base = Path(place)
        shutil.copy(SCENE, base)
        record(base / RECORD, peak=peak, frequency=0.8, duration=6.0)
        keys = [f"analysis.duration={duration}", *([] if out is not None else ["output.pictures=false"])]
        scene = load(base / SCENE.name, overrides=keys)
        tied = run(scene, base / "results" if out is None else out, base=base, observers=[(seen := _Bars())])
        free = run_once(load(base / SCENE.name, overrides=[*keys, "ties=[]"]), base)
    if out is not None and free.fall is not None:
        fall = free.fall
        draw_mechanism(Scenery.of(fall.model, fall.state), fall.mechanism, out / "fallen.png")
    return Facade(
        tied=tied.summary.response["top"].greatest,
        force=seen.force,
        verdict=free.verdict,
        message=free.message,
    )


class _Bars:
    """The greatest force of a bar in all steps."""

    def __init__(self) -> None:
        self.force = 0.0

    def __call__(self, model: Model, state: SystemState, report: StepReport) -> None:
        self.force = max(self.force, *report.tie_forces.values())


if __name__ == "__main__":
    facade = main(out=Path("results/shaken_facade"))
    print(f"with its bars: top {1e3 * facade.tied:.2f} mm, bars up to {facade.force / 1e3:.0f} kN")
    print(f"without them: {facade.message}")
