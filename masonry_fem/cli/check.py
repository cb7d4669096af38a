"""Command ``check``: validate a scene and count, without solving."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse

from masonry_fem.cli.console import print_table
from masonry_fem.cli.grammar import Commands, Parents, read_scene
from masonry_fem.records.told import plain


def check_scene(options: argparse.Namespace) -> int:
    """Validate a scene and print its sizes."""
    scene, base = read_scene(options)
    from masonry_fem.analyses.inspect import check_scene as check

    facts = check(scene, base)
    if not options.quiet:
        print_table(plain(facts))
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "check", parents=[parents.scene, parents.common], help="validate and count, without solving"
    )
    own.set_defaults(command=check_scene)
