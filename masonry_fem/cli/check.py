"""Command ``check``: validate a scene and count, without solving."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse

from masonry_fem.cli.console import print_table
from masonry_fem.cli.grammar import Commands, Parents, read_scene
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (("how large is it, and are its joints found", "masonry-fem check demos/tower.toml"),)

NAMED = 12  # blocks


def check_scene(options: argparse.Namespace) -> int:
    """Validate a scene and print its sizes."""
    scene, base = read_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.inspect import check_scene as check
    from masonry_fem.records.remark import first_few
    from masonry_fem.records.told import plain

    facts = plain(check(scene, base))
    if "names" in facts:
        facts["names"] = first_few(facts["names"], NAMED)
    facts["estimated_memory"] = f"{facts.pop('estimated_memory_mb'):.0f} MB"
    if not options.quiet:
        print_table(facts)
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "check", parents=[parents.scene, parents.common], help="validate and count, without solving"
    )
    own.set_defaults(command=check_scene)
