"""Places: where a load that moves stood, what that led to, and the envelope over all places.

places = PlacesTable(scene, built, out)         # a recorder, which writes places.csv and envelope.csv
result, files = places.told(result)             # with what the summary says, and the picture
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.run.combinations import write_envelope
from masonry_fem.build import Built
from masonry_fem.build.strengths import strengths_of
from masonry_fem.host.atomic import write_records
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import without_ties
from masonry_fem.output.history import AXES
from masonry_fem.output.render import can_render
from masonry_fem.results.combinations import (
    AtPlace,
    Envelope,
    Extremes,
    Places,
    SupportOverPlaces,
    components,
)
from masonry_fem.scene import specs

if TYPE_CHECKING:
    from masonry_fem.analyses.run.result import RunResult

FloatArray = NDArray[np.float64]

ROUNDING = 1e-9  # of a load factor
STONES = (("utilisation [-]", 1.0), ("mean_sigma_3 [Pa]", -1.0), ("mean_sigma_1 [Pa]", 1.0))  # and sense
JOINTS = ("edge_share", "friction_used")  # by label
YES, NO = "yes", "no"


class PlacesTable:
    """Recorder of ``places.csv``, one line a place, and ``envelope.csv``, their extremes.

    Parameters
    ----------
    scene : With a load that moves. built : Made of it. out : Results folder.
    """

    dense = False

    def __init__(self, scene: specs.Scene, built: Built, out: Path) -> None:
        self._scene, self._out = scene, out
        self._strengths = strengths_of(scene, built.stones)
        self._dimension = scene.dimension
        self._rows: list[dict[str, Any]] = []
        self._most: dict[str, tuple[FloatArray, FloatArray]] = {}  # values and places, by quantity
        self._stones: list[str] = []

    def start(self, model: Model) -> None:
        """Nothing is written before the end."""

    def saved(self) -> dict[str, Any]:
        """The lines and extremes so far."""
        return {
            "rows": list(self._rows),
            "most": {name: list(pair) for name, pair in self._most.items()},
            "stones": list(self._stones),
        }

    def go_on(self, model: Model, saved: dict[str, Any]) -> None:
        """Go on with them."""
        self._rows, self._stones = list(saved["rows"]), list(saved["stones"])
        self._most = {name: (pair[0].copy(), pair[1].copy()) for name, pair in saved["most"].items()}

    def record(self, model: Model, state: SystemState, report: Any) -> None:
        """Enter a place, unless loads are still growing there."""
        statics = not self._scene.analysis.inertia
        if statics and state.time < 1.0 - ROUNDING:
            return
        travel = next(load.travel for load in model.loads if load.travel is not None)
        place = travel.place(state.time)
        row: dict[str, Any] = {"place [m]": place}
        for axis, value in zip(AXES[self._dimension], travel.position(place).tolist(), strict=True):
            row[f"{axis} [m]"] = value
        row["load_factor [-]" if statics else "time [s]"] = state.time
        row["stands"] = YES if report.outcome.solved else NO
        if report.outcome.solved:
            row |= self._effects(model, state, report, place)
        self._rows.append(row)

    def close(self, summary: Any) -> list[Path]:
        """Write the tables."""
        if not self._rows:
            return []
        path = write_records(self._out / "places.csv", self._rows)
        return [path, write_envelope(self._out / "envelope.csv", self._envelope(), "place [m]")]

    def told(self, result: RunResult, *, draws: bool) -> tuple[RunResult, list[Path]]:
        """A result with what the summary says of the places, and the picture of them.

        Parameters
        ----------
        result : What the march tells. draws : Whether pictures that the scene asks for are drawn.
        """
        stood = [row for row in self._rows if row["stands"] == YES]
        result = result.telling(places=self._summary(stood))
        asked = self._scene.output.pictures
        wanted = asked if isinstance(asked, bool) else "places" in asked
        if len(stood) < 2 or not (wanted and draws and can_render()):
            return result, []
        from masonry_fem.output.places_picture import draw_places  # noqa: PLC0415 - matplotlib

        return result, [draw_places(self._out / "places.png", self._scene.title, stood, self._dimension)]

    def _effects(self, model: Model, state: SystemState, report: Any, place: float) -> dict[str, Any]:
        """What the load leads to at a place, as cells of a line."""
        from masonry_fem.output.asked.stones import stone_columns  # noqa: PLC0415 - loads much

        cells: dict[str, Any] = {}
        for name, resultant in report.support_resultants.items():
            self._enter(f"least {name}", resultant, place, -1.0)
            self._enter(f"greatest {name}", resultant, place, 1.0)
            titles = components(len(resultant))
            cells |= {
                f"{name} {title}": value for title, value in zip(titles, resultant.tolist(), strict=True)
            }
        nothing = [""] * len(model.assembly.blocks)
        columns = stone_columns(model, state, nothing, self._strengths)
        self._stones = columns["block"]
        local = np.array(columns["utilisation [-]"], dtype=float)
        mean = np.array(columns["utilisation_of_mean [-]"], dtype=float)
        columns["utilisation [-]"] = np.where(np.isnan(local), mean, local).tolist()
        for title, sense in STONES:
            values = np.array(columns[title], dtype=float)
            self._enter(title, values, place, sense)
            cells |= _worst(title, values, self._stones, sense)
        return cells | self._joints(model, state)

    def _joints(self, model: Model, state: SystemState) -> dict[str, Any]:
        """The joints that are nearest to opening on a hinge and to sliding, and how many are hinges."""
        from masonry_fem.output.interfaces import HINGE, interface_forces  # noqa: PLC0415 - only here

        model, state = without_ties(model, state)
        if not model.interfaces:
            return {}
        told, blocks = interface_forces(model, state), model.assembly.blocks
        joints = [model.interfaces[row] for row in told.faces.first.tolist()]
        names = [f"{blocks[a].name} – {blocks[b].name}" for a, b in (one.blocks for one in joints)]
        labels = np.array([one.label or "joint" for one in joints])
        cells: dict[str, Any] = {}
        for label in np.unique(labels).tolist():
            for quantity in JOINTS:
                values = np.where(labels == label, getattr(told, quantity), np.nan)
                cells |= _worst(f"{label} {quantity} [-]", values, names, 1.0)
            cells[f"{label} hinges"] = int((told.status == HINGE)[labels == label].sum())
            cells[f"{label} sliding"] = int(told.slides[labels == label].sum())
        return cells

    def _enter(self, name: str, values: FloatArray, place: float, sense: float) -> None:
        """Keep what exceeds all earlier places."""
        most, where = self._most.get(name, (np.full(len(values), np.nan), np.full(len(values), np.nan)))
        more = ~np.isnan(values) & (np.isnan(most) | (sense * values > sense * most))
        self._most[name] = np.where(more, values, most), np.where(more, place, where)

    def _envelope(self) -> Envelope | None:
        """The extremes; None where nothing stood anywhere."""
        if not self._most:
            return None

        def extremes(key: str, names: Sequence[str]) -> Extremes:
            value, place = self._most[key]
            return Extremes(names, value, [f"{at:.12g}" for at in place.tolist()])

        stones = [extremes(title, self._stones) for title, _ in STONES]
        supports = {}
        for name in (key.removeprefix("least ") for key in self._most if key.startswith("least ")):
            titles = components(len(self._most[f"least {name}"][0]))
            supports[name] = extremes(f"least {name}", titles), extremes(f"greatest {name}", titles)
        return Envelope(stones[0], stones[2], stones[1], supports)

    def _summary(self, stood: Sequence[dict[str, Any]]) -> Places:
        """What the summary says."""

        def worst(title: str, sense: float) -> AtPlace | None:
            found = [row for row in stood if row.get(title, "") != ""]
            if not found:
                return None
            row = max(found, key=lambda row: sense * row[title])
            return AtPlace(value=row[title], place=row["place [m]"], of=row[_of(title)])

        def by_label(quantity: str) -> dict[str, AtPlace]:
            titles = {title: None for row in stood for title in row if title.endswith(f" {quantity} [-]")}
            found = {title.removesuffix(f" {quantity} [-]"): worst(title, 1.0) for title in titles}
            return {label: one for label, one in found.items() if one is not None}

        def all_of(key: str) -> tuple[AtPlace, ...]:
            values, places = self._most[key]
            pairs = zip(values.tolist(), places.tolist(), strict=True)
            return tuple(AtPlace(value=value, place=place) for value, place in pairs)

        names = [key.removeprefix("least ") for key in self._most if key.startswith("least ")]
        fell = [row["place [m]"] for row in self._rows if row["stands"] == NO]
        return Places(
            count=len(stood),
            first=stood[0]["place [m]"] if stood else None,
            last=stood[-1]["place [m]"] if stood else None,
            fell_at=fell[0] if fell else None,
            utilisation=worst(STONES[0][0], 1.0),
            compression=worst(STONES[1][0], -1.0),
            tension=worst(STONES[2][0], 1.0),
            edge_share=by_label(JOINTS[0]),
            friction_used=by_label(JOINTS[1]),
            supports={
                name: SupportOverPlaces(least=all_of(f"least {name}"), greatest=all_of(f"greatest {name}"))
                for name in names
            },
        )


def _of(title: str) -> str:
    """Title of the column that names what has the extreme value of another column."""
    return f"{title.rpartition(' ')[0]}_of"


def _worst(title: str, values: FloatArray, names: Sequence[str], sense: float) -> dict[str, Any]:
    """An extreme value and the name of what has it, empty where nothing is known."""
    if np.isnan(values).all():
        return {title: "", _of(title): ""}
    at = int(np.nanargmax(sense * values))
    return {title: float(values[at]), _of(title): names[at]}
