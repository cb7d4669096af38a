"""Quasistatic: what analyses without inertia have in common."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.parts.base import Strategy


class Quasistatic(Strategy, frozen=True, kw_only=True):
    """Equilibria one after another; time is the load factor."""

    @property
    def end(self) -> float:
        """All of it."""
        return 1.0

    @property
    def inertia(self) -> bool:
        """None."""
        return False

    @property
    def kept(self) -> float:
        """No velocity goes from one step into the next."""
        return 0.0


def equal_parts(count: int, since: float = 0.0) -> Iterator[tuple[Scheme, float]]:
    """Steps of length 1/n, so that time is the share that is reached, each with its end.

    Parameters
    ----------
    count : Number of steps. since : Where the first begins.
    """
    for index in range(1, count + 1):
        yield Scheme(1.0 / count, 1.0, 0.0), since + index / count
