"""Marking: which blocks get finer elements, and how a scene says so.

chosen = marked(errors.square, cells, allowed)         # mask of blocks
settings = halved(MeshSettings(divisions=(2, 2, 2)), mesh, volume)
overrides = mesh_overrides({"wall.c1.b2": settings}, groups)
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from glob import escape

import msgspec
import numpy as np
from numpy.typing import NDArray

from masonry_fem.scene import specs
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

# of the squared error, where elements are half as large: order 1, as at joints and corners for any
LEFT = 0.25
LEAST, MOST = 0.15, 0.7  # of the squared error are marked in a round
ALIKE = 0.02  # blocks whose errors, squared, differ by less are treated alike, or symmetry would go


def marked(square: FloatArray, cells: FloatArray, allowed: float) -> Mask:
    """Which blocks get elements half as large, shape (k,).

    The marked blocks together have a given share of the squared error, beginning with those whose elements
    have the greatest errors. The share is as large as is needed to bring the sum down to ``allowed``,
    within limits.

    Parameters
    ----------
    square : Squared error of each block, shape (k,).
    cells : Number of elements of each block, shape (k,).
    allowed : Sum of squared errors that the target allows.

    References
    ----------
    Dörfler, A convergent adaptive algorithm for Poisson's equation, SIAM J. Numer. Anal. 33 (1996).
    """
    total, each = max(float(square.sum()), 1e-300), square / cells
    part = min(max((1.0 - allowed / total) / (1.0 - LEFT), LEAST), MOST)
    order = np.argsort(-each, kind="stable")
    share = np.cumsum(square[order])
    last = min(int(np.searchsorted(share, part * share[-1] * (1 - 1e-12))), len(square) - 1)
    chosen: Mask = (each >= (1.0 - ALIKE) * each[order[last]]) & (square > 0)
    return chosen


def halved(settings: specs.MeshSettings, mesh: Mesh, volume: float) -> specs.MeshSettings:
    """Settings of elements half as large as those of a mesh.

    Where the settings allow, nodes of the coarse mesh remain nodes: blocks that are refined more often than
    their neighbours then have nodes in common with these, which makes contact easier to solve.

    Parameters
    ----------
    settings : Of the mesh.
    mesh : The elements.
    volume : Of the shape that they fill [m³; m² in 2D].
    """
    d = mesh.dimension
    if settings.size is None and settings.divisions is None:
        simplices = 1 if settings.elements[0] == "Q" else math.factorial(d)
        if len(mesh.cells) == 2**d * simplices:  # the two divisions that a box has by itself
            return msgspec.structs.replace(settings, divisions=(4,) * d)
        return msgspec.structs.replace(
            settings, size=float(f"{0.5 * (volume / len(mesh.cells)) ** (1 / d):.4g}")
        )
    if settings.divisions is not None:
        return msgspec.structs.replace(settings, divisions=tuple(2 * count for count in settings.divisions))
    assert settings.size is not None
    return msgspec.structs.replace(settings, size=0.5 * settings.size)


def mesh_overrides(
    settings: Mapping[str, specs.MeshSettings], groups: Mapping[str, tuple[str, ...]]
) -> tuple[specs.Override, ...]:
    """Overrides that give blocks their elements; if all blocks of a group have the same, it is named instead.

    Parameters
    ----------
    settings : Mesh settings by block.
    groups : Groups of every block that has elements.
    """
    members: dict[str, set[str]] = {}
    for name, own in groups.items():
        for group in own:
            members.setdefault(group, set()).add(name)
    ranked = sorted(members, key=lambda group: (-len(members[group]), group))
    overrides = []
    for wanted in dict.fromkeys(settings.values()):
        left = {name for name, own in settings.items() if own == wanted}
        for group in ranked:
            if len(members[group]) > 1 and members[group] <= left:
                overrides.append(specs.Override(blocks=escape(group), mesh=wanted))
                left -= members[group]
        overrides += [specs.Override(blocks=escape(name), mesh=wanted) for name in sorted(left)]
    return tuple(overrides)
