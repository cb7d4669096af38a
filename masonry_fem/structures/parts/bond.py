"""Bond: how the bricks of a wall's courses lie, before openings are cut.

    for row in rows_of(spec, course=1):
        row.low, row.high, [(piece.start, piece.end, piece.kind) for piece in row.pieces]

Seen from above, a course has as many rows as there are stones across the wall's thickness. Lengths are
counted in quarters of a brick: a stretcher has 4 of them, the face of a header 2, a closer 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate, cycle, pairwise
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from masonry_fem.structures.wall import WallStructure


Bond = Literal["running", "stack", "header", "english", "flemish"]
Kind = Literal["stretcher", "header", "closer"]
STRETCHER, HEADER, CLOSER = 4, 2, 1  # quarters of a brick
KIND: dict[int, Kind] = {STRETCHER: "stretcher", 3: "stretcher", HEADER: "header", CLOSER: "closer"}


@dataclass(frozen=True, slots=True)
class Piece:
    """A stone of a row.

    Attributes
    ----------
    start, end : Its ends along the wall [m].
    kind : Stretcher, header or closer.
    """

    start: float
    end: float
    kind: Kind

    @property
    def length(self) -> float:
        """Along the wall [m]."""
        return self.end - self.start


@dataclass(frozen=True, slots=True)
class Row:
    """Stones side by side along the wall.

    Attributes
    ----------
    low, high : The row extends from wythe ``low`` up to, not including, wythe ``high``; 0 is at the front.
    pieces : Its stones, from the left.
    """

    low: int
    high: int
    pieces: tuple[Piece, ...]


def rows_of(spec: WallStructure, course: int) -> list[Row]:
    """Rows of a course, from the front.

    Parameters
    ----------
    spec : The wall.
    course : Number of the course, 1 for the lowest.
    """
    if spec.pattern:
        return [Row(0, spec.wythes, _listed(spec, course))]
    count = round(4 * (spec.columns or 0))
    even = course % 2 == 0
    if spec.bond == "flemish":
        lengths = _flemish(count, even)
        return [Row(0, spec.wythes, _pieces(spec, lengths, kinds=KIND))]
    headers = _pieces(spec, _headers(count, even, spec.bond), kinds=KIND | {3: "header"})
    lengths, start = _stretchers(spec, count, even)
    stretchers = _pieces(spec, lengths, start, kinds=dict.fromkeys(KIND, "stretcher"))
    across = _across(spec, course)
    return [Row(low, high, headers if pair else stretchers) for low, high, pair in across]


def period_of(spec: WallStructure) -> int:
    """Number of courses after which the bond repeats itself.

    Parameters
    ----------
    spec : The wall.
    """
    return len(spec.pattern) or 2 * (spec.header_courses or 1)


def _across(spec: WallStructure, course: int) -> list[tuple[int, int, bool]]:
    """Wythes that each row of a course takes, and whether it is of headers."""
    every, wythes = spec.header_courses, spec.wythes
    of_headers, whole = _of_headers(spec, course), spec.through or wythes <= 2
    if not of_headers and (whole or spec.bond != "english"):
        return [(low, low + 1, False) for low in range(wythes)]
    if whole:
        return [(0, wythes, True)]
    # headers tie wythes 1 and 2, 3 and 4 ...; in every other course of headers wythes 2 and 3, 4 and 5 ...
    first = course // every % 2 == 1 if every else course % 2 == 0
    ends = [0, *range(2 if first else 1, wythes, 2), wythes]
    return [(low, high, high == low + 2) for low, high in pairwise(ends)]


def _of_headers(spec: WallStructure, course: int) -> bool:
    """Whether headers tie the wythes of a course."""
    match spec.bond:
        case "header":
            return True
        case "english":
            return course % 2 == 0
        case _:
            return spec.header_courses is not None and course % spec.header_courses == 0


def _pieces(
    spec: WallStructure, lengths: list[int], start: int = 0, *, kinds: dict[int, Kind]
) -> tuple[Piece, ...]:
    """Pieces of these lengths [quarters] from ``start`` on."""
    quarter = spec.brick[0] / 4
    ends = list(accumulate(lengths, initial=start))
    return tuple(Piece(a * quarter, b * quarter, kinds[b - a]) for a, b in pairwise(ends))


def _stretchers(spec: WallStructure, count: int, even: bool) -> tuple[list[int], int]:
    """Whole bricks, halves closing the shifted courses; and where they begin."""
    shifted = spec.bond == "running" and even != (spec.half_bricks == "odd")
    first = STRETCHER // 2 if shifted else 0
    wholes, rest = divmod(count - first, STRETCHER)
    bricks = [STRETCHER] * wholes
    if spec.half_bricks == "none":
        return bricks, first
    return [first] * (first > 0) + bricks + [rest] * (rest > 0), 0


def _headers(count: int, even: bool, bond: Bond) -> list[int]:
    """Headers whose joints lie over the middle of stretchers, and of the headers of a header bond."""
    corner = [HEADER, CLOSER] if bond == "english" else [3]
    inner = count - 2 * sum(corner)
    if inner < 0 or (bond == "header" and not even):
        return [HEADER] * (count // HEADER)
    return corner + [HEADER] * (inner // HEADER) + corner[::-1]


def _flemish(count: int, even: bool) -> list[int]:
    """Stretcher and header by turns; the other courses begin with a header and a closer."""
    head = [HEADER, CLOSER] if even and count > HEADER + CLOSER else []
    tail = head[::-1] if (count - STRETCHER) % (STRETCHER + HEADER) == 0 else []
    lengths, left = head, count - sum(head) - sum(tail)
    turn = cycle((STRETCHER, HEADER))
    while left > 0:
        lengths = [*lengths, min(next(turn), left)]
        left -= lengths[-1]
    return lengths + tail


def _listed(spec: WallStructure, course: int) -> tuple[Piece, ...]:
    """Stretchers of the lengths that a pattern has, openings left out."""
    lengths = spec.pattern[(course - 1) % len(spec.pattern)]
    ends = [end * spec.brick[0] for end in accumulate(map(abs, lengths), initial=0.0)]
    return tuple(
        Piece(a, b, "stretcher") for (a, b), length in zip(pairwise(ends), lengths, strict=True) if length > 0
    )
