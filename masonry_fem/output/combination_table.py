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
    for stone in told.get("utilisation") or ():
        yield "envelope", f"utilisation, {stone['block']}", f"{stone['value']:.3g} ({stone['combination']})"
    for key in ("compression", "tension"):
        if stone := told.get(key):
            words = f"{quantity(stone['value'], 'Pa', DIGITS)} in {stone['block']} ({stone['combination']})"
            yield "envelope", f"mean {key}", words
    dimension = len(summary.get("applied", ()))
    for name, support in told["supports"].items():
        for number, axis in enumerate(AXES.get(dimension, "")):
            pair = (support[end][number] for end in ("least", "greatest"))
            unit = "N/m" if dimension == 2 else "N"
            words = " to ".join(
                f"{quantity(one['value'], unit, DIGITS)} ({one['combination']})" for one in pair
            )
            yield "envelope", f"support {name}, {axis}", words
