"""Remark: what a user should know of a scene or a result that is none the less computed, and words for it.

    with gathered() as remarks:
        remark("abrupt", "joints gave way abruptly in 3 steps", "wall.c2.b1")
    remarks[0].code, remarks[0].blocks

It is made where it is found, logged as a warning there and then, and kept in the result of who gathers.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

from masonry_fem.records.told import Told

logger = logging.getLogger(__name__)


def first_few(texts: Iterable[str], most: int, *, separator: str = ", ", noun: str = "") -> str:
    """``a, b and 3 more``: what a sentence names of many things.

    Parameters
    ----------
    texts : What each of them is called.
    most : How many are named.
    separator : Between them.
    noun : What the others are, in the plural.
    """
    said = list(texts)
    left = len(said) - most
    more = " and " + " ".join(filter(None, (str(left), "more", noun))) if left > 0 else ""
    return separator.join(said[:most]) + more


def counted(number: int, thing: str) -> str:
    """A number of things in words, as ``2 trials``.

    Parameters
    ----------
    number : How many.
    thing : What, in the singular.
    """
    return f"{number} {thing}{'' if number == 1 else 's'}"


class Remark(Told, frozen=True, kw_only=True):
    """A remark.

    Attributes
    ----------
    code : Its kind, for programs. sentence : For people. blocks : That it names.
    """

    code: str
    sentence: str
    blocks: tuple[str, ...]


_gathering: ContextVar[tuple[list[Remark], bool] | None] = ContextVar("gathering", default=None)
_muted: ContextVar[tuple[str, ...]] = ContextVar("muted", default=())


def remark(code: str, sentence: str, *blocks: str) -> None:
    """Make a remark.

    Parameters
    ----------
    code, sentence : As the record has them. blocks : Names of the blocks.
    """
    if code in _muted.get():
        return
    found, aloud = _gathering.get() or ([], True)
    found.append(Remark(code=code, sentence=sentence, blocks=blocks))
    if aloud:
        logger.warning("%s", sentence)


@contextmanager
def gathered(*, aloud: bool = True) -> Iterator[list[Remark]]:
    """Gather remarks meanwhile; if not ``aloud`` they are neither logged nor gathered further out."""
    outer, found = _gathering.get(), list[Remark]()
    token = _gathering.set((found, aloud and (outer is None or outer[1])))
    try:
        yield found
    finally:
        _gathering.reset(token)
        if outer is not None and aloud:
            outer[0].extend(found)


@contextmanager
def muted(*codes: str) -> Iterator[None]:
    """Make no remarks of some kinds meanwhile."""
    token = _muted.set((*_muted.get(), *codes))
    try:
        yield
    finally:
        _muted.reset(token)


def repeated(remarks: Sequence[Remark]) -> Iterator[str]:
    """Remarks of many trials, one sentence for each kind."""
    kinds: dict[str, list[str]] = {}
    for one in remarks:
        kinds.setdefault(one.code, []).append(one.sentence)
    for said in kinds.values():
        yield f"in {counted(len(said), 'trial')}, the last time so: {said[-1]}"
