"""Mechanism picture: each part that moves as one in a colour, hinges as circles, sliding as double arrows.

    draw_mechanism(Scenery.of(model, state), mechanism, Path("mechanism.png"))

The structure is drawn as it begins to move: displaced along its velocities by a few per cent of its size.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.rotation import lever
from masonry_fem.march.mechanism import Joint, Mechanism
from masonry_fem.output import fields
from masonry_fem.output.arrows import add_arrows, legend_sample
from masonry_fem.output.backdrop import GHOST, title_of
from masonry_fem.output.grid import three
from masonry_fem.output.marks import discs
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import INK, LINE, Key, Sheet

FloatArray = NDArray[np.float64]

# muted, told apart by readers who confuse red and green; parts beyond them share the colours again
PART_COLOURS = ("#9dbbd9", "#e7c08a", "#b7c4a0", "#c3b1cf", "#d9a99a", "#9fc3bd", "#d9cf8f", "#aab2c9")
FIXED, HINGE, SLIDING, OPENING, ARROW = "#cfd2d6", "#c8352b", "#7a4fa3", "#1b7f5c", INK
CARRIED = 0.06  # of the structure's size: displacement of its fastest corner in the picture
MANY = 60  # moving blocks: with more, there is one arrow per part instead of one per block


def draw_mechanism(scenery: Scenery, mechanism: Mechanism, path: Path) -> Path:
    """Draw a mechanism on the displaced structure.

    Parameters
    ----------
    scenery : What to draw.
    mechanism : Its parts, hinges and sliding joints.
    path : The picture.
    """
    shape = DeformedShape(scenery, 1.0)
    here, edges = shape.deformed(), shape.deformed_outline()
    size = float(np.linalg.norm(np.ptp(here.points, axis=0)))
    carried = _Carried(mechanism, CARRIED * size)
    ghost = edges.copy()
    for mesh in (here, edges):
        mesh.points = carried.points(mesh.points, np.asarray(mesh.point_data[fields.BLOCK]))
    centre, velocity = _arrows(mechanism, carried)
    longest = 0.1 * size
    top = float(np.linalg.norm(velocity, axis=1).max(initial=0.0)) or 1.0
    vectors = velocity * (longest / top)
    seen = np.concatenate([here.points, ghost.points, centre + vectors])
    sheet = Sheet(title_of(scenery.title, "mechanism"), _caption(mechanism, CARRIED * size))
    stage = Stage(View.of(seen, scenery.dimension), sheet.image_width, scenery.length)
    _draw_parts(stage, here, mechanism)
    stage.lines(edges, LINE, 1.6)
    stage.lines(ghost, GHOST, 1.0, rank=2, opacity=0.7)
    add_arrows(stage, centre, vectors, ARROW, fine=len(centre) < 500)
    radius = float(np.clip(0.09 * scenery.length * stage.scale, 6.0, 13.0)) / stage.scale
    _draw_joints(stage, mechanism, carried, radius)
    sample, pixels = legend_sample(top, longest * stage.scale)
    sheet.keys.append(Key(f"{sample:g} of the fastest corner", ARROW, "arrow", pixels))
    sheet.keys += _keys(mechanism)
    return sheet.save(path, stage)


class _Carried:
    """Points of blocks carried on along the velocities."""

    def __init__(self, mechanism: Mechanism, far: float) -> None:
        self._row = {int(block): row for row, block in enumerate(mechanism.blocks)}
        self._mechanism, self._far = mechanism, far

    def points(self, points: FloatArray, blocks: NDArray[np.int64]) -> FloatArray:
        """Where points (n, 3) of ``blocks`` (n,) go."""
        motion, d = self._mechanism, self._mechanism.centre.shape[1]
        row = np.array([self._row.get(int(block), -1) for block in range(int(blocks.max(initial=0)) + 1)])
        own = row[blocks]
        moved = np.array(points, float)
        free = np.flatnonzero(own >= 0)
        which = own[free]
        arms = lever(moved[free, :d] - motion.centre[which])
        turned = np.einsum("kij,kj->ki", arms, motion.spin[which])
        moved[free, :d] += self._far * (motion.velocity[which] + turned)
        return moved

    def joint(self, joint: Joint, blocks: tuple[int, int]) -> FloatArray:
        """Where the middle of a joint goes, between its two blocks, shape (3,)."""
        at = np.repeat(three(joint.at[None]), 2, axis=0)
        middle: FloatArray = self.points(at, np.array(blocks)).mean(axis=0)
        return middle


def _arrows(mechanism: Mechanism, carried: _Carried) -> tuple[FloatArray, FloatArray]:
    """Where arrows start and the velocities there, one a block, or one a part where there are many."""
    moving = {number for part in mechanism.parts for number in part.numbers}
    if len(moving) > MANY:
        at = np.stack([part.at for part in mechanism.bodies])
        blocks = np.array([part.numbers[0] for part in mechanism.bodies])
        velocity = np.stack([part.velocity for part in mechanism.bodies])
    else:
        rows = np.array([r for r, b in enumerate(mechanism.blocks.tolist()) if b in moving], dtype=int)
        at, blocks, velocity = mechanism.centre[rows], mechanism.blocks[rows], mechanism.velocity[rows]
    return carried.points(three(at), blocks), three(velocity)


def _draw_parts(stage: Stage, surface: Any, mechanism: Mechanism) -> None:
    block = np.asarray(surface.cell_data[fields.BLOCK])
    left = np.ones(len(block), dtype=bool)
    for rank, part in enumerate(mechanism.bodies):
        own = np.isin(block, part.numbers)
        left &= ~own
        if own.any():
            colour = PART_COLOURS[rank % len(PART_COLOURS)]
            stage.surface(surface.extract_cells(np.flatnonzero(own)), color=colour)
    if left.any():
        stage.surface(surface.extract_cells(np.flatnonzero(left)), color=FIXED)


def _draw_joints(stage: Stage, mechanism: Mechanism, carried: _Carried, radius: float) -> None:
    """Circles, double arrows and dots, over everything else."""
    places = {
        how: [carried.joint(joint, joint.numbers) for joint in mechanism.of(how)]
        for how in ("hinge", "slides", "opens")
    }
    if places["opens"]:
        stage.mark(discs(stage.view, np.stack(places["opens"]), 0.6 * radius), OPENING, rank=8)
    if places["slides"]:
        points = np.stack(places["slides"])
        along = three(np.stack([joint.slip for joint in mechanism.of("slides")]))
        along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
        across = np.cross(stage.view.axes[2], along)
        reach = 5.0 * radius
        for side in (1.0, -1.0):
            start = points + side * (0.6 * radius * across - 0.5 * reach * along)
            add_arrows(stage, start, side * reach * along, SLIDING, fine=len(points) < 500)
    if places["hinge"]:
        points = np.stack(places["hinge"])
        stage.mark(discs(stage.view, points, radius), HINGE, rank=10)
        stage.mark(discs(stage.view, points, 0.62 * radius), "#ffffff", rank=12)


def _caption(mechanism: Mechanism, far: float) -> str:
    """What moves and how far it is carried on."""
    counts = [
        f"{len(found)} {name}{'' if len(found) == 1 else 's'}"
        for how, name in (("hinge", "hinge"), ("slides", "sliding joint"), ("opens", "opening joint"))
        if (found := mechanism.of(how))
    ]
    parts = "1 part" if len(mechanism.parts) == 1 else f"{len(mechanism.parts)} parts"
    blocks = "1 block moves" if mechanism.moving == 1 else f"{mechanism.moving} blocks move"
    return f"{blocks} in {parts}; {', '.join(counts) or 'no joint'}; fastest corner carried on by {far:.3g} m"


def _keys(mechanism: Mechanism) -> list[Key]:
    told = [
        Key("hinge", HINGE) if mechanism.of("hinge") else None,
        Key("slides", SLIDING, "arrow", 34) if mechanism.of("slides") else None,
        Key("opens", OPENING) if mechanism.of("opens") else None,
    ]
    keys = [key for key in told if key is not None] + [Key("fixed", FIXED)]
    for part, colour in zip(mechanism.bodies, PART_COLOURS, strict=False):
        one = part.blocks[0] if len(part.blocks) == 1 else f"{part.blocks[0]} … {part.blocks[-1]}"
        keys.append(Key(one, colour))
    return keys
