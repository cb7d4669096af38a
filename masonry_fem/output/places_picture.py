"""Places picture: what a load that moves leads to, over the places where it stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.output.chart import COLOURS, blank, frame, save
from masonry_fem.output.history import AXES
from masonry_fem.output.sheet import INK, PALE, prefix_of

PANEL = (9.0, 2.9)  # [inch]
ZERO = 1e-9  # of the greatest force: a component with less is left out


def draw_places(path: Path, title: str, rows: Sequence[Mapping[str, Any]], dimension: int) -> Path:
    """Draw reactions of supports, greatest mean stresses, utilisation and how near joints are to failing.

    Parameters
    ----------
    path : Of the picture. title : Of the scene. rows : Lines of ``places.csv`` at which all stood, in turn.
    dimension : Of the scene.
    """
    panels = [*_reactions(rows, dimension), *_stones(rows), *_joints(rows)]
    tall = PANEL[1] * len(panels) + 0.6
    figure = blank(PANEL[0], tall)
    axes = np.ravel(figure.subplots(len(panels), 1, sharex=True, squeeze=False))
    places = _column(rows, "place [m]")
    for axis, (heading, unit, lines) in zip(axes, panels, strict=True):
        most = max(float(np.nanmax(np.abs(values))) for values in lines.values())
        factor, prefix = prefix_of(most) if unit else (1.0, "")
        for number, (name, values) in enumerate(lines.items()):
            colour = COLOURS[number % len(COLOURS)]
            axis.plot(places, values / factor, "o-", ms=3.5, lw=1.5, color=colour, label=name)
        axis.set_title(heading, fontsize=11.5, color=INK, loc="left", weight="bold")
        axis.set_ylabel(f"[{prefix}{unit}]" if unit else "[-]", fontsize=9.5, color=PALE)
        frame(axis)
        if len(lines) > 1:
            axis.legend(
                frameon=False, fontsize=9, labelcolor=INK, loc="center left", bbox_to_anchor=(1.0, 0.5)
            )
    axes[-1].set_xlabel("place of the first axle along its path [m]", fontsize=9.5, color=PALE)
    figure.suptitle(title or "a load that moves", x=0.012, ha="left", fontsize=14, weight="bold", color=INK)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.25 / tall), h_pad=1.4)
    return save(figure, path)


Panel = tuple[str, str, dict[str, np.ndarray]]


def _column(rows: Sequence[Mapping[str, Any]], title: str) -> np.ndarray:
    return np.array([np.nan if row.get(title, "") == "" else row[title] for row in rows], dtype=float)


def _reactions(rows: Sequence[Mapping[str, Any]], dimension: int) -> list[Panel]:
    """Forces of supports along each axis."""
    unit, found = "N/m" if dimension == 2 else "N", []
    marks = {axis: f" force_{axis} [{unit}]" for axis in AXES[dimension]}
    forces = {
        axis: {title.removesuffix(mark): _column(rows, title) for title in rows[0] if title.endswith(mark)}
        for axis, mark in marks.items()
    }
    every = [np.abs(values).max() for lines in forces.values() for values in lines.values()]
    least = ZERO * max(every, default=0.0)
    for axis, lines in forces.items():
        kept = {name: values for name, values in lines.items() if np.abs(values).max() > least}
        if kept:
            found.append((f"force of supports along {axis}", unit, kept))
    return found


def _stones(rows: Sequence[Mapping[str, Any]]) -> list[Panel]:
    """Extremes of the stones' mean stresses, and what they use of their strength."""
    titles = {"greatest compression": "mean_sigma_3 [Pa]", "greatest tension": "mean_sigma_1 [Pa]"}
    stress = {name: _column(rows, title) for name, title in titles.items()}
    used = {"utilisation": _column(rows, "utilisation [-]")}
    found = [("mean stress of stones", "Pa", stress), ("greatest utilisation of a stone", "", used)]
    return [panel for panel in found if not any(np.isnan(line).all() for line in panel[2].values())]


def _joints(rows: Sequence[Mapping[str, Any]]) -> list[Panel]:
    """How near the joints are to hinges and to sliding, by label."""
    found = []
    for heading, mark in (
        ("thrust from the middle of a joint (0) to its edge (1), greatest", " edge_share [-]"),
        ("friction used, greatest", " friction_used [-]"),
    ):
        titles = dict.fromkeys(title for row in rows for title in row if title.endswith(mark))
        lines = {title.removesuffix(mark): _column(rows, title) for title in titles}
        lines = {name: values for name, values in lines.items() if not np.isnan(values).all()}
        if lines:
            found.append((heading, "", lines))
    return found
