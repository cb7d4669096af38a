"""Refinement table: the rounds of a refinement on the console."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol


class Told(Protocol):
    """A round: which, how large, how exact, what comes next, how long it took."""

    @property
    def round(self) -> int: ...  # noqa: D102
    @property
    def unknowns(self) -> int: ...  # noqa: D102
    @property
    def meshes(self) -> int: ...  # noqa: D102
    @property
    def made(self) -> int: ...  # noqa: D102
    @property
    def error(self) -> float: ...  # noqa: D102
    @property
    def refined(self) -> int: ...  # noqa: D102
    @property
    def seconds(self) -> float: ...  # noqa: D102


def round_line(made: Told) -> str:
    """One round in a line, as it ends."""
    after = f"; {_blocks(made.refined)} next" if made.refined else ""
    return (
        f"round {made.round}: {_told(made.unknowns, made.error, made.meshes, made.made, made.seconds)}{after}"
    )


def refinement_rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Heading, name and value of each line; none where nothing was refined."""
    told = summary.get("refinement")
    if not told:
        return
    for one in told["rounds"]:
        words = _told(one["unknowns"], one["error"], one["meshes"], one["made"], one["seconds"])
        yield "refinement", f"round {one['round']}", words
    yield "refinement", "", str(told["message"])


def _told(unknowns: int, error: float, meshes: int, made: int, seconds: float) -> str:
    count = f"{unknowns:,}".replace(",", " ")
    return f"{count} unknowns, {meshes} meshes ({made} new), error {100 * error:.3g} %, {seconds:.1f} s"


def _blocks(count: int) -> str:
    return "finer elements in 1 block" if count == 1 else f"finer elements in {count} blocks"
