"""Strategies: how a scene's ``[analysis]`` is marched, one file a kind; what they share stands in ``parts``.

A kind is its record and what it does in one class: which steps it makes, what it does between them, and
when it has arrived. ``kinds()`` finds them; nothing else lists them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from masonry_fem.march.equilibrium.parts.base import Strategy
from masonry_fem.records.discovery import discovered

__all__ = ["Strategy", "kinds"]


@cache
def kinds() -> Mapping[str, type[Strategy]]:
    """Every strategy by its name in scene files."""
    found = discovered("masonry_fem.march.equilibrium", __path__, Strategy, "strategy")
    return {name: one.kind for name, one in found.items()}
