"""Places: whether coordinates in double precision resolve the blocks, and whether sizes are plausible."""

from __future__ import annotations

import numpy as np

from masonry_fem.build.stones import Stones
from masonry_fem.contact.posed import corners
from masonry_fem.errors import SceneError
from masonry_fem.records.remark import remark

LOST = 1e-4  # of a block's thickness: spacing of coordinates above which they distort the block
COARSE = 1e-8  # of it: spacing above which gaps and lever arms lose digits

SIZES = (1e-4, 100.0)  # plausible sizes of stones [m]; coordinates in mm read as m lie outside


def check_places(stones: Stones) -> None:
    """Check the blocks' distances from the origin and their sizes.

    Blocks so far from the origin that rounding of coordinates distorts them are refused; if only gaps and
    lever arms lose digits, there is a warning, as there is for sizes that no stones have.

    Raises
    ------
    SceneError : Coordinates cannot resolve a block.
    """
    assembly = stones.assembly
    thin = np.array([float(np.ptp(shape.solid.vertices, axis=0).min()) for shape in assembly.shapes])
    thin = thin[assembly.blocks.shape]
    far = np.abs(corners(assembly)[0]).max(axis=(1, 2))
    share = np.divide(np.spacing(far), thin, out=np.full(len(far), np.inf), where=thin > 0)
    worst = int(share.argmax())
    name, away = assembly.blocks.names[worst], far[worst]
    cure = "move the structure nearer to the origin: take the same offset off all positions"
    if not share[worst] <= LOST:
        raise SceneError(
            f"structures: block '{name}' is {thin[worst]:.2g} m thin and stands {away:.2g} m from the "
            f"origin, where coordinates are {np.spacing(away):.1g} m apart; expected less than {LOST:g} of "
            f"that; {cure}, or make the block thicker"
        )
    if share[worst] > COARSE:
        remark(
            "far_away",
            f"block '{name}' stands {away:.2g} m from the origin, where coordinates are "
            f"{np.spacing(away):.1g} m apart: gaps and arms lose digits; {cure}",
            name,
        )
    long = np.array([float(np.ptp(shape.solid.vertices, axis=0).max()) for shape in assembly.shapes])
    free = long[assembly.blocks.shape[~assembly.blocks.support]]
    typical = float(np.median(free)) if len(free) else 1.0
    if not SIZES[0] <= typical <= SIZES[1]:
        remark(
            "size",
            f"blocks are some {typical:.2g} m long, expected {SIZES[0]:g} to {SIZES[1]:g} m: are "
            "lengths in mm taken for m? see units",
        )
