"""Thrust line: how forces pass from joint to joint through the blocks, and which joints are about to rotate.

    draw_thrust(scenery, Path("thrust.png"))

A band as wide as the force connects the centres of pressure of a block's loaded joints: directly if there are
two, through their mean, weighted by the forces, if there are more; from a single joint the band goes to the
block's middle. Supports have no band. Dots on the joints show their state.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output import fields, interface_fields
from masonry_fem.output.backdrop import draw_pale, title_of
from masonry_fem.output.grid import SUPPORT
from masonry_fem.output.interfaces import CLOSED, CRACKED, FREE, HELD, HINGE, MIDDLE_THIRD, STATUS_WORDS
from masonry_fem.output.marks import bands, discs, mark_ties
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import Key, Sheet, quantity, round_down

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

BAND, SLIDE = "#7fa6d4", "#7a4fa3"
COLOURS = {
    MIDDLE_THIRD: "#1b7f5c", CRACKED: "#e07b1a", HINGE: "#c8352b", CLOSED: "#33383f", HELD: "#8c6d1f",
    FREE: "#b9bec4",
}  # fmt: skip
WIDEST = 0.2  # of a block, the widest band
LEAST = 1e-6  # of the greatest force: no band is drawn for less


def draw_thrust(scenery: Scenery, path: Path) -> Path:
    """Draw the thrust through all blocks, on the structure where it is now.

    Parameters
    ----------
    scenery : What to draw.
    path : The picture.
    """
    told = scenery.joints
    status, slides = told[fields.STATUS], told[interface_fields.SLIDES].astype(bool)
    centre = told[interface_fields.CENTRE]
    size = np.linalg.norm(told[interface_fields.FORCE], axis=1)
    top = float(size.max(initial=0.0)) or 1.0
    # what pulls has no centre of pressure in its face
    drawn = np.isfinite(centre).all(axis=1) & ~np.isin(status, (FREE, HELD)) & (size > LEAST * top)
    starts, ends, force = thrust_segments(scenery, drawn, centre, size)
    sheet = Sheet(title_of(scenery.title, "thrust"), _caption(status, slides, size, scenery.force_unit))
    shape = DeformedShape(scenery, 1.0)
    stage = Stage(View.of(shape.deformed().points, scenery.dimension), sheet.image_width, scenery.length)
    draw_pale(stage, shape.deformed(), shape.deformed_outline())
    widest = float(np.clip(WIDEST * scenery.length * stage.scale, 3.0, 26.0))  # pixels
    wide = force * (widest / top / stage.scale)
    stage.mark(bands(stage.view, starts, ends, wide), BAND)
    for points, side in ((starts, 0), (ends, 1)):  # round where bands meet
        stage.mark(discs(stage.view, points, 0.5 * wide[:, side]), BAND)
    _draw_joints(stage, scenery)
    mark_ties(stage, sheet, scenery, shape, 1.0)
    radius = float(np.clip(0.05 * scenery.length * stage.scale, 2.2, 7.0)) / stage.scale
    if scenery.dimension == 3:
        radius *= 0.8
    stage.mark(discs(stage.view, centre[drawn & slides], 1.9 * radius), SLIDE, rank=6)
    for code, colour in COLOURS.items():
        own = centre[drawn & (status == code)]
        big = 1.5 if code == HINGE else 1.0
        stage.mark(discs(stage.view, own, 1.25 * big * radius), "#ffffff", rank=8)
        stage.mark(discs(stage.view, own, big * radius), colour, rank=10)
    sample = round_down(top)
    sheet.keys.append(Key(quantity(sample, scenery.force_unit), BAND, "band", widest * sample / top))
    for code in (MIDDLE_THIRD, CRACKED, HINGE, CLOSED, HELD):
        if (status == code).any():
            sheet.keys.append(Key(STATUS_WORDS[code], COLOURS[code]))
    if slides.any():
        sheet.keys.append(Key("slides (ring)", SLIDE))
    if scenery.dimension == 2 and (status == FREE).any():
        sheet.keys.append(Key("open", COLOURS[FREE], "line", 30))
    return sheet.save(path, stage)


def thrust_segments(
    scenery: Scenery, drawn: NDArray[np.bool_], centre: FloatArray, size: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where bands start and end (n, 3) [m], and the forces there (n, 2), over all blocks but supports."""
    told = scenery.joints
    sides = np.stack([told[name][drawn] for name in (fields.CANDIDATE, fields.ANTAGONIST)], axis=1)
    cell_block = np.asarray(scenery.blocks.cell_data[fields.BLOCK])
    fidelity = np.asarray(scenery.blocks.cell_data[fields.FIDELITY])
    held = np.unique(cell_block[fidelity == SUPPORT])
    joint = np.repeat(np.arange(len(sides)), 2)
    block = sides.ravel()
    free = ~np.isin(block, held)
    joint, block = joint[free], block[free]
    points, force = centre[drawn][joint], size[drawn][joint]
    count = int(block.max(initial=-1)) + 1
    many = np.bincount(block, minlength=count)
    total = np.bincount(block, force, count)
    hub = np.stack([np.bincount(block, force * x, count) for x in points.T], axis=1)
    hub = np.divide(hub, total[:, None], out=np.zeros_like(hub), where=total[:, None] > 0)
    hub = np.where((many == 1)[:, None], _middles(scenery, count), hub)
    star = many[block] != 2
    starts, ends = points[star], hub[block[star]]
    forces = np.repeat(force[star][:, None], 2, axis=1)
    twos = np.flatnonzero(~star)
    pairs = twos[np.argsort(block[twos], kind="stable")].reshape(-1, 2)
    return (
        np.concatenate([starts, points[pairs[:, 0]]]),
        np.concatenate([ends, points[pairs[:, 1]]]),
        np.concatenate([forces, force[pairs]]),
    )


