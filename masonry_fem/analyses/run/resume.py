"""Resume: a run goes on from the checkpoint in its results folder, bit for bit as if it had not ended.

result = resume("results/arch")                                          # after a kill, or Ctrl-C
result = resume("results/arch", ("analysis.duration=2",))                # after its end
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from masonry_fem.analyses.run.reopening import untrusted
from masonry_fem.analyses.run.result import RunResult
from masonry_fem.analyses.run.writing import go_on
from masonry_fem.output.checkpoint import CHECKPOINT, Checkpoint, CheckpointError, read_checkpoint
from masonry_fem.output.folder import refuse_busy
from masonry_fem.records.remark import first_few
from masonry_fem.scene import loads, specs
from masonry_fem.scene.overrides import texts, trusting_text
from masonry_fem.scene.writing import plain

SHOWN = 3  # differences that a message names
FREE = ("output", "analysis", "title", "reading", "large")  # keys of a scene that may be changed on the way


class EndedError(CheckpointError):
    """A run that is done.

    Parameters
    ----------
    text : The message. outcome : How the run ended.
    """

    def __init__(self, text: str, outcome: str) -> None:
        super().__init__(text)
        self.outcome = outcome


def resume(
    folder: str | Path, overrides: Iterable[str] = (), *, trust: bool = False, quiet: bool = True
) -> RunResult:
    """Continue a run from its last checkpoint, and write its results as if it had not been interrupted.

    Parameters
    ----------
    folder : Results folder of a run with checkpoints (``output.checkpoint_steps``).
    overrides : Texts ``dotted.key=value`` that ask for more steps or for other outputs.
    trust : Whether to run files of the scene that are programs (``.geo``, ``.py``).
    quiet : Whether to show no progress on a terminal.

    Raises
    ------
    CheckpointError : There is no checkpoint, it does not fit, or the overrides change anything else.
    EndedError : All steps have been made already.
    """
    folder = Path(folder)
    refuse_busy(folder)
    checkpoint = read_checkpoint(folder)
    overrides = list(texts(overrides))
    source = f"{folder / CHECKPOINT} (its scene)"
    text = untrusted(checkpoint.scene)
    trusted = trusting_text(text, overrides) if trust else []
    first = loads(text, trusted, base=folder, source=source)
    scene = loads(text, [*overrides, *trusted], base=folder, source=source)
    _refuse_changes(first, scene)
    _refuse_other_steps(first.analysis, scene, checkpoint)
    return go_on(scene, folder, checkpoint, quiet=quiet)


def _refuse_changes(first: specs.Scene, scene: specs.Scene) -> None:
    """Refuse another scene, and tell the differences."""
    told = [
        difference
        for key in scene.__struct_fields__
        if key not in FREE
        for difference in _differences(plain(getattr(first, key)), plain(getattr(scene, key)), key)
    ]
    if told:
        raise CheckpointError(
            f"a run is resumed with its own scene, but {first_few(told, SHOWN, separator='; ')}: leave that "
            "as it was, or let another scene start from where this one ended (analysis.start)"
        )


def _differences(one: Any, other: Any, path: str) -> Iterator[str]:
    if isinstance(one, dict) and isinstance(other, dict):
        for key in dict.fromkeys([*one, *other]):
            yield from _differences(one.get(key), other.get(key), f"{path}.{key}")
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for number, pair in enumerate(zip(one, other, strict=True)):
            yield from _differences(*pair, f"{path}.{number}")
    elif one != other:
        yield f"{path} was {_shown(one)}, and is {_shown(other)}"


def _shown(value: Any) -> str:
    return "left out" if value is None else f"{value!r:.60}"


def _refuse_other_steps(before: specs.Analysis, scene: specs.Scene, checkpoint: Checkpoint) -> None:
    """Refuse an analysis whose first steps are not those that were made, and one that has no more."""
    if scene.combinations and before != scene.analysis:
        changed = "; ".join(_differences(plain(before), plain(scene.analysis), "analysis"))
        raise CheckpointError(
            f"combinations that are done would be of another analysis than the others ({changed}): leave "
            "that as it was, or go on with the folder of one combination"
        )
    done = 0 if checkpoint.standing is None else checkpoint.standing.done
    _refuse_other_plan(before, scene.analysis, done)
    at = checkpoint.standing
    changes = at is not None and (at.ages or any(one is not None for one in at.warmed))
    fades = scene.analysis.start is not None and changes
    _refuse_other_ramp(before, scene, fades=fades)
    if checkpoint.outcome and (_steps(before, done, 1) or not _steps(scene.analysis, done, 1)):
        raise EndedError(
            f"the run has come to its end ({checkpoint.outcome}), nothing is left to do; for more steps of a "
            "march in time set analysis.duration, or analysis.max_steps where it ran out of them",
            checkpoint.outcome,
        )


def _refuse_other_plan(before: specs.Analysis, after: specs.Analysis, done: int) -> None:
    """Refuse an analysis of another kind, or whose first ``done`` steps are others."""
    counts = {"load_steps", "duration", "max_steps"}
    same = type(before) is type(after) and all(
        getattr(before, key) == getattr(after, key) for key in before.__struct_fields__ if key not in counts
    )
    if not same or _steps(before, 0, done) != _steps(after, 0, done):
        changed = "; ".join(_differences(plain(before), plain(after), "analysis"))
        raise CheckpointError(
            f"the {done} steps that are made are not the first ones of this analysis ({changed}): a march in "
            "time goes on with a longer duration, or more max_steps; let another scene start from where this "
            "one ended for anything else (analysis.start)"
        )


def _refuse_other_ramp(before: specs.Analysis, scene: specs.Scene, *, fades: bool) -> None:
    """Refuse an analysis whose ramp, which motions follow that have no time of their own, is another.

    ``fades``: so may temperatures and materials of the start.
    """
    after = scene.analysis
    motions = [one.motion.time for one in scene.supports if one.motion is not None]
    times = motions + [one.time for one in scene.loads.temperatures]
    if before.ramp != after.ramp and (fades or None in times):
        raise CheckpointError(
            f"motions, materials or temperatures without a time function go on until t = {before.ramp:g} s, "
            f"with this analysis until {after.ramp:g} s, so that steps that are made would be others; give "
            "motions and temperatures a time, and let another scene start from this end (analysis.start)"
        )


def _steps(plan: specs.Analysis, first: int, count: int) -> list[Any]:
    """So many steps of an analysis, as far as it has them."""
    return list(islice(plan.schedule(), first, first + count))
