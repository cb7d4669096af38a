"""Command ``report``: present the results in a folder in one HTML file."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
import logging
from pathlib import Path

from masonry_fem.cli.console import print_files
from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.errors import OutputError
from masonry_fem.host.phases import LOADING, phase

logger = logging.getLogger(__name__)

EXAMPLES = (("report.html beside the results", "masonry-fem report results/arch"),)


def report_results(options: argparse.Namespace) -> int:
    """Write report.html into a results folder, from the files there.

    Raises
    ------
    OutputError : The folder has no summary.json.
    """
    from masonry_fem.output.folder import Folder, unfinished

    with phase(LOADING):
        from masonry_fem.output.report import write_report

    if not (options.folder / "summary.json").is_file():
        raise OutputError(
            f"'{options.folder}' has no summary.json, expected the results folder of 'masonry-fem run'; give "
            "that folder, or run the scene first"
        )
    if said := unfinished(options.folder):
        logger.warning("%s", said)
    with Folder(options.folder, "report"):
        print_files([write_report(options.folder)])
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "report", parents=[parents.common], help="present the results in a folder in one HTML file"
    )
    own.add_argument("folder", type=Path, metavar="DIR", help="results folder of a run")
    own.set_defaults(command=report_results)
