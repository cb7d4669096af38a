"""Extremes: what load combinations, or a load that moves, lead to, on the console."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from masonry_fem.output.sheet import quantity

AXES = {2: "xy", 3: "xyz"}
DIGITS = 5

Rows = Iterator[tuple[str, str, str]]
Where = Callable[[Mapping[str, Any]], str]


def combination_rows(summary: Mapping[str, Any]) -> Rows:
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
        yield "envelope", f"utilisation, {stone['block']}", f"{stone['value']:.3g} {_combination(stone)}"
    for name, words in _extremes(told, len(summary.get("applied", ())), "block", _combination):
        yield "envelope", name, words


def places_rows(summary: Mapping[str, Any]) -> Rows:
    """Rows of the console's table: heading, name, value; none of a scene in which no load moves.

    Parameters
    ----------
    summary : What ``summary.json`` says.
    """
    told = summary.get("places")
    if not told:
        return
    yield "moving load", "places", _way(told)
    shares = {"utilisation": told.get("utilisation")}
    for key, words in (("edge_share", "thrust to edge"), ("friction_used", "friction used")):
        shares |= {f"{words}, {label}": one for label, one in told[key].items()}
    for name, worst in shares.items():
        if worst:
            yield "moving load", name, f"{worst['value']:.3g} in {worst['of']} {_place(worst)}"
    for name, words in _extremes(told, len(summary.get("applied", ())), "of", _place):
        yield "moving load", name, words


def _way(told: Mapping[str, Any]) -> str:
    """Which places there are."""
    words = f"{told['count']}"
    if told["first"] is not None:
        words += f", from {told['first']:.4g} to {told['last']:.4g} m along the path"
    if told.get("fell_at") is not None:
        words += f"; no equilibrium at {told['fell_at']:.4g} m"
    return words


def _extremes(told: Mapping[str, Any], dimension: int, of: str, where: Where) -> Iterator[tuple[str, str]]:
    """The worst mean stresses, and between which forces each support is.

    Parameters
    ----------
    told : Of the summary. dimension : 2 or 3. of : Key of a stone's name. where : What governs, in words.
    """
    for key in ("compression", "tension"):
        if worst := told.get(key):
            yield f"mean {key}", f"{quantity(worst['value'], 'Pa', DIGITS)} in {worst[of]} {where(worst)}"
    unit = "N/m" if dimension == 2 else "N"
    for name, support in told["supports"].items():
        for axis, *pair in zip(AXES.get(dimension, ""), support["least"], support["greatest"], strict=False):
            ends = (f"{quantity(one['value'], unit, DIGITS)} {where(one)}" for one in pair)
            yield f"support {name}, {axis}", " to ".join(ends)


def _place(one: Mapping[str, Any]) -> str:
    return f"(at {one['place']:.4g} m)"


def _combination(one: Mapping[str, Any]) -> str:
    return f"({one['combination']})"
