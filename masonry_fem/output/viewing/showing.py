"""Showing: a plotter that shows one step, and what a window or a browser changes of it.

    showing = Showing(recorded, plotter, look)
    showing.step(3); showing.factor(200.0); showing.section(Section(1, 0.2))
    showing.pick(120, 80)

A pick names the block under a pixel, with its figures.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from masonry_fem.errors import SceneError
from masonry_fem.output import fields
from masonry_fem.output.scenery import surface_of
from masonry_fem.output.sheet import HELD, INK, LINE, quantity
from masonry_fem.output.viewing.look import SHADES, VALUES, Look, Section, Shade, fields_of
from masonry_fem.output.viewing.recorded import Recorded

CHOSEN = "#1f7ae0"  # edges of the block that was picked


class Showing:
    """What a plotter shows of a results folder.

    Parameters
    ----------
    recorded : The steps. plotter : pyvista's, empty. look : How it begins. place : Of the first step shown.
    """

    def __init__(self, recorded: Recorded, plotter: Any, look: Look, place: int = -1) -> None:
        self.recorded, self.plotter, self.look = recorded, plotter, look
        self.place = place % len(recorded.files)
        self.chosen: int | None = None
        self._surface: Any = None
        plotter.set_background("white")
        self._shades: dict[str, Shade] = {}
        self._draw()
        if self.dimension == 2:
            plotter.view_xy()
        else:
            plotter.view_vector((-0.62, -1.0, 0.52), (0.0, 0.0, 1.0))
        plotter.enable_parallel_projection()
        plotter.reset_camera()
        plotter.camera.zoom(1.25)
        plotter.add_axes(color=INK)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self._blocks.field_data["dimension"][0])

    @property
    def fields(self) -> list[str]:
        """Names of what can be coloured."""
        return fields_of(self._blocks)

    @property
    def _blocks(self) -> Any:
        return self.recorded.blocks(self.place)

    def step(self, place: int) -> None:
        """Show another step, by its place from 0 on."""
        self.place = int(np.clip(place, 0, len(self.recorded.files) - 1))
        self._draw()

    def field(self, name: str) -> None:
        """Colour another field."""
        self.look = replace(self.look, field=name)
        self._draw()

    def factor(self, factor: float) -> None:
        """Amplify displacements otherwise."""
        self.look = replace(self.look, factor=max(factor, 0.0))
        self._draw()

    def apart(self, share: float) -> None:
        """Pull blocks apart: their distances from the middle grow by this share."""
        self.look = replace(self.look, apart=max(share, 0.0))
        self._draw()

    def section(self, section: Section | None) -> None:
        """Cut away what is before a plane; None: nothing. A plane that would leave nothing is not taken."""
        before, self.look = self.look, replace(self.look, section=section)
        try:
            self._draw()
        except SceneError:
            self.look = before
            self._draw()

    def pick(self, x: float, y: float) -> str:
        """Choose the block under a pixel, counted from the lower left corner; what there is to say of it."""
        from vtkmodules.vtkRenderingCore import vtkCellPicker  # noqa: PLC0415

        picker = vtkCellPicker()
        picker.SetTolerance(0.0005)
        picker.PickFromListOn()
        picker.AddPickList(self._surface)
        hit = picker.Pick(x, y, 0.0, self.plotter.renderer)
        cell = picker.GetCellId()
        mesh = self._surface.mapper.dataset
        self.chosen = int(mesh.cell_data[fields.BLOCK][cell]) if hit and cell >= 0 else None
        self._draw()
        return self.told()

    def told(self) -> str:
        """Name and figures of the chosen block in this step; empty where none is chosen."""
        if self.chosen is None:
            return ""
        blocks = self._blocks
        own = np.asarray(blocks.point_data[fields.BLOCK]) == self.chosen
        lines = [self._names()[self.chosen]]
        for array, column, unit, words in SHADES.values():
            if array not in blocks.point_data:
                continue
            values = np.asarray(blocks.point_data[array], float)[own].reshape(int(own.sum()), -1)
            one = np.linalg.norm(values, axis=1) if column is None else values[:, column]
            if len(one) and np.isfinite(one).any():
                end = float(np.nanmin(one) if words.startswith("least") else np.nanmax(one))
                lines.append(f"{words}: {quantity(end, unit) if unit else f'{end:.3g}'}")
        return "\n".join(lines)

    def caption(self) -> str:
        """Step, time and amplification in words."""
        time = self.recorded.times[self.place]
        apart = f"; stones pulled apart by {self.look.apart:.2g}" if self.look.apart else ""
        return (
            f"step {self.place + 1} of {len(self.recorded.files)}, t = {time:.4g}; "
            f"displacements × {self.look.factor:.4g}{apart}"
        )

    def _names(self) -> list[str]:
        return bytes(np.asarray(self._blocks.field_data["block_names"])).decode().splitlines()

    def _shade(self) -> Shade:
        """Colours that suit all steps: they are the same whichever is shown."""
        name = self.look.field
        if name not in self._shades:
            count = len(self.recorded.files)
            some = np.unique(np.linspace(0, count - 1, min(count, 9)).round().astype(int)).tolist()
            self._shades[name] = Shade.of([self.recorded.blocks(place) for place in some], name)
        return self._shades[name]

    def _draw(self) -> None:
        """All anew; the camera stays."""
        shown, shade, plotter = self.look.shown(self._blocks), self._shade(), self.plotter
        factor, words = shade.label
        data = shown.surface.point_data if VALUES in shown.surface.point_data else shown.surface.cell_data
        data[VALUES] = np.asarray(data[VALUES], float) / factor
        plotter.suppress_rendering = True
        if plotter.scalar_bars:
            plotter.remove_scalar_bar(render=False)
        bar = {
            "title": words.replace(" stress", ""), "color": INK, "vertical": True, "position_x": 0.86,
            "position_y": 0.25, "title_font_size": 16, "label_font_size": 14, "height": 0.5, "width": 0.06,
        }  # fmt: skip
        self._surface = plotter.add_mesh(
            shown.surface, name="surface", scalars=VALUES, cmap=shade.colours, show_scalar_bar=True,
            clim=[end / factor for end in shade.limits], nan_color=HELD, scalar_bar_args=bar,
            reset_camera=False, render=False, ambient=0.45, diffuse=0.6, lighting=self.dimension == 3,
        )  # fmt: skip
        plotter.add_mesh(
            shown.outline, name="outline", color=LINE, line_width=1.5, reset_camera=False, render=False,
            pickable=False,
        )  # fmt: skip
        plotter.add_text(self.caption(), name="caption", position="upper_left", color=INK, font_size=10)
        self._mark(shown.surface)
        plotter.suppress_rendering = False

    def _mark(self, surface: Any) -> None:
        """Edges of the chosen block, and its figures."""
        plotter = self.plotter
        own = np.flatnonzero(np.asarray(surface.cell_data[fields.BLOCK]) == self.chosen)
        if self.chosen is None or not len(own):
            plotter.remove_actor("chosen", render=False)
            plotter.remove_actor("told", render=False)
            return
        edges = surface_of(surface.extract_cells(own)).extract_feature_edges(25.0)
        plotter.add_mesh(
            edges, name="chosen", color=CHOSEN, line_width=5, reset_camera=False, render=False, pickable=False
        )
        plotter.add_text(
            self.told(), name="told", position=(0.01, 0.72), viewport=True, color=CHOSEN, font_size=9
        )
