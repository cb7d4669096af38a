"""Command line ``masonry-fem``: one function a command, each a few calls into the package.

Exit codes: 0 finished or equilibrium, 1 bad input, 2 no convergence, 3 no equilibrium,
130 interrupted. Nothing heavy is loaded before a command needs it, hence the imports in functions.
"""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
import dataclasses
import json
import logging
import math
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import masonry_fem
from masonry_fem.errors import MasonryError

if TYPE_CHECKING:
    from masonry_fem.scene import Scene

BAD_INPUT = 1
INTERRUPTED = 130
PIPE_CLOSED = 141
COLLAPSE_CODES = {
    "bracketed": 0,
    "unlimited": 0,
    "undecided": 2,
    "falls at the start": 3,
    "interrupted": INTERRUPTED,
}
EXIT_CODES = {"equilibrium": 0, "finished": 0, "no_convergence": 2, "no_equilibrium": 3}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; errors become one line on standard error."""
    options = parser().parse_args(arguments)
    # PETSc would answer a closed pipe or a kill with a crash report of its own
    asked = os.environ.get("PETSC_OPTIONS", "").split()
    if "-no_signal_handler" not in asked:
        os.environ["PETSC_OPTIONS"] = " ".join([*asked, "-no_signal_handler"])
    logging.basicConfig(format="%(levelname)s: %(message)s")
    logging.getLogger("masonry_fem").setLevel(_level(options))
    try:
        code: int = options.command(options)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        out = getattr(options, "out", None)
        kept = f"; what was written so far is in {out}" if out and out.exists() else ""
        _complain(f"interrupted{kept}")
        return INTERRUPTED
    # who read our output has had enough, as in "masonry-fem run ... | head"; rich ends the program itself
    except (BrokenPipeError, SystemExit):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python complains at its end
        return PIPE_CLOSED
    except MasonryError as error:
        if options.debug:
            raise
        _complain(str(error))
    except OSError as error:
        if options.debug:
            raise
        _complain(f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except Exception as error:  # a defect of ours: one sentence to a user, all of it with --debug
        if options.debug:
            raise
        _complain(f"unexpected {type(error).__name__}: {error}; run again with --debug for the details")
    return BAD_INPUT


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are bad input, exit code 1, as 2 means no convergence here."""

    def error(self, message: str) -> NoReturn:
        """Print usage and message, end the program."""
        self.print_usage(sys.stderr)
        self.exit(BAD_INPUT, f"{self.prog}: {message}\n")


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    common = Parser(add_help=False)
    common.add_argument("--debug", action="store_true", help="show tracebacks and all messages")
    common.add_argument("--quiet", action="store_true", help="no progress bar, no table")
    scene = Parser(add_help=False)
    scene.add_argument("scene", type=Path, metavar="SCENE.toml", help="scene file")
    scene.add_argument(
        "--set", action="append", default=[], dest="overrides", metavar="KEY=VALUE",
        help="change a value of the scene: structures.arch.voussoirs=21 (may be repeated)",
    )  # fmt: skip
    top = Parser(
        prog="masonry-fem",
        description="Mechanics of block masonry: finite-element stones, true frictional joints.",
        epilog="Exit codes: 0 equilibrium or finished, 1 bad input, 2 no convergence, 3 no equilibrium.",
    )
    top.add_argument("--version", action="version", version=f"masonry-fem {masonry_fem.__version__}")
    commands = top.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser("run", parents=[scene, common], help="solve a scene and write results")
    run.add_argument("--out", type=Path, metavar="DIR", help="results folder (default: results/SCENE)")
    run.add_argument(
        "--save-contact", type=int, metavar="STEP", help="also write that step's contact problem as .npz"
    )
    run.add_argument(
        "--refine-to", metavar="ERROR",
        help="finer elements where the stress is least exact, until its estimated error is that (5%%)",
    )  # fmt: skip
    run.set_defaults(command=run_scene)

    check = commands.add_parser("check", parents=[scene, common], help="validate and count, without solving")
    check.set_defaults(command=check_scene)

    limit = commands.add_parser(
        "limit", parents=[scene, common], help="limit analysis: can the loads be carried, and grow how far"
    )
    limit.add_argument(
        "--dead", action="append", default=[], metavar="LOAD",
        help="a load that does not grow, as points.0 or tractions.* (may be repeated); gravity never does",
    )  # fmt: skip
    limit.add_argument(
        "--tilt",
        metavar="AXIS",
        help="grow an acceleration of g along x or y (--tilt=-x: against x); loads are dead",
    )
    limit.add_argument("--json", action="store_true", help="print everything as JSON")
    limit.set_defaults(command=limit_scene)

    falls = commands.add_parser(
        "collapse",
        parents=[scene, common],
        help="find by simulation how far loads may grow",
    )
    falls.add_argument(
        "--tilt", metavar="AXIS", help="tilt the ground towards x or y (--tilt=-x: the other way)"
    )
    falls.add_argument(
        "--acceleration", metavar="AXIS", help="grow an acceleration of g along x or y, gravity stays"
    )
    falls.add_argument(
        "--dead", action="append", default=[], metavar="LOAD",
        help="a load that does not grow, where neither is given (may be repeated); gravity never does",
    )  # fmt: skip
    falls.add_argument(
        "--tolerance", type=float, default=1e-2, metavar="T", help="relative width of the bracket (0.01)"
    )
    falls.add_argument("--start", type=float, default=0.0, metavar="M", help="first multiplier (0)")
    falls.add_argument(
        "--at-once", action="store_true",
        help="put the whole load on the first state in each trial, instead of on the last that stood",
    )  # fmt: skip
    falls.add_argument("--no-limit", action="store_true", help="do not ask limit analysis where to look")
    falls.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE)")
    falls.add_argument("--json", action="store_true", help="print everything as JSON")
    falls.set_defaults(command=collapse_scene)

    sweep = commands.add_parser(
        "study", parents=[scene, common], help="run a scene with many settings: cost and error of each"
    )
    sweep.add_argument(
        "--vary", action="append", default=[], metavar="KEY=VALUE,VALUE",
        help="values of a key: mesh.size=0.2,0.1 (may be repeated: all combinations run)",
    )  # fmt: skip
    sweep.add_argument(
        "--reference", action="append", default=[], metavar="WHAT",
        help="what to compare with: settings of a cell, a results folder, a file of numbers, or numbers as "
        "probes.top.z=-1.77e-6 (default: the finest cell)",
    )  # fmt: skip
    sweep.add_argument(
        "--quantity", action="append", default=[], metavar="NAME",
        help="what to compare: thrust, probes.crown.z, stress.p95 ... (default: everything)",
    )  # fmt: skip
    sweep.add_argument("--accuracy", default="1%", metavar="A", help="error that is asked for (1%%)")
    sweep.add_argument("--workers", type=int, metavar="N", help="cells at a time (as cores and memory allow)")
    sweep.add_argument("--time-limit", type=float, metavar="S", help="CPU seconds a cell may take")
    sweep.add_argument("--fresh", action="store_true", help="compute again what is known")
    sweep.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE-study)")
    sweep.add_argument("--json", action="store_true", help="print everything as JSON")
    sweep.set_defaults(command=study_scene)

    mesh = commands.add_parser("mesh", parents=[scene, common], help="write and picture mesh and interfaces")
    mesh.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE)")
    mesh.set_defaults(command=mesh_scene)

    view = commands.add_parser("view", parents=[common], help="show the results in a folder")
    view.add_argument("folder", type=Path, metavar="DIR", help="results folder of a run")
    view.add_argument("--png", action="store_true", help="write pictures there instead of opening a window")
    view.set_defaults(command=view_results)

    contact = commands.add_parser("contact", parents=[common], help="solve a saved contact problem")
    contact.add_argument("file", type=Path, metavar="FILE.npz", help="contact problem")
    contact.add_argument("--solver", default="auto", metavar="NAME", help="a solver.method (default: auto)")
    contact.add_argument("--tol", type=float, metavar="T", help="tolerance on the natural map")
    contact.add_argument("--relaxation", type=float, metavar="W", help="of solver nsgs, between 0 and 2")
    contact.add_argument("--threads", type=int, metavar="N", help="of solver nsgs, colour by colour")
    contact.add_argument("--reaction", type=Path, metavar="OUT.npy", help="write the impulses there")
    contact.add_argument(
        "--least-norm", action="store_true",
        help="of all impulses that solve the problem take those of least norm, and tell which are unique",
    )  # fmt: skip
    contact.set_defaults(command=solve_contact)

    info = commands.add_parser("info", parents=[common], help="versions, and what this machine lacks")
    info.set_defaults(command=print_info)
    return top


