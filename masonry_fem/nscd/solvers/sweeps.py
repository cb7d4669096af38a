"""Sweeps: the compiled inner loops of nonlinear Gauss–Seidel.

Four loops, for blocks of W or velocities of bodies, in 2D and 3D. Each makes ``count`` sweeps over
the contacts in the given ``order``, measures the natural map every ``interval`` sweeps with the velocities
of that moment, and returns early at ``tolerance``. All arrays are flat in their last axes; ``law`` is the
stiffness of cohesion (``local``). Where it is None Numba leaves out, before it compiles, all that it is for.

The measure is ``Quality.error`` without the bodies' balance, which sweeps keep by themselves.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from masonry_fem.nscd.local import Law, answer_2d, answer_3d, pressed_2d, pressed_3d, solve_2d, solve_3d

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@njit(cache=True, inline="always")
def _map_2d(mu: float, w: float, pn: float, pt: float, vn: float, vt: float) -> float:
    """‖p − P_K(p − v̂/w)‖² of one contact."""
    xn = pn - (vn + mu * abs(vt)) / w
    xt = pt - vt / w
    size = abs(xt)
    if size > mu * xn:
        if mu * size <= -xn:
            xn, xt = 0.0, 0.0
        else:
            xn = (xn + mu * size) / (1.0 + mu * mu)
            xt = mu * xn * (1.0 if xt > 0.0 else -1.0)
    return (pn - xn) ** 2 + (pt - xt) ** 2


@njit(cache=True, inline="always")
def _map_3d(mu: float, w: float, pn: float, p1: float, p2: float, vn: float, v1: float, v2: float) -> float:
    """‖p − P_K(p − v̂/w)‖² of one contact."""
    xn = pn - (vn + mu * math.sqrt(v1 * v1 + v2 * v2)) / w
    x1 = p1 - v1 / w
    x2 = p2 - v2 / w
    size = math.sqrt(x1 * x1 + x2 * x2)
    if size > mu * xn:
        if mu * size <= -xn:
            xn, x1, x2 = 0.0, 0.0, 0.0
        else:
            xn = (xn + mu * size) / (1.0 + mu * mu)
            x1 *= mu * xn / size
            x2 *= mu * xn / size
    return (pn - xn) ** 2 + (p1 - x1) ** 2 + (p2 - x2) ** 2


@njit(cache=True, inline="always")
def _error(square: float, size: float, worst: float, caused: float, fastest: float) -> float:
    """Both natural maps' larger one, from sums of squares and squared maxima."""
    if size == 0.0:
        return 0.0 if worst == 0.0 else math.sqrt(worst / fastest)
    if worst == 0.0:
        return 0.0
    return max(math.sqrt(square / size), math.sqrt(worst / caused) if caused > 0.0 else math.inf)


@njit(cache=True)
def plain_2d(
    order: IntArray, pointer: IntArray, other: IntArray, blocks: FloatArray, own: FloatArray,
    local: FloatArray, scale: FloatArray, friction: FloatArray, free: FloatArray, impulse: FloatArray,
    count: int, interval: int, tolerance: float, law: Law,
) -> tuple[int, float]:  # fmt: skip
    """Sweeps with W's off-diagonal ``blocks`` (k, 4) by rows and its diagonal ones ``own`` (c, 4)."""
    error = math.inf
    for sweep in range(count):
        for i in order:
            bn, bt = free[i, 0], free[i, 1]
            for k in range(pointer[i], pointer[i + 1]):
                j = other[k]
                bn += blocks[k, 0] * impulse[j, 0] + blocks[k, 1] * impulse[j, 1]
                bt += blocks[k, 2] * impulse[j, 0] + blocks[k, 3] * impulse[j, 1]
            if law is None:
                impulse[i, 0], impulse[i, 1] = solve_2d(local[i], friction[i], bn, bt)
            else:
                impulse[i, 0], impulse[i, 1] = answer_2d(local[i], friction[i], bn, bt, law, i)
        if (sweep + 1) % interval and sweep + 1 < count:
            continue
        square = size = worst = caused = fastest = 0.0
        for i in range(len(friction)):
            pn, pt = impulse[i, 0], impulse[i, 1]
            un = own[i, 0] * pn + own[i, 1] * pt
            ut = own[i, 2] * pn + own[i, 3] * pt
            for k in range(pointer[i], pointer[i + 1]):
                j = other[k]
                un += blocks[k, 0] * impulse[j, 0] + blocks[k, 1] * impulse[j, 1]
                ut += blocks[k, 2] * impulse[j, 0] + blocks[k, 3] * impulse[j, 1]
            vn, vt = un + free[i, 0], ut + free[i, 1]
            if law is None:
                miss = _map_2d(friction[i], scale[i], pn, pt, vn, vt)
            else:
                xn, xt = pressed_2d(pn, pt, vn, vt, law, i)
                miss = _map_2d(friction[i], scale[i], xn, xt, vn, vt)
            given = pn * pn + pt * pt
            square += miss
            size += given
            worst = max(worst, scale[i] ** 2 * miss)
            caused = max(caused, un * un + ut * ut)
            fastest = max(fastest, vn * vn + vt * vt)
        error = _error(square, size, worst, caused, fastest)
        if error <= tolerance:
            return sweep + 1, error
    return count, error


