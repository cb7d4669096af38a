"""Notebook: what a notebook shows of a run: its summary as a table, and pictures.

summary_html(result.summary)
picture_of(march, summary, "thrust")
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from masonry_fem.errors import OutputError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.output.terminal import GOOD, ORDER
from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy
    from masonry_fem.march.march import March
    from masonry_fem.output.strength import Strengths


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of a run; a notebook shows it.

    Attributes
    ----------
    name : As in ``output.pictures`` of a scene.
    png : The file's content.
    """

    name: str
    png: bytes

    def save(self, path: str | Path) -> Path:
        """Write it to a file, and return its path."""
        path = Path(path)
        write_atomic(path, self.png)
        return path

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        """Without the content."""
        return f"Picture({self.name!r}, {len(self.png)} bytes)"


def picture_of(
    march: March, determinacy: ForceDeterminacy | None, summary: Any, name: str | None = None, *,
    amplification: float | None = None, strengths: Strengths | None = None,
) -> Picture:  # fmt: skip
    """One picture of the end of a march.

    Parameters
    ----------
    march : How it ended. determinacy : Which forces are facts, if that is known.
    summary : What ``summary.json`` holds.
    name : Of the picture, as in ``output.pictures`` of a scene; None: ``overview`` where stones have
        stresses, else ``deformed``.
    amplification : Of displacements; None to choose one.
    strengths : Of the stones, for their utilisation.

    Raises
    ------
    OutputError : There is nothing to draw it from, or nothing to draw it with.
    """
    from masonry_fem.output.asked.pictures import Pictures  # noqa: PLC0415 - what draws takes a second to load
    from masonry_fem.output.render import can_render  # noqa: PLC0415

    if not can_render():
        raise OutputError(
            "pictures cannot be drawn here; install the extra 'pictures' and libEGL or libOSMesa "
            "('masonry-fem info' tells what is missing)"
        )
    state = march.state if determinacy is None else determinacy.state
    with TemporaryDirectory() as folder:
        if name is None:
            name = next(one for one in ("overview", "deformed") if one in _known(march, strengths))
        made = Pictures(
            Path(folder), summary.title, amplification, joints=True, strengths=strengths, only={name}
        )
        made.record(march.model, state, march.report)
        made.end(march, determinacy)
        drawn = made.close(summary)
        if not drawn:
            there = ", ".join(f"'{one}'" for one in _known(march, strengths))
            raise OutputError(
                f"'{name}' cannot be drawn of this run, expected one that it has data for ({there}); "
                "docs/results.md tells which needs what"
            )
        return Picture(name, drawn[0].read_bytes())


def _known(march: March, strengths: Strengths | None) -> list[str]:
    """Names of the pictures that a march has data for."""
    from masonry_fem.output.picture import drawable  # noqa: PLC0415
    from masonry_fem.output.scenery import Scenery  # noqa: PLC0415

    return drawable(Scenery.of(march.model, march.state, joints=True, strengths=strengths))


def summary_html(told: Any) -> str:
    """A summary as a table in HTML, in the order of the console.

    Parameters
    ----------
    told : A record, or the contents of ``summary.json``.
    """
    summary = plain(told)
    outcome = str(summary.get("outcome", "unknown"))
    colour = "#1a7f37" if outcome in GOOD else "#b3261e"
    head = f'<b style="color:{colour}">{escape(outcome.replace("_", " "))}</b>'
    title, message = escape(str(summary.get("title") or "")), escape(str(summary.get("message") or ""))
    rows, section = [], ""
    for part in ORDER:
        for heading, name, value in part(summary):
            cells = ("" if heading == section else f"<b>{escape(heading)}</b>", escape(name), escape(value))
            rows.append(
                "<tr>" + "".join(f'<td style="text-align:left">{one}</td>' for one in cells) + "</tr>"
            )
            section = heading
    caption = f"{title}: " if title else ""
    return f"<div><p>{caption}{head}<br>{message}</p><table>{''.join(rows)}</table></div>"
