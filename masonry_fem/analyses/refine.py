"""Refinement: finer elements where the stress is least exact, until its error is what was asked for.

    found = refine(load("wall.toml"), Path("results"), Path("."), target=0.05)
    found.reached, found.rounds[-1].error        # True, 0.047
    found.scene                                  # with overrides of the mesh for the refined blocks

Each round solves the scene, estimates the error of each block's stress, and halves the elements of the blocks
whose errors dominate; the others keep their elements, matrices and factors.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from msgspec import structs

from masonry_fem.analyses.marking import halved, marked, mesh_overrides
from masonry_fem.analyses.refine_limits import Limits
from masonry_fem.analyses.run import RunResult, run
from masonry_fem.analyses.run.reopening import refuse_start
from masonry_fem.build import Built
from masonry_fem.errors import MasonryError
from masonry_fem.host.atomic import announce
from masonry_fem.march.clock import Clock
from masonry_fem.march.march import March
from masonry_fem.output.folder import OWN, Folder
from masonry_fem.output.report import write_report
from masonry_fem.output.stress_error import block_errors, by_modes, unjudged
from masonry_fem.records.record import check_share
from masonry_fem.records.told import write
from masonry_fem.results.discretisation import RefinementTold, Round
from masonry_fem.results.summarise import size
from masonry_fem.scene import check, save, specs
from masonry_fem.scene.writing import moved
from masonry_fem.solid.mesh import Mesh

SPARE = 0.95  # of the target: what is aimed at


@dataclass(frozen=True, slots=True)
class Refinement:
    """Results of a refinement; a round is one solution, each on finer elements than the one before.

    Attributes
    ----------
    result : Results of the last round.
    scene : The scene with the meshes of that round.
    reached : Whether the estimated error is below the target.
    message : The same as a sentence.
    rounds : Error, unknowns and CPU time of each round, in order.
    files : Paths of the files written.
    """

    result: RunResult
    scene: specs.Scene
    reached: bool
    message: str
    rounds: tuple[Round, ...]
    files: list[Path]

    def __repr__(self) -> str:
        """The message, and the table of the last round's run."""
        return f"{self.message}\n{self.result!r}"


def refine(
    scene: specs.Scene,
    out: str | Path,
    base: str | Path = Path(),
    *,
    target: float = 0.05,
    most_rounds: int = 10,
    most_unknowns: int = 1_000_000,
    quiet: bool = True,
    tell: Callable[[Round], None] | None = None,
) -> Refinement:
    """Solve a scene on finer and finer elements until the estimated error of its stress is below ``target``.

    Parameters
    ----------
    scene, out, base, quiet : As for ``run``; ``out`` gets the files of the last round, and ``refined.toml``,
        the scene with its meshes.
    target : Relative error in the energy norm.
    most_rounds, most_unknowns : Limits at which it gives up.
    tell : Called after each round.

    Raises
    ------
    MasonryError : No block is elastic, the target is not between 0 and 1, or the scene cannot be built.
    """
    out, base = Path(out), Path(base)
    check_share("the error to refine to", target)
    refuse_start(scene, "refinement")
    scene = check(scene, base=base)
    search = _Search(scene, base, Limits(target, most_rounds, most_unknowns))
    with Folder(out, "run", title=scene.title, clears=("view",)):
        files = _rounds(search, out, quiet, tell)
        result = search.result
        assert result is not None
        result.files[:] = [*files, write(out / "summary.json", result.summary)]
        if scene.output.report:  # again: that of the round knows neither the folder nor the rounds
            write_report(out)
    return Refinement(
        result, search.solved, search.reached, search.end, tuple(search.rounds), list(result.files)
    )


def _rounds(search: _Search, out: Path, quiet: bool, tell: Callable[[Round], None] | None) -> list[Path]:
    """Solve round by round, each in a folder of its own; files of the last whole one."""
    folder = out / ".round"
    announce(folder)
    files: list[Path] = []
    try:
        while not search.end:
            search.round(folder, quiet)
            files = [*_lifted(folder, out), _written(search, out)]
            if tell is not None:
                tell(search.rounds[-1])
    except BaseException:  # Ctrl-C too: what there is of the first round is kept, else the last whole one
        if search.result is None:
            _lifted(folder, out, summary=True)
        else:
            write(out / "summary.json", search.result.summary)
        raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return files


