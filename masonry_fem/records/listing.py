"""Listing: the first few of many things, and how many more there are."""

from __future__ import annotations

from collections.abc import Iterable


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
