"""Response picture: how far probes went in time, and response spectra, a line of panels for each axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_fem.output.chart import COLOURS, blank, frame, head, save
from masonry_fem.output.history import AXES
from masonry_fem.output.response import ProbeMotion, ResponseTold
from masonry_fem.output.sheet import INK, PALE, prefix_of, quantity

if TYPE_CHECKING:
    from masonry_fem.output.spectrum import Spectrum

DASHES = ("--", ":", "-.")  # of accelerograms on the same axis
SMALL = 1e-6  # of the greatest displacement: an axis with less is left out
ROUNDING = 1e-9  # of the height of a panel: a residual that is none
TIME = "time [s]"
PANEL = (7.0, 3.4)  # [inch]
GAP = 0.06  # between labels, of the height of a panel
DECADES = 3.5  # of spectra that are shown


def draw_response(
    path: Path, title: str, motions: Sequence[ProbeMotion], told: Sequence[ResponseTold],
    spectra: Mapping[str, Spectrum], *, clock: str = TIME,
) -> Path:  # fmt: skip
    """Draw it, of the six probes that went farthest.

    Parameters
    ----------
    path : Of the picture. title : Of the scene.
    motions : Of the probes, one at least. told : Their peaks and residuals.
    spectra : By the names of motions, as in ``spectra.csv``; may be empty.
    clock : What goes on from step to step, with its unit.
    """
    kept = sorted(sorted(range(len(told)), key=lambda k: -told[k].greatest)[: len(COLOURS)])
    names, axes = AXES[len(told[0].peak)], _axes(told, spectra)
    columns = 2 if spectra else 1
    tall = PANEL[1] * len(axes) + 1.3
    figure = blank(PANEL[0] * columns, tall)
    panels = figure.subplots(len(axes), columns, squeeze=False)
    for line, number in zip(panels, axes, strict=True):
        _ways(line[0], number, names[number], [motions[k] for k in kept], [told[k] for k in kept], clock)
        if spectra:
            _spectra(line[1], names[number], [motions[k].name for k in kept], spectra)
    figure.tight_layout(rect=(0, 0.38 / tall, 1, 1 - 0.82 / tall), h_pad=1.6, w_pad=2.2)
    head(figure, title or "response", _caption(len(kept), len(told), spectra, clock))
    _legend(figure, [motions[k].name for k in kept], spectra)
    return save(figure, path)


def _axes(told: Sequence[ResponseTold], spectra: Mapping[str, Spectrum]) -> list[int]:
    """Axes along which the ground or a probe moves; the first one where nothing does."""
    most = max(one.greatest for one in told)
    found = [
        number
        for number, name in enumerate(AXES[len(told[0].peak)])
        if _of_ground(spectra, name) or any(abs(one.peak[number]) > SMALL * most for one in told)
    ]
    return found or [0]


def _caption(shown: int, count: int, spectra: Mapping[str, Spectrum], clock: str) -> str:
    """What is drawn, of so many probes."""
    words = "displacements of probes; dot: greatest, right: last"
    if clock == TIME:
        words = "displacements relative to the ground; dot: peak, right: residual"
    if spectra:
        damping = next(iter(spectra.values())).damping
        words += f"; spectra: motion in space, damping ratio {100 * damping:.3g} %"
    if shown < count:
        words += f"; the {shown} of {count} probes that went farthest"
    return words


def _of_ground(spectra: Mapping[str, Spectrum], axis: str) -> list[str]:
    """Names of the accelerograms along an axis."""
    return [name for name in spectra if name.startswith("accelerograms.") and name.endswith(f".{axis}")]


def _ways(
    panel: Any, number: int, name: str, motions: Sequence[ProbeMotion], told: Sequence[ResponseTold],
    clock: str,
) -> None:  # fmt: skip
    """Displacements along an axis."""
    factor, prefix = prefix_of(float(max(abs(one.peak[number]) for one in told)))
    for colour, motion, one in zip(COLOURS, motions, told, strict=False):
        panel.plot(motion.times, motion.relative[:, number] / factor, color=colour, lw=1.2)
        panel.plot(one.peak_time[number], one.peak[number] / factor, "o", ms=5.5, color=colour, mec="white")
    frame(panel)
    panel.margins(x=0.0, y=0.1)
    low, high = panel.get_ylim()
    residual = np.array([one.residual[number] for one in told])
    residual[np.abs(residual) < ROUNDING * factor * (high - low)] = 0.0
    heights = _apart((residual / factor - low) / (high - low))
    for colour, height, value in zip(COLOURS, heights, residual, strict=False):
        panel.annotate(
            quantity(float(value), "m", 3), (1.0, height), xycoords="axes fraction", xytext=(3, 0),
            textcoords="offset points", va="center", fontsize=8, color=colour,
        )  # fmt: skip
    panel.set_title(f"displacement along {name}", fontsize=11.5, color=INK, loc="left", weight="bold")
    panel.set_xlabel(clock, fontsize=9.5, color=PALE)
    panel.set_ylabel(f"[{prefix}m]", fontsize=9.5, color=PALE)


def _apart(heights: np.ndarray) -> np.ndarray:
    """Heights of labels, moved up where they would cover each other."""
    order = np.argsort(heights, kind="stable")
    gaps = GAP * np.arange(len(heights))
    found = np.empty(len(heights))
    found[order] = np.maximum.accumulate(heights[order] - gaps) + gaps
    return found


def _spectra(panel: Any, name: str, probes: Sequence[str], spectra: Mapping[str, Spectrum]) -> None:
    """Pseudo-accelerations along an axis."""
    drawn = [
        (spectra[f"probes.{probe}.{name}"], colour, "-")
        for probe, colour in zip(probes, COLOURS, strict=False)
        if f"probes.{probe}.{name}" in spectra
    ]
    for place, record in enumerate(_of_ground(spectra, name)):
        drawn.append((spectra[record], INK, DASHES[place % len(DASHES)]))
    for one, colour, dash in drawn:
        panel.plot(one.periods, one.accelerations, color=colour, ls=dash, lw=1.4)
    frame(panel)
    panel.set_xscale("log")
    tops = [float(np.nanmax(one.accelerations)) for one, _, _ in drawn]
    if max(tops, default=0.0) > 0:
        panel.set_yscale("log")
        low, high = panel.get_ylim()
        panel.set_ylim(max(low, high / 10**DECADES), high)
    panel.set_xlim(0.02, 10.0)
    panel.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    panel.set_title(f"pseudo-acceleration along {name}", fontsize=11.5, color=INK, loc="left", weight="bold")
    panel.set_xlabel("period [s]", fontsize=9.5, color=PALE)
    panel.set_ylabel("[m/s²]", fontsize=9.5, color=PALE)


def _legend(figure: Any, probes: Sequence[str], spectra: Mapping[str, Spectrum]) -> None:
    """Names of probes, and of accelerograms."""
    from matplotlib.lines import Line2D  # noqa: PLC0415

    handles = [
        Line2D([], [], color=colour, lw=2, label=name) for name, colour in zip(probes, COLOURS, strict=False)
    ]
    for axis in AXES[3]:
        for place, name in enumerate(_of_ground(spectra, axis)):
            handles.append(Line2D([], [], color=INK, lw=1.4, ls=DASHES[place % len(DASHES)], label=name))
    figure.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.005, 0.0), ncols=min(len(handles), 6),
        frameon=False, fontsize=9.5, handletextpad=0.5, columnspacing=1.4, labelcolor=INK,
    )  # fmt: skip
