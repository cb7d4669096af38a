"""Command ``export``: write the results in a folder as files for other programs."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import print_files
from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    ("for ParaView, all steps", "masonry-fem export results/arch arch.xdmf"),
    ("for ParaView, the end with a name for each stone", "masonry-fem export results/arch arch.vtm"),
    ("for COMPAS, and a table of the stones", "masonry-fem export results/arch arch.json arch.csv"),
)


def export_results(options: argparse.Namespace) -> int:
    """Write a file for each name that is given."""
    with phase(LOADING):
        from masonry_fem.output.exporting import export

    for path in options.files:
        print_files(export(options.folder, path, options.step))
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "export", parents=[parents.common], help="write the results in a folder for other programs"
    )
    own.add_argument("folder", type=Path, metavar="DIR", help="results folder of a run")
    own.add_argument(
        "files", type=Path, nargs="+", metavar="FILE",
        help=".json (COMPAS, with contact forces), .xdmf (all steps), .vtm (blocks by name, for ParaView), "
        ".csv (a line a block), .glb (glTF)",
    )  # fmt: skip
    own.add_argument("--step", type=int, help="recorded step, counted from 1 (default: the last)")
    own.set_defaults(command=export_results)
