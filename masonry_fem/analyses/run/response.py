"""Response: what the history of a run in dynamics tells of its probes, as tables and for the summary."""

from __future__ import annotations

from pathlib import Path

from masonry_fem.analyses.run.result import RunResult
from masonry_fem.output.response import read_motions, response_of, write_response
from masonry_fem.results.response import ResponseTold
from masonry_fem.scene import specs


def responded(scene: specs.Scene, out: Path, result: RunResult) -> tuple[RunResult, list[Path]]:
    """A result with the response of its probes, and the files of it; statics has none.

    Parameters
    ----------
    scene : What was solved. out : Results folder, with the whole history. result : What its march tells.
    """
    if not scene.analysis.inertia or not scene.probes or not result.summary.steps:
        return result, []
    names = [probe.name for probe in scene.probes]
    motions = read_motions(out / "history.csv", names, scene.dimension, result.built.model.ground)
    told = [response_of(one) for one in motions]
    result = result.telling(response={one.name: ResponseTold.of(one) for one in told})
    return result, [write_response(out / "response.csv", told)]
