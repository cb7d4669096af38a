"""Solving: a scene in memory, and what its march and its end tell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from masonry_fem.analyses.run.asked import answered, limits_of
from masonry_fem.analyses.run.reopening import begun
from masonry_fem.analyses.run.result import RunResult
from masonry_fem.analyses.run.start import said, started
from masonry_fem.build import Built, build
from masonry_fem.errors import MasonryError
from masonry_fem.march.march import March, Observer, Seeing, StepMade, march, marching, seen_by
from masonry_fem.records.remark import gathered
from masonry_fem.results.limit_analysis import LimitAnalysis
from masonry_fem.results.summarise import summarise
from masonry_fem.scene import check, of_records, specs


def solve_scene(
    scene: specs.Scene, base: str | Path = Path(), observers: Sequence[Observer | Seeing] = ()
) -> RunResult:
    """Solve a scene without writing anything.

    Parameters
    ----------
    scene : What to solve.
    base : Folder that the paths in the scene are relative to.
    observers : Called after every step: functions of model, state and report (see ``steps``), or recorders.

    Raises
    ------
    MasonryError : The scene cannot be built.
    """
    base = Path(base)
    scene = of_records(scene, base=base)
    _refuse_several(scene)
    with gathered() as remarks:
        scene = check(scene, base=base)
        built, state = begun(scene, build(scene, base), base)
        limits = limits_of(scene, built)
        made = march(
            built.model, scene.analysis, scene.solver.settings, bodies=built.bodies, start=state,
            observers=seen_by(observers),
        )  # fmt: skip
        result = answered(scene, base, told(scene, built, made, limits))
    return result.telling(remarks=tuple(remarks))


def steps(scene: specs.Scene, base: str | Path = Path()) -> Iterator[StepMade]:
    """Solve a scene step by step: a step is computed when the loop asks for it.

        for model, state, report in masonry_fem.steps(scene):
            print(report.time, report.probes, state.gap.max())

    Nothing is written, and there is no summary at the end as ``solve`` returns it.

    Parameters
    ----------
    scene : What to solve.
    base : Folder that the paths in the scene are relative to.

    Returns
    -------
    Iterator of the steps, each a ``StepMade``.

    Raises
    ------
    MasonryError : The scene cannot be built, or has stages or combinations.
    """
    base = Path(base)
    scene = of_records(scene, base=base)
    _refuse_several(scene)
    scene = check(scene, base=base)
    built, state = begun(scene, build(scene, base), base)
    return marching(built.model, scene.analysis, scene.solver.settings, bodies=built.bodies, start=state)


def _refuse_several(scene: specs.Scene) -> None:
    """Refuse a scene of several marches."""
    if scene.stages:
        raise MasonryError(
            "a scene with stages leaves where each of them ends; run it into a folder, and let what is tried "
            "again and again start from a stage there (analysis.start)"
        )
    if scene.combinations:
        raise MasonryError("a scene with combinations has several ends; run it into a folder")


def told(scene: specs.Scene, built: Built, made: March, limits: LimitAnalysis | None) -> RunResult:
    """What a march tells, before the scene's questions of its end are answered.

    Parameters
    ----------
    scene : What was solved. built : Made of it. made : How its march ended.
    limits : What limit analysis says, where the scene asks for it.
    """
    source = started(made)
    made = said(made, source)
    start = None if source is None else source.told()
    summary = summarise(scene, built, made, limit_analysis=limits, start=start)
    return RunResult(summary, [], built, made, scene=scene)
