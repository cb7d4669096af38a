"""Command ``mesh``: write and draw the mesh and the interfaces."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import print_files
from masonry_fem.cli.grammar import Commands, Parents, read_scene, results_folder
from masonry_fem.host.phases import LOADING, phase

EXAMPLES = (
    (
        "the elements and the joints that were found",
        "masonry-fem mesh demos/tower.toml --out results/tower",
    ),
)


def mesh_scene(options: argparse.Namespace) -> int:
    """Write and picture the mesh and the interfaces."""
    scene, base = read_scene(options)
    with phase(LOADING):
        from masonry_fem.analyses.inspect import write_mesh

    options.out = results_folder(options)
    print_files(write_mesh(scene, options.out, base))
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "mesh", parents=[parents.scene, parents.common], help="write and draw the mesh and the interfaces"
    )
    own.add_argument("--out", type=Path, metavar="DIR", help="folder (default: results/SCENE)")
    own.set_defaults(command=mesh_scene)
