"""Opening: what a door or a window takes from the courses of a wall.

    door = Opening(position=(1.0, 0.0), size=(0.9, 2.0))     # has a lintel, unless it goes up to the top
    span = Span.of(door, length=0.5, height=0.25, courses=12)
    span.open_in(3), span.lintel_in(9)

Its sill and its head lie on bed joints; its jambs may be anywhere: rows of bricks are cut to them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from masonry_fem.records.opening import Opening
from masonry_fem.structures.parts.bond import Piece

ROUNDING = 1e-6  # of a brick: rounding of decimals in a scene file
SLIVER = 0.25  # of a brick: no stone is shorter


@dataclass(frozen=True, slots=True)
class Span:
    """What an opening takes from a wall of courses.

    Attributes
    ----------
    left, right : Of the opening, from the wall's left end [m].
    bottom, top : First course that it opens, and first above it (0 is the lowest course).
    bearing : Of the lintel on each jamb [m]. lintel : Its courses, 0 where there is none.
    """

    left: float
    right: float
    bottom: int
    top: int
    bearing: float
    lintel: int

    @classmethod
    def of(cls, opening: Opening, *, length: float, height: float, courses: int) -> Span:
        """The span in a wall of ``courses`` courses of bricks of this length and height."""
        bottom = round(opening.position[1] / height)
        top = round((opening.position[1] + opening.size[1]) / height)
        left = opening.position[0]
        has_lintel = opening.lintel and top < courses
        return cls(
            left=left,
            right=left + opening.size[0],
            bottom=bottom,
            top=top,
            bearing=(opening.bearing or length / 2) if has_lintel else 0.0,
            lintel=opening.lintel_courses if has_lintel else 0,
        )

    def open_in(self, course: int) -> bool:
        """Whether it opens a course (0 is the lowest)."""
        return self.bottom <= course < self.top

    def lintel_in(self, course: int) -> bool:
        """Whether its lintel lies in a course."""
        return self.top <= course < self.top + self.lintel

    def taken(self, course: int) -> tuple[float, float] | None:
        """The stretch of a course that has no bricks of the bond, from the wall's left end [m]."""
        if self.open_in(course):
            return self.left, self.right
        if self.lintel_in(course):
            return self.left - self.bearing, self.right + self.bearing
        return None


def solid_stretches(
    spans: tuple[Span, ...], course: int, extent: tuple[float, float], rounding: float
) -> list[tuple[float, float]]:
    """The stretches of a course that openings and lintels leave, from the left [m].

    Where openings overlap, a stretch has its end before its start.

    Parameters
    ----------
    spans : What openings take from the wall.
    course : Number of the course, 0 for the lowest.
    extent : Ends of the course [m].
    rounding : Stretches shorter than this are left out [m].
    """
    taken = sorted(stretch for span in spans if (stretch := span.taken(course)) is not None)
    ends = [extent[0], *(x for stretch in taken for x in stretch), extent[1]]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if abs(b - a) > rounding]


def fitted(pieces: tuple[Piece, ...], start: float, end: float, *, brick: float) -> list[Piece]:
    """The pieces of a row within a stretch of wall.

    A brick is cut where the stretch ends. A rest shorter than a quarter of a brick is joined with its
    neighbour, if the two are no longer than a brick; otherwise it is extended to a quarter at the
    neighbour's cost.

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