# --- commands ---------------------------------------------------------------------------------


def run_scene(options: argparse.Namespace) -> int:
    """Solve a scene; the exit code tells how it ended."""
    if options.refine_to is not None:
        return refine_scene(options)
    scene, base = _read(options)
    from masonry_fem.run import run

    options.out = _folder(options)
    result = run(scene, options.out, base=base, save_contact=options.save_contact, quiet=options.quiet)
    code = EXIT_CODES.get(result.outcome, BAD_INPUT)
    if not options.quiet:
        from masonry_fem.post.report import print_summary

        # what went wrong is said once, at the end and on standard error
        print_summary({**result.summary, "message": ""} if code else result.summary)
        _print_files(result.files)
    if code:
        _complain(result.message)
    return code


def refine_scene(options: argparse.Namespace) -> int:
    """Solve a scene on finer and finer elements; exit code 2 tells that its error stayed larger."""
    scene, base = _read(options)
    from masonry_fem.post.refinement_table import round_line
    from masonry_fem.refinement import refine

    if options.save_contact is not None:
        raise MasonryError(
            "--save-contact and --refine-to exclude each other; run refined.toml with the former"
        )
    options.out = _folder(options)
    found = refine(
        scene,
        options.out,
        base,
        target=_share(options.refine_to),
        quiet=options.quiet,
        tell=None if options.quiet else lambda made: print(round_line(made), flush=True),
    )
    code = EXIT_CODES.get(found.result.outcome, BAD_INPUT)
    if not options.quiet:
        from masonry_fem.post.report import print_summary

        print_summary({**found.result.summary, "message": ""} if code else found.result.summary)
        _print_files(found.files)
    if code or not found.reached:
        _complain(found.result.message if code else found.message)
    return code or (0 if found.reached else EXIT_CODES["no_convergence"])


