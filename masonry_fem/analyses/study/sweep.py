"""Study: one scene with many settings, what each costs, how far each is off, and which to use.

made = study("arch.toml", {"mesh.size": [0.2, 0.1], "fidelity": ["rigid", "elastic"]}, accuracy=0.01)
made.recommendations[0].words
made.write(Path("results/arch-study"))
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from masonry_fem.analyses.cells.cell import Cell, fingerprint
from masonry_fem.analyses.cells.crew import Crew
from masonry_fem.analyses.cells.history import FOLDER, last_stage
from masonry_fem.analyses.cells.kept import Kept, Tell, outlook
from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.cells.unwritten import unwritten
from masonry_fem.analyses.study.comparison import Comparison, compare
from masonry_fem.analyses.study.notes import explores, notes, replaced, unseen
from masonry_fem.analyses.study.outputs import write_study
from masonry_fem.analyses.study.pareto import Point, gather
from masonry_fem.analyses.study.plan import plan
from masonry_fem.analyses.study.recommendation import recommend
from masonry_fem.analyses.study.reference import Reference
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.target import Target, targets
from masonry_fem.analyses.study.variation import Variation, variations
from masonry_fem.errors import MasonryError
from masonry_fem.output.folder import Folder
from masonry_fem.records.record import check_share
from masonry_fem.results.study import Recommendation
from masonry_fem.scene import Scene, dumps, loads
from masonry_fem.scene.misfit import listed
from masonry_fem.scene.overrides import texts


@dataclass(frozen=True, slots=True)
class Study:
    """Results of a study; a cell is one combination of the varied values.

    Attributes
    ----------
    title : Title of the scene.
    vary : Varied keys and their values.
    rows : Settings, cost and quantities of each cell, the coarsest first.
    reference : What the cells are compared with.
    comparisons : One for each case.
    targets, accuracy : Quantities that the recommendations are for, and the wanted relative error.
    recommendations : One for each target.
    notes : What was done otherwise than asked, and what the study cannot tell.
    folder : Folder in which the results of the cells are kept.
    interrupted : Whether it was interrupted.
    """

    title: str
    vary: tuple[Variation, ...]
    rows: tuple[Row, ...]
    reference: Reference
    comparisons: tuple[Comparison, ...]
    targets: tuple[Target, ...]
    accuracy: float
    recommendations: tuple[Recommendation, ...]
    notes: tuple[str, ...]
    folder: Path
    interrupted: bool = False

    def __repr__(self) -> str:
        """The tables that the command prints."""
        from rich.console import Console  # noqa: PLC0415 - only who looks needs it

        from masonry_fem.analyses.study.table import print_study  # noqa: PLC0415

        page = io.StringIO()
        print_study(self, Console(file=page, force_jupyter=False))
        return page.getvalue().rstrip()

    @property
    def decided(self) -> bool:
        """Whether any cell was solved."""
        return any(row.solved for row in self.rows)

    @property
    def outlook(self) -> str:
        """How many cells are done, and how to go on."""
        done = sum(row.outcome != "missing" for row in self.rows)
        return outlook(done, len(self.rows), "cells are done", self.folder)

    @property
    def explores(self) -> bool:
        """Whether each cell is a problem of its own, so that values are told, and no errors."""
        return explores(self.vary, self.reference)

    def points(self, target: Target) -> list[Point]:
        """Cost and error of each setting for a target."""
        return gather(self.comparisons, self.vary, target.names)

    def row(self, **settings: Any) -> Row:
        """The first row with the given settings; dots of keys are written as two underscores."""
        wanted = {key.replace("__", "."): str(value) for key, value in settings.items()}
        for row in self.rows:
            if all(row.cell.settings.get(key) == value for key, value in wanted.items()):
                return row
        raise MasonryError(f"no cell has {wanted}")

    def write(self, directory: str | Path | None = None, *, pictures: bool = True) -> list[Path]:
        """Write ``study.csv``, ``study.json`` and ``pareto.png`` or ``values.png``; returns their paths."""
        return write_study(self, self.folder if directory is None else Path(directory), pictures=pictures)


def study(
    scene: Scene | str | Path,
    vary: Mapping[str, Sequence[Any]] | Iterable[str],
    *,
    base: str | Path | None = None,
    out: str | Path | None = None,
    overrides: Sequence[str] = (),
    reference: Any = None,
    quantities: Sequence[str] = (),
    peaks: Sequence[str] = (),
    accuracy: float = 0.01,
    workers: int | None = None,
    time_limit: float | None = None,
    fresh: bool = False,
    tell: Tell | None = None,
) -> Study:
    """Run a scene with all combinations of some values, and compare cost and results.

    Each combination is called a cell.

    Parameters
    ----------
    scene : A scene, or the path of its file.
    vary : Values by dotted key, or texts ``key=value,value``.
    base : Folder that paths in the scene are relative to; None: that of its file, else the current one.
    out : Folder of the results, in which a later call finds them; None: ``results/SCENE-study``.
    overrides : Texts ``key=value`` for all cells.
    reference : What to compare with: None for the finest cell, settings of a cell, a results folder, a file
        of numbers, or numbers by name.
    quantities : Names, groups or patterns of quantities to compare; empty for all.
    peaks : Names of numbers whose greatest absolute value over the steps is recorded and compared:
        ``supports.NAME.x``, ``probes.NAME``, ``time``.
    accuracy : Wanted relative error.
    workers : Number of cells that run at the same time; None: as cores and memory allow.
    time_limit : CPU time that a cell may take [s]; None: no limit.
    fresh : Whether to repeat cells whose results are kept.
    tell : Called with the number of finished cells, the number of all, and what was finished last.

    Raises
    ------
    MasonryError : Unknown keys or peaks, no values, or too many cells.
    """
    check_share("accuracy", accuracy)
    quantities, peaks = texts(quantities), texts(peaks)
    varied = variations(vary)
    source = Source.of(scene, overrides, Path(base) if base else None)
    wanted = Reference.of(reference, varied)
    varied = wanted.gather(varied)
    cells = plan(source, varied)
    _refuse_combinations(source, cells)
    folder = source.folder(out, "study")
    crew = Crew(workers, time_limit)
    together = crew.workers > 1
    made = loads(next(cell.scene for cell in cells if cell.scene), base=source.base)
    # what an earlier study told is removed, its cells are not
    with Folder(folder, "study", title=made.title, keeps=[] if fresh else [f"{FOLDER}/"]):
        cells = [_led(cell, source.base, folder) for cell in cells]
        told, interrupted = Kept(folder, fresh=fresh).computed(cells, crew, source.base, tell)
    rows = tuple(_row(cell, told, peaks) for cell in cells)
    wanted.check(rows)
    comparisons, aims = _compared(rows, varied, wanted, quantities)
    blind = unseen(made, varied, rows) if wanted.given is None else []
    advised = () if explores(varied, wanted) else aims
    advice = tuple(recommend(aim, comparisons, varied, accuracy, blind) for aim in advised)
    said = (
        *replaced(source, varied),
        *unwritten(made, "a study"),
        *notes(varied, rows, comparisons, wanted, together=together),
    )
    return Study(
        made.title, varied, rows, wanted, comparisons, aims, accuracy, advice, said, folder, interrupted
    )


def _refuse_combinations(source: Source, cells: Sequence[Cell]) -> None:
    """Refuse scenes of which each cell would have several ends."""
    for scene in (loads(cell.scene, base=source.base) for cell in cells if cell.scene):
        if scene.combinations:
            names = listed(one.name for one in scene.combinations)
            raise MasonryError(
                f"{source.name} has the load combinations {names}, and a cell of a study is one run: 'run' "
                "the scene for the envelope, and vary keys of the as_run.toml that stands in a combination's "
                "folder; 'threshold' searches in all of them"
            )


def _led(cell: Cell, base: Path, folder: Path) -> Cell:
    """The cell as its last stage, from where those before end; what these have in common is run once."""
    scene = None if cell.scene is None else loads(cell.scene, base=base)
    if scene is None or not scene.stages:
        return cell
    try:
        own = last_stage(scene, base, folder)
    except MasonryError as error:
        return replace(cell, scene=None, fault=str(error))
    return replace(cell, scene=dumps(own), key=fingerprint(own, base))


def _row(cell: Cell, told: Mapping[str, Any], peaks: Sequence[str]) -> Row:
    if cell.scene is None:
        return Row.unsolved(cell, "bad_scene", cell.fault)
    if cell.key not in told:
        return Row.unsolved(cell, "missing", "not computed yet")
    return Row.of(cell, told[cell.key], peaks)


def _compared(
    rows: Sequence[Row], vary: Sequence[Variation], wanted: Reference, quantities: Sequence[str]
) -> tuple[tuple[Comparison, ...], tuple[Target, ...]]:
    """The comparison of each case, and what advice is for: nothing where no cell was solved."""
    comparisons = tuple(compare(case, vary, wanted, quantities) for case in _cases(rows, vary))
    solved = any(row.solved for row in rows)
    return comparisons, tuple(targets(comparisons, quantities)) if solved else ()


def _cases(rows: Sequence[Row], vary: Sequence[Variation]) -> list[list[Row]]:
    """Rows that answer one problem, together."""
    found: dict[tuple[int, ...], list[Row]] = {}
    for row in rows:
        pairs = zip(vary, row.cell.places, strict=True)
        found.setdefault(tuple(place for one, place in pairs if one.is_case), []).append(row)
    return list(found.values())
