"""Selector: a shell-style pattern for blocks by name or group, ``wall.c5.*``, or their faces.

matches("wall.*", ("wall.c0.b1", "wall"))       # True: the name matches
split_face("wall.c5.*/top")                     # ('wall.c5.*', 'top')
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from masonry_fem.errors import SceneError
from masonry_fem.scene.misfit import listed, nearest

SHOWN = 8


def matches(selector: str, names: Iterable[str]) -> bool:
    """True if the pattern matches one of a block's names.

    Parameters
    ----------
    selector : Shell-style pattern.
    names : The block's own name and those of its groups.
    """
    return any(fnmatchcase(name, selector) for name in names)


def split_face(selector: str) -> tuple[str, str | None]:
    """Block pattern and face pattern of ``blocks/face``; no face pattern where there is no slash."""
    blocks, slash, face = selector.partition("/")
    return blocks, face if slash else None


def select(selector: str, candidates: Sequence[Iterable[str]], what: str, noun: str = "block") -> list[int]:
    """Indexes of the candidates that a selector names.

    Parameters
    ----------
    selector : Pattern of blocks, or of faces.
    candidates : The names of each candidate: its own first, then its groups.
    what : The key that holds the selector, for the message: ``supports.0.on``.
    noun : What the candidates are.

    Raises
    ------
    SceneError : Where nothing is selected; it lists the nearest names.
    """
    names = [tuple(one) for one in candidates]
    chosen = [index for index, one in enumerate(names) if matches(selector, one)]
    if not chosen:
        raise SceneError(nothing_selected(selector, [name for one in names for name in one], what, noun))
    return chosen


def only(chosen: Sequence[int], selector: str, names: Sequence[str], what: str) -> int:
    """The block that was selected, where a single one is meant.

    Parameters
    ----------
    chosen : Numbers of the selected blocks.
    selector : Pattern that selected them.
    names : Of all blocks.
    what : Key of the selector, for the message.

    Raises
    ------
    SceneError : There are several; the message names the first of them.
    """
    if len(chosen) > 1:
        some = [names[index] for index in chosen[:SHOWN]]
        more = ", ..." if len(chosen) > SHOWN else ""
        raise SceneError(
            f"{what} = '{selector}' selects {len(chosen)} blocks ({listed(some)}{more}), expected one; "
            "name it"
        )
    return chosen[0]


def nothing_selected(selector: str, names: Iterable[str], what: str, noun: str = "block") -> str:
    """The sentence for a selector that names nothing, with the nearest of the names there are.

    Parameters
    ----------
    selector : Pattern. names : Of all candidates and their groups.
    what : Key of the selector. noun : What the candidates are.
    """
    known = list(dict.fromkeys(name for name in names if name))
    near = nearest(selector, known)
    some = listed(known[:SHOWN]) + (", ..." if len(known) > SHOWN else "")
    if not known and noun.startswith("face"):
        some = (
            "none with a name: give faces names in their file (in gmsh physical groups of surfaces); or hold "
            "the whole block or one below it, and load points (loads.points)"
        )
    return f"{what} = '{selector}' selects no {noun}{near}; there are {some or 'none'}"
