"""Stages: the scene of each stage of a history.

for stage, own in stage_scenes(scene):       # own: a scene without stages
    ...
"""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import structs

from masonry_fem.scene.specs import Scene, Stage

KEYS = ("analysis", "loads", "supports", "joints", "ties", "without")  # replaced as a whole


def stage_scenes(scene: Scene) -> Iterator[tuple[Stage, Scene]]:
    """Each stage with its scene: that of the stage where it begins, with what the stage says."""
    made: dict[str, Scene] = {}
    before = structs.replace(scene, stages=())
    for stage in scene.stages:
        before = made.get(stage.after or "", before)
        changes = {key: value for key in KEYS if (value := getattr(stage, key)) is not None}
        if stage.materials is not None:
            changes["materials"] = before.materials | stage.materials
        if made:  # velocities at the start are those of the first
            changes["initial"] = ()
        title = f"{scene.title}, {stage.name}" if scene.title else stage.name
        before = made[stage.name] = structs.replace(before, title=title, **changes)
        yield stage, before


def predecessor(scene: Scene, stage: Stage) -> str | None:
    """Name of the stage where one begins; None: in the reference, or where the scene says.

    Parameters
    ----------
    scene : With the stages. stage : One of them.
    """
    if stage.after is not None:
        return stage.after
    number = [one.name for one in scene.stages].index(stage.name)
    return scene.stages[number - 1].name if number else None
