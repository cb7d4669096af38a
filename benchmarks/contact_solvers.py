"""Contact solvers: problems x solvers x tolerances, with the error reached, the steps and the CPU time.

python -m benchmarks.contact_solvers                       # our own walls
python -m benchmarks.contact_solvers --data DIR            # and the contact problems (.npz) of a folder
python -m benchmarks.contact_solvers --walls 64x64 --solvers auto,clarabel --tolerances 1e-8
python -m benchmarks.contact_solvers --walls 128x128 --loads 0.1 --frictions 0.6 --solvers auto

The error is the unit-free natural map (``Quality.natural_map``), made from p and U alone. A solver
stops on ``Quality.error``, which is stricter. ``clarabel`` solves the convex problem with the friction
term frozen at zero and says what that is worth where joints slide.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy import sparse

from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, assess, load_problem, solve
from masonry_fem.nscd.threads import one_thread
from tests.nscd.walls import rigid_wall

HERE = Path(__file__).resolve().parent
WALLS = ("10x8", "20x10", "40x20", "64x64")
LOADS = ("0.1", "0.3", "0.6")
FRICTIONS = ("0.2", "0.6", "1.2")


@dataclass(frozen=True, slots=True)
class Row:
    """What a solver made of a problem."""

    problem: str
    contacts: int
    solver: str
    tolerance: float
    outcome: str
    error: float
    velocity_error: float
    steps: int
    seconds: float
    method: str

    @property
    def held(self) -> bool:
        """True where the natural map is within the tolerance."""
        return self.error <= self.tolerance


def problems(
    walls: list[str], loads: list[str], frictions: list[str], data: Path | None
) -> Iterator[tuple[str, ContactProblem]]:
    """Names and problems, one after the other: a large wall's W is some hundred megabytes."""
    for path in sorted(data.glob("*.npz")) if data else ():
        yield path.stem, load_problem(path)
    for size in walls:
        bricks, courses = (int(part) for part in size.split("x"))
        for load in loads:
            for friction in frictions:
                wall = rigid_wall(bricks, courses, friction=float(friction), horizontal=float(load))
                yield f"{size}, {load} g, µ {friction}", wall


def measure(name: str, problem: ContactProblem, solver: str, tolerance: float, limit: float) -> Row:
    if solver == "clarabel":
        return clarabel(name, problem, tolerance)
    settings = SolverSettings(method=solver, tolerance=tolerance, time_limit=limit)  # type: ignore[arg-type]
    before = time.process_time()
    made = solve(problem, settings)
    seconds = time.process_time() - before
    quality = made.quality
    return Row(
        name, problem.count, solver, tolerance, made.outcome.value, quality.natural_map,
        quality.natural_map_velocity, made.iterations, seconds, made.method,
    )  # fmt: skip


def clarabel(name: str, problem: ContactProblem, tolerance: float) -> Row:
    """The general conic solver on min ½ ‖U − U_free‖²_M, B U + q ∈ K*, with the friction term at zero."""
    import clarabel as library  # noqa: PLC0415 - a test dependency

    if not problem.rigid or not problem.body_count:
        raise ValueError("clarabel is compared on rigid walls only")
    with one_thread():
        before = time.process_time()
        d, mu = problem.dimension, problem.friction
        # dual cone of K: v_N ≥ µ‖v_T‖, as (v_N/µ, v_T) in the second-order cone
        weight = np.ones((problem.count, d))
        weight[:, 0] = 1 / mu
        B = sparse.diags_array(weight.ravel()) @ problem.rigid_matrix().tocsr()
        mass = problem.rigid_mass.ravel()
        linear = -(mass * problem.rigid_velocity.ravel() + problem.rigid_impulse.ravel())
        settings = library.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = min(tolerance, 1e-8)
        solver = library.DefaultSolver(
            sparse.csc_matrix(sparse.diags_array(mass)),
            linear,
            sparse.csc_matrix(-B),
            (weight * problem.free_velocity).ravel(),
            [library.SecondOrderConeT(d)] * problem.count,
            settings,
        )
        found = solver.solve()
        seconds = time.process_time() - before
    impulse = np.array(found.z).reshape(-1, d) * weight
    quality = assess(problem, impulse, problem.balanced_velocity(impulse))
    outcome = Outcome.CONVERGED if quality.natural_map <= tolerance else Outcome.STALLED
    return Row(
        name, problem.count, "clarabel", tolerance, outcome.value, quality.natural_map,
        quality.natural_map_velocity, found.iterations, seconds, "clarabel",
    )  # fmt: skip


def told(rows: list[Row]) -> Table:
    table = Table(title="CPU seconds, one thread; x: the error that was reached instead")
    for column in (
        "problem",
        "contacts",
        "solver",
        "tolerance",
        "error",
        "in speeds",
        "steps",
        "CPU s",
        "by",
    ):
        table.add_column(column, justify="left" if column in {"problem", "solver", "by"} else "right")
    for row in rows:
        cpu = f"{row.seconds:.3f}" if row.held else f"x {row.seconds:.3f}"
        table.add_row(
            row.problem, str(row.contacts), row.solver, f"{row.tolerance:.0e}", f"{row.error:.0e}",
            f"{row.velocity_error:.0e}", str(row.steps), cpu, row.method,
        )  # fmt: skip
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--walls", default=",".join(WALLS[:3]), help="bricks x courses, or none")
    parser.add_argument("--loads", default=",".join(LOADS), help="horizontal accelerations [g]")
    parser.add_argument("--frictions", default=",".join(FRICTIONS), help="friction coefficients")
    parser.add_argument("--data", type=Path, help="folder of contact problems")
    parser.add_argument("--solvers", default="auto,newton,interior_point,nsgs")
    parser.add_argument("--tolerances", default="1e-4,1e-8")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds a problem and solver")
    parser.add_argument("--output", type=Path, help="write the table to this file, too")
    given = parser.parse_args()
    walls = [] if given.walls == "none" else given.walls.split(",")
    wall = rigid_wall(5, 4)  # compiled code and MUMPS are loaded, not timed
    solve(wall)
    solve(wall, SolverSettings(method="nsgs", tolerance=1e-4))
    solve(ContactProblem.plain(wall.delassus(), wall.plain_velocity(), wall.friction))
    rows = []
    chosen = problems(walls, given.loads.split(","), given.frictions.split(","), given.data)
    for name, problem in track(list(chosen), description="solving"):
        for solver in given.solvers.split(","):
            if solver == "clarabel" and not (problem.rigid and problem.body_count):
                continue
            for tolerance in given.tolerances.split(","):
                rows.append(measure(name, problem, solver, float(tolerance), given.limit))
    console = Console(width=140)
    console.print(told(rows))
    if given.output:
        with given.output.open("w") as file:
            Console(file=file, width=140).print(told(rows))


if __name__ == "__main__":
    main()
