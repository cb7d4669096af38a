"""Command ``view``: show the results in a folder."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import print_files
from masonry_fem.cli.grammar import Commands, Parents

EXAMPLES = (
    ("in a window", "masonry-fem view results/arch"),
    ("as pictures", "masonry-fem view results/arch --png"),
)


def view_results(options: argparse.Namespace) -> int:
    """Show a results folder, or picture it."""
    from masonry_fem.output.view import view

    print_files(view(options.folder, options.folder if options.png else None))
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser("view", parents=[parents.common], help="show the results in a folder")
    own.add_argument("folder", type=Path, metavar="DIR", help="results folder of a run")
    own.add_argument("--png", action="store_true", help="write pictures there instead of opening a window")
    own.set_defaults(command=view_results)
