"""Command ``resume``: continue a run that was interrupted, or make more steps of one that has ended."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import BAD_INPUT, EXIT_CODES, conclude_run
from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    ("after Ctrl-C or a kill", "masonry-fem resume results/column"),
    ("more steps than the run had", "masonry-fem resume results/column --set analysis.steps=400"),
)


def resume_run(options: argparse.Namespace) -> int:
    """Make the steps that are left; the exit code says how the run ended."""
    with phase(LOADING):
        from masonry_fem.analyses.run.resume import EndedError, resume
    from masonry_fem.host import installation

    installation.require_python()
    changed = [*options.overrides, *(["large=true"] if options.yes else [])]
    try:
        result = resume(options.out, changed, trust=options.trust, quiet=options.quiet)
    except EndedError as ended:
        if not options.quiet:
            print(f"{options.out}: {ended}")
        return EXIT_CODES.get(ended.outcome, BAD_INPUT)
    return conclude_run(options, result)


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "resume",
        parents=[parents.common],
        help="continue a run that was interrupted, or make more steps of it",
    )
    own.add_argument(
        "out", type=Path, metavar="DIR", help="results folder of a run with output.checkpoint_steps"
    )
    own.add_argument(
        "--set", action="append", default=[], dest="overrides", metavar="KEY=VALUE",
        help="more steps, or other outputs: analysis.duration=2 (may be repeated)",
    )  # fmt: skip
    own.add_argument(
        "--trust", action="store_true",
        help="run files of the scene that are programs (.geo, .py), if you have read them",
    )  # fmt: skip
    own.add_argument("--yes", action="store_true", help="run whatever memory it needs")
    own.set_defaults(command=resume_run)
