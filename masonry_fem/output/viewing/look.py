"""Look: what of a step is shown: which field by colour, how much amplified, and what is cut away.

    look = Look("von_mises", 200.0, Section.read("y=0.25"))
    shown = look.shown(recorded.blocks(-1))

It is a surface with edges, displaced, with the values to colour.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.output import fields
from masonry_fem.output.cut import SIGNED_COLOURS
from masonry_fem.output.scenery import amplification_of, at_rest, outline_of, surface_of
from masonry_fem.output.sheet import STRESS_COLOURS, ColourBar, prefix_of
from masonry_fem.output.stone_pictures import USED_COLOURS

FloatArray = NDArray[np.float64]

VALUES = "_shown"  # array of what is coloured
SHADES: dict[str, tuple[str, int | None, str, str]] = {  # array, column (None: its length), unit, words
    "von_mises": (fields.VON_MISES, 0, "Pa", "von Mises stress"),
    "utilisation": (fields.UTILISATION, 0, "", "utilisation"),
    "greatest": (fields.PRINCIPAL, 0, "Pa", "greatest principal stress"),
    "least": (fields.PRINCIPAL, 2, "Pa", "least principal stress"),
    "displacement": (fields.DISPLACEMENT, None, "m", "displacement"),
    "velocity": (fields.VELOCITY, None, "m/s", "velocity"),
}
UNTOLD = {fields.BLOCK, fields.GROUP, fields.FIDELITY, fields.MATERIAL, fields.PROMOTED}


@dataclass(frozen=True, slots=True)
class Section:
    """A plane across an axis, before which everything is cut away, as seen in the pictures.

    Attributes
    ----------
    axis : 0, 1 or 2. at : Where the plane meets it [m].
    """

    axis: int
    at: float

    @classmethod
    def read(cls, text: str) -> Section:
        """From words such as ``y=0.25``, in metres.

        Raises
        ------
        SceneError : They are none.
        """
        name, _, value = text.partition("=")
        try:
            return cls("xyz".index(name.strip() or "?"), float(value))
        except ValueError:
            raise SceneError(f"--section '{text}', expected an axis and metres, such as y=0.25") from None

    def keep(self, grid: Any) -> Any:
        """What is behind the plane: the eye is at negative x and y, and above."""
        normal = np.eye(3)[self.axis] * (-1.0 if self.axis == 2 else 1.0)
        kept = grid.clip(normal=normal, origin=self.at * np.eye(3)[self.axis], invert=False)
        if not kept.n_cells:
            low, high = (float(end[self.axis]) for end in (grid.points.min(axis=0), grid.points.max(axis=0)))
            raise SceneError(
                f"the section {'xyz'[self.axis]} = {self.at:g} m leaves nothing to show, expected a plane "
                f"between {low:.4g} and {high:.4g} m"
            )
        return kept


@dataclass(frozen=True, slots=True)
class Shown:
    """What a look makes of a step.

    Attributes
    ----------
    surface, outline : Faces and edges of the blocks, displaced, as pyvista meshes.
    """

    surface: Any
    outline: Any


@dataclass(frozen=True, slots=True)
class Look:
    """How a step is shown.

    Attributes
    ----------
    field : Name of what is coloured, of ``fields_of``. factor : Amplification of displacements.
    section : What is cut away; None: nothing.
    """

    field: str
    factor: float
    section: Section | None = None

    def shown(self, blocks: Any) -> Shown:
        """Surface and edges of a step."""
        grid = blocks.copy()
        known, values = _values(grid, self.field)
        (grid.point_data if known == "points" else grid.cell_data)[VALUES] = values
        grid.points = grid.points + self.factor * np.asarray(grid.point_data[fields.DISPLACEMENT])
        if self.section is not None:
            grid = self.section.keep(grid)
        surface = surface_of(grid)
        return Shown(surface, outline_of(surface))


@dataclass(frozen=True, slots=True)
class Shade:
    """Colours of a field.

    Attributes
    ----------
    field : Its name. colours : The map. limits : In SI units. over : Whether values are beyond the upper one.
    """

    field: str
    colours: Any  # a name that matplotlib knows, or a map
    limits: tuple[float, float]
    over: bool

    @classmethod
    def of(cls, grids: list[Any], field: str) -> Shade:
        """Limits that suit all of some steps.

        Parameters
        ----------
        grids : Blocks of the steps. field : Name of what is coloured.
        """
        values = np.concatenate([_values(grid, field)[1] for grid in grids])
        values = values[np.isfinite(values)]
        if not len(values):
            return cls(field, STRESS_COLOURS, (0.0, 1.0), False)
        # corners in contact are singular: colours end where hardly any point has more
        low, high = (float(end) for end in np.quantile(values, (0.005, 0.995)))
        if values.min() >= 0:
            low = 0.0
            over = values.max() > 1.1 * high > 0
            high = high if over else float(values.max())
        else:
            low, high, over = min(low, -abs(high)), max(abs(low), high), False
        if field == "utilisation" and values.max() > 1:
            high, over = 1.0, True
        named = USED_COLOURS if field == "utilisation" else SIGNED_COLOURS if low < 0 else STRESS_COLOURS
        return cls(field, named, (low, high if high > low else low + 1e-12), bool(over))

    @property
    def words(self) -> str:
        """What the field is called."""
        return SHADES[self.field][3] if self.field in SHADES else self.field.replace("_", " ")

    @property
    def label(self) -> tuple[float, str]:
        """What values are divided by on the bar, and its words."""
        unit = SHADES[self.field][2] if self.field in SHADES else ""
        if not unit:
            return 1.0, self.words
        factor, prefix = prefix_of(max(abs(end) for end in self.limits))
        return factor, f"{self.words} [{prefix}{unit}]"

    def bar(self) -> ColourBar:
        """The scale of colours on a sheet."""
        factor, words = self.label
        low, high = (end / factor for end in self.limits)
        return ColourBar(
            words.replace(" stress", "").replace(" [", "\n["), self.colours, (low, high), self.over
        )


def fields_of(blocks: Any) -> list[str]:
    """Names of what a step's blocks can be coloured by; the first is what matters most."""
    named = [name for name, (array, *_) in SHADES.items() if array in blocks.point_data]
    rest = [
        name
        for name, values in {**blocks.point_data, **blocks.cell_data}.items()
        if values.ndim == 1 and name not in UNTOLD and not name.startswith("has_") and name not in SHADES
    ]
    return [*named, *dict.fromkeys(rest)]


