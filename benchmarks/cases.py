"""Cases: scenes to time, each run in a process of its own so that its memory is its own.

python -m benchmarks.cases "rigid wall 10x10"    # prints one line of JSON
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.build import build
from masonry_fem.build.stones import lay, meshed
from masonry_fem.contact.detection import detect
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.contact.surface import surfaces_of
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.nscd import SolverSettings, load_problem, solve
from masonry_fem.output.recorder import StepReport
from masonry_fem.results.summarise import peak_memory
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Override,
    Probe,
    Scene,
    Solver,
    Statics,
    Structure,
    Support,
    Table,
    Traction,
    material_record,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.barrel_vault import BarrelVaultStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.rubble import RubbleStructure
from masonry_fem.structures.wall import WallStructure

G = 9.81
SWEEPS = 2000
Row = dict[str, Any]


class StepTimes(list[float]):
    """CPU time of each step [s], as an observer of the march."""

    def __init__(self) -> None:
        self._last = time.process_time()

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        now = time.process_time()
        self.append(now - self._last)
        self._last = now


def scene(structure: Structure, **keys: Any) -> Scene:
    given = {
        "materials": {"stone": Material(density=2400.0, young=10e9, poisson=0.2)},
        "structures": (structure,),
        "joints": (Joint(friction=0.6),),
        "loads": Loads(gravity=(0.0, 0.0, -G)),
    } | keys
    return Scene(**given)


def wall(columns: int, courses: int, brick: tuple[float, ...] = (0.4, 0.2, 0.2)) -> WallStructure:
    return WallStructure(name="wall", material="stone", brick=brick, columns=columns, courses=courses)


def arch(voussoirs: int, thickness: float, depth: float) -> ArchStructure:
    return ArchStructure(
        name="arch", material="stone", radius=1.0, thickness=thickness, voussoirs=voussoirs, depth=depth
    )


def solved(given: Scene) -> Row:
    return told(solve_scene(check(given)))


def told(result: RunResult) -> Row:
    summary = result.summary
    return {
        "outcome": result.outcome,
        "blocks": summary.blocks,
        "shapes": summary.shapes,
        "contacts": summary.contacts,
        "steps": summary.solver.iterations,
        "solves": summary.solver.linear_solves,
        "error": summary.certificate.natural_map,
        "seconds": summary.seconds,
        "memory_mb": peak_memory(),
    }


def rigid_march(structure: Structure, tolerance: float, steps: int) -> Row:
    """A dynamic march as in the peers' table; the first step, which compiles or loads, by itself."""
    marched = {"fidelity": "rigid", "solver": Solver(tolerance=tolerance)}
    # a few steps first: what is loaded at the first use of each method is not the march's
    warm = time.process_time()
    solve_scene(scene(structure, analysis=Dynamics(step=1e-2, duration=5e-2, theta=0.5), **marched))
    warm = time.process_time() - warm
    given = check(scene(structure, analysis=Dynamics(step=1e-2, duration=steps * 1e-2, theta=0.5), **marched))
    built = build(given, Path())
    setup = sum(built.seconds.values())
    times = StepTimes()
    result = solve_scene(given, observers=(times,))
    first, rest = times[0] - setup, np.array(times[1:]) * 1e3
    weight = np.linalg.norm(result.summary.applied)
    total = sum(value.force for value in result.summary.supports.values())
    march = result.march
    speed = 0.0
    for group, own in zip(result.built.model.groups, march.state.bodies, strict=True):
        if not group.prescribed:
            speed = max(speed, float(np.abs(own.velocity[:, :3]).max()))
    return told(result) | {
        "step_ms": {"median": float(np.median(rest)), "mean": float(rest.mean()), "max": float(rest.max())},
        "first_step_ms": 1e3 * first,
        "warm_up_s": warm,
        "reaction_error": abs(float(np.linalg.norm(total)) / weight - 1),
        "speed": speed,
    }


def low_wall(size: float) -> Row:
    return solved(scene(wall(4, 5, (0.5, 0.25, 0.25)), mesh=MeshSettings(size=size), analysis=Statics()))


def elastic_arch() -> Row:
    return solved(scene(arch(11, 0.3, 0.3), mesh=MeshSettings(divisions=(8, 8, 8)), analysis=Statics()))


