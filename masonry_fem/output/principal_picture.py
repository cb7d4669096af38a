"""Principal stresses as crosses: at points of the stones, or of the mean of each where they are many."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from masonry_fem.output import fields
from masonry_fem.output.arrows import legend_sample
from masonry_fem.output.backdrop import by_depth, draw_pale, faded, title_of
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import Key, Sheet, quantity

FloatArray = NDArray[np.float64]

COMPRESSION, TENSION = "#1f5fa8", "#c8352b"
FEW = 60  # stones: of more the means are drawn
POINTS = 900  # at most
APART = 0.3  # of a block's size: how far points are at least from each other
SHORTEST = 0.04  # of the longest arm: shorter ones are dots


def draw_principal(scenery: Scenery, path: Path) -> Path:
    """Principal stresses as crosses, blue where they press.

    Parameters
    ----------
    scenery : What to draw. path : The picture.
    """
    import pyvista as pv  # noqa: PLC0415

    blocks = scenery.blocks.copy()
    blocks.points = blocks.points + blocks.point_data[fields.DISPLACEMENT]
    centres, stress, words, spacing = _crosses(blocks, scenery.length)
    arrays = fields.stress_arrays(stress)
    values = np.asarray(arrays[fields.PRINCIPAL], float)
    directions = np.stack([np.asarray(arrays[name], float) for name in fields.DIRECTIONS], axis=1)
    if scenery.dimension == 2:
        values = np.where(np.abs(directions[:, :, 2]) > 0.9, 0.0, values)
    # corners in contact are singular: the arms of hardly any point are longer than those of their neighbours
    top = float(np.quantile(np.abs(values).max(axis=1), 0.98)) or 1.0
    arm_length = 0.45 * spacing
    half = arm_length * np.clip(values / top, -1.0, 1.0)[..., None] * directions
    sheet = Sheet(
        title_of(scenery.title, "principal stresses"),
        f"{words}, from {quantity(float(values.min()), 'Pa')} to {quantity(float(values.max()), 'Pa')} "
        "(tension positive)" + (f", arms end at {quantity(top, 'Pa')}" if np.abs(values).max() > top else ""),
    )
    shape = DeformedShape(scenery, 1.0)
    stage = Stage(View.of(shape.deformed().points, scenery.dimension), sheet.image_width, scenery.length)
    draw_pale(stage, shape.deformed(), shape.deformed_outline())
    radius = max(0.035 * arm_length, 1.3 / stage.scale)
    for rank, colour, mask in (
        (3, COMPRESSION, values < -SHORTEST * top), (5, TENSION, values > SHORTEST * top)
    ):  # fmt: skip
        where, which = np.nonzero(mask)
        for own, strength in by_depth(stage.view, centres[where]):
            middle, arm = centres[where[own]], half[where[own], which[own]]
            bars = pv.PolyData(np.concatenate([middle - arm, middle + arm]))
            pairs = np.arange(len(own))
            bars.lines = np.column_stack([np.full_like(pairs, 2), pairs, pairs + len(pairs)]).ravel()
            if len(own):
                tubes = bars.tube(radius=radius, n_sides=12 if len(where) < 500 else 5)
                stage.solid(tubes, faded(colour, strength), rank=rank)
    sample, pixels = legend_sample(top, 2 * arm_length * stage.scale)
    if (values < -SHORTEST * top).any():
        sheet.keys.append(Key(f"compression, {quantity(sample, 'Pa')}", COMPRESSION, "bar", pixels))
    if (values > SHORTEST * top).any():
        sheet.keys.append(Key(f"tension, {quantity(sample, 'Pa')}", TENSION, "bar", pixels))
    return sheet.save(path, stage)


def _crosses(blocks: Any, length: float) -> tuple[FloatArray, FloatArray, str, float]:
    """Where crosses are, the stress there, both in words, and how far they are apart [m].

    Parameters
    ----------
    blocks : Displaced grid. length : A typical block size [m].
    """
    stress = np.asarray(blocks.cell_data[fields.STRESS], float)
    known = ~np.isnan(stress[:, 0])
    number = np.asarray(blocks.cell_data[fields.BLOCK])[known]
    stones = len(np.unique(number))
    if stones > FEW or known.sum() <= stones:
        centres, means = _block_means(blocks, known)
        return centres, means, "Mean stress of each block", _spacing(centres, length)
    centres = np.asarray(blocks.cell_centers().points, float)[known]
    chosen, apart = thinned(centres, APART * length, POINTS)
    return centres[chosen], stress[known][chosen], f"Stress of {len(chosen)} elements", apart


def thinned(points: FloatArray, apart: float, most: int) -> tuple[NDArray[np.int64], float]:
    """Rows of points of which each cube of a lattice has one, the nearest to its middle, and the cubes' size.

    Parameters
    ----------
    points : Shape (n, 3) [m]. apart : Least size of the cubes [m]. most : Number of points at most.
    """
    low = points.min(axis=0)
    while True:
        place = (points - low) / apart
        cube = np.floor(place + 1e-9).astype(np.int64)
        off = np.linalg.norm(place - cube - 0.5, axis=1).round(9)
        _, where = np.unique(cube, axis=0, return_inverse=True)
        order = np.lexsort((off, where.ravel()))
        first = np.flatnonzero(np.diff(where.ravel()[order], prepend=-1))
        if len(first) <= most:
            return np.sort(order[first]), apart
        apart *= 1.15


def _block_means(blocks: Any, known: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Centre and volume mean of the stress of each block that has one, shapes (b, 3), (b, 6)."""
    sizes = blocks.compute_cell_sizes(length=False, area=True, volume=True)
    volume = (np.abs(sizes.cell_data["Volume"]) + np.abs(sizes.cell_data["Area"]))[known]
    stress = np.asarray(blocks.cell_data[fields.STRESS], float)[known]
    centres = np.asarray(blocks.cell_centers().points, float)[known]
    _, where = np.unique(np.asarray(blocks.cell_data[fields.BLOCK])[known], return_inverse=True)
    total = np.bincount(where, volume)[:, None]

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([np.bincount(where, volume * v) for v in values.T], axis=1) / total

    return mean(centres), mean(stress)


def _spacing(centres: FloatArray, length: float) -> float:
    """Usual distance from a block's centre to the nearest other one: crosses that long stay apart."""
    if len(centres) < 2:
        return length
    distance, _ = cKDTree(centres).query(centres, k=2)
    return float(np.median(distance[:, 1]))
