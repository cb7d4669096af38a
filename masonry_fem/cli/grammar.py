"""Grammar: the options that commands share, and how commands read them."""

from __future__ import annotations

import argparse
import shutil
import sys
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from masonry_fem.cli.console import BAD_INPUT
from masonry_fem.errors import MasonryError

if TYPE_CHECKING:
    from masonry_fem.scene import Scene

NARROWEST = 11  # columns: argparse goes no lower
type Commands = argparse._SubParsersAction[Any]


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are bad input, exit code 1, as 2 means no convergence here.

    Its epilog is shown as it is written.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings, formatter_class=argparse.RawDescriptionHelpFormatter)

    def error(self, message: str) -> NoReturn:
        """Print usage and message, end the program."""
        self.print_usage(sys.stderr)
        self.exit(BAD_INPUT, f"{self.prog}: {message}\n")


@dataclass(frozen=True, slots=True)
class Parents:
    """Options that commands share.

    Attributes
    ----------
    common : Options of all commands.
    scene : Options of commands that read a scene.
    """

    common: Parser
    scene: Parser


def epilog(examples: Sequence[tuple[str, str]], codes: Sequence[tuple[str, str]]) -> str:
    """What stands below the options of a command.

    Parameters
    ----------
    examples : What each one does, and what is typed.
    codes : Exit codes and their meanings.
    """
    # as wide as argparse writes its own lines
    width = max(shutil.get_terminal_size().columns - 2, NARROWEST)
    shown = [f"  # {what}\n  {line}" for what, line in examples]
    ends = [textwrap.fill(f"  {code}  {what}", width, subsequent_indent="    ") for code, what in codes]
    return "\n".join([*(["Examples:", *shown, ""] if shown else []), "Exit codes:", *ends])


def parents() -> Parents:
    """The options that commands share."""
    common = Parser(add_help=False)
    common.add_argument("--debug", action="store_true", help="show tracebacks and all messages")
    common.add_argument(
        "--verbose",
        action="store_true",
        help="show the imbalance after each round of a step, and other notes",
    )
    common.add_argument("--quiet", action="store_true", help="no progress bar, no table")
    common.add_argument(
        "--no-color",
        action="store_true",
        help="no colours, as with the environment variable NO_COLOR; pipes never have any",
    )
    scene = Parser(add_help=False)
    scene.add_argument("scene", type=Path, metavar="SCENE.toml", help="scene file")
    scene.add_argument(
        "--set", action="append", default=[], dest="overrides", metavar="KEY=VALUE",
        help="change a value of the scene: structures.arch.voussoirs=21 (may be repeated)",
    )  # fmt: skip
    scene.add_argument(
        "--trust", action="store_true",
        help="run files of the scene that are programs (.geo, .py), if you have read them",
    )  # fmt: skip
    scene.add_argument(
        "--yes", action="store_true",
        help="build the scene even if it exceeds the limits on blocks, elements and memory",
    )  # fmt: skip
    return Parents(common, scene)


def overrides_of(options: argparse.Namespace) -> list[str]:
    """What the command line changes in the scene."""
    from masonry_fem.scene.overrides import trusting  # noqa: PLC0415 - not on the path of --help

    changed: list[str] = [*options.overrides, *(["large=true"] if options.yes else [])]
    return [*changed, *trusting(options.scene, changed)] if options.trust else changed


def read_scene(options: argparse.Namespace) -> tuple[Scene, Path]:
    """The scene of a command and the folder that its paths start from."""
    from masonry_fem.host import installation  # noqa: PLC0415 - not on the path of --help
    from masonry_fem.scene import load  # noqa: PLC0415

    installation.require_python()
    scene = load(options.scene, overrides_of(options))
    return scene, options.scene.resolve().parent


def results_folder(options: argparse.Namespace) -> Path:
    """Results folder: what was asked for, else one named after the scene."""
    asked: Path | None = options.out
    return Path("results") / str(options.scene.stem) if asked is None else asked


def share(text: str, option: str) -> float:
    """A share of one, from a number or a percentage.

    Parameters
    ----------
    text : ``0.01`` or ``1%``.
    option : Name of the option, for the message.

    Raises
    ------
    MasonryError : The text is neither.
    """
    try:
        return float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        raise MasonryError(f"{option} is '{text}', expected a share such as 1% or 0.01") from None