@njit(cache=True)
def plain_3d(
    order: IntArray, pointer: IntArray, other: IntArray, blocks: FloatArray, own: FloatArray,
    local: FloatArray, scale: FloatArray, friction: FloatArray, free: FloatArray, impulse: FloatArray,
    slip: FloatArray,
    count: int, interval: int, tolerance: float, law: Law,
) -> tuple[int, float]:  # fmt: skip
    """Sweeps with W's off-diagonal ``blocks`` (k, 9) and diagonal ones ``own`` (c, 9); λ in ``slip``."""
    error = math.inf
    for sweep in range(count):
        for i in order:
            bn, b1, b2 = free[i, 0], free[i, 1], free[i, 2]
            for k in range(pointer[i], pointer[i + 1]):
                j = other[k]
                pn, p1, p2 = impulse[j, 0], impulse[j, 1], impulse[j, 2]
                bn += blocks[k, 0] * pn + blocks[k, 1] * p1 + blocks[k, 2] * p2
                b1 += blocks[k, 3] * pn + blocks[k, 4] * p1 + blocks[k, 5] * p2
                b2 += blocks[k, 6] * pn + blocks[k, 7] * p1 + blocks[k, 8] * p2
            if law is None:
                impulse[i, 0], impulse[i, 1], impulse[i, 2], slip[i] = solve_3d(
                    local[i], friction[i], bn, b1, b2, slip[i]
                )
            else:
                impulse[i, 0], impulse[i, 1], impulse[i, 2], slip[i] = answer_3d(
                    local[i], friction[i], bn, b1, b2, slip[i], law, i
                )
        if (sweep + 1) % interval and sweep + 1 < count:
            continue
        square = size = worst = caused = fastest = 0.0
        for i in range(len(friction)):
            qn, q1, q2 = impulse[i, 0], impulse[i, 1], impulse[i, 2]
            un = own[i, 0] * qn + own[i, 1] * q1 + own[i, 2] * q2
            u1 = own[i, 3] * qn + own[i, 4] * q1 + own[i, 5] * q2
            u2 = own[i, 6] * qn + own[i, 7] * q1 + own[i, 8] * q2
            for k in range(pointer[i], pointer[i + 1]):
                j = other[k]
                pn, p1, p2 = impulse[j, 0], impulse[j, 1], impulse[j, 2]
                un += blocks[k, 0] * pn + blocks[k, 1] * p1 + blocks[k, 2] * p2
                u1 += blocks[k, 3] * pn + blocks[k, 4] * p1 + blocks[k, 5] * p2
                u2 += blocks[k, 6] * pn + blocks[k, 7] * p1 + blocks[k, 8] * p2
            vn, v1, v2 = un + free[i, 0], u1 + free[i, 1], u2 + free[i, 2]
            if law is None:
                miss = _map_3d(friction[i], scale[i], qn, q1, q2, vn, v1, v2)
            else:
                xn, x1, x2 = pressed_3d(qn, q1, q2, vn, v1, v2, law, i)
                miss = _map_3d(friction[i], scale[i], xn, x1, x2, vn, v1, v2)
            given = qn * qn + q1 * q1 + q2 * q2
            square += miss
            size += given
            worst = max(worst, scale[i] ** 2 * miss)
            caused = max(caused, un * un + u1 * u1 + u2 * u2)
            fastest = max(fastest, vn * vn + v1 * v1 + v2 * v2)
        error = _error(square, size, worst, caused, fastest)
        if error <= tolerance:
            return sweep + 1, error
    return count, error


