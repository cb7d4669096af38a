"""Products of small blocks, contact by contact.

NumPy hands each block to BLAS: that takes two to five times as long as a loop, and its last bits are those of
the kernel that BLAS chooses for a processor.

    force = applied(by_velocity, velocity)    # (c, d, d) and (c, d)
    slope = multiplied(inverse, by_velocity)     # (c, d, d) and (c, d, d)
    inverse = inverted(own)                      # (c, d, d)
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
    return multiplied(blocks, vectors[:, :, None])[:, :, 0]


def multiplied(first: FloatArray, second: FloatArray) -> FloatArray:
    """Each block times its other block, shape (n, r, t).

    Parameters
    ----------
    first : Shape (n, r, s). second : Shape (n, s, t).
    """
    from masonry_fem.nscd.transfer import block_products  # noqa: PLC0415 - Numba is slow to import

    product: FloatArray = block_products(np.ascontiguousarray(first), np.ascontiguousarray(second))
    return product


def inverted(blocks: FloatArray) -> FloatArray:
    """Inverse of each block, shape (n, d, d).

    Parameters
    ----------
    blocks : Shape (n, d, d).

    Raises
    ------
    LinAlgError : One is exactly singular.
    """
    from masonry_fem.nscd.transfer import block_inverses  # noqa: PLC0415 - Numba is slow to import

    inverse, all_have = block_inverses(np.ascontiguousarray(blocks))
    if not all_have:
        raise np.linalg.LinAlgError("a block of a contact is exactly singular")
    found: FloatArray = inverse
    return found
