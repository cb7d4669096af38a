"""Command ``explain``: say what a key of scene files means and expects."""

from __future__ import annotations

import argparse
import shutil
import textwrap

from masonry_fem.cli.grammar import Commands, Parents

EXAMPLES = (
    ("wherever such a key stands", "masonry-fem explain friction"),
    ("a kind of structure", "masonry-fem explain structures.wall"),
)


def explain_key(options: argparse.Namespace) -> int:
    """Print the meaning of a key, a table or a kind of table."""
    from masonry_fem.scene.explaining import explain  # noqa: PLC0415 - not on the path of --help

    width = shutil.get_terminal_size().columns
    print("\n".join(_wrapped(line, width) for line in explain(options.key).split("\n")))
    return 0


def _wrapped(line: str, width: int) -> str:
    """A line that is broken between words, further parts indented as the first."""
    start = line[: len(line) - len(line.lstrip())]
    return textwrap.fill(
        line, width, subsequent_indent=start + "  ", break_long_words=False, break_on_hyphens=False
    )


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "explain", parents=[parents.common], help="say what a key of scene files means and expects"
    )
    own.add_argument("key", metavar="KEY", help="such as friction, materials.NAME.young, structures.wall")
    own.set_defaults(command=explain_key)