def checked_field(blocks: Any, field: str | None) -> str:
    """A field that is there.

    Parameters
    ----------
    blocks : Of a step. field : Its name; None for the one that matters most.

    Raises
    ------
    SceneError : There is no such field.
    """
    known = fields_of(blocks)
    if field is None:
        return known[0]
    if field not in known:
        raise SceneError(f"no field '{field}' in these results, expected one of {', '.join(known)}")
    return field


def suited_factor(grids: list[Any]) -> float:
    """Amplification that shows the greatest displacements of some steps well; 1 where nothing moves."""
    return min((amplification_of(*_moves(grid)) for grid in grids if not at_rest(*_moves(grid))), default=1.0)


def _moves(grid: Any) -> tuple[FloatArray, FloatArray]:
    return np.asarray(grid.point_data[fields.DISPLACEMENT], float), np.asarray(grid.points, float)


def _values(grid: Any, field: str) -> tuple[str, FloatArray]:
    """Whether a field belongs to points or cells, and its values, NaN where a step lacks it."""
    array, column, _, _ = SHADES.get(field, (field, 0, "", ""))
    where = "points" if array in grid.point_data else "cells"
    data = grid.point_data if where == "points" else grid.cell_data
    if array not in data:
        return "points", np.full(grid.n_points, np.nan)
    values = np.asarray(data[array], float).reshape(len(data[array]), -1)
    return where, np.linalg.norm(values, axis=1) if column is None else values[:, column]
