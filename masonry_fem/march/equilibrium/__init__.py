"""Strategies: how a scene's ``[analysis]`` is marched, one file a kind; what they share stands in ``parts``.

A kind is its record and what it does in one class: which steps it makes, what it does between them, and
when it has arrived. They are listed nowhere; ``record`` loads the one with a name.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from masonry_fem.march.equilibrium.parts.base import Strategy
from masonry_fem.records import discovery

__all__ = ["Strategy", "kinds", "names", "record"]


def names() -> tuple[str, ...]:
    """The strategies that a scene may ask for; none is loaded."""
    return discovery.names(__path__)


@cache
def record(name: str) -> type[Strategy]:
    """The strategy with a name, which is also what a scene file says of it."""
    kind: type[Strategy] = discovery.discovered(__name__, name, Strategy, "strategy").kind
    return kind


def kinds() -> Mapping[str, type[Strategy]]:
    """Every strategy by its name in scene files."""
    return {name: record(name) for name in names()}
