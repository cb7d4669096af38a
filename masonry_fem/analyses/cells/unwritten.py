"""Unwritten: what a scene asks to be written, and a search of many runs does not write."""

from __future__ import annotations

from masonry_fem.scene import Scene


def unwritten(scene: Scene, search: str) -> list[str]:
    """Notes on keys of ``[output]`` that a search leaves aside.

    Parameters
    ----------
    scene : What is searched. search : Its kind, as ``a study``.
    """
    if not scene.output.report:
        return []
    return [
        f"output.report = true has no effect here: a report presents one run, not {search}; run the scene "
        "with the values that you choose (masonry-fem run SCENE --set KEY=VALUE), and it is written"
    ]
