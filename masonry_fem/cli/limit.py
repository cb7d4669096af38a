"""Command ``limit``: decide by limit analysis whether loads can be carried, and how far they may grow."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse

from masonry_fem.cli.console import EXIT_CODES
from masonry_fem.cli.grammar import Commands, Parents, read_scene
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    ("can rigid stones carry the loads", "masonry-fem limit demos/spreading_arch.toml"),
    ("how far may a push along x grow", "masonry-fem limit demos/low_wall.toml --tilt x"),
)


def limit_scene(options: argparse.Namespace) -> int:
    """Decide by limit analysis whether the loads of a scene can be carried; the exit code says so."""
    scene, base = read_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.limit import analyse
    from masonry_fem.records.told import text

    told = analyse(scene, base, dead=options.dead, tilt=options.tilt)
    if options.json:
        print(text(told))
    elif not options.quiet:
        from masonry_fem.output.limit_table import print_limits

        print_limits(told, scene.dimension)
    return EXIT_CODES["equilibrium" if told.admissible else "no_equilibrium"]


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "limit",
        parents=[parents.scene, parents.common],
        help="limit analysis: whether loads can be carried, and how far they may grow",
    )
    own.add_argument(
        "--dead", action="append", default=[], metavar="LOAD",
        help="a load that does not grow, such as points.0 or tractions.* (may be repeated); gravity never",
    )  # fmt: skip
    own.add_argument(
        "--tilt",
        metavar="AXIS",
        help="grow an acceleration along x or y, in units of g (--tilt=-x: against x); loads do not grow",
    )
    own.add_argument("--json", action="store_true", help="print everything as JSON")
    own.set_defaults(command=limit_scene)