def falling_arch() -> Row:
    """An elastic arch whose springings part until it falls to the ground, 1.3 m below its crown."""
    slowly = Table(points=((0.0, 0.0), (0.5, 1.0)))
    parted = tuple(
        Support(on=f"arch.springing_{side}", motion=Motion(displacement=(way, 0.0), time=slowly))
        for side, way in (("left", -0.1), ("right", 0.1))
    )
    ring = ArchStructure(
        name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=21, straight=True
    )
    ground = BlockStructure(
        name="ground", material="stone", size=(4.0, 0.2), position=(-2.0, -0.5), support=True
    )
    given = scene(
        ring,
        dimension=2,
        structures=(ring, ground),
        supports=parted,
        mesh=MeshSettings(divisions=(2, 2)),
        loads=Loads(gravity=(0.0, -G)),
        probes=(Probe(name="crown", block="arch.v11", point=(0.0, 1.0)),),
        analysis=Dynamics(step=2e-3, duration=1.6, theta=1.0),
    )
    result = solve_scene(check(given))
    return told(result) | {"fallen": -float(result.summary.probes["crown"][1])}


def elastic_wall(
    count: int,
    analysis: Statics | Dynamics,
    tolerance: float | None = None,
    size: float = 0.1,
    push: float = 0.0,
    friction: float = 0.6,
) -> Row:
    """A wall of so many columns and courses.

    Parameters
    ----------
    count, analysis, tolerance : Of the wall and of its solution.
    size : Length of its elements [m]. push : Acceleration along the wall, over that of gravity.
    friction : Of its joints.
    """
    return solved(
        scene(
            wall(count, count),
            mesh=MeshSettings(size=size),
            analysis=analysis,
            solver=Solver(tolerance=tolerance),
            joints=(Joint(friction=friction),),
            loads=Loads(gravity=(push * G, 0.0, -G)),
            large=True,  # what is foreseen for 200×200 is 19 GB
        )
    )


def elastic_steps(count: int, steps: int) -> Row:
    """Steps of a wall of 2×1×1 bricks under its weight, from rest, to 1e-6; the first one by itself."""
    given = scene(
        wall(count, count),
        mesh=MeshSettings(size=0.2),
        analysis=Dynamics(step=1e-2, duration=steps * 1e-2, theta=1.0),
        solver=Solver(tolerance=1e-6),
    )
    times = StepTimes()
    result = solve_scene(check(given), observers=(times,))
    later = np.array(times[1:]) * 1e3
    shown = {"median": float(np.median(later)), "mean": float(later.mean()), "max": float(later.max())}
    return told(result) | {"step_ms": shown, "first_step_ms": 1e3 * times[0]}


def rebounding_steps(count: int, divisions: tuple[int, int, int], steps: int) -> Row:
    """Steps of 5 ms of a wall whose weight acts at once, with θ = ½: it rebounds, and joints open and hit."""
    given = scene(
        wall(count, count, brick=(1.0, 0.5, 0.5) if divisions == (2, 1, 1) else (0.5, 0.25, 0.25)),
        mesh=MeshSettings(divisions=divisions),
        analysis=Dynamics(step=5e-3, duration=steps * 5e-3, theta=0.5),
    )
    times = StepTimes()
    result = solve_scene(check(given), observers=(times,))
    return told(result) | {"step_s": {"mean": float(np.mean(times[1:])), "max": max(times[1:])}}


def pressed_wall(analysis: Statics | Dynamics, **keys: Any) -> tuple[RunResult, StepTimes]:
    """A wall of 10×10 bricks of 4×2×2 elements under its weight and, growing, 2 MPa on its top."""
    end = analysis.duration if isinstance(analysis, Dynamics) else 1.0
    grows = Table(points=((0.0, 0.0), (end, 1.0)))
    stone = {"density": 2400.0, "young": 10e9, "poisson": 0.2}
    law = material_record("drucker_prager", cohesion=4e5, friction_angle=30.0, dilatancy_angle=10.0)
    given = {
        "materials": {"stone": Material(**stone), "weak": Material(**stone, inelastic=law)},
        "mesh": MeshSettings(divisions=(4, 2, 2)),
        "loads": Loads(
            gravity=(0.0, 0.0, -G),
            tractions=(Traction(on="wall.c10.*/top", vector=(0.0, 0.0, -2e6), time=grows),),
        ),
        "analysis": analysis,
    }
    times = StepTimes()
    return solve_scene(check(scene(wall(10, 10), **given | keys)), observers=(times,)), times


