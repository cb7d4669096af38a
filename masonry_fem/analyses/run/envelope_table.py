"""Envelope table: extremes of stones and supports as a CSV file, with what governs each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from masonry_fem.host.atomic import write_table
from masonry_fem.results.combinations import Envelope, Extremes


def write_envelope(path: Path, found: Envelope | None, by: str) -> Path:
    """Write the envelope, one line for each extreme.

    Parameters
    ----------
    path : Of the file. found : The extremes; None: there are none.
    by : Title of the column of what governs.
    """
    lines = () if found is None else _lines(found)
    return write_table(path, ("of", "name", "quantity", "value", by), lines)


def _lines(found: Envelope) -> Iterator[tuple[Any, ...]]:
    def of_stones(quantity: str, extremes: Extremes) -> Iterator[tuple[Any, ...]]:
        for name, value, by in zip(
            extremes.names, extremes.value.tolist(), extremes.combination, strict=True
        ):
            if not math.isnan(value):
                yield "stone", name, quantity, value, by

    yield from of_stones("utilisation [-]", found.utilisation)
    yield from of_stones("mean_sigma_3 [Pa]", found.compression)
    yield from of_stones("mean_sigma_1 [Pa]", found.tension)
    for support, pair in found.supports.items():
        for end, extremes in zip(("least", "greatest"), pair, strict=True):
            for axis, value, by in zip(
                extremes.names, extremes.value.tolist(), extremes.combination, strict=True
            ):
                yield "support", support, f"{end}_{axis}", value, by
