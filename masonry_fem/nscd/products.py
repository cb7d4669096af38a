"""Products of small blocks, contact by contact.

    force = applied(by_velocity, velocity)    # (c, d, d) and (c, d)
    slope = chained(inverse, by_velocity)     # (c, d, d) and (c, d, d)

Blocks and vectors are stacked along the first axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def applied(blocks: FloatArray, vectors: FloatArray) -> FloatArray:
    """Each block times its vector, shape (n, r).

    Parameters
    ----------
    blocks : Shape (n, r, s). vectors : Shape (n, s).
    """
    product: FloatArray = (blocks @ vectors[:, :, None])[:, :, 0]
    return product


def chained(first: FloatArray, second: FloatArray) -> FloatArray:
    """Each block times its other block, shape (n, r, t).

    Parameters
    ----------
    first : Shape (n, r, s). second : Shape (n, s, t).
    """
    product: FloatArray = first @ second
    return product
