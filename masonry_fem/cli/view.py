"""Command ``view``: show the results in a folder, in a window, in the browser, or as files."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import print_files
from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    ("in a window", "masonry-fem view results/arch"),
    ("as pictures", "masonry-fem view results/arch --png"),
    ("as a movie of how it deforms", "masonry-fem view results/arch --movie arch.gif --movie-of growth"),
)


def view_results(options: argparse.Namespace) -> int:
    """Show a results folder, or picture it."""
    with phase(LOADING):
        from masonry_fem.output.view import Wishes, view

    wishes = Wishes(
        png=options.folder if options.png else None, movie=options.movie, movie_of=options.movie_of,
        gltf=options.gltf, browser=options.browser, port=options.port, step=options.step,
        field=options.field, amplification=options.amplification, section=options.section,
        apart=options.apart,
    )  # fmt: skip
    print_files(view(options.folder, wishes=wishes))
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser("view", parents=[parents.common], help="show the results in a folder")
    own.add_argument("folder", type=Path, metavar="DIR", help="results folder of a run")
    own.add_argument(
        "--png", action="store_true", help="write pictures to the folder instead of opening a window"
    )
    own.add_argument("--movie", type=Path, metavar="FILE", help="write a movie, .mp4 or .gif")
    own.add_argument(
        "--movie-of", choices=("steps", "growth", "mechanism"),
        help="what the movie shows: the recorded steps, the last displacement as it grows, or how it falls",
    )  # fmt: skip
    own.add_argument("--gltf", type=Path, metavar="FILE.glb", help="write a model for Blender and browsers")
    own.add_argument("--browser", action="store_true", help="show it in the browser instead of a window")
    own.add_argument("--port", type=int, default=0, help="port of the browser's page (default: a free one)")
    own.add_argument("--step", type=int, help="recorded step, counted from 1 (default: the last)")
    own.add_argument("--field", help="what is coloured, such as von_mises, utilisation, displacement")
    own.add_argument("--amplification", type=float, metavar="FACTOR", help="factor of displacements")
    own.add_argument(
        "--section", metavar="AXIS=METRES", help="cut away what is in front of a plane, such as y=0.25"
    )
    own.add_argument(
        "--apart", type=float, default=0.0, metavar="SHARE",
        help="pull stones apart to show their joints: distances from the middle grow by this share",
    )  # fmt: skip
    own.set_defaults(command=view_results)