def beside(one: tuple[RunResult, StepTimes], other: tuple[RunResult, StepTimes]) -> Row:
    """What the steps of a march cost beside those of another, the first one, with all before it, left out."""
    (result, taken), (_, compared) = one, other
    ratios = np.array(taken[1:]) / np.array(compared[1:])
    return told(result) | {
        "steps_s": [round(value, 3) for value in taken[1:]],
        "beside_s": [round(value, 3) for value in compared[1:]],
        "ratio": sum(taken[1:]) / sum(compared[1:]),
        "worst": float(ratios.max()),
    }


def some_that_yield(analysis: Statics | Dynamics) -> Row:
    """One brick in ten is inelastic and weak, beside a wall of elastic bricks."""
    weak = tuple(
        Override(blocks=f"wall.c{course}.b{1 + 3 * course % 10}", fidelity="inelastic", material="weak")
        for course in range(1, 11)
    )
    inelastic, elastic = pressed_wall(analysis, overrides=weak), pressed_wall(analysis)
    yielded = inelastic[0].summary.stress.yielded or ()
    return beside(inelastic, elastic) | {"yielded": len(yielded)}


def bricks_that_turn(analysis: Statics | Dynamics) -> Row:
    """Bricks with frames that rotate, beside small rotations and contacts of the start."""
    return beside(pressed_wall(analysis), pressed_wall(analysis, contact=Contact(update="fixed")))


def elastic_rubble(stones: int) -> Row:
    """A wall of rubble under its weight: no two stones are alike. A stone fills 0.015 m³ in the mean."""
    rubble = RubbleStructure(
        name="rubble",
        material="stone",
        size=(2.4 * (stones / 120) ** 0.5, 0.5, 1.5 * (stones / 120) ** 0.5),
        stones=stones,
        seed=1,
        elongation=1.8,
    )
    return solved(
        scene(
            rubble,
            mesh=MeshSettings(element="P1", size=0.5),
            analysis=Statics(),
            solver=Solver(tolerance=1e-8),
        )
    )


def irregular_vault(voussoirs: int, stones: int) -> BarrelVaultStructure:
    """A barrel vault of so many courses and stones in each, whose joints are displaced at random."""
    return BarrelVaultStructure(
        name="vault",
        material="stone",
        radius=4.0,
        thickness=0.6,
        depth=0.75 * stones,
        embrace=120.0,
        voussoirs=voussoirs,
        stones=stones,
        irregularity=0.15,
    )


def elastic_vault(voussoirs: int, stones: int, tolerance: float) -> Row:
    """A barrel vault whose joints are displaced at random, under its weight: no two stones are alike.

    Parameters
    ----------
    voussoirs, stones : Its courses, and stones in each. tolerance : Of the solution.
    """
    vault = irregular_vault(voussoirs, stones)
    return solved(
        scene(
            vault,
            mesh=MeshSettings(size=0.3),
            joints=(Joint(friction=0.6),),
            analysis=Statics(),
            solver=Solver(tolerance=tolerance),
        )
    )


def elastic_build(count: int) -> Row:
    """Mesh, contacts, operators and factors only."""
    from masonry_fem.bodies.base import Scheme  # noqa: PLC0415

    given = check(scene(wall(count, count), mesh=MeshSettings(size=0.1)))
    built = build(given, Path())
    start = time.process_time()
    groups = [group for group in built.model.groups if not group.prescribed]
    for group in groups:
        group.factor(Scheme(step=1.0, theta=1.0, inertia=0.0))
    factorise = time.process_time() - start
    return {
        "outcome": "built",
        "blocks": len(built.model.assembly.blocks),
        "shapes": len(groups),
        "contacts": built.model.contacts.count,
        "seconds": built.seconds | {"factorise": factorise},
        "memory_mb": peak_memory(),
    }


