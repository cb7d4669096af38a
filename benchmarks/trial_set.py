"""Trial set: some 400 contact problems of masonry, which tell what each part of the contact solver is worth.

python -m benchmarks.trial_set --cache DIR                 # make those that the folder has not yet
python -m benchmarks.trial_set --cache DIR --size tiny     # one of each family, the smallest

Each is the contact problem of a step of a scene, as the program itself gives it to its solver: walls,
arches, domes, lunes and rubble of rigid and elastic blocks, joints with laws, statics and dynamics, the first
step and later ones, which start where the one before ended, and later rounds of one step, whose blocks have
turned. The horizontal acceleration is a share of what limit analysis says the structure bears. Problems are
kept as .npz files; nothing of them depends on the machine but rounding.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from itertools import count
from pathlib import Path
from unittest.mock import patch

import msgspec
import numpy as np
from rich.progress import track

from benchmarks.cases import G
from benchmarks.trial_recipes import NEXT_TO, STATICS, TOLERANCE, Recipe, Size, recipes
from masonry_fem.analyses.limit import posed
from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.joints import fold
from masonry_fem.limit import collapse_multiplier
from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start, load_problem, solve
from masonry_fem.nscd.files import save_problem
from masonry_fem.scene import check
from masonry_fem.scene import specs as s


@dataclass(frozen=True, slots=True)
class Trial:
    """A problem of the set, with the start that it was given, and what is right for it.

    That is its outcome, and how many joints its mechanism has; None: nobody knows. The tolerance is what the
    solver is asked for.
    """

    name: str
    problem: ContactProblem
    start: Start | None
    right: frozenset[str] | None
    joints: int | None = None
    tolerance: float = TOLERANCE


# --- making and reading -------------------------------------------------------------------------


class _EnoughError(Exception):
    """The solver was called as often as was asked for."""


class Maker:
    """Makes problems; loads of limit analysis are found once for each structure and friction."""

    def __init__(self) -> None:
        self._bears: dict[bytes, float] = {}

    def make(self, recipe: Recipe) -> tuple[ContactProblem, Start | None]:
        """The problem of a recipe, and what the program would have started it from."""
        given = recipe.scene
        if not isinstance(given, s.Scene):
            return given if isinstance(given, ContactProblem) else given(), None
        if recipe.share is not None:
            bears = self.bears(given)
            # what cannot bear its own weight is not pushed, and what bears any push is pushed by its weight
            pull = recipe.share * G * (bears if np.isfinite(bears) else float(bears > 0))
            push = s.Acceleration(vector=(pull,) + (0.0,) * (given.dimension - 1))
            loads = msgspec.structs.replace(given.loads, accelerations=(push,))
            given = msgspec.structs.replace(given, loads=loads)
        kept: list[tuple[ContactProblem, Start | None]] = []
        calls = count(1)

        def listen(
            problem: ContactProblem, settings: SolverSettings | None = None, start: Start | None = None
        ) -> Solution:
            kept[:] = [(problem, start)]
            if next(calls) == recipe.call:
                raise _EnoughError
            return solve(problem, settings, start)

        with (
            patch.object(fold, "solve", listen),
            suppress(_EnoughError),
        ):
            solve_scene(check(given))
        ((problem, start),) = kept
        return problem, start if start is not None and start.impulse is not None else None

    def bears(self, given: s.Scene) -> float:
        """Horizontal acceleration in g that dry rigid blocks bear; inf: any; nan: not even their weight."""
        joints = tuple(msgspec.structs.replace(joint, law=None, mortar=None) for joint in given.joints)
        dry = msgspec.structs.replace(given, joints=joints, fidelity="rigid", overrides=(), analysis=STATICS)
        key = msgspec.json.encode(dry)
        if key not in self._bears:
            dry = check(dry)
            problem, _ = posed(dry, build(dry, Path(), solved=False), tilt="x")
            self._bears[key] = collapse_multiplier(problem).multiplier
        return self._bears[key]


def trials(cache: Path, size: Size = "default", more: tuple[Path, ...] = ()) -> Iterator[Trial]:
    """The set, one after the other, and beside it the problems (.npz) of other folders.

    Parameters
    ----------
    cache : Folder that problems are kept in; what is missing is made. size : Which of them.
    more : Folders of further problems, of which the right outcome is not known.
    """
    cache.mkdir(parents=True, exist_ok=True)
    maker = Maker()
    for recipe in recipes(size):
        path = cache / recipe.path
        if not path.exists():
            problem, start = maker.make(recipe)
            bears = np.nan
            if isinstance(recipe.scene, s.Scene) and recipe.share is not None:
                bears = maker.bears(recipe.scene)
            save_problem(problem, path, _start_arrays(start) | {"bears": np.array(bears)})
        with np.load(path, allow_pickle=False) as file:
            right = right_outcomes(recipe, float(file["bears"]))
        yield Trial(path.stem, load_problem(path), _start(path), right, recipe.joints, recipe.tolerance)
    for folder in more:
        for path in sorted(folder.glob("*.npz")):
            yield Trial(f"{folder.name}/{path.stem}", load_problem(path), _start(path), None)


def right_outcomes(recipe: Recipe, bears: float) -> frozenset[str] | None:
    """What a solver may say of a problem; None: limit analysis does not tell.

    Steps in time always have a solution, and so have rough walls. Rigid blocks that can bear their load may
    rest, and none of any kind bear more. Elastic ones below the limit may run off all the same, if nothing
    presses them together.
    """
    solved = {"converged"}
    if recipe.falls is not None:
        return frozenset({"no_equilibrium"} if recipe.falls else solved)
    if not isinstance(recipe.scene, s.Scene) or isinstance(recipe.scene.analysis, s.Dynamics):
        return frozenset(solved)
    dry = all(joint.dry for joint in recipe.scene.joints)
    if recipe.share is None or not dry or abs(recipe.share - 1) < NEXT_TO:
        return None
    if np.isnan(bears) or (recipe.share > 1 and np.isfinite(bears)):
        return frozenset({"no_equilibrium"})
    return frozenset(solved if recipe.scene.fidelity == "rigid" else solved | {"at_limit", "unstressed"})


def _start_arrays(start: Start | None) -> dict[str, np.ndarray]:
    if start is None:
        return {}
    return {f"start_{name}": values for name, values in asdict(start).items() if values is not None}


def _start(path: Path) -> Start | None:
    with np.load(path, allow_pickle=False) as file:
        given = {field.name: f"start_{field.name}" for field in fields(Start)}
        kept = {name: file[key] for name, key in given.items() if key in file.files}
    return Start(**kept) if kept else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cache", type=Path, required=True, help="folder that problems are kept in")
    parser.add_argument("--size", choices=("tiny", "default"), default="default")
    given = parser.parse_args()
    made = list(track(trials(given.cache, given.size), total=len(recipes(given.size)), description="making"))
    sizes = np.sort([trial.problem.count for trial in made])
    warm = sum(trial.start is not None for trial in made)
    led = sum(trial.start is not None and trial.start.velocity is not None for trial in made)
    print(
        f"{len(made)} problems of {sizes[0]} to {sizes[-1]} contacts, half of them below "
        f"{np.median(sizes):g}; {warm} start where another ended, {led} of them in full"
    )


if __name__ == "__main__":
    main()
