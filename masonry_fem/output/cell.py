"""Cell: the VTK cell that a rigid block is: a tetrahedron, pyramid or hexahedron.

Wedges are none: programs do not agree which way round these are.
"""

from __future__ import annotations

import functools

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
    others = {corner for one in faces for corner in one} - set(base)
    edges = [edge for one in faces for edge in zip(one, one[1:] + one[:1], strict=True)]
    above = {a: b for a, b in edges if a in base and b in others}
    top = [above.get(corner) for corner in base] if kind == HEXAHEDRON else [*others]
    if None in top or set(top) != others or len(top) != len(others):
        return None
    return kind, (*base, *(corner for corner in top if corner is not None))
