"""Placement: which points of an interface carry its contact, one file a rule.

A file has a function ``points(patch, rule) -> Spots``; its name is that of the rule. Nothing else lists it.
It may have ``together(joints, rule) -> list[list[Spots]]``, which places on many joints at once, and
``ROUND_FACES = True`` where that takes all patches that two round faces have in common as one joint. With
``LEAST_INSET`` it bears no inset below.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.records import discovery

if TYPE_CHECKING:  # Numba is slow to import, and scenes that are only read need the names alone
    from masonry_fem.contact.placement.parts.cover import Joint
    from masonry_fem.contact.placement.parts.patch import Patch

__all__ = ["Rule", "Spots", "least_inset", "names", "on_round_faces", "points_of", "together_of"]


def names() -> tuple[str, ...]:
    """The rules that a scene may ask for."""
    return discovery.names(__path__)


@cache
def points_of(name: str) -> Callable[[Patch, Rule], Spots]:
    """What places the points of a rule."""
    points: Callable[[Patch, Rule], Spots] = discovery.function(
        f"{__name__}.{name}", "points(patch: Patch, rule: Rule) -> Spots", "places contact points"
    )
    return points


@cache
def together_of(name: str) -> Callable[[Sequence[Joint], Rule], list[list[Spots]]] | None:
    """What places the points of a rule on many joints at once; None where the rule has no such function."""
    return getattr(import_module(f"{__name__}.{name}"), "together", None)


@cache
def on_round_faces(name: str) -> bool:
    """Whether a rule takes all patches that two round faces have in common as one joint."""
    return bool(getattr(import_module(f"{__name__}.{name}"), "ROUND_FACES", False))


@cache
def least_inset(name: str) -> float:
    """The least inset that a rule bears; 0 where it bears any, or has none."""
    return float(getattr(import_module(f"{__name__}.{name}"), "LEAST_INSET", 0.0))