@njit(cache=True)
def bodies_2d(
    order: IntArray, bodies: IntArray, maps: FloatArray, own: FloatArray, local: FloatArray,
    scale: FloatArray, friction: FloatArray, free: FloatArray, impulse: FloatArray, motion: FloatArray,
    speed: float, count: int, interval: int, tolerance: float, law: Law,
) -> tuple[int, float]:  # fmt: skip
    """Sweeps that keep the bodies' velocities ``motion`` = M^½ U (b, 3); ``maps`` = B M^-½ (c, 2, 6).

    ``speed`` is the largest free velocity, which errors are measured by.
    """
    error = math.inf
    for sweep in range(count):
        for i in order:
            pn, pt = impulse[i, 0], impulse[i, 1]
            bn = free[i, 0] - own[i, 0] * pn - own[i, 1] * pt
            bt = free[i, 1] - own[i, 2] * pn - own[i, 3] * pt
            for s in range(2):
                body = bodies[i, s]
                if body >= 0:
                    for m in range(3):
                        bn += maps[i, s, m] * motion[body, m]
                        bt += maps[i, s, 3 + m] * motion[body, m]
            if law is None:
                impulse[i, 0], impulse[i, 1] = solve_2d(local[i], friction[i], bn, bt)
            else:
                impulse[i, 0], impulse[i, 1] = answer_2d(local[i], friction[i], bn, bt, law, i)
            pn, pt = impulse[i, 0] - pn, impulse[i, 1] - pt
            for s in range(2):
                body = bodies[i, s]
                if body >= 0:
                    for m in range(3):
                        motion[body, m] += maps[i, s, m] * pn + maps[i, s, 3 + m] * pt
        if (sweep + 1) % interval and sweep + 1 < count:
            continue
        square = size = worst = caused = fastest = 0.0
        for i in range(len(friction)):
            pn, pt = impulse[i, 0], impulse[i, 1]
            vn, vt = free[i, 0], free[i, 1]
            for s in range(2):
                body = bodies[i, s]
                if body >= 0:
                    for m in range(3):
                        vn += maps[i, s, m] * motion[body, m]
                        vt += maps[i, s, 3 + m] * motion[body, m]
            if law is None:
                miss = _map_2d(friction[i], scale[i], pn, pt, vn, vt)
            else:
                xn, xt = pressed_2d(pn, pt, vn, vt, law, i)
                miss = _map_2d(friction[i], scale[i], xn, xt, vn, vt)
            given = pn * pn + pt * pt
            square += miss
            size += given
            worst = max(worst, scale[i] ** 2 * miss)
            caused = max(caused, scale[i] ** 2 * given)
            fastest = max(fastest, vn * vn + vt * vt)
        error = _error(square, size, worst, speed**2 if speed > 0.0 else caused, fastest)
        if error <= tolerance:
            return sweep + 1, error
    return count, error


@njit(cache=True)
def bodies_3d(
    order: IntArray, bodies: IntArray, maps: FloatArray, own: FloatArray, local: FloatArray,
    scale: FloatArray, friction: FloatArray, free: FloatArray, impulse: FloatArray, motion: FloatArray,
    slip: FloatArray,
    speed: float, count: int, interval: int, tolerance: float, law: Law,
) -> tuple[int, float]:  # fmt: skip
    """Sweeps that keep the bodies' velocities ``motion`` = M^½ U (b, 6); ``maps`` = B M^-½ (c, 2, 18).

    ``speed`` is the largest free velocity, which errors are measured by.
    """
    error = math.inf
    for sweep in range(count):
        for i in order:
            pn, p1, p2 = impulse[i, 0], impulse[i, 1], impulse[i, 2]
            bn = free[i, 0] - own[i, 0] * pn - own[i, 1] * p1 - own[i, 2] * p2
            b1 = free[i, 1] - own[i, 3] * pn - own[i, 4] * p1 - own[i, 5] * p2
            b2 = free[i, 2] - own[i, 6] * pn - own[i, 7] * p1 - own[i, 8] * p2
            for s in range(2):
                body = bodies[i, s]
                if body >= 0:
                    for m in range(6):
                        u = motion[body, m]
                        bn += maps[i, s, m] * u
                        b1 += maps[i, s, 6 + m] * u
                        b2 += maps[i, s, 12 + m] * u
            if law is None:
                qn, q1, q2, slip[i] = solve_3d(local[i], friction[i], bn, b1, b2, slip[i])
            else:
                qn, q1, q2, slip[i] = answer_3d(local[i], friction[i], bn, b1, b2, slip[i], law, i)
            impulse[i, 0], impulse[i, 1], impulse[i, 2] = qn, q1, q2
            qn, q1, q2 = qn - pn, q1 - p1, q2 - p2
            if qn == 0.0 and q1 == 0.0 and q2 == 0.0:
                continue
            for s in range(2):
                body = bodies[i, s]
                if body >= 0:
                    for m in range(6):
                        motion[body, m] += (
                            maps[i, s, m] * qn + maps[i, s, 6 + m] * q1 + maps[i, s, 12 + m] * q2
                        )
        if (sweep + 1) % interval and sweep + 1 < count:
            continue
        square = size = worst = caused = fastest = 0.0
        for i in range(len(friction)):
            pn, p1, p2 = impulse[i, 0], impulse[i, 1], impulse[i, 2]
            vn, v1, v2 = free[i, 0], free[i, 1], free[i, 2]
            for s in range(2):
                body = bodies[i, s]
                if body >= 0:
                    for m in range(6):
                        u = motion[body, m]
                        vn += maps[i, s, m] * u
                        v1 += maps[i, s, 6 + m] * u
                        v2 += maps[i, s, 12 + m] * u
            if law is None:
                miss = _map_3d(friction[i], scale[i], pn, p1, p2, vn, v1, v2)
            else:
                xn, x1, x2 = pressed_3d(pn, p1, p2, vn, v1, v2, law, i)
                miss = _map_3d(friction[i], scale[i], xn, x1, x2, vn, v1, v2)
            given = pn * pn + p1 * p1 + p2 * p2
            square += miss
            size += given
            worst = max(worst, scale[i] ** 2 * miss)
            caused = max(caused, scale[i] ** 2 * given)
            fastest = max(fastest, vn * vn + v1 * v1 + v2 * v2)
        error = _error(square, size, worst, speed**2 if speed > 0.0 else caused, fastest)
        if error <= tolerance:
            return sweep + 1, error
    return count, error
