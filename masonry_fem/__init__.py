"""masonry_fem: mechanics of block masonry with finite-element stones and true frictional joints.

scene = masonry_fem.load("wall.toml")              # or a masonry_fem.Scene made of dicts, lists and numbers
result = masonry_fem.run(scene, "results")         # solves it and writes tables, fields and pictures
result = masonry_fem.resume("results")             # continues an interrupted run (output.checkpoint_steps)
result = masonry_fem.solve(scene)                  # solves it and writes nothing
result.plot("thrust").save("thrust.png")
for model, state, report in masonry_fem.steps(scene): ...    # computes one step after the other
made = masonry_fem.study(scene, {"mesh.size": [0.2, 0.1]})   # variants of it: cost against accuracy
masonry_fem.collapse(scene)                                  # the multiplier of the loads at which it falls
masonry_fem.threshold("wall.toml", "joints.0.friction", (0.1, 0.6))   # the friction at which it falls
masonry_fem.save(masonry_fem.check(scene), "wall.toml")

Importing masonry_fem loads nothing heavy: each name is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from masonry_fem.analyses.collapse import collapse
    from masonry_fem.analyses.refine import refine
    from masonry_fem.analyses.run import run, steps
    from masonry_fem.analyses.run import solve_scene as solve
    from masonry_fem.analyses.run.resume import resume
    from masonry_fem.analyses.study.sweep import study
    from masonry_fem.analyses.threshold import threshold
    from masonry_fem.scene import check, load, save
    from masonry_fem.scene.specs import Scene

__version__ = "0.2.0"

__all__ = [
    "Scene",
    "check",
    "collapse",
    "load",
    "refine",
    "resume",
    "run",
    "save",
    "solve",
    "steps",
    "study",
    "threshold",
]

_HOMES = {
    "Scene": "masonry_fem.scene.specs:Scene",
    "check": "masonry_fem.scene:check",
    "collapse": "masonry_fem.analyses.collapse:collapse",
    "load": "masonry_fem.scene:load",
    "refine": "masonry_fem.analyses.refine:refine",
    "resume": "masonry_fem.analyses.run.resume:resume",
    "run": "masonry_fem.analyses.run:run",
    "save": "masonry_fem.scene:save",
    "solve": "masonry_fem.analyses.run:solve_scene",
    "steps": "masonry_fem.analyses.run:steps",
    "study": "masonry_fem.analyses.study:study",
    "threshold": "masonry_fem.analyses.threshold:threshold",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'masonry_fem' has no '{name}'; its names are {', '.join(__all__)}")
    module, attribute = _HOMES[name].split(":")
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
