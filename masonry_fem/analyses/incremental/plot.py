"""Plot: ``ida.png``, intensity against demand, a curve a record; ``fragility.png``, probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.incremental.fragility import Fragility
from masonry_fem.analyses.incremental.outputs import intensities, unit_of
from masonry_fem.output.chart import COLOURS, blank, frame, head, save
from masonry_fem.output.sheet import INK, PALE
from masonry_fem.results.incremental import IncrementalTold, ShakenTold

FloatArray = NDArray[np.float64]

NAMED = 12  # records: of more none is named
SHARES = ((0.16, ":"), (0.5, "-"), (0.84, "--"))  # of the records that ask for less
LEAST = 5  # records, of which these are drawn
ROOM = 1.15  # beyond the greatest demand, where records that fall go


def draw_curves(path: Path, told: IncrementalTold, demand: str) -> Path:
    """Draw intensity against a demand: each record a curve, which goes off to the right where it falls.

    Parameters
    ----------
    path : Of the picture. told : What was found. demand : Its name.
    """
    figure, (panel,) = _figure(1)
    records = list(dict.fromkeys(one.record for one in told.runs))
    curves = {name: _curve(told.runs, name, demand) for name in records}
    most = max((float(way.max(initial=0.0, where=np.isfinite(way))) for _, way in curves.values()), default=0)
    edge = ROOM * (most or 1.0)
    for place, (name, (at, way)) in enumerate(curves.items()):
        colour = COLOURS[place % len(COLOURS)]
        x, y = np.append(0.0, np.minimum(way, edge)), np.append(0.0, at)
        fallen = np.isinf(way)
        label = name if len(records) <= NAMED else None
        panel.plot(x, y, color=colour, lw=1.1, alpha=0.75, label=label)
        panel.plot(way[~fallen], at[~fallen], "o", ms=3.5, color=colour, mec="white", mew=0.5)
        panel.plot(
            np.full(fallen.sum(), edge), at[fallen], ">", ms=4.5, color=colour, alpha=0.75, clip_on=False
        )
    if len(records) >= LEAST:
        _shares(panel, curves, edge)
    panel.set_xlim(0.0, edge)
    panel.set_ylim(0.0, _top(curves))
    words = "greatest lean of a stone" if demand == "lean" else demand
    panel.set_xlabel(
        f"{words} [{unit_of(demand)}]; at the right edge: a stone falls", fontsize=9.5, color=PALE
    )
    panel.set_ylabel(f"{told.intensity} [m/s²]", fontsize=9.5, color=PALE)
    if panel.get_legend_handles_labels()[0]:
        panel.legend(
            frameon=False, fontsize=8.5, labelcolor=INK, loc="upper left", bbox_to_anchor=(1.01, 1.0)
        )
    return _written(figure, path, told.title, "incremental dynamic analysis")


def draw_fragility(path: Path, told: IncrementalTold, fits: Sequence[Fragility]) -> Path:
    """Draw probabilities against intensity, with what they are fitted to: a bar for the interval of a record.

    Parameters
    ----------
    path : Of the picture. told : What was found. fits : Distributions, one a limit.
    """
    figure, panels = _figure(len(fits))
    at = intensities(told)
    for panel, one, fit, colour in zip(panels, told.fragilities, fits, COLOURS * len(fits), strict=False):
        least, most = fit.band(at)
        panel.fill_between(at, least, most, color=colour, alpha=0.15, lw=0)
        panel.plot(at, fit.probability(at), color=colour, lw=1.8)
        known = [own for own in one.capacities if own.passes is not None]
        known.sort(key=lambda own: (own.passes, own.stands))
        for place, own in enumerate(known):
            height = (place + 0.5) / one.records
            panel.plot([own.stands, own.passes], [height] * 2, color=INK, lw=1.4, alpha=0.7)
        panel.set_xlim(0.0, at[-1])
        panel.set_ylim(-0.02, 1.02)
        panel.set_title(one.state, fontsize=11.5, color=INK, loc="left", weight="bold")
        panel.set_title(_figures(one, fit), fontsize=8.5, color=PALE, loc="right")
        panel.set_xlabel(f"{told.intensity} [m/s²]", fontsize=9.5, color=PALE)
        panel.set_ylabel("probability", fontsize=9.5, color=PALE)
    return _written(figure, path, told.title, "bars: records, from what they stand to what they do not")


def _figures(one: Any, fit: Fragility) -> str:
    """Sample and parameters, for the head of a panel."""
    sample = f"{one.passed} of {one.records} records"
    if fit.outcome != "fitted":
        return f"{sample}: {fit.outcome}"
    return f"{sample}: θ = {fit.median:.3g} m/s², β = {fit.dispersion:.2g}; band: {100 * one.confidence:g} %"


def _curve(runs: Sequence[ShakenTold], record: str, demand: str) -> tuple[FloatArray, FloatArray]:
    """Intensities of a record, and demands there, infinite where it falls."""
    own = [one for one in runs if one.record == record and one.verdict != "undecided"]
    own.sort(key=lambda one: one.intensity)
    ways = [one.demands.get(demand, np.inf) for one in own]
    return np.array([one.intensity for one in own]), np.array(ways, dtype=float)


def _top(curves: dict[str, tuple[FloatArray, FloatArray]]) -> float | None:
    """A little more than where the last record falls; None where some never do."""
    first = [at[np.isinf(way)] for at, way in curves.values()]
    return None if any(not len(own) for own in first) else 1.25 * max(float(own[0]) for own in first)


def _shares(panel: Any, curves: dict[str, tuple[FloatArray, FloatArray]], edge: float) -> None:
    """Demands that 16, 50 and 84 % of the records stay below, at intensities that all were tried at."""
    tried = [own for own in curves.values() if len(own[0])]
    at = np.linspace(0.0, min(float(own[0][-1]) for own in tried), 101)
    ways = np.array(
        [np.interp(at, np.append(0, own), np.append(0, np.minimum(way, edge))) for own, way in tried]
    )
    for share, dash in SHARES:
        panel.plot(
            np.quantile(ways, share, axis=0, method="higher"), at, color=INK, ls=dash, lw=2.0,
            label=f"{100 * share:g} %",
        )  # fmt: skip


def _figure(panels: int) -> tuple[Any, list[Any]]:
    figure = blank(7.6, 4.2 * panels + 0.6)
    found = list(figure.subplots(panels, 1, squeeze=False)[:, 0])
    for panel in found:
        frame(panel)
    return figure, found


def _written(figure: Any, path: Path, title: str, words: str) -> Path:
    top = 1 - 0.75 / figure.get_figheight()
    figure.tight_layout(rect=(0, 0, 1, top))
    head(figure, title or "records", words)
    return save(figure, path)