def check_scene(options: argparse.Namespace) -> int:
    """Validate a scene and print what it holds."""
    scene, base = _read(options)
    from masonry_fem.inspection import check_scene as check

    facts = check(scene, base)
    if not options.quiet:
        _print_table(facts)
    return 0


def limit_scene(options: argparse.Namespace) -> int:
    """Ask limit analysis whether a scene's loads can be carried; the exit code tells."""
    scene, base = _read(options)
    from masonry_fem.limit_analysis import analyse

    told = analyse(scene, base, dead=options.dead, tilt=options.tilt)
    if options.json:
        from masonry_fem.post.summary import plain

        print(json.dumps(plain(told), indent=2, ensure_ascii=False))
    elif not options.quiet:
        from masonry_fem.post.limit_table import print_limits

        print_limits(told, scene.dimension)
    return EXIT_CODES["equilibrium" if told["admissible"] else "no_equilibrium"]


def collapse_scene(options: argparse.Namespace) -> int:
    """Find the multiplier at which a scene falls; the exit code tells whether it was found."""
    scene, base = _read(options)
    from masonry_fem.collapse import collapse
    from masonry_fem.post.collapse_table import Watch, print_collapse
    from masonry_fem.post.folder import make_folder

    options.out = _folder(options)
    make_folder(options.out)  # before the search, lest its findings have no place to go
    with Watch(quiet=options.quiet) as watch:
        found = collapse(
            scene,
            base,
            tilt=options.tilt,
            acceleration=options.acceleration,
            dead=options.dead,
            tolerance=options.tolerance,
            start=options.start,
            at_once=options.at_once,
            limit=not options.no_limit,
            tell=watch.tell,
        )
    told, stopped = found.told(), found.outcome == "interrupted"
    files = found.write(options.out, pictures=scene.output.pictures and not stopped)
    if options.json:
        from masonry_fem.post.summary import plain

        print(json.dumps(plain(told), indent=2, ensure_ascii=False))
    elif not options.quiet:
        print_collapse(told)
        _print_files(files)
    code = COLLAPSE_CODES[found.outcome]
    if code:
        _complain(found.message)
    return code


def study_scene(options: argparse.Namespace) -> int:
    """Run a scene with many settings; the exit code tells whether there is anything to compare."""
    from masonry_fem.study import study
    from masonry_fem.study.table import Watch, print_study

    options.out = options.out or Path("results") / f"{options.scene.stem}-study"
    with Watch(quiet=options.quiet) as watch:
        made = study(
            options.scene,
            options.vary,
            out=options.out,
            overrides=options.overrides,
            reference=options.reference,
            quantities=options.quantity,
            accuracy=_share(options.accuracy),
            workers=options.workers,
            time_limit=options.time_limit,
            fresh=options.fresh,
            tell=watch.tell,
        )
    files = made.write(pictures=not made.interrupted)
    if options.json:
        print((options.out / "study.json").read_text(encoding="utf-8"), end="")
    elif not options.quiet:
        print_study(made)
        _print_files(files)
    if made.interrupted:
        _complain(made.outlook)
        return INTERRUPTED
    if not any(row.solved for row in made.rows):
        _complain("no cell was solved; see the messages in study.csv")
        return EXIT_CODES["no_convergence"]
    return 0