class _Search:
    """The rounds so far, and the scene of the next one."""

    def __init__(self, scene: specs.Scene, base: Path, limits: Limits) -> None:
        self.base, self.solved = base, scene
        self.rounds: list[Round] = []
        self.end = ""  # why there is no further round
        self.reached = False
        self._first, self._next, self._limits = scene, scene, limits
        self.result: RunResult | None = None  # of the last whole round
        self._built: Built | None = None
        self._finer: dict[str, specs.MeshSettings] = {}
        self._clock = Clock()

    def round(self, folder: Path, quiet: bool) -> None:
        """Solve, judge, and refine where there is to be another round."""
        shutil.rmtree(folder, ignore_errors=True)
        chosen: list[int] = []

        def is_last(built: Built, march: March) -> bool:
            """Which is the one that is pictured."""
            chosen.extend(self._judged(built, march))
            return bool(self.end)

        result = run(self._next, folder, base=self.base, quiet=quiet, before=self._built, draws=is_last)
        result = replace(result, summary=structs.replace(result.summary, refinement=self.told()))
        self.result, self._built, self.solved = result, result.built, self._next
        if not self.end:
            self._refine(result.built, chosen)

    def told(self) -> RefinementTold:
        """What ``summary.json`` says."""
        return RefinementTold(
            target=self._limits.target,
            reached=self.reached,
            message=self.end or "Interrupted: there was to be another round.",
            rounds=tuple(self.rounds),
        )

    def _judged(self, built: Built, march: March) -> list[int]:
        """Enter the round; the blocks that want finer elements."""
        errors = block_errors(march.model, march.state)
        if errors is None:
            raise MasonryError("nothing to refine: no block is elastic; give some fidelity = 'elastic'")
        modes = by_modes(errors, march.model)
        if modes.all():
            raise MasonryError(
                "nothing to refine: finer elements change nothing of reduced blocks, and no other block "
                "deforms; raise materials.NAME.degree, or give some fidelity = 'elastic'"
            )
        given = modes | np.isin(errors.block, list(built.stones.given))
        allowed = (SPARE * self._limits.target) ** 2 * errors.total
        cells = np.array([len(_mesh(built, int(block)).cells) for block in errors.block], dtype=float)
        chosen = marked(np.where(given, 0.0, errors.square), cells, allowed)
        blind = unjudged(errors, march.model) & ~given
        chosen |= blind
        d = built.model.assembly.dimension
        growth = 1.0 + (2**d - 1) * float(cells[chosen].sum() / cells.sum())
        unknowns = size(built.model)["unknowns"]
        believed = not blind.any()
        self.reached = self._limits.reached(march, errors.relative, believed)
        fixed = float(np.linalg.norm(errors.of_whole[given]))
        self.end = self._limits.why_last(
            self.rounds, march, errors.relative, believed, unknowns, growth, fixed
        )
        known = set() if self._built is None else _meshes(self._built)
        self._clock.lap(str(len(self.rounds)))
        self.rounds.append(
            Round(
                round=len(self.rounds) + 1,
                unknowns=unknowns,
                meshes=len(_meshes(built)),
                made=len(_meshes(built) - known),
                error=errors.relative,
                refined=0 if self.end else int(chosen.sum()),
                seconds=round(self._clock.phases[str(len(self.rounds))], 3),
            )
        )
        return [int(block) for block in errors.block[chosen]]

    def _refine(self, built: Built, chosen: list[int]) -> None:
        """The scene of the next round, with finer elements in the chosen blocks."""
        assembly, stones = built.model.assembly, built.stones
        for block in chosen:
            volume = assembly.solid(block).mass_properties().volume
            self._finer[assembly.blocks.names[block]] = halved(
                stones.mesh[block], _mesh(built, block), volume
            )
        groups = {assembly.blocks.names[b]: assembly.blocks[b].groups for b in stones.deforming}
        overrides = (*self._first.overrides, *mesh_overrides(self._finer, groups))
        self._next = structs.replace(self._first, overrides=overrides)


def _mesh(built: Built, block: int) -> Mesh:
    """Elements of an elastic block."""
    assembly = built.model.assembly
    mesh = assembly.shapes[int(assembly.blocks.shape[block])].mesh
    assert mesh is not None
    return mesh


def _meshes(built: Built) -> set[int]:
    """Which meshes there are."""
    return {id(shape.mesh) for shape in built.model.assembly.shapes if shape.mesh is not None}


def _lifted(folder: Path, out: Path, *, summary: bool = False) -> list[Path]:
    """Move a round's files to where they belong; those of the round before are replaced."""
    files = []
    for path in sorted(folder.rglob("*")):
        inner = path.relative_to(folder)
        if path.is_file() and inner.parts[0] != OWN and (summary or inner.name != "summary.json"):
            place = out / inner
            place.parent.mkdir(parents=True, exist_ok=True)
            announce(place)
            files.append(path.replace(place))
    return [path for path in files if path.parent == out]


def _written(search: _Search, out: Path) -> Path:
    """The scene of the round, to be run again."""
    scene = out / "refined.toml"
    save(moved(search.solved, search.base, out), scene)
    return scene
