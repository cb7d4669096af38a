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
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import psutil

from masonry_fem.build import Built
from masonry_fem.dynamics.clock import Clock
from masonry_fem.dynamics.march import March
from masonry_fem.errors import MasonryError
from masonry_fem.marking import halved, marked, mesh_overrides
from masonry_fem.post.folder import make_folder
from masonry_fem.post.stress_error import block_errors, unjudged
from masonry_fem.post.summary import write_summary
from masonry_fem.run import RunResult, run
from masonry_fem.scene import save, specs
from masonry_fem.scene.moved import moved
from masonry_fem.solid.mesh import Mesh
from masonry_fem.summary import peak_memory, size

SPARE = 0.95  # of the target: what is aimed at
STALLED = 0.9  # two rounds that each leave more of the error, with twice the unknowns, get nowhere
MEMORY = 0.8  # of the machine's that is free may be used
GROWTH = 4 / 3  # of memory with unknowns: what factors of solids take


@dataclass(frozen=True, slots=True)
class Round:
    """One solution.

    Attributes
    ----------
    round : From 1. unknowns : Of displacement and contact. meshes : Distinct ones, ``made`` of them new.
    error : Estimated, relative, in the energy norm. refined : Blocks that get finer elements next.
    seconds : CPU time [s].
    """

    round: int
    unknowns: int
    meshes: int
    made: int
    error: float
    refined: int
    seconds: float


