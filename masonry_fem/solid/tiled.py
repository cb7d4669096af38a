"""Tiled: what shapes have, once for each block of them, block after block.

rows, block = tiled([shape.solid.vertices for shape in assembly.shapes], assembly.blocks.shape)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_fem.solid.mesh import IntArray


def tiled[A: np.ndarray](parts: Sequence[A], of: IntArray) -> tuple[A, IntArray]:
    """``parts[of[0]]``, ``parts[of[1]]`` … one after another, and the place in ``of`` of each row.

    Parameters
    ----------
    parts : Arrays of as many rows as they like, shape (r, ...), at least one.
    of : Which of them, shape (b,).

    Returns
    -------
    Shapes (k, ...) and (k,).
    """
    length = np.array([len(part) for part in parts], dtype=np.int64)
    first, count = np.cumsum(length) - length, length[of]
    owner = np.repeat(np.arange(len(of)), count)
    within = np.arange(len(owner)) - (np.cumsum(count) - count)[owner]
    rows: A = np.concatenate(parts)[first[of][owner] + within]
    return rows, owner
