"""Mesh picture: the blocks' cells by shape and the detected interfaces, before anything is solved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.march.model import Model
from masonry_fem.output import fields
from masonry_fem.output.backdrop import draw_pale, title_of
from masonry_fem.output.grid import fidelity_names, grid_of, three
from masonry_fem.output.render import Stage, View, can_render
from masonry_fem.output.scenery import element_edges_of, outline_of, pyvista_grid, surface_of
from masonry_fem.output.sheet import LINE, Key, Sheet
from masonry_fem.output.vtu import named, write_vtu

FloatArray = NDArray[np.float64]

# muted, told apart by readers who confuse red and green
SHAPE_COLOURS = ("#d9c8a5", "#a8bccf", "#c9a79a", "#b7c4a0", "#c3b1cf", "#9fc3bd", "#e0b98a", "#b3b3b3")
JOINT_COLOURS = ("#c8352b", "#1f5fa8", "#1b7f5c", "#e07b1a", "#7a4fa3", "#4d4d4d")
SHOWN = 6


def write_mesh_files(model: Model, directory: Path, title: str = "") -> list[Path]:
    """Write ``mesh.vtu`` and, if this machine can draw, ``mesh.png`` and ``interfaces.png``.

    Parameters
    ----------
    model : The model.
    directory : Folder for the files.
    title : Of the scene.
    """
    directory = Path(directory)
    grid = grid_of(model, shells=True)
    shape = model.assembly.blocks.shape
    arrays: fields.Arrays = {
        fields.BLOCK: grid.cell_block,
        fields.GROUP: grid.cell_group,
        fields.FIDELITY: grid.cell_fidelity,
        "shape": shape[grid.cell_block],
    }
    paths = [directory / "mesh.vtu"]
    names: fields.Arrays = {
        "block_names": named(model.assembly.blocks.names),
        "shape_names": named([one.name for one in model.assembly.shapes]),
        "fidelity_names": named(fidelity_names()),
    }
    write_vtu(paths[0], grid, {fields.BLOCK: grid.point_block}, arrays, names)
    if can_render():
        paths.append(draw_mesh(model, directory / "mesh.png", title))
        if not model.interfaces.tie.all():
            paths.append(draw_interfaces(model, directory / "interfaces.png", title))
    return paths


def draw_mesh(model: Model, path: Path, title: str = "") -> Path:
    """Blocks coloured by shape, with the edges of their elements."""
    grid = grid_of(model)
    shape = model.assembly.blocks.shape
    blocks = pyvista_grid(grid)
    blocks.cell_data["shape"] = shape[grid.cell_block]
    surface = surface_of(blocks)
    ranges = zip(grid.group_cells, model.groups, strict=True)
    elements = sum(stop - start for (start, stop), group in ranges if group.deforms)
    sheet = Sheet(
        title_of(title, "mesh"),
        f"{len(model.assembly.blocks)} blocks of {len(model.assembly.shapes)} shapes, "
        f"{elements} elements, {len(grid.points)} nodes",
    )
    stage = Stage(View.of(grid.points, grid.dimension), sheet.image_width, model.length)
    present = np.unique(shape)
    for rank, number in enumerate(present):
        colour = SHAPE_COLOURS[rank % len(SHAPE_COLOURS)]
        part = surface.extract_cells(np.flatnonzero(surface.cell_data["shape"] == number))
        stage.surface(part, color=colour)
        if rank < SHOWN:
            sheet.keys.append(
                Key(f"{model.assembly.shapes[number].name} × {(shape == number).sum()}", colour)
            )
    if len(present) > SHOWN:
        sheet.keys.append(Key(f"and {len(present) - SHOWN} more shapes", LINE, "none"))
    stage.lines(element_edges_of(blocks), LINE, 0.9, opacity=0.45)
    stage.lines(outline_of(surface), LINE, 1.8)
    return sheet.save(path, stage)


def draw_interfaces(model: Model, path: Path, title: str = "") -> Path:
    """Detected interfaces coloured by joint label, each with its normal towards the candidate."""
    grid = grid_of(model)
    surface = surface_of(pyvista_grid(grid))
    interfaces = model.interfaces.only(~model.interfaces.tie)
    labels = sorted(set(interfaces.label_of_each))
    unit = "m²" if grid.dimension == 3 else "m"
    area = interfaces.area.sum()
    points = int((~model.contacts.tied).sum())
    sheet = Sheet(
        title_of(title, "interfaces"),
        f"{len(interfaces)} interfaces, {points} contact points, {area:.4g} {unit}; "
        "normals point to the candidate",
    )
    stage = Stage(View.of(grid.points, grid.dimension), sheet.image_width, model.length)
    draw_pale(stage, surface, outline_of(surface))
    for rank, label in enumerate(labels):
        colour = JOINT_COLOURS[rank % len(JOINT_COLOURS)]
        chosen = interfaces.only(np.array(interfaces.label_of_each) == label)
        _add_patches(stage, chosen, colour, grid.dimension)
        _add_normals(stage, chosen, colour, 0.22 * model.length)
        if rank < SHOWN:
            sheet.keys.append(Key(f"{label or 'no label'} × {len(chosen)}", colour))
    return sheet.save(path, stage)


def _add_patches(stage: Stage, chosen: Interfaces, colour: str, dimension: int) -> None:
    loops = np.insert(np.arange(chosen.first[-1]), chosen.first[:-1], chosen.size)
    patches = _poly_data(three(chosen.corners), loops, lines=dimension == 2)
    if dimension == 2:
        stage.lines(patches, colour, 5.0, rank=2)
    else:
        stage.surface(patches, color=colour, opacity=0.55)
        stage.lines(outline_of(patches), colour, 1.6)


def _add_normals(stage: Stage, chosen: Interfaces, colour: str, size: float) -> None:
    import pyvista as pv  # noqa: PLC0415

    middles = np.add.reduceat(chosen.corners, chosen.first[:-1]) / chosen.size[:, None]
    cloud = pv.PolyData(three(middles))
    cloud["_normal"] = three(chosen.normal)
    arrow = pv.Arrow(tip_length=0.3, tip_radius=0.09, shaft_radius=0.028)
    stage.solid(cloud.glyph(orient="_normal", scale=False, factor=size, geom=arrow), colour)


def _poly_data(points: FloatArray, cells: NDArray[np.int64], *, lines: bool) -> Any:
    import pyvista as pv  # noqa: PLC0415

    return pv.PolyData(points, lines=cells) if lines else pv.PolyData(points, faces=cells)
