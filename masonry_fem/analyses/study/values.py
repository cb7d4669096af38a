"""Values: what a study shows where each of its cells is a problem of its own: quantities over a key.

    names = shown(study.targets)                  # of the quantities that have a column
    draw_values(study, Path("values.png"))

Vectors are shown by their size. The key with the most numbers is the abscissa, the others make lines.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain, cycle, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_fem.analyses.study.quantity import Quantity
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.target import Target
from masonry_fem.output.chart import COLOURS, blank, frame, head, save
from masonry_fem.output.sheet import INK, PALE, quantity

if TYPE_CHECKING:
    from masonry_fem.analyses.study.sweep import Study
    from masonry_fem.analyses.study.variation import Variation

MOST = 4  # quantities
ASIDE = ("supports", "moments", "energy", "stress.means")  # have a column only if nothing else has
PANEL = (5.2, 3.6)  # [inch]


def shown(aims: Sequence[Target]) -> list[str]:
    """Names of quantities that are shown: the first of each target, then the second of each.

    Parameters
    ----------
    aims : The study's targets.
    """
    first = [aim for aim in aims if aim.label not in ASIDE] or list(aims)
    turns = zip_longest(*(aim.names for aim in first))
    return [name for name in chain.from_iterable(turns) if name is not None][:MOST]


def number(row: Row, name: str) -> float:
    """A quantity of a cell, of vectors the size; NaN where the cell has none.

    Parameters
    ----------
    row : The cell. name : Of the quantity.
    """
    found = row.quantities.get(name)
    return math.nan if found is None else _number(found)


def words(row: Row, name: str) -> str:
    """The same with its unit; a dash where the cell has none.

    Parameters
    ----------
    row : The cell. name : Of the quantity.
    """
    found = row.quantities.get(name)
    return "–" if found is None else quantity(_number(found), found.unit, 4)


def _number(found: Quantity) -> float:
    return found.values[0] if len(found.values) == 1 else found.size


def drawable(study: Study) -> bool:
    """Whether there is a curve: a key with several values, and a quantity that cells have."""
    return study.explores and len(_abscissa(study.vary).values) > 1 and bool(shown(study.targets))


def draw_values(study: Study, path: Path) -> Path:
    """Draw each quantity over the key with the most values.

    Parameters
    ----------
    study : The study. path : The picture.
    """
    names, key = shown(study.targets), _abscissa(study.vary)
    columns = min(2, len(names))
    lines = math.ceil(len(names) / columns)
    figure = blank(PANEL[0] * columns, PANEL[1] * lines + 0.9)
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    others = [one for one in study.vary if one is not key and len(one.values) > 1]
    for panel, name in zip(panels, names, strict=False):
        _draw_curves(panel, name, key, _lines(study.rows, others))
    for panel in panels[len(names) :]:
        panel.set_visible(False)
    if others:
        panels[0].legend(frameon=False, fontsize=9, labelcolor=INK)
    head(figure, study.title or "study", "one point a cell; cells that were not solved are left out")
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.8 / figure.get_figheight()))
    return save(figure, path)


def _draw_curves(panel: Any, name: str, key: Variation, lines: dict[str, list[Row]]) -> None:
    """Draw a quantity over a key.

    Parameters
    ----------
    panel : Where to. name : Of the quantity. key : The abscissa. lines : Cells that a line joins, by label.
    """
    frame(panel)
    texts = [key.text(at) for at in range(len(key.values))]
    counts = all(isinstance(value, int | float) for value in key.values)
    places = dict(zip(texts, map(float, key.values) if counts else range(len(texts)), strict=True))
    for colour, (label, rows) in zip(cycle(COLOURS), lines.items(), strict=False):
        spots = sorted((places[row.cell.settings[key.key]], number(row, name)) for row in rows)
        panel.plot(*zip(*spots, strict=True), "o-", ms=5, lw=1.6, color=colour, label=label)
    if not counts:
        panel.set_xticks(list(places.values()), texts)
    panel.set_title(name, fontsize=11, color=INK, loc="left", weight="bold")
    panel.set_xlabel(f"{key.key.rpartition('.')[2]}{_bracketed(key.unit)}", fontsize=9.5, color=PALE)
    panel.set_ylabel(_bracketed(_unit(name, lines)).strip(), fontsize=9.5, color=PALE)
    panel.margins(0.06, 0.12)


def _unit(name: str, lines: dict[str, list[Row]]) -> str:
    """Unit of a quantity; empty where no cell has it."""
    found = (row.quantities[name].unit for rows in lines.values() for row in rows if name in row.quantities)
    return next(found, "")


def _bracketed(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _abscissa(vary: Sequence[Variation]) -> Variation:
    """The key with the most values."""
    return max(vary, key=lambda one: len(one.values))


def _lines(rows: Sequence[Row], others: Sequence[Variation]) -> dict[str, list[Row]]:
    """Cells that a line joins, by what they have in common."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        label = ", ".join(
            f"{one.key.rpartition('.')[2]} = {row.cell.settings[one.key]} {one.unit}".rstrip()
            for one in others
        )
        found.setdefault(label, []).append(row)
    return found