def weighted_wall(count: int, dimension: int) -> Row:
    """Contacts placed on the joints of a wall whose courses have elements of two kinds, by ``auto``."""
    every_other = tuple(f"wall.c{course}.*" for course in range(2, count + 1, 2))
    return placed(
        scene(
            wall(count, count, (0.5, 0.25, 0.25)[:dimension]),
            dimension=dimension,
            mesh=MeshSettings(divisions=(4, 2, 2)[:dimension]),
            overrides=tuple(
                Override(blocks=blocks, mesh=MeshSettings(divisions=(5, 3, 2)[:dimension]))
                for blocks in every_other
            ),
            loads=Loads(gravity=(0.0, 0.0, -G)[-dimension:]),
        )
    )


def weighted_vault(voussoirs: int, stones: int) -> Row:
    """The same on a barrel vault no two joints of which are alike, every other course meshed otherwise."""
    vault = irregular_vault(voussoirs, stones)
    every_other = tuple(f"vault.c{course}.*" for course in range(2, voussoirs + 1, 2))
    return placed(
        scene(
            vault,
            mesh=MeshSettings(divisions=(4, 2, 2)),
            overrides=tuple(
                Override(blocks=blocks, mesh=MeshSettings(divisions=(5, 3, 2))) for blocks in every_other
            ),
        )
    )


def placed(given: Scene) -> Row:
    """Contacts placed on the joints of a scene by ``auto``, where they are known."""
    assembly = meshed(lay(check(given), Path())).assembly
    interfaces, surfaces = detect(assembly), surfaces_of(assembly)
    start = time.process_time()
    contacts = place(assembly, interfaces, [Rule("auto")] * len(interfaces), surfaces)
    taken = time.process_time() - start
    weighted = 0 if contacts.means is None else int((np.diff(contacts.means.indptr)[::2] > 0).sum())
    return {
        "outcome": f"{len(interfaces)} interfaces, {weighted} weighted contacts",
        "contacts": contacts.count,
        "seconds": {"place": taken},
        "place_s": taken,
        "memory_mb": peak_memory(),
    }


def large_stone(divisions: int, analysis: Statics | Dynamics) -> Row:
    """A cube of Q1 elements on rigid ground, so many elements a side."""
    stone = BlockStructure(name="stone", material="stone", size=(1.0, 1.0, 1.0))
    ground = BlockStructure(
        name="ground", material="stone", size=(1.4, 1.4, 0.2), position=(-0.2, -0.2, -0.2), support=True
    )
    mesh = MeshSettings(divisions=(divisions, divisions, divisions))
    return solved(scene(stone, structures=(stone, ground), mesh=mesh, analysis=analysis))


