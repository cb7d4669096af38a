"""Trial set: some 320 contact problems of masonry, which tell what each part of the contact solver is worth.

python -m benchmarks.trial_set --cache DIR                 # make those that the folder has not yet
python -m benchmarks.trial_set --cache DIR --size tiny     # one of each family, the smallest

Each is the contact problem of a step of a scene, as the program itself gives it to its solver: walls,
arches, domes, lunes and rubble of rigid and elastic blocks, joints with laws, statics and dynamics, the first
step and later ones, which start where the one before ended. The horizontal acceleration is a share of what
limit analysis says the structure bears. Problems are kept as .npz files; nothing of them depends on the
machine but rounding.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Literal
from unittest.mock import patch

import msgspec
import numpy as np
from rich.progress import track

from benchmarks.cases import G
from masonry_fem.analyses.limit import posed
from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.joints import fold
from masonry_fem.limit import collapse_multiplier
from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start, load_problem, solve
from masonry_fem.nscd.files import save_problem
from masonry_fem.scene import check
from masonry_fem.scene import specs as s
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.dome import DomeStructure
from masonry_fem.structures.rubble import RubbleStructure
from masonry_fem.structures.wall import WallStructure
from tests.nscd.families import elastic

Size = Literal["tiny", "default"]
STATICS = s.Statics()
DYNAMICS = s.Dynamics(step=5e-3, duration=1.0)
STONE = {"stone": s.Material(density=2400.0, young=10e9, poisson=0.2)}
LAST = 40  # calls of the solver that a scene may take to the one that is kept


@dataclass(frozen=True, slots=True)
class Recipe:
    """How a problem is made.

    Attributes
    ----------
    family : What it is like. name : What tells it from the others of its family.
    scene : Without its horizontal load; or a problem that is none of a scene's.
    share : Of the load of limit analysis; None: it has no such load.
    call : Which call of the contact solver is kept, from 1; the last one where there are fewer.
    """

    family: str
    name: str
    scene: s.Scene | ContactProblem
    share: float | None
    call: int = 1

    @property
    def path(self) -> str:
        """Name of its file."""
        return f"{self.family} {self.name}".replace(" ", "_").replace("/", "_") + ".npz"


@dataclass(frozen=True, slots=True)
class Trial:
    """A problem of the set, with the start that it was given and the outcomes that are right for it."""

    name: str
    problem: ContactProblem
    start: Start | None
    right: frozenset[str] | None


# --- what the problems are of -----------------------------------------------------------------


def wall(columns: int, courses: int, dimension: int = 3) -> s.Structure:
    brick = (0.4, 0.2, 0.2) if dimension == 3 else (0.4, 0.2)
    return WallStructure(name="wall", material="stone", brick=brick, columns=columns, courses=courses)


def arch(voussoirs: int, thickness: float = 0.2) -> s.Structure:
    return ArchStructure(
        name="arch", material="stone", radius=1.0, thickness=thickness, voussoirs=voussoirs, depth=0.3
    )


def dome(rings: int, slices: int, thickness: float, **more: Any) -> s.Structure:
    return DomeStructure(
        name="dome", material="stone", radius=5.0, thickness=thickness, rings=rings, slices=slices, **more
    )


def rubble(stones: int, seed: int, dimension: int = 3) -> s.Structure:
    size = (1.2, 0.4, 1.0) if dimension == 3 else (2.0, 1.2)
    return RubbleStructure(name="rubble", material="stone", size=size, stones=stones, seed=seed)


def scene(
    structure: s.Structure, friction: float, fidelity: str = "rigid", dimension: int = 3, **keys: Any
) -> s.Scene:
    """A structure of dry joints under its weight."""
    joints = (s.Joint(friction=friction),)
    mesh = s.MeshSettings(element="Q1", divisions=(2,) * dimension)
    loads = s.Loads(gravity=(0.0,) * (dimension - 1) + (-G,))
    given = {"joints": joints, "loads": loads, "analysis": STATICS, "fidelity": fidelity, "mesh": mesh} | keys
    return s.Scene(dimension=dimension, materials=STONE, structures=(structure,), **given)


# --- families -----------------------------------------------------------------------------------


def recipes(size: Size = "default") -> list[Recipe]:
    """All recipes of a size; "tiny" has the first of each family that is made in a second."""
    every = [recipe for family in FAMILIES for recipe in family()]
    if size == "default":
        return every
    firsts: dict[str, Recipe] = {}
    for recipe in every:
        firsts.setdefault(recipe.family, recipe)
    return [recipe for family, recipe in firsts.items() if family != "large walls"]


def _walls() -> Iterator[Recipe]:
    """Rigid, in space and in a plane, standing still."""
    for (columns, courses), friction, share in product(
        ((6, 3), (3, 10), (6, 6)), (0.2, 0.6, 1.2), (0.5, 0.95, 0.99, 1.02)
    ):
        given = scene(wall(columns, courses), friction)
        yield Recipe("walls", f"{columns}x{courses} mu {friction:g} at {share:g}", given, share)
    for (columns, courses), friction, share in product(
        ((8, 4), (4, 12)), (0.1, 0.5, 0.8, 1e3), (0.8, 0.99, 1.1)
    ):
        given = scene(wall(columns, courses, 2), friction, dimension=2)
        yield Recipe("plane walls", f"{columns}x{courses} mu {friction:g} at {share:g}", given, share)


def _arches() -> Iterator[Recipe]:
    for voussoirs, friction, share in product((11, 41), (0.45, 0.7, 1e3), (0.5, 0.99, 1.02)):
        given = scene(arch(voussoirs), friction, dimension=2)
        yield Recipe("plane arches", f"{voussoirs} mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.5, 0.8), (0.5, 0.99, 1.1)):
        yield Recipe("arches", f"15 mu {friction:g} at {share:g}", scene(arch(15), friction), share)


def _domes() -> Iterator[Recipe]:
    for friction, share in product((0.4, 0.8), (None, 0.5, 0.95, 1.1)):
        told = "weight" if share is None else f"at {share:g}"
        yield Recipe("domes", f"6x10 mu {friction:g} {told}", scene(dome(6, 10, 0.5), friction), share)
    for friction, ratio in product((0.25, 0.4, 0.6), (0.045, 0.07, 0.1)):
        lune = dome(18, 1, 5 * ratio, sweep=5.0, sides=True)
        smooth = (s.Joint(friction=friction), s.Joint(friction=0.0, interface="meridian"))
        given = scene(lune, friction, joints=smooth)
        yield Recipe("lunes", f"mu {friction:g} thickness {ratio:g}", given, None)


def _rubble() -> Iterator[Recipe]:
    for seed, friction, share in product((1, 2), (0.4, 0.8), (0.5, 0.95, 1.1)):
        given = scene(rubble(30, seed), friction)
        yield Recipe("rubble", f"30 seed {seed} mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.3, 0.8), (0.8, 0.99)):
        given = scene(rubble(40, 3, 2), friction, dimension=2)
        yield Recipe("plane rubble", f"40 mu {friction:g} at {share:g}", given, share)


def _elastic() -> Iterator[Recipe]:
    for friction, share in product((0.3, 0.6, 1e3), (0.5, 0.95, 0.99, 1.02)):
        given = scene(wall(4, 4, 2), friction, "elastic", 2)
        yield Recipe("elastic plane walls", f"4x4 mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.3, 0.8), (0.5, 0.95, 1.02)):
        given = scene(wall(3, 3), friction, "elastic")
        yield Recipe("elastic walls", f"3x3 mu {friction:g} at {share:g}", given, share)
    for friction, share in product((0.5, 0.8), (0.5, 0.95, 1.1)):
        given = scene(arch(11), friction, "elastic", 2)
        yield Recipe("elastic arches", f"11 mu {friction:g} at {share:g}", given, share)
    for voussoirs, thickness in ((101, 0.12), (101, 0.11), (201, 0.11), (401, 0.11)):
        given = scene(arch(voussoirs, thickness), 0.7, "elastic", 2)
        yield Recipe("elastic arches", f"{voussoirs} thickness {thickness:g} weight", given, None)
    for friction in (0.4, 0.8):
        given = scene(dome(4, 8, 0.5), friction, "elastic")
        yield Recipe("elastic domes", f"4x8 mu {friction:g} weight", given, None)


def _mixed() -> Iterator[Recipe]:
    """Every other course rigid."""
    rigid = tuple(s.Override(blocks=f"wall.c{k}.*", fidelity="rigid") for k in (1, 3))
    for dimension, friction, share in product((2, 3), (0.4, 0.8), (0.5, 0.95, 1.02)):
        given = scene(wall(3, 4, dimension), friction, "elastic", dimension, overrides=rigid)
        yield Recipe("mixed walls", f"{dimension}D 3x4 mu {friction:g} at {share:g}", given, share)


def _laws() -> Iterator[Recipe]:
    """Joints that hold by more than friction, under what the dry ones bear and more."""
    soft: dict[str, Any] = {"normal_stiffness": 1e10, "tangential_stiffness": 4e9}
    bond: dict[str, Any] = {
        "normal_strength": 1e4, "tangential_strength": 2e4, "normal_energy": 1.0, "tangential_energy": 5.0,
    }  # fmt: skip
    laws: dict[str, dict[str, Any]] = {
        "mohr coulomb": {"law": s.law_record("mohr_coulomb", cohesion=5e3)},
        "springs": {"law": s.law_record("elastic", **soft)},
        "bilinear": {"law": s.law_record("bilinear", **soft, **bond)},
        "mortar": {"mortar": s.Mortar(**soft)},
    }
    for (name, keys), fidelity, share in product(laws.items(), ("rigid", "elastic"), (0.8, 1.1)):
        joints = (s.Joint(friction=0.6, **keys),)
        given = scene(wall(3, 4, 2), 0.6, fidelity, 2, joints=joints)
        yield Recipe("joints with laws", f"{name} {fidelity} 3x4 at {share:g}", given, share, call=3)
    for name, share in product(("mohr coulomb", "bilinear"), (0.8, 1.1)):
        joints = (s.Joint(friction=0.6, **laws[name]),)
        given = scene(wall(3, 4), 0.6, joints=joints, analysis=DYNAMICS)
        yield Recipe("laws in motion", f"{name} 3x4 at {share:g}", given, share, call=8)


def _dynamics() -> Iterator[Recipe]:
    """The first step, and one that has the step before to start from."""
    for (columns, courses), friction, share, call in product(
        ((6, 3), (5, 8)), (0.2, 0.6, 1.2), (0.5, 0.99, 1.1), (1, 10)
    ):
        given = scene(wall(columns, courses), friction, analysis=DYNAMICS)
        name = f"{columns}x{courses} mu {friction:g} at {share:g} step {call}"
        yield Recipe("moving walls", name, given, share, call)
    for friction, share, call in product((0.4, 0.8), (0.95, 1.1), (1, 10)):
        given = scene(wall(3, 3, 2), friction, "elastic", 2, analysis=DYNAMICS)
        name = f"3x3 mu {friction:g} at {share:g} step {call}"
        yield Recipe("moving elastic walls", name, given, share, call)
    for kind, structure in (("arch", arch(15)), ("rubble", rubble(25, 4)), ("dome", dome(5, 8, 0.4))):
        for friction, call in product((0.4, 0.8), (1, 10)):
            given = scene(structure, friction, analysis=DYNAMICS)
            yield Recipe(
                "moving arches and domes", f"{kind} mu {friction:g} at 1.1 step {call}", given, 1.1, call
            )


def _tipping() -> Iterator[Recipe]:
    """Walls that tip and slide at once, well beyond what they bear."""
    for (columns, courses), friction, share in product(((6, 6), (10, 8)), (0.4, 0.6), (1.2, 1.5)):
        given = scene(wall(columns, courses, 2), friction, dimension=2, analysis=DYNAMICS)
        name = f"{columns}x{courses} mu {friction:g} at {share:g}"
        yield Recipe("tipping plane walls", name, given, share)
    for friction, share in product((0.6, 0.7), (1.2, 1.4)):
        given = scene(wall(12, 12), friction, analysis=DYNAMICS)
        yield Recipe("tipping walls", f"12x12 mu {friction:g} at {share:g}", given, share)


def _layers() -> Iterator[Recipe]:
    """Layers of mortar between bricks, all of elements: the layers are slender."""
    for thickness in (1e-2, 2e-3, 5e-4):
        sizes = (0.06, thickness, 0.06)
        heights = np.concatenate([[0.0], np.cumsum(sizes)])
        pile = tuple(
            BlockStructure(
                name=f"b{k}", material="stone", size=(0.22, 0.1, size), position=(0.0, 0.0, heights[k]),
                mesh=s.MeshSettings(element="Q1", divisions=(4, 2, 1 if k == 1 else 2)),
            )
            for k, size in enumerate(sizes)
        )  # fmt: skip
        floor = BlockStructure(
            name="floor", material="stone", size=(2.0, 2.0, 0.1), position=(-0.5, -0.5, -0.1), support=True,
            fidelity="rigid",
        )  # fmt: skip
        push = s.Traction(on="b2/top", vector=(1e5, 0.0, -1e6))
        loads = s.Loads(gravity=(0.0, 0.0, -G), tractions=(push,))
        given = scene(floor, 0.6, "elastic", loads=loads)
        given = msgspec.structs.replace(given, structures=(floor, *pile))
        yield Recipe("layers", f"{1e3 * thickness:g} mm", given, None)


def _rough() -> Iterator[Recipe]:
    """Walls of five blocks that stand, soft by random matrices, and so rough that nothing slips."""
    for dimension, seed in product((2, 3), range(30)):
        made = elastic(np.random.default_rng(seed), dimension, 0.0)
        made = replace(made, friction=np.full(made.count, 100.0))
        yield Recipe("rough walls", f"{dimension}D seed {seed}", made, None)


def _large() -> Iterator[Recipe]:
    for friction, share, analysis in product((0.3, 0.7), (0.5, 0.99), (STATICS, DYNAMICS)):
        told = "statics" if analysis is STATICS else "dynamics"
        given = scene(wall(15, 10), friction, analysis=analysis)
        yield Recipe("large walls", f"15x10 mu {friction:g} at {share:g} {told}", given, share)
    for columns, courses, analysis in ((30, 16, DYNAMICS), (40, 20, STATICS)):
        given = scene(wall(columns, courses), 0.6, analysis=analysis)
        yield Recipe("large walls", f"{columns}x{courses} mu 0.6 at 0.5", given, 0.5)


FAMILIES = (
    _walls,
    _arches,
    _domes,
    _rubble,
    _elastic,
    _mixed,
    _laws,
    _dynamics,
    _tipping,
    _layers,
    _rough,
    _large,
)


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
        if isinstance(given, ContactProblem):
            return given, None
        if recipe.share is not None:
            bears = self.bears(given)
            # what cannot bear its own weight is not pushed, and what bears any push is pushed by its weight
            pull = recipe.share * G * (bears if np.isfinite(bears) else float(bears > 0))
            push = s.Acceleration(vector=(pull,) + (0.0,) * (given.dimension - 1))
            loads = msgspec.structs.replace(given.loads, accelerations=(push,))
            given = msgspec.structs.replace(given, loads=loads)
        kept: list[tuple[ContactProblem, Start | None]] = []

        def listen(
            problem: ContactProblem, settings: SolverSettings | None = None, start: Start | None = None
        ) -> Solution:
            kept.append((problem, start))
            if len(kept) >= min(recipe.call, LAST):
                raise _EnoughError
            return solve(problem, settings, start)

        with (
            patch.object(fold, "solve", listen),
            suppress(_EnoughError),
        ):
            solve_scene(check(given))
        problem, start = kept[-1]
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
        yield Trial(path.stem, load_problem(path), _start(path), right)
    for folder in more:
        for path in sorted(folder.glob("*.npz")):
            yield Trial(f"{folder.name}/{path.stem}", load_problem(path), _start(path), None)


def right_outcomes(recipe: Recipe, bears: float) -> frozenset[str] | None:
    """What a solver may say of a problem; None: limit analysis does not tell.

    Steps in time always have a solution, and so have rough walls. Rigid blocks that can bear their load may
    rest, and none of any kind bear more. Elastic ones below the limit may run off all the same, if nothing
    presses them together.
    """
    solved = {"converged", "inexact"}
    if isinstance(recipe.scene, ContactProblem) or isinstance(recipe.scene.analysis, s.Dynamics):
        return frozenset(solved)
    dry = all(joint.dry for joint in recipe.scene.joints)
    if recipe.share is None or not dry:
        return None
    if np.isnan(bears) or (recipe.share > 1 and np.isfinite(bears)):
        return frozenset({"no_equilibrium"})
    return frozenset(solved if recipe.scene.fidelity == "rigid" else solved | {"at_limit", "unstressed"})


def _start_arrays(start: Start | None) -> dict[str, np.ndarray]:
    if start is None:
        return {}
    given = {"start_impulse": start.impulse, "start_rigid_velocity": start.rigid_velocity}
    return {name: values for name, values in given.items() if values is not None}


def _start(path: Path) -> Start | None:
    with np.load(path, allow_pickle=False) as file:
        if "start_impulse" not in file.files:
            return None
        moves = file["start_rigid_velocity"] if "start_rigid_velocity" in file.files else None
        return Start(file["start_impulse"], moves)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cache", type=Path, required=True, help="folder that problems are kept in")
    parser.add_argument("--size", choices=("tiny", "default"), default="default")
    given = parser.parse_args()
    count = len(recipes(given.size))
    made = list(track(trials(given.cache, given.size), total=count, description="making"))
    sizes = np.sort([trial.problem.count for trial in made])
    warm = sum(trial.start is not None for trial in made)
    print(
        f"{len(made)} problems of {sizes[0]} to {sizes[-1]} contacts, half of them below "
        f"{np.median(sizes):g}; {warm} start where the step before ended"
    )


if __name__ == "__main__":
    main()
