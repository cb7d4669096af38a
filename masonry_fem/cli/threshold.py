"""Command ``threshold``: find the value of a key beyond which a scene no longer stands."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import THRESHOLD_CODES, conclude
from masonry_fem.cli.grammar import Commands, Parents, overrides_of
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    (
        "the thinnest arch that stands",
        "masonry-fem threshold demos/arch.toml structures.arch.thickness \\\n"
        "      --between '8 cm' '20 cm' --set fidelity=rigid",
    ),
    (
        "the least friction",
        "masonry-fem threshold demos/arch.toml joints.0.friction --between 0.1 0.6 \\\n"
        "      --set fidelity=rigid",
    ),
)


def find_threshold(options: argparse.Namespace) -> int:
    """Find the threshold of a key; the exit code says whether it was found."""
    with phase(LOADING):
        from masonry_fem.analyses.threshold import threshold
    from masonry_fem.host import installation
    from masonry_fem.output.search_table import print_threshold, watched

    installation.require_python()
    options.out = options.out or Path("results") / f"{options.scene.stem}-threshold"
    with watched(options.tolerance) as say:
        found = threshold(
            options.scene,
            options.key,
            tuple(options.between),
            along=options.along or (),
            out=options.out,
            overrides=overrides_of(options),
            tolerance=options.tolerance,
            limit=not options.no_limit,
            fresh=options.fresh,
            tell=say,
        )
    told = found.summary
    files = found.write(pictures=told.outcome != "interrupted")
    return conclude(options, told, files, print_threshold, THRESHOLD_CODES[told.outcome])


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "threshold",
        parents=[parents.scene, parents.common],
        help="find the value of a key beyond which a scene no longer stands",
    )
    own.add_argument("key", metavar="KEY", help="dotted key, as --set takes it: structures.arch.thickness")
    own.add_argument(
        "--between", nargs=2, required=True, metavar=("A", "B"),
        help="two values: the scene stands at one and falls at the other ('5 cm' '20 cm')",
    )  # fmt: skip
    own.add_argument(
        "--along", nargs="+", type=float, metavar="X",
        help="direction of a key that is a vector (1 1 0); A and B are its lengths",
    )  # fmt: skip
    own.add_argument(
        "--tolerance",
        type=float,
        default=1e-2,
        metavar="T",
        help="relative width of the bracket (default: 0.01)",
    )
    own.add_argument("--no-limit", action="store_true", help="do not start at the answer of limit analysis")
    own.add_argument("--fresh", action="store_true", help="repeat trials whose results are stored")
    own.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE-threshold)")
    own.add_argument("--json", action="store_true", help="print everything as JSON")
    own.set_defaults(command=find_threshold)
