"""History: what a trial of a scene with stages runs, its last stage, and the stages before, run once for all.

    own = last_stage(scene, base, folder)        # without stages; it starts where the one before has ended

Trials that change a key of a late stage have the earlier ones in common. Each stage is run into a folder that
is named by all that its state depends on, so that it is known where another trial or search has run it.
"""

from __future__ import annotations

from pathlib import Path

from msgspec import structs

from masonry_fem.analyses.cells.cell import fingerprint
from masonry_fem.analyses.run.stages import GOOD, check_stages, kept_part, starting
from masonry_fem.analyses.run.writing import run
from masonry_fem.march.toppling import ToppledError, Toppling
from masonry_fem.output.checkpoint import CHECKPOINT
from masonry_fem.records.remark import muted
from masonry_fem.scene import specs
from masonry_fem.scene.stages import predecessor

FOLDER = "stages"  # of a search's folder


def last_stage(scene: specs.Scene, base: Path, folder: Path) -> specs.Scene:
    """The scene of the last stage, or of the first one that does not come to a good end.

    Parameters
    ----------
    scene : With stages, or without: then it is returned as it is.
    base : Folder that its paths are relative to.
    folder : Of the search; states of earlier stages are kept in ``stages`` of it.

    Raises
    ------
    MasonryError : A stage cannot be built.
    """
    if not scene.stages:
        return scene
    ends: dict[str, Path] = {}
    for stage, checked in zip(scene.stages, check_stages(scene, base), strict=True):
        after = predecessor(scene, stage)
        own = starting(checked, None if after is None else ends[after], base)
        if stage is scene.stages[-1]:
            break
        ends[stage.name] = path = folder / FOLDER / fingerprint(own, base)
        if not (kept_part(path)[1] or _stands(own, base, path)):
            (path / CHECKPOINT).unlink(missing_ok=True)  # nothing goes on from there
            break
    return own


def _stands(scene: specs.Scene, base: Path, out: Path) -> bool:
    """Run a stage that others go on from; whether it comes to a good end, and in time no stone has fallen."""
    quiet = specs.Output(fields=False, pictures=False, checkpoint_steps=scene.analysis.steps)
    with muted("idle_joint"):
        made = run(structs.replace(scene, output=quiet), out, base=base)
    if made.outcome not in GOOD:
        return False
    if scene.analysis.seeks_equilibrium:
        return True
    fallen = Toppling(made.built.model, made.built.bodies, scene.loads.gravity)
    try:
        fallen.record(made.march.model, made.march.state, made.march.report)
    except ToppledError:
        return False
    return True
