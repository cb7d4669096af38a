"""Snapping: measured outlines of stones, moved by no more than a tolerance so that neighbours touch.

    outlines, report = snapped(outlines, names, tolerance=0.01)

Corners on a straight side are left out; sides of neighbours that nearly touch are gathered on common lines,
and corners go to where the lines of their two sides cross. What still overlaps is cut off along the
neighbour's side; gaps wider than the tolerance stay.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.importing.common_lines import CommonLines
from masonry_fem.importing.sides import Sides
from masonry_fem.importing.triangles import turn
from masonry_fem.importing.trimming import trimmed
from masonry_fem.records.remark import first_few, remark
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

FARTHEST = 3.0  # tolerances: a corner stays on one of its lines if the lines cross farther away
ABREAST = 0.2  # sine of the angle between lines below which their crossing is too uncertain
SEARCH = 5.0  # tolerances: gaps up to this size are reported
SHARE = 0.05  # of the shorter side: two sides face each other if their common length is larger
CLOSED = 1e-6  # tolerances: smaller gaps and moves are rounding errors
SHOWN = 4  # gaps and stones that a message names

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SnapReport:
    """What snapping did.

    Attributes
    ----------
    corners, straight : Corners that were measured, and those left out on straight sides.
    largest, rms : Move of the others in the wall's plane [m].
    merged : Corners that now coincide with one of another stone.
    lines : Lines that sides of two or more stones lie on.
    loose : Corners that lie on the line of one of their sides only.
    cut : Pairs of stones that overlapped, names and depth [m]. gaps : Pairs that stand apart, names and
        mean width [m], the widest first.
    dropped : Stones of which nothing is left.
    """

    corners: int
    straight: int
    largest: float
    rms: float
    merged: int
    lines: int
    loose: int
    cut: tuple[tuple[str, str, float], ...]
    gaps: tuple[tuple[str, str, float], ...]
    dropped: tuple[str, ...]

    def tell(self, title: str, structure: str) -> None:
        """Remark what was moved, cut or dropped, and what stays open; log how far corners are from lines.

        Parameters
        ----------
        title : Name of the file in messages.
        structure : Name of the structure that the stones belong to.
        """
        moved = (
            f"{title}: {self.corners} corners moved by at most {1e3 * self.largest:.2g} mm (rms "
            f"{1e3 * self.rms:.2g} mm) to {self.lines} common lines; {self.merged} of them merged, "
            f"{self.straight} left out on straight sides, {self.loose} on one line only"
        )
        if self.straight or self.cut or self.dropped or self.largest > 0:
            remark("moved_corners", moved)
        else:
            logger.info("%s", moved)
        for code, pairs, what in (
            ("open_joints", self.gaps, "joints stay open"),
            ("cut_overlaps", self.cut, "overlaps were cut off"),
        ):
            if pairs:
                named = dict.fromkeys(f"{structure}.{stone}" for pair in pairs for stone in pair[:2])
                remark(code, f"{title}: {len(pairs)} {what}: {_listed(pairs)}", *named)
        if self.dropped:
            remark(
                "dropped_stones",
                f"{title}: {len(self.dropped)} stones are dropped, nothing of them is left within the "
                f"tolerance: {first_few(self.dropped, SHOWN)}; correct their corners or take a smaller "
                "tolerance",
            )


def _listed(pairs: Sequence[tuple[str, str, float]]) -> str:
    return first_few((f"'{one}' and '{two}' by {1e3 * wide:.2g} mm" for one, two, wide in pairs), SHOWN)


def snapped(
    outlines: Sequence[FloatArray], names: Sequence[str], tolerance: float, title: str
) -> tuple[list[FloatArray | None], SnapReport]:
    """Outlines that touch; None for stones that are dropped.

    Parameters
    ----------
    outlines : Counter-clockwise corners in the wall's plane, shape (k, 2) each [m]. names : Of the stones.
    tolerance : What joints may be open by, or overlap, to be closed [m].

    Raises
    ------
    GeometryError : Two stones overlap by more than two tolerances.
    """
    plain = [straightened(outline, tolerance) for outline in outlines]
    sides = Sides.of(plain)
    lines = CommonLines.of(sides, sides.facing(2 * tolerance), tolerance)
    corners, loose = _crossings(sides, lines, tolerance)
    made: list[FloatArray | None] = [
        _sound(corners[a:b], tolerance) for a, b in zip(sides.first[:-1], sides.first[1:], strict=True)
    ]
    kept = np.array([one is not None for one in made])[sides.stone]
    moves = np.linalg.norm(corners - sides.start, axis=1)[kept]
    moves[moves < CLOSED * tolerance] = 0.0
    made, cut = trimmed(made, names, tolerance, title)
    report = SnapReport(
        corners=sum(map(len, outlines)),
        straight=sum(map(len, outlines)) - sum(map(len, plain)),
        largest=float(moves.max(initial=0.0)),
        rms=float(np.sqrt(np.mean(moves**2))) if len(moves) else 0.0,
        merged=_merged(made, tolerance),
        lines=int((lines.members > 1).sum()),
        loose=loose,
        cut=cut,
        gaps=gaps_between(made, names, tolerance),
        dropped=tuple(name for name, one in zip(names, made, strict=True) if one is None),
    )
    return made, report


def straightened(outline: FloatArray, tolerance: float) -> FloatArray:
    """The outline without corners that lie within the tolerance of a line between their neighbours."""
    while len(outline) > 3:
        before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
        chord = after - before
        length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
        arm = outline - before
        away = np.abs(chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / length
        if away.min() > tolerance:
            break
        outline = np.delete(outline, int(away.argmin()), axis=0)
    return outline


def _crossings(sides: Sides, lines: CommonLines, tolerance: float) -> tuple[FloatArray, int]:
    """Where each corner goes: the crossing of the lines of its two sides, and how many have none near."""
    before = np.arange(len(sides.start)) - 1
    before[sides.first[:-1]] = sides.first[1:] - 1
    one, two = lines.line[before], lines.line
    a, b = lines.along[one], lines.along[two]
    sine = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    apart = lines.point[two] - lines.point[one]
    safe = np.where(np.abs(sine) > ABREAST, sine, 1.0)
    crossing = lines.point[one] + ((apart[:, 0] * b[:, 1] - apart[:, 1] * b[:, 0]) / safe)[:, None] * a
    move = np.linalg.norm(crossing - sides.start, axis=1)
    bad = (np.abs(sine) <= ABREAST) | (move > FARTHEST * tolerance)
    alone = (lines.members[one] == 1) & (lines.members[two] == 1)
    crossing[bad] = _on_one(sides, lines, one, two)[bad]
    crossing[alone] = sides.start[alone]
    return crossing, int((bad & ~alone).sum())


def _on_one(sides: Sides, lines: CommonLines, one: IntArray, two: IntArray) -> FloatArray:
    """The nearest point to each corner on the line with more members."""
    stronger = np.where(lines.members[one] >= lines.members[two], one, two)
    return lines.to_line(sides.start, stronger)


def _sound(outline: FloatArray, tolerance: float) -> FloatArray | None:
    """The outline where it still bounds a stone as wide as the tolerance, counter-clockwise, uncrossed."""
    x, y = (outline - outline[0]).T
    area = 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    size = float(np.ptp(outline, axis=0).max())
    return outline if area > tolerance * size and not crosses_itself(outline) else None


def crosses_itself(outline: FloatArray) -> bool:
    """Whether two sides that are no neighbours cross."""
    n = len(outline)
    ends = np.roll(outline, -1, axis=0)

    for i in range(n):
        for j in range(i + 2, n - (i == 0)):
            a, b, c, d = outline[i], ends[i], outline[j], ends[j]
            if turn(a, b, c) * turn(a, b, d) < 0 and turn(c, d, a) * turn(c, d, b) < 0:
                return True
    return False


def _merged(made: Sequence[FloatArray | None], tolerance: float) -> int:
    """Corners that coincide with one of another stone."""
    corners = np.concatenate([one for one in made if one is not None] or [np.zeros((0, 2))])
    _, count = np.unique(np.round(corners / (CLOSED * tolerance)), axis=0, return_counts=True)
    return int((count - 1).sum())


def gaps_between(
    made: Sequence[FloatArray | None], names: Sequence[str], tolerance: float
) -> tuple[tuple[str, str, float], ...]:
    """Pairs of stones whose sides face each other a little apart, and how far in the mean [m]."""
    rows = [row for row, one in enumerate(made) if one is not None]
    if len(rows) < 2:
        return ()
    sides = Sides.of([one for one in made if one is not None])
    facing = sides.facing(SEARCH * tolerance)
    width = facing.gaps.mean(axis=1)
    wide = np.flatnonzero((width > CLOSED * tolerance) & (facing.share > SHARE))
    found = [
        (names[rows[sides.stone[one]]], names[rows[sides.stone[two]]], float(width[pair]))
        for pair, (one, two) in zip(wide.tolist(), facing.pairs[wide].tolist(), strict=True)
    ]
    return tuple(sorted(found, key=lambda gap: -gap[2]))
