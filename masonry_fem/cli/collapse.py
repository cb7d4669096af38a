"""Command ``collapse``: find by simulation how far loads may grow."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import COLLAPSE_CODES, conclude
from masonry_fem.cli.grammar import Commands, Parents, read_scene, results_folder
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    ("the ground tilts until it falls", "masonry-fem collapse demos/rubble_wall.toml --tilt x"),
    ("a push along x", "masonry-fem collapse demos/low_wall.toml --acceleration x --tolerance 0.05"),
)


def collapse_scene(options: argparse.Namespace) -> int:
    """Find the collapse multiplier of a scene; the exit code says whether it was found."""
    scene, base = read_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.collapse import collapse
    from masonry_fem.output.folder import Folder
    from masonry_fem.output.search_table import print_collapse, watched

    options.out = results_folder(options)
    # before the search, so that a folder that cannot be written to is found at once
    with Folder(options.out, "collapse", title=scene.title):
        with watched(options.tolerance) as say:
            found = collapse(
                scene,
                base,
                tilt=options.tilt,
                acceleration=options.acceleration,
                dead=options.dead,
                tolerance=options.tolerance,
                start=options.start,
                at_once=options.at_once,
                limit=not options.no_limit,
                tell=lambda trial, *ends: say(trial.multiplier, trial.verdict, *ends),
            )
        told = found.summary
        asked = scene.output.pictures
        drawn = asked if isinstance(asked, bool) else "mechanism" in asked
        pictures = drawn and told.outcome != "interrupted"
        files = found.write(options.out, pictures=pictures)
    return conclude(options, told, files, print_collapse, COLLAPSE_CODES[told.outcome])


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "collapse",
        parents=[parents.scene, parents.common],
        help="find by simulation how far loads may grow",
    )
    own.add_argument(
        "--tilt", metavar="AXIS", help="tilt the ground towards x or y (--tilt=-x: the other way)"
    )
    own.add_argument(
        "--acceleration",
        metavar="AXIS",
        help="grow an acceleration along x or y, in units of g, beside gravity",
    )
    own.add_argument(
        "--dead", action="append", default=[], metavar="LOAD",
        help="a load that does not grow, if neither is given (may be repeated); gravity never does",
    )  # fmt: skip
    own.add_argument(
        "--tolerance",
        type=float,
        default=1e-2,
        metavar="T",
        help="relative width of the bracket (default: 0.01)",
    )
    own.add_argument(
        "--start",
        type=float,
        default=0.0,
        metavar="M",
        help="first multiplier, at which it must stand (default: 0)",
    )
    own.add_argument(
        "--at-once", action="store_true",
        help="put the whole load on the first state in each trial, instead of on the last that stood",
    )  # fmt: skip
    own.add_argument(
        "--no-limit", action="store_true", help="do not start at the multiplier of limit analysis"
    )
    own.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE)")
    own.add_argument("--json", action="store_true", help="print everything as JSON")
    own.set_defaults(command=collapse_scene)
