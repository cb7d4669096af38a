"""Asked: what a scene's ``output`` asks of the end of its march, for the summary.

limits = limits_of(scene, built)                 # before the march
result = answered(scene, base, result)           # after it

What a scene did not ask for is not loaded.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import structs

from masonry_fem.analyses.run.discretisation import errors_of
from masonry_fem.analyses.run.result import RunResult
from masonry_fem.build import Built
from masonry_fem.build.strengths import strengths_of
from masonry_fem.errors import ProblemError
from masonry_fem.host.phases import phase
from masonry_fem.march.march import March
from masonry_fem.march.state import SystemState
from masonry_fem.records.remark import remark
from masonry_fem.results.blocks import status_counts
from masonry_fem.results.determinacy import Determinacy
from masonry_fem.results.joints import Joints
from masonry_fem.results.limit_analysis import LimitAnalysis
from masonry_fem.results.summarise import wrenches
from masonry_fem.results.summary import Summary
from masonry_fem.results.utilisation import Utilisation
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy


def answered(scene: specs.Scene, base: Path, result: RunResult) -> RunResult:
    """A result with all that the scene asks of its end.

    Parameters
    ----------
    scene : What was solved. base : Folder that the paths in it are relative to.
    result : What its march tells.
    """
    built, made = result.built, result.march
    told, keys = _determinacy(scene, made)
    state = made.state if told is None else told.state
    result = result.telling(
        errors=errors_of(scene, built, made, base),
        limit_analysis=_compared(result.summary),
        joints=_joints(scene, made, state),
        utilisation=_utilisation(scene, built, made, state),
        **keys,
    )
    return replace(result, determinacy=told)


def limits_of(scene: specs.Scene, built: Built) -> LimitAnalysis | None:
    """What limit analysis says, where the scene asks for it; before the march, as it may refuse.

    Parameters
    ----------
    scene : The scene. built : Made of it.

    Raises
    ------
    MasonryError : The scene has what limit analysis does not know.
    """
    if not scene.output.limit_analysis:
        return None
    from masonry_fem.analyses.limit import cross_check  # noqa: PLC0415 - only who asks needs its solvers

    try:
        with phase("limit analysis"):
            return cross_check(scene, built)
    except ProblemError as error:
        remark("limit_analysis", f"limit analysis has no answer: {error}")
        return None


def _compared(summary: Summary) -> LimitAnalysis | None:
    """Limit analysis, where it was asked, with forces of an equilibrium that lie outside its intervals."""
    told = summary.limit_analysis
    if told is None or summary.outcome != "equilibrium":
        return told
    from masonry_fem.results.limit import outside  # noqa: PLC0415 - as above

    note = (
        "the run found an equilibrium all the same: that is for blocks where they came to rest, limit "
        "analysis for rigid blocks where they stood at the start"
    )
    return structs.replace(
        told,
        outside=outside(told, summary.supports, summary.applied),
        notes=told.notes if told.admissible else (*told.notes, note),
    )


def _determinacy(scene: specs.Scene, made: March) -> tuple[ForceDeterminacy | None, dict[str, Any]]:
    """What is determined, where the scene asks for it, and what the summary says then."""
    if not scene.output.determinacy:
        return None, {}
    if not made.last.solution.solved:
        unsolved = "as solved, which is not to the tolerance: nothing is determined"
        return None, {"determinacy": Determinacy(reactions=unsolved)}
    from masonry_fem.march.determinacy import determine  # noqa: PLC0415
    from masonry_fem.results.determinacy import determinacy_summary  # noqa: PLC0415

    told = determine(made.model, made.last)
    return told, {
        "supports": wrenches(told.supports, made.model.assembly.dimension),
        "status": status_counts(told.state),
        "determinacy": determinacy_summary(made.model, told),
    }


def _joints(scene: specs.Scene, made: March, state: SystemState) -> Joints | None:
    """Joints by state, where the scene asks for them."""
    if not scene.output.interfaces or made.model.interfaces.tie.all():
        return None
    from masonry_fem.results.joints import joint_summary  # noqa: PLC0415

    return joint_summary(made.model, state)


def _utilisation(scene: specs.Scene, built: Built, made: March, state: SystemState) -> Utilisation | None:
    """How much of their strength stones use, where some have one."""
    strengths = strengths_of(scene, built.stones)
    if strengths is None:
        return None
    from masonry_fem.results.utilisation import utilisation_summary  # noqa: PLC0415

    return utilisation_summary(made.model, state, strengths)
