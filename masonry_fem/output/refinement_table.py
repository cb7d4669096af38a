"""Refinement table: the rounds of a refinement on the console."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def round_line(made: Mapping[str, Any]) -> str:
    """One round in a line, as it ends."""
    refined = made["refined"]
    blocks = "1 block" if refined == 1 else f"{refined} blocks"
    after = f"; finer elements in {blocks} next" if refined else ""
    return f"round {made['round']}: {_told(made)}{after}"


def refinement_rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Heading, name and value of each line; none where nothing was refined."""
    told = summary.get("refinement")
    if not told:
        return
    for one in told["rounds"]:
        yield "refinement", f"round {one['round']}", _told(one)
    if told["message"]:
        yield "refinement", "", str(told["message"])


def _told(made: Mapping[str, Any]) -> str:
    unknowns = f"{made['unknowns']:,}".replace(",", " ")
    meshes = "1 mesh" if made["meshes"] == 1 else f"{made['meshes']} meshes"
    error = f"error {100 * made['error']:.3g} %"
    return f"{unknowns} unknowns, {meshes} ({made['made']} new), {error}, {made['seconds']:.1f} s"
