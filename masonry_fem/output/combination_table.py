"""Combination table: what load combinations lead to, on the console."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from masonry_fem.output.sheet import quantity

AXES = {2: "xy", 3: "xyz"}
DIGITS = 5


def combination_rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Rows of the console's table: heading, name, value; none of a scene without combinations.

    Parameters
    ----------
    summary : What ``summary.json`` says.
    """
    told = summary.get("combinations")
    if not told:
        return
    for one in told["runs"]:
        factors = ", ".join(f"{case} × {factor:g}" for case, factor in one["factors"].items())
        yield "combinations", one["name"], f"{one['outcome'].replace('_', ' ')}: {factors}"
    yield from (("envelope", name, words) for name, words in _envelope(told, len(summary.get("applied", ()))))


def _envelope(told: Mapping[str, Any], dimension: int) -> Iterator[tuple[str, str]]:
    """What is the most of all combinations, and in which."""
    for stone in told.get("utilisation") or ():
        yield f"utilisation, {stone['block']}", f"{stone['value']:.3g} ({stone['combination']})"
    for key in ("compression", "tension"):
        if stone := told.get(key):
            words = f"{quantity(stone['value'], 'Pa', DIGITS)} in {stone['block']} ({stone['combination']})"
            yield f"mean {key}", words
    unit = "N/m" if dimension == 2 else "N"
    for name, support in told["supports"].items():
        for axis, *pair in zip(AXES.get(dimension, ""), support["least"], support["greatest"], strict=False):
            ends = (f"{quantity(one['value'], unit, DIGITS)} ({one['combination']})" for one in pair)
            yield f"support {name}, {axis}", " to ".join(ends)
