"""Run: a scene from its description to results on disk.

    from masonry_fem.analyses.run import run
    from masonry_fem.scene import load
    result = run(load("arch.toml"), Path("results"), base=Path("."))
    result.outcome, result.summary.supports, result.files

``solving`` solves a scene and ``writing`` writes what it leaves to its folder. ``asked``, ``discretisation``
and ``start`` tell what a scene asks of its end. ``keeping`` writes checkpoints, ``resume`` goes on with them,
``reopening`` starts another scene from one, and ``stages`` runs a scene of several.
"""

from masonry_fem.analyses.run.result import RunResult
from masonry_fem.analyses.run.solving import solve_scene, steps
from masonry_fem.analyses.run.writing import go_on, run

__all__ = ["RunResult", "go_on", "run", "solve_scene", "steps"]
