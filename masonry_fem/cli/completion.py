"""Command ``completion``: print a script with which a shell completes commands, options, files and names."""
# ruff: noqa: PLC0415

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable

from masonry_fem.cli.grammar import Commands, Parents
from masonry_fem.errors import MasonryError

SHELLS = ("bash", "zsh", "tcsh", "fish")
EXAMPLES = (
    (
        "for bash: of this user, from the next shell on",
        "masonry-fem completion bash > ~/.local/share/bash-completion/completions/masonry-fem",
    ),
    ("for zsh: into a folder of $fpath", "masonry-fem completion zsh > ~/.zfunc/_masonry-fem"),
    ("for fish", "masonry-fem completion fish > ~/.config/fish/completions/masonry-fem.fish"),
)


def print_script(options: argparse.Namespace) -> int:
    """Print the script of a shell.

    Raises
    ------
    MasonryError : shtab, which makes the script, is not installed.
    """
    from masonry_fem.cli import parser

    try:
        import shtab
    except ImportError:
        raise MasonryError(
            "the script is made by shtab, which is not installed: 'pip install shtab' does it"
        ) from None
    top = parser()
    for command, action in _arguments(top):
        name = action.metavar if isinstance(action.metavar, str) else ""
        if (command, action.dest) in NAMES:
            action.choices = sorted(NAMES[command, action.dest]())
        elif name == "DIR":
            action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]  # where shtab looks
        elif "." in name:
            action.complete = shtab.glob(f"*.{name.rpartition('.')[2]}")  # type: ignore[attr-defined]
    print(shtab.complete(top, options.shell))
    return 0


def _arguments(top: argparse.ArgumentParser) -> Iterable[tuple[str, argparse.Action]]:
    """Each command with each of its arguments."""
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, own in action.choices.items():
                yield from ((name, one) for one in own._actions)


def _structures() -> Iterable[str]:
    from masonry_fem.structures import names

    return names()


def _keys() -> Iterable[str]:
    """The keys of scene files, without those below names that users give."""
    from masonry_fem.scene.explaining import NAME, all_keys

    return {key.name.removesuffix(f".{NAME}") for key in all_keys() if NAME not in key.path[:-1]}


def _solvers() -> Iterable[str]:
    from masonry_fem.nscd.methods import names

    return ["auto", *names()]


# what may stand for an argument of a command
NAMES: dict[tuple[str, str], Callable[[], Iterable[str]]] = {
    ("new", "kind"): _structures,
    ("explain", "key"): _keys,
    ("contact", "solver"): _solvers,
}


def add(commands: Commands, parents: Parents) -> None:
    """What can be written after the command."""
    own = commands.add_parser(
        "completion", parents=[parents.common], help="print a script for completion in a shell"
    )
    own.add_argument("shell", choices=SHELLS, help="which shell")
    own.set_defaults(command=print_script)