def kernel() -> Row:
    """Microseconds a contact and sweep of NSGS on the public problems: long runs less short ones."""
    here = Path(__file__).resolve().parents[1]
    folder = Path(os.environ.get("MASONRY_FEM_SHARED", here.parent / "shared")) / "data" / "fc"
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        return {"outcome": "skipped: set MASONRY_FEM_SHARED"}
    costs = {}
    for path in paths:
        problem = load_problem(path)
        if problem.count < 100:
            continue
        taken = []
        for sweeps in (SWEEPS // 10, SWEEPS):
            start = time.process_time()
            settings = SolverSettings(method="nsgs", tolerance=1e-15, max_iterations=sweeps)
            made = solve(problem, settings)
            taken.append((time.process_time() - start, made.iterations))
        swept = taken[1][1] - taken[0][1]
        if swept > 100:
            costs[path.stem] = 1e6 * (taken[1][0] - taken[0][0]) / swept / problem.count
    values = np.array(list(costs.values()))
    return {
        "outcome": f"{len(values)} problems",
        "median_us": float(np.median(values)),
        "worst_us": float(values.max()),
        "by_problem": costs,
        "memory_mb": peak_memory(),
    }


STEP = Dynamics(step=1e-2, duration=1e-2, theta=1.0)
LMGC90 = 1.7e-4  # its default tolerance

CASES: dict[str, Callable[[], Row]] = {
    "low wall 2x1x1": lambda: low_wall(0.25),
    "low wall 4x2x2": lambda: low_wall(0.125),
    "low wall 8x4x4": lambda: low_wall(0.0625),
    "rigid arch 31": lambda: rigid_march(arch(31, 0.2, 0.5), LMGC90, 50),
    "rigid wall 10x10": lambda: rigid_march(wall(10, 10), LMGC90, 50),
    "rigid wall 20x20": lambda: rigid_march(wall(20, 20), LMGC90, 50),
    "rigid wall 32x32": lambda: rigid_march(wall(32, 32), LMGC90, 50),
    "elastic arch 11, 8x8x8": elastic_arch,
    "elastic arch 21, its fall": falling_arch,
    "elastic wall 5x5, statics": lambda: elastic_wall(5, Statics()),
    "elastic wall 10x10, statics": lambda: elastic_wall(10, Statics()),
    "elastic wall 20x20, one step": lambda: elastic_wall(20, STEP),
    "elastic wall 20x20, to 1e-8": lambda: elastic_wall(20, Statics(), 1e-8),
    "elastic wall 40x40, to 1e-8": lambda: elastic_wall(40, Statics(), 1e-8),
    "elastic wall 100x100, to 1e-8": lambda: elastic_wall(100, Statics(), 1e-8),
    "elastic wall 200x200, to 1e-8": lambda: elastic_wall(200, Statics(), 1e-8),
    "elastic wall 64x64, to 1e-8": lambda: elastic_wall(64, Statics(), 1e-8),
    "elastic wall 40x40 of 8x4x4, to 1e-8": lambda: elastic_wall(40, Statics(), 1e-8, size=0.05),
    "elastic wall 20x20, .2 g, to 1e-8": lambda: elastic_wall(20, Statics(), 1e-8, push=0.2, friction=0.3),
    "elastic wall 40x40, .2 g, to 1e-8": lambda: elastic_wall(40, Statics(), 1e-8, push=0.2, friction=0.3),
    "elastic wall 10x10, 20 steps": lambda: elastic_steps(10, 20),
    "elastic wall 20x20, 20 steps": lambda: elastic_steps(20, 20),
    "elastic wall 12x12 that rebounds": lambda: rebounding_steps(12, (2, 1, 1), 10),
    "elastic wall 16x16 that rebounds": lambda: rebounding_steps(16, (2, 1, 1), 10),
    "elastic wall 20x20 of 4x2x2 that rebounds": lambda: rebounding_steps(20, (4, 2, 2), 8),
    "one brick in ten yields, statics": lambda: some_that_yield(Statics(load_steps=8)),
    "bricks that turn, statics": lambda: bricks_that_turn(Statics(load_steps=8)),
    "bricks that turn, dynamics": lambda: bricks_that_turn(Dynamics(step=1e-3, duration=6e-3, theta=1.0)),
    "elastic rubble, 200 stones": lambda: elastic_rubble(200),
    "elastic rubble, 1000 stones": lambda: elastic_rubble(1000),
    "elastic rubble, 5000 stones": lambda: elastic_rubble(5000),
    "elastic vault, 180 unlike stones, to 1e-6": lambda: elastic_vault(21, 8, 1e-6),
    "elastic vault, 512 unlike stones, to 1e-6": lambda: elastic_vault(21, 24, 1e-6),
    "elastic vault, 5000 unlike stones, to 1e-6": lambda: elastic_vault(21, 238, 1e-6),
    "elastic wall 40x40, built": lambda: elastic_build(40),
    "weighted wall 58x58, placed": lambda: weighted_wall(58, 3),
    "weighted plane wall 58x58, placed": lambda: weighted_wall(58, 2),
    "weighted vault, 180 unlike stones, placed": lambda: weighted_vault(21, 8),
    "weighted vault, 1200 unlike stones, placed": lambda: weighted_vault(48, 25),
    "one stone 10x10x10": lambda: large_stone(10, Statics()),
    "one stone 20x20x20": lambda: large_stone(20, Statics()),
    "one stone 20x20x20, one step": lambda: large_stone(20, STEP),
    "one stone 30x30x30": lambda: large_stone(30, Statics()),
    "one stone 50x50x50": lambda: large_stone(50, Statics()),
    "NSGS kernel": kernel,
}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("case", choices=CASES, metavar="CASE", help="\n".join(CASES))
    print(json.dumps(CASES[parser.parse_args().case]()))
