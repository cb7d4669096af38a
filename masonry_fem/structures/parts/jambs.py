"""Jambs: a row of bricks cut to the stretches of wall that openings and lintels leave.

    fitted(pieces, 1.0, 2.5, brick=0.4)

A brick is cut where a stretch ends. A rest shorter than a quarter of a brick is joined with its neighbour, if
the two are no longer than a brick; otherwise the rest is extended to a quarter at the neighbour's cost.
"""

from __future__ import annotations

from dataclasses import replace

from masonry_fem.structures.parts.bond import Piece
from masonry_fem.structures.parts.opening import ROUNDING

SLIVER = 0.25  # of a brick: no stone is shorter


def fitted(pieces: tuple[Piece, ...], start: float, end: float, *, brick: float) -> list[Piece]:
    """The pieces of a row within a stretch of wall.

    Parameters
    ----------
    pieces : The whole row.
    start, end : Ends of the stretch along the wall [m].
    brick : Length of a whole brick [m].
    """
    rounding = ROUNDING * brick
    inside = []
    for piece in pieces:
        a = piece.start if piece.start > start - rounding else start
        b = piece.end if piece.end < end + rounding else end
        if b - a > rounding:
            inside.append(replace(piece, start=a, end=b))
    if len(inside) > 1 and inside[0].length < SLIVER * brick - rounding:
        inside[:2] = _mended(inside[0], inside[1], brick)
    if len(inside) > 1 and inside[-1].length < SLIVER * brick - rounding:
        inside[-2:] = _mended(inside[-2], inside[-1], brick)
    return inside


def _mended(one: Piece, two: Piece, brick: float) -> list[Piece]:
    """Two pieces, one of them a sliver, as one or with the joint moved."""
    longer, shorter = (one, two) if one.length > two.length else (two, one)
    if one.length + two.length <= brick * (1 + ROUNDING):
        return [replace(longer, start=one.start, end=two.end)]
    moved = SLIVER * brick if shorter is one else -SLIVER * brick
    return [replace(one, end=one.end + moved), replace(two, start=two.start + moved)]
