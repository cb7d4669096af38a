"""Command ``info``: versions, and what this machine lacks."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse

from masonry_fem.cli.grammar import Commands, Parents


def print_info(options: argparse.Namespace) -> int:
    """Print versions and what is missing, with the cure."""
    from masonry_fem.host import installation

    for finding in installation.report():
        cure = f"  -> {finding.cure}" if finding.cure else ""
        print(f"{finding.name:<14}{finding.state}{cure}")
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser("info", parents=[parents.common], help="versions, and what this machine lacks")
    own.set_defaults(command=print_info)
