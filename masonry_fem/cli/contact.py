"""Command ``contact``: solve a contact problem from a file, and print the result as JSON."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from pathlib import Path

from masonry_fem.cli.console import EXIT_CODES
from masonry_fem.cli.grammar import Commands, Parents

EXAMPLES = (
    ("with the method that suits", "masonry-fem contact results/arch/contact_1.npz"),
    ("by another one, to 1e-12", "masonry-fem contact contact_1.npz --solver newton --tol 1e-12"),
)


def solve_contact(options: argparse.Namespace) -> int:
    """Solve a contact problem from a file; prints JSON."""
    from masonry_fem.nscd import SolverSettings, load_problem, solve
    from masonry_fem.nscd.settings import ACCEPTABLE

    given = {"tolerance": options.tol, "relaxation": options.relaxation, "threads": options.threads}
    chosen = {name: value for name, value in given.items() if value is not None}
    acceptable = ACCEPTABLE if options.tol is None else 0.0
    settings = SolverSettings(method=options.solver, acceptable=acceptable, **chosen)
    problem = load_problem(options.file)
    solution = solve(problem, settings)
    impulse, determinacy = solution.impulse, None
    if options.least_norm and solution.solved:
        from masonry_fem.nscd.determinacy import summarise_contacts

        impulse, determinacy = summarise_contacts(problem, solution)
    if options.reaction is not None:
        import io

        import numpy as np

        from masonry_fem.host.atomic import write_atomic

        content = io.BytesIO()
        np.save(content, impulse.ravel())
        write_atomic(options.reaction, content.getvalue())
    facts = {
        "file": str(options.file),
        "outcome": solution.outcome.value,
        "message": f"{solution.outcome.sentence} {solution.outcome.advice(settings)}".strip(),
        "method": solution.method,
        "contacts": problem.count,
        "dimension": problem.dimension,
        "iterations": solution.iterations,
        "linear_solves": solution.linear_solves,
        "seconds": solution.seconds,
        "tolerance": settings.tolerance,
        "error": finite(solution.quality.error),
        "measures": {name: finite(value) for name, value in dataclasses.asdict(solution.quality).items()},
    }
    if options.least_norm:
        facts["determinacy"] = determinacy
    print(json.dumps(facts, indent=2))
    if solution.solved:
        return 0
    return EXIT_CODES["no_equilibrium" if solution.outcome.moves else "no_convergence"]


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser("contact", parents=[parents.common], help="solve a saved contact problem")
    own.add_argument("file", type=Path, metavar="FILE.npz", help="contact problem")
    own.add_argument(
        "--solver", default="auto", metavar="NAME", help="a value of solver.method (default: auto)"
    )
    own.add_argument("--tol", type=float, metavar="T", help="relative tolerance")
    own.add_argument(
        "--relaxation", type=float, metavar="W", help="relaxation of solver nsgs, between 0 and 2"
    )
    own.add_argument("--threads", type=int, metavar="N", help="threads of solver nsgs")
    own.add_argument("--reaction", type=Path, metavar="OUT.npy", help="write the impulses there")
    own.add_argument(
        "--least-norm", action="store_true",
        help="take the solution of least norm, and say which impulses are the same in all solutions",
    )  # fmt: skip
    own.set_defaults(command=solve_contact)


def finite(value: float) -> float | None:
    """The value, or None where JSON has no number for it."""
    return value if math.isfinite(value) else None
