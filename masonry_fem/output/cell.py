"""Cell: the VTK cell that a rigid block is: a tetrahedron, pyramid or hexahedron.

Wedges are none: programs do not agree which way round these are.
"""

from __future__ import annotations

import functools
import itertools

TETRA, HEXAHEDRON, PYRAMID = 10, 12, 14
KINDS = {(3, 3, 3, 3): TETRA, (3, 3, 3, 3, 4): PYRAMID, (4,) * 6: HEXAHEDRON}


@functools.lru_cache(maxsize=4096)
def standard_cell(faces: tuple[tuple[int, ...], ...]) -> tuple[int, tuple[int, ...]] | None:
    """VTK type and corners in VTK's order; None where the face loops are those of no such cell.

    ``faces`` run counter-clockwise seen from outside.
    """
    kind = KINDS.get(tuple(sorted(map(len, faces))))
    if kind is None:
        return None
    base = max(faces, key=len)[::-1]  # seen from outside VTK's run clockwise
    others = {*itertools.chain.from_iterable(faces)} - {*base}
    top = _above(base, faces) if kind == HEXAHEDRON else [*others]
    if {*top} != others or len(top) != len(others):
        return None
    return kind, (*base, *top)


def _above(base: tuple[int, ...], faces: tuple[tuple[int, ...], ...]) -> list[int]:
    """Where the edges lead that rise from the corners of the base; −1 from where none does."""
    edges = [edge for one in faces for edge in zip(one, one[1:] + one[:1], strict=True)]
    above = {a: b for a, b in edges if a in base and b not in base}
    return [above.get(corner, -1) for corner in base]
