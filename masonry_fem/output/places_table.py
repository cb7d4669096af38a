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
    words = f"{told['count']}"
    if told["first"] is not None:
        words += f", from {told['first']:.4g} to {told['last']:.4g} m along the path"
    if told.get("fell_at") is not None:
        words += f"; no equilibrium at {told['fell_at']:.4g} m"
    yield "moving load", "places", words
    shares = {"utilisation": told.get("utilisation")}
    for key, words in (("edge_share", "thrust to edge"), ("friction_used", "friction used")):
        shares |= {f"{words}, {label}": one for label, one in told[key].items()}
    for name, worst in shares.items():
        if worst:
            yield "moving load", name, f"{worst['value']:.3g} in {worst['of']} (at {worst['place']:.4g} m)"
    for key in ("compression", "tension"):
        if worst := told.get(key):
            words = f"{quantity(worst['value'], 'Pa', DIGITS)} in {worst['of']} (at {worst['place']:.4g} m)"
            yield "moving load", f"mean {key}", words
    dimension = len(summary.get("applied", ()))
    unit = "N/m" if dimension == 2 else "N"
    for name, support in told["supports"].items():
        for number, axis in enumerate(AXES.get(dimension, "")):
            pair = (support[end][number] for end in ("least", "greatest"))
            words = " to ".join(
                f"{quantity(one['value'], unit, DIGITS)} (at {one['place']:.4g} m)" for one in pair
            )
            yield "moving load", f"support {name}, {axis}", words
