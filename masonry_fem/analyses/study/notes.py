"""Notes: what the reader of a study must know besides its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.study.comparison import Comparison
from masonry_fem.analyses.study.plan import room
from masonry_fem.analyses.study.reference import Reference
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.variation import Variation
from masonry_fem.scene import Scene


def replaced(source: Source, vary: Sequence[Variation]) -> list[str]:
    """Notes on keys of the scene that varied keys replace.

    Parameters
    ----------
    source : The scene. vary : Keys and their values.
    """
    made = room(source, vary)
    return [f"what is varied replaces a key of the scene, whose rest is {one}" for one in made]


def notes(
    vary: Sequence[Variation],
    rows: Sequence[Row],
    comparisons: Sequence[Comparison],
    reference: Reference,
    *,
    together: bool = True,
) -> list[str]:
    """Notes on a finished study.

    Parameters
    ----------
    vary : Keys and their values.
    rows : All cells with their results.
    comparisons : One per case.
    reference : What they were compared with.
    together : Whether cells were computed side by side.
    """
    said = []
    cases = [one.key for one in vary if one.is_case]
    if explores(vary, reference):
        said.append(
            "each cell is a different problem: its values are shown; for errors vary the mesh or another "
            "key of accuracy, too"
        )
    elif cases:
        said.append(
            f"{' and '.join(cases)} poses another problem with each value: each is compared with its own "
            "finest cell, errors are the worst of all, costs their sum"
        )
    if reference.given is None:
        said += _unordered(vary)
        said += _not_finest(vary, comparisons)
    else:
        said.append("the reference comes from outside and is taken as exact")
    left = sorted({name for made in comparisons for name in made.left_out})
    if left:
        said.append(f"too small to be compared: {', '.join(left)}")
    if together and sum(row.solved for row in rows) > 1:
        said.append(
            "CPU times of cells side by side, which share caches and memory, are a few per cent longer"
        )
    return said


def explores(vary: Sequence[Variation], reference: Reference) -> bool:
    """Whether no two cells pose one problem, so that none tells of another's error.

    Parameters
    ----------
    vary : Keys and their values.
    reference : What cells are compared with.
    """
    return reference.given is None and all(one.is_case for one in vary if len(one.values) > 1)


def unseen(scene: Scene, vary: Sequence[Variation], rows: Sequence[Row]) -> list[str]:
    """Discretisations whose errors the study cannot estimate, as it does not vary them.

    Parameters
    ----------
    scene : The scene.
    vary : Keys and their values.
    rows : All cells with their results.
    """
    told = {one.setting.of for one in vary if len(one.values) > 1}
    found = []
    if "mesh" not in told and any("stress.means" in row.quantities for row in rows):
        found.append("the mesh")
    if "time" not in told and not scene.analysis.seeks_equilibrium:
        found.append("the time step")
    return found


def _unordered(vary: Sequence[Variation]) -> Iterator[str]:
    """Which values count as the best only because they come last."""
    last = ", ".join(f"{one.key} = {one.text(one.finest)}" for one in vary if one.setting.role == "given")
    if last:
        yield f"of what has no order the value given last counts as the best: {last}"


def _not_finest(vary: Sequence[Variation], comparisons: Sequence[Comparison]) -> list[str]:
    """References that are not what one would take for the finest."""
    if all(made.reference is None for made in comparisons):
        return ["no cell was solved: there is nothing to compare with"]
    said = chain.from_iterable(_coarse(vary, made) for made in comparisons)
    return list(dict.fromkeys(said))


def _coarse(vary: Sequence[Variation], made: Comparison) -> Iterator[str]:
    """What one case's reference lacks to be the finest."""
    if made.reference is None:
        of = ", ".join(f"{one.key} = {made.rows[0].cell.settings[one.key]}" for one in vary if one.is_case)
        yield f"no cell{' of ' if of else ''}{of} was solved: there is nothing to compare with"
        return
    pairs = zip(vary, made.reference.cell.places, strict=True)
    lower = [one.key for one, place in pairs if not one.is_case and place != one.finest]
    if lower:
        own = ", ".join(f"{key} = {value}" for key, value in made.reference.cell.settings.items())
        yield f"the reference is {own}: not the finest in {', '.join(lower)}"