def mesh_scene(options: argparse.Namespace) -> int:
    """Write and picture the mesh and the interfaces."""
    scene, base = _read(options)
    from masonry_fem.inspection import write_mesh

    options.out = _folder(options)
    _print_files(write_mesh(scene, options.out, base))
    return 0


def view_results(options: argparse.Namespace) -> int:
    """Show a results folder, or picture it."""
    from masonry_fem.post.view import view

    _print_files(view(options.folder, options.folder if options.png else None))
    return 0


def solve_contact(options: argparse.Namespace) -> int:
    """Solve a contact problem from a file; prints JSON."""
    from masonry_fem.nscd import SolverSettings, load_problem, solve

    given = {"tolerance": options.tol, "relaxation": options.relaxation, "threads": options.threads}
    chosen = {name: value for name, value in given.items() if value is not None}
    settings = SolverSettings(method=options.solver, **chosen)
    problem = load_problem(options.file)
    solution = solve(problem, settings)
    impulse, determinacy = solution.impulse, None
    if options.least_norm and solution.converged:
        from masonry_fem.nscd.determinacy import summarise_contacts

        impulse, determinacy = summarise_contacts(problem, solution)
    if options.reaction is not None:
        import numpy as np

        np.save(options.reaction, impulse.ravel())
    facts = {
        "file": str(options.file),
        "outcome": solution.outcome.value,
        "message": f"{solution.outcome.sentence} {solution.outcome.advice}".strip(),
        "method": solution.method,
        "contacts": problem.count,
        "dimension": problem.dimension,
        "iterations": solution.iterations,
        "linear_solves": solution.linear_solves,
        "seconds": solution.seconds,
        "tolerance": settings.tolerance,
        "error": _finite(solution.quality.error),
        "measures": {name: _finite(value) for name, value in dataclasses.asdict(solution.quality).items()},
    }
    if options.least_norm:
        facts["determinacy"] = determinacy
    print(json.dumps(facts, indent=2))
    if solution.converged:
        return 0
    return EXIT_CODES["no_equilibrium" if solution.outcome.moves else "no_convergence"]


def print_info(options: argparse.Namespace) -> int:
    """Print versions and what is missing, with the cure."""
    from masonry_fem import installation

    for finding in installation.report():
        cure = f"  -> {finding.cure}" if finding.cure else ""
        print(f"{finding.name:<14}{finding.state}{cure}")
    return 0


# --- helpers ----------------------------------------------------------------------------------


def _read(options: argparse.Namespace) -> tuple[Scene, Path]:
    """The scene of a command and the folder that its paths start from."""
    from masonry_fem import installation
    from masonry_fem.scene import load

    installation.require_python()
    scene = load(options.scene, options.overrides)
    return scene, options.scene.resolve().parent


def _folder(options: argparse.Namespace) -> Path:
    """Results folder: what was asked for, else one named after the scene."""
    asked: Path | None = options.out
    return Path("results") / str(options.scene.stem) if asked is None else asked


def _share(text: str) -> float:
    """A share of one, written so or in per cent."""
    try:
        return float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        raise MasonryError(f"accuracy is '{text}', expected a share such as 1% or 0.01") from None


def _finite(value: float) -> float | None:
    """The value, or None where JSON has no number for it."""
    return value if math.isfinite(value) else None


def _complain(sentence: str) -> None:
    """One line on standard error."""
    print(f"masonry-fem: {sentence}", file=sys.stderr)


def _level(options: argparse.Namespace) -> int:
    return logging.DEBUG if options.debug else logging.WARNING


def _print_files(files: Sequence[Path]) -> None:
    for file in files:
        print(f"wrote {file}")


def _print_table(facts: Mapping[str, Any]) -> None:
    """Names and values in two columns; nested facts indented under theirs."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, show_header=False, pad_edge=False)
    for name, value in facts.items():
        if isinstance(value, Mapping):
            table.add_row(name.replace("_", " "), "")
            for inner, number in value.items():
                table.add_row(f"  {inner}", _text(number))
        else:
            table.add_row(name.replace("_", " "), _text(value))
    Console().print(table)


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    sys.exit(main())
