"""Cones: the algebra of c second-order cones L = {x : ‖x_T‖ ≤ x_N}, as interior-point methods need it.

Vectors have shape (c, d), component 0 first; the Jordan product is x ∘ y = (x · y, x_N y_T + y_N x_T).
Pure functions; the formulae are those of Vandenberghe, "The CVXOPT linear and quadratic cone program
solvers" (2010), sections 4 and 5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import lengths

FloatArray = NDArray[np.float64]


def determinant(x: FloatArray) -> FloatArray:
    """x_N² − ‖x_T‖², > 0 inside, shape (c,)."""
    size = lengths(x[:, 1:])
    result: FloatArray = (x[:, 0] - size) * (x[:, 0] + size)
    return result


def product(x: FloatArray, y: FloatArray) -> FloatArray:
    """Jordan product x ∘ y, shape (c, d).

    Parameters
    ----------
    x, y : Vectors, shape (c, d).
    """
    result = x[:, :1] * y + y[:, :1] * x
    result[:, 0] = (x * y).sum(axis=1)
    return result


def quotient(x: FloatArray, y: FloatArray) -> FloatArray:
    """The u with x ∘ u = y, shape (c, d).

    Parameters
    ----------
    x, y : Vectors, shape (c, d); x inside its cones.
    """
    result = np.empty_like(y)
    inner = (x[:, 1:] * y[:, 1:]).sum(axis=1)
    result[:, 0] = (x[:, 0] * y[:, 0] - inner) / determinant(x)
    result[:, 1:] = (y[:, 1:] - result[:, :1] * x[:, 1:]) / x[:, :1]
    return result


def inverse(x: FloatArray) -> FloatArray:
    """The x⁻¹ with x ∘ x⁻¹ = (1, 0), shape (c, d)."""
    mirrored = -x
    mirrored[:, 0] = x[:, 0]
    result: FloatArray = mirrored / determinant(x)[:, None]
    return result


def scaling(x: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nesterov–Todd scaling W with W z = W⁻¹ x, and its inverse, both (c, d, d) and symmetric.

    Parameters
    ----------
    x, z : Vectors inside their cones, shape (c, d).
    """
    size_x, size_z = np.sqrt(determinant(x)), np.sqrt(determinant(z))
    unit_x, unit_z = x / size_x[:, None], z / size_z[:, None]
    mirrored = -unit_z
    mirrored[:, 0] = unit_z[:, 0]
    middle = np.sqrt((1 + (unit_x * unit_z).sum(axis=1)) / 2)
    point = (unit_x + mirrored) / (2 * middle)[:, None]
    length = np.sqrt(size_x / size_z)
    d = x.shape[1]
    forth = np.empty((len(x), d, d))
    forth[:, 0, 0] = point[:, 0]
    forth[:, 0, 1:] = forth[:, 1:, 0] = point[:, 1:]
    forth[:, 1:, 1:] = point[:, 1:, None] * point[:, None, 1:] / (1 + point[:, 0])[:, None, None]
    forth[:, 1:, 1:] += np.eye(d - 1)
    back = forth.copy()
    back[:, 0, 1:] *= -1
    back[:, 1:, 0] *= -1
    return forth * length[:, None, None], back / length[:, None, None]


def longest_steps(x: FloatArray, change: FloatArray) -> FloatArray:
    """Largest a of each cone with x + a · change inside, shape (c,); inf where nothing limits it.

    Parameters
    ----------
    x : Vectors inside their cones, shape (c, d).
    change : Direction, shape (c, d).
    """
    # the smaller positive root of det(x + a dx) = 0, in the form that does not cancel
    square = determinant(change)
    half = x[:, 0] * change[:, 0] - (x[:, 1:] * change[:, 1:]).sum(axis=1)
    root = np.sqrt(np.maximum(half**2 - square * determinant(x), 0.0))
    limit = np.full(len(x), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        falling = (half < 0) & (half**2 >= square * determinant(x))
        limit[falling] = (determinant(x) / (root - half))[falling]
        turning = (half >= 0) & (square < 0)
        limit[turning] = (-(half + root) / square)[turning]
        shrinking = change[:, 0] < 0
        limit[shrinking] = np.minimum(limit, -x[:, 0] / change[:, 0])[shrinking]
    return limit


def longest_step(x: FloatArray, change: FloatArray) -> float:
    """Largest a with x + a · change in all cones; inf where none limits it.

    Parameters
    ----------
    x : Vectors inside their cones, shape (c, d).
    change : Direction, shape (c, d).
    """
    return float(longest_steps(x, change).min(initial=np.inf))
