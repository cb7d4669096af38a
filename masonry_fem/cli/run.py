"""Command ``run``: solve a scene, once or on finer and finer elements."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import BAD_INPUT, EXIT_CODES, complain, conclude_run, print_files
from masonry_fem.cli.grammar import Commands, Parents, read_scene, results_folder, share
from masonry_fem.errors import MasonryError
from masonry_fem.host.memory import put_off
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    ("an arch under its own weight", "masonry-fem run demos/arch.toml --out results/arch"),
    ("the same with less friction", "masonry-fem run demos/arch.toml --set joints.0.friction=0.4"),
    ("finer elements where the stress needs them", "masonry-fem run demos/arch.toml --refine-to 5%"),
)


def run_scene(options: argparse.Namespace) -> int:
    """Solve a scene; the exit code says how it ended."""
    with put_off():
        return _solved(options)


def _solved(options: argparse.Namespace) -> int:
    if options.refine_to is not None:
        return refine_scene(options)
    scene, base = read_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.run import run

    options.out = results_folder(options)
    result = run(scene, options.out, base=base, save_contact=options.save_contact, quiet=options.quiet)
    return conclude_run(options, result)


def refine_scene(options: argparse.Namespace) -> int:
    """Solve a scene on finer and finer elements; with exit code 2 its error stayed too large.

    Raises
    ------
    MasonryError : The contact problem of a step is to be saved, too.
    """
    scene, base = read_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.refine import refine
    from masonry_fem.output.refinement_table import round_line
    from masonry_fem.records.told import plain

    if options.save_contact is not None:
        raise MasonryError(
            "--save-contact and --refine-to exclude each other; run refined.toml with the former"
        )
    options.out = results_folder(options)
    found = refine(
        scene,
        options.out,
        base,
        target=share(options.refine_to, "--refine-to"),
        quiet=options.quiet,
        tell=None if options.quiet else lambda made: print(round_line(plain(made)), flush=True),
    )
    code = EXIT_CODES.get(found.result.outcome, BAD_INPUT)
    if not options.quiet:
        from masonry_fem.output.terminal import print_summary

        summary = plain(found.result.summary) | ({"message": ""} if code else {})
        if not found.reached:  # the reason is printed once, as above
            summary["refinement"]["message"] = ""
        print_summary(summary)
        print_files(found.files)
    if code or not found.reached:
        complain(found.result.message if code else found.message)
    return code or (0 if found.reached else EXIT_CODES["no_convergence"])


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "run", parents=[parents.scene, parents.common], help="solve a scene and write results"
    )
    own.add_argument("--out", type=Path, metavar="DIR", help="results folder (default: results/SCENE)")
    own.add_argument(
        "--save-contact", type=int, metavar="STEP", help="also write that step's contact problem as .npz"
    )
    own.add_argument(
        "--refine-to", metavar="ERROR",
        help="refine elements until the estimated relative error of the stress is below this, such as 5%%",
    )  # fmt: skip
    own.set_defaults(command=run_scene)
