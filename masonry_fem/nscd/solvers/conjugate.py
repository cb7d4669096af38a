"""Conjugate gradients with a first guess: for systems that change a little from one call to the next.

x, count = conjugate(product, precondition, rhs, x, accuracy=1e-2)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Map = Callable[[FloatArray], FloatArray]

ITERATIONS = 500
# Residual below which nothing is left to gain, relative to the right-hand side.
ROUNDED = 1e-15


def conjugate(
    product: Map, precondition: Map, rhs: FloatArray, guess: FloatArray, accuracy: float
) -> tuple[FloatArray, int]:
    """Solve A x = ``rhs`` to ``accuracy`` of the residual that ``guess`` has.

    Parameters
    ----------
    product, precondition : A x, and an approximation of A⁻¹ x; both symmetric, positive definite.
    rhs, guess : Shape (n,).
    accuracy : Residual to reach, relative to the guess's, in the norm of the preconditioner.

    Returns
    -------
    x (n,), and the products that it took.
    """
    x = guess.copy()
    residual = rhs - product(x)
    direction = precondition(residual)
    square = float(residual @ direction)
    enough = max(accuracy**2 * square, ROUNDED**2 * float(rhs @ precondition(rhs)))
    for made in range(1, ITERATIONS):
        if not square > enough:
            return x, made
        image = product(direction)
        length = square / float(direction @ image)
        x += length * direction
        residual -= length * image
        conditioned = precondition(residual)
        last, square = square, float(residual @ conditioned)
        direction = conditioned + square / last * direction
    return x, ITERATIONS
