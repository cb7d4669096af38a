"""Places table: what a load that moves leads to, on the console."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from masonry_fem.output.sheet import quantity

AXES = {2: "xy", 3: "xyz"}
DIGITS = 5


def places_rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Rows of the console's table: heading, name, value; none of a scene in which no load moves.

    Parameters
    ----------
    summary : What ``summary.json`` says.
    """
    told = summary.get("places")
    if not told:
        return
    dimension = len(summary.get("applied", ()))
    for name, words in (
        ("places", _way(told)),
        *_extremes(told),
        *_supports(told["supports"], AXES.get(dimension, ""), "N/m" if dimension == 2 else "N"),
    ):
        yield "moving load", name, words


def _way(told: Mapping[str, Any]) -> str:
    """Which places there are."""
    words = f"{told['count']}"
    if told["first"] is not None:
        words += f", from {told['first']:.4g} to {told['last']:.4g} m along the path"
    if told.get("fell_at") is not None:
        words += f"; no equilibrium at {told['fell_at']:.4g} m"
    return words


def _extremes(told: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The worst of stones and joints."""
    shares = {"utilisation": told.get("utilisation")}
    for key, words in (("edge_share", "thrust to edge"), ("friction_used", "friction used")):
        shares |= {f"{words}, {label}": one for label, one in told[key].items()}
    for name, worst in shares.items():
        if worst:
            yield name, f"{worst['value']:.3g} in {worst['of']} (at {worst['place']:.4g} m)"
    for key in ("compression", "tension"):
        if worst := told.get(key):
            words = f"{quantity(worst['value'], 'Pa', DIGITS)} in {worst['of']} (at {worst['place']:.4g} m)"
            yield f"mean {key}", words


def _supports(told: Mapping[str, Any], axes: str, unit: str) -> Iterator[tuple[str, str]]:
    """Between which forces each support is."""
    for name, support in told.items():
        for number, axis in enumerate(axes):
            pair = (support[end][number] for end in ("least", "greatest"))
            words = (f"{quantity(one['value'], unit, DIGITS)} (at {one['place']:.4g} m)" for one in pair)
            yield f"support {name}, {axis}", " to ".join(words)
