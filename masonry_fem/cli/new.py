"""Command ``new``: write a commented scene file to begin with."""

from __future__ import annotations

import argparse
from pathlib import Path

from masonry_fem.cli.console import print_files
from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.errors import OutputError

EXAMPLES = (
    ("a wall in wall.toml, with every key explained", "masonry-fem new wall"),
    ("an arch in a file of your own", "masonry-fem new arch bridge.toml"),
)


def new_scene(options: argparse.Namespace) -> int:
    """Write a scene with a structure of some kind; a file that is there is left alone.

    Raises
    ------
    OutputError : The file exists.
    """
    from masonry_fem.host.atomic import write_atomic  # noqa: PLC0415 - not on the path of --help
    from masonry_fem.scene.beginning import beginning  # noqa: PLC0415

    text = beginning(options.kind)
    path: Path = options.file or Path(f"{options.kind}.toml")
    if path.exists():
        raise OutputError(f"'{path}' exists and is left alone; give another name, or remove it first")
    write_atomic(path, text.encode())
    print_files([path])
    return 0


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "new", parents=[parents.common], help="write a commented scene file to begin with"
    )
    own.add_argument("kind", metavar="KIND", help="kind of structure: wall, arch, dome, ...")
    own.add_argument(
        "file", type=Path, metavar="FILE.toml", nargs="?", help="file to write (default: KIND.toml)"
    )
    own.set_defaults(command=new_scene)