def _middles(scenery: Scenery, count: int) -> FloatArray:
    """Means of the blocks' nodes where they are now, shape (count, 3) [m]."""
    blocks = scenery.blocks
    points = np.asarray(blocks.points, float) + np.asarray(blocks.point_data[fields.DISPLACEMENT], float)
    number = np.asarray(blocks.point_data[fields.BLOCK])
    length = max(count, int(number.max(initial=0)) + 1)
    many = np.maximum(np.bincount(number, minlength=length), 1)
    middles = np.stack([np.bincount(number, x, length) for x in points.T], axis=1) / many[:, None]
    result: FloatArray = middles[:count]
    return result


def _draw_joints(stage: Stage, scenery: Scenery) -> None:
    """Joints of a plane structure in the colours of their states; faces in 3D would hide each other."""
    if scenery.dimension == 3:
        return
    faces = scenery.interfaces.copy()
    status = np.asarray(faces.cell_data[fields.STATUS])
    faces.points = faces.points + faces.point_data[fields.DISPLACEMENT]
    for code, colour in COLOURS.items():
        chosen = np.flatnonzero(status == code)
        if len(chosen):
            stage.lines(faces.extract_cells(chosen), colour, 2.2, rank=3)


def _caption(status: IntArray, slides: NDArray[np.bool_], size: FloatArray, unit: str) -> str:
    told = (MIDDLE_THIRD, CRACKED, HINGE, CLOSED, HELD, FREE)
    counts = [
        f"{int((status == code).sum())} {STATUS_WORDS[code]}" for code in told if (status == code).any()
    ]
    if slides.any():
        counts.append(f"{int(slides.sum())} slide")
    greatest = quantity(float(size.max(initial=0.0)), unit)
    joints = "1 joint" if len(status) == 1 else f"{len(status)} joints"
    return f"{joints}: {', '.join(counts)}; greatest force {greatest}; displacements × 1"
