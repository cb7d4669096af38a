"""Command ``compile``: compile the program's loops for this processor, so that the first run need not."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse

from masonry_fem.cli.console import complain
from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.host.phases import phase

EXAMPLES = (("once after an installation", "masonry-fem compile"),)


def compile_all(options: argparse.Namespace) -> int:
    """Solve small scenes that use all compiled code."""
    from masonry_fem.analyses.cells.crew import cores
    from masonry_fem.analyses.rehearsal import SCENES, rehearse, silence

    if not options.verbose:
        silence()
    if not options.quiet:
        complain("compiling for this processor; the first time this takes up to a minute")
    with phase("scenes", len(SCENES)) as at:
        for number, name in enumerate(rehearse(aided=cores() > 1)):
            at(number + 1, f"{number + 1}/{len(SCENES)} {name}")
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "compile", parents=[parents.common], help="compile the loops of the program for this processor"
    )
    own.set_defaults(command=compile_all)
