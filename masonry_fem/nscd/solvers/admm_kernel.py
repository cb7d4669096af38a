"""The compiled loops of ADMM over the contacts: projection on the cones, and what the step leaves."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@njit(cache=True)
def reflect(
    state: FloatArray, weight: FloatArray, friction: FloatArray, slip: FloatArray, free: FloatArray,
    projected: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    """``projected`` = y = P_K(z) and ``force`` = D (2 y − z) − q − μ s n, both (c, d)."""
    d = state.shape[1]
    for i in range(len(state)):
        mu, normal = friction[i], state[i, 0]
        size = abs(state[i, 1]) if d == 2 else math.hypot(state[i, 1], state[i, 2])
        first, ratio = normal, 1.0
        if mu * size <= -normal:
            first, ratio = 0.0, 0.0
        elif size > mu * normal:
            first = (normal + mu * size) / (1.0 + mu * mu)
            ratio = mu * first / size
        projected[i, 0] = first
        for k in range(1, d):
            projected[i, k] = ratio * state[i, k]
        for k in range(d):
            force[i, k] = weight[i] * (2.0 * projected[i, k] - state[i, k]) - free[i, k]
        force[i, 0] -= mu * slip[i]


@njit(cache=True)
def advance(
    state: FloatArray, projected: FloatArray, impulse: FloatArray, weight: FloatArray, friction: FloatArray,
    slip: FloatArray, root: FloatArray, relaxation: float,
    image: FloatArray, sliding: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """``image`` = √w (z + a (x − y)) and ``sliding`` = ‖v_T‖ of the dual velocity D (y − z).

    Returns ‖x − y‖² and ‖μ (s − ‖v_T‖)‖², the first weighted with D, the second with its inverse.
    """
    d = state.shape[1]
    gap = late = 0.0
    for i in range(len(state)):
        square = own = 0.0
        for k in range(d):
            change = impulse[i, k] - projected[i, k]
            own += change * change
            image[i, k] = root[i] * (state[i, k] + relaxation * change)
            if k:
                square += (projected[i, k] - state[i, k]) ** 2
        sliding[i] = weight[i] * math.sqrt(square)
        gap += weight[i] * own
        late += (friction[i] * (slip[i] - sliding[i])) ** 2 / weight[i]
    return gap, late