@dataclass(frozen=True, slots=True)
class Refinement:
    """What a refinement leaves.

    Attributes
    ----------
    result : Run of the last round. scene : With the meshes of that round.
    reached : Whether the estimate is below the target. message : The same as a sentence.
    rounds : In their order. files : Written.
    """

    result: RunResult
    scene: specs.Scene
    reached: bool
    message: str
    rounds: tuple[Round, ...]
    files: list[Path]


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a refinement ends: at its target, or after too many rounds or unknowns."""

    target: float
    rounds: int
    unknowns: int


def refine(
    scene: specs.Scene,
    out: Path,
    base: Path = Path(),
    *,
    target: float = 0.05,
    most_rounds: int = 10,
    most_unknowns: int = 1_000_000,
    quiet: bool = True,
    tell: Callable[[Round], None] | None = None,
) -> Refinement:
    """Solve a scene on finer and finer elements until the error of its stress is estimated at ``target``.

    Parameters
    ----------
    scene, out, base, quiet : As for ``run``; ``out`` gets the files of the last round, and ``refined.toml``.
    target : Relative error in the energy norm.
    most_rounds, most_unknowns : Where to give up.
    tell : Is told each round.

    Raises
    ------
    MasonryError : No block is elastic, the target is not between 0 and 1, or the scene cannot be built.
    """
    if not 0 < target < 1:
        raise MasonryError(f"the error to refine to is {target:g}, expected one between 0 and 1, as 5%")
    make_folder(out)
    search = _Search(scene, base, Limits(target, most_rounds, most_unknowns))
    folder = out / "round"
    try:
        while True:
            result = search.round(folder, quiet)
            files = [*_lifted(folder, out), *_written(search, result, out)]
            if tell is not None:
                tell(search.rounds[-1])
            if search.end:
                break
    except BaseException:  # Ctrl-C too: what there is of the first round is kept, else the last whole one
        if not search.rounds:
            _lifted(folder, out)
        raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    result.files[:] = files
    return Refinement(result, search.solved, search.reached, search.end, tuple(search.rounds), files)


class _Search:
    """The rounds so far, and the scene of the next one."""

    def __init__(self, scene: specs.Scene, base: Path, limits: Limits) -> None:
        self.base, self.solved = base, scene
        self.rounds: list[Round] = []
        self.end = ""  # why there is no further round
        self.reached = False
        self._first, self._next, self._limits = scene, scene, limits
        self._built: Built | None = None
        self._finer: dict[str, specs.MeshSettings] = {}
        self._clock, self._idle = Clock(), peak_memory()

    def round(self, folder: Path, quiet: bool) -> RunResult:
        """Solve, judge, and refine where there is to be another round."""
        shutil.rmtree(folder, ignore_errors=True)
        chosen: list[int] = []

        def is_last(built: Built, march: March) -> bool:
            """Which is the one that is pictured."""
            chosen.extend(self._judged(built, march))
            return bool(self.end)

        result = run(self._next, folder, base=self.base, quiet=quiet, before=self._built, draws=is_last)
        result.summary["refinement"] = self.told()
        self._built, self.solved = result.built, self._next
        if not self.end:
            self._refine(result.built, chosen)
        return result

    def told(self) -> dict[str, Any]:
        """What ``summary.json`` says."""
        return {
            "target": self._limits.target,
            "reached": self.reached,
            "message": self.end or "Interrupted: there was to be another round.",
            "rounds": [asdict(one) for one in self.rounds],
        }

    def _judged(self, built: Built, march: March) -> list[int]:
        """Enter the round; the blocks that want finer elements."""
        errors = block_errors(march.model, march.state)
        if errors is None:
            raise MasonryError("nothing to refine: no block is elastic; give some fidelity = 'elastic'")
        given = np.isin(errors.block, list(built.stones.given))
        allowed = (SPARE * self._limits.target) ** 2 * errors.total
        cells = np.array([len(_mesh(built, int(block)).cells) for block in errors.block], dtype=float)
        chosen = marked(np.where(given, 0.0, errors.square), cells, allowed)
        blind = unjudged(errors, march.model) & ~given
        chosen |= blind
        d = built.model.assembly.dimension
        growth = 1.0 + (2**d - 1) * float(cells[chosen].sum() / cells.sum())
        unknowns = size(built)["unknowns"]
        self.end = self._why_last(march, errors.relative, bool(blind.any()), unknowns, growth)
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

    def _why_last(self, march: March, error: float, blind: bool, unknowns: int, growth: float) -> str:
        """Why this is the last round; "" where it is not. ``blind``: some blocks cannot be judged yet."""
        if march.outcome not in ("equilibrium", "finished"):
            return f"Not refined: {march.message}"
        said = f"The error of the stress is estimated at {_percent(error)}"
        self.reached = error <= self._limits.target and not blind
        if self.reached:
            return f"{said}; {_percent(self._limits.target)} was asked for."
        why = self._obstacle(error, unknowns, growth)
        missed = f", not {_percent(self._limits.target)}" if error > self._limits.target else ""
        missed += ", and does not show that of blocks one linear element thick" if blind else ""
        return f"{said}{missed}: {why}" if why else ""

    def _obstacle(self, error: float, unknowns: int, growth: float) -> str:
        """Why there can be no further round; "" where there can."""
        if growth == 1.0:
            return "all blocks came with their elements, which stay."
        if self._stalls(error, unknowns):
            return (
                "it hardly falls as elements become finer, as at sharp corners under load. Read stresses "
                "away from them."
            )
        if len(self.rounds) + 1 >= self._limits.rounds:
            return f"{self._limits.rounds} rounds are made. Allow more, or begin with finer elements."
        if unknowns * growth > self._limits.unknowns:
            return (
                f"the next round would have about {unknowns * growth:.2g} unknowns, and "
                f"{self._limits.unknowns:.2g} are allowed. Allow more, or take elements of order 2."
            )
        needed = self._idle + (peak_memory() - self._idle) * growth**GROWTH
        free = psutil.virtual_memory().available + psutil.Process().memory_info().rss
        there = MEMORY * free / 1024**2
        if needed <= there:
            return ""
        return (
            f"the next round would need about {needed:.0f} MB of memory, and {there:.0f} MB are free. Take a "
            "larger machine, elements of order 2, or fewer elastic blocks."
        )

    def _stalls(self, error: float, unknowns: int) -> bool:
        if len(self.rounds) < 2:
            return False
        older, newer = self.rounds[-2:]
        slow = error > STALLED * newer.error and newer.error > STALLED * older.error
        return slow and unknowns > 2 * older.unknowns

    def _refine(self, built: Built, chosen: list[int]) -> None:
        """The scene of the next round, with finer elements in the chosen blocks."""
        assembly, stones = built.model.assembly, built.stones
        for block in chosen:
            volume = assembly.solid(block).mass_properties().volume
            self._finer[assembly.blocks[block].name] = halved(stones.mesh[block], _mesh(built, block), volume)
        groups = {assembly.blocks[b].name: assembly.blocks[b].groups for b in stones.of_role("elastic")}
        overrides = (*self._first.overrides, *mesh_overrides(self._finer, groups))
        self._next = msgspec.structs.replace(self._first, overrides=overrides)


def _mesh(built: Built, block: int) -> Mesh:
    """Elements of an elastic block."""
    assembly = built.model.assembly
    mesh = assembly.shapes[assembly.blocks[block].shape].mesh
    assert mesh is not None
    return mesh


def _meshes(built: Built) -> set[int]:
    """Which meshes there are."""
    return {id(shape.mesh) for shape in built.model.assembly.shapes if shape.mesh is not None}


def _percent(error: float) -> str:
    return f"{100 * error:.3g} %"


def _lifted(folder: Path, out: Path) -> list[Path]:
    """Move a round's files to where they belong; those of the round before are replaced."""
    files = []
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            place = out / path.relative_to(folder)
            place.parent.mkdir(parents=True, exist_ok=True)
            files.append(path.replace(place))
    return [path for path in files if path.name != "summary.json" and path.parent == out]


def _written(search: _Search, result: RunResult, out: Path) -> list[Path]:
    """The scene of the round, to be run again, and the summary with the rounds so far."""
    scene = out / "refined.toml"
    save(moved(search.solved, search.base, out), scene)
    return [scene, write_summary(out / "summary.json", result.summary)]
