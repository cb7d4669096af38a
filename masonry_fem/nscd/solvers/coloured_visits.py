"""Visits: what coloured sweeps do to one group of contacts, and how they judge it.

For blocks of W or velocities of bodies, in 2D and 3D, a ``visit`` and a ``judge`` each. Contacts stand in
the order of the colouring, a group's from ``first`` to before ``last``; ``data`` are the arrays of
``sweeps`` in that order.

A visit goes ω times as far as the exact local solution s, and back to the cone: p ← P_K(p + ω (s − p)).
Its fixed points are those of ω = 1: there ω (s − p) is normal to K at p, so (s − p)·(z − p) ≤ 0 for all
z in K, s among them, and s = p.

Each sweep (``turn``) begins a group at another contact and goes forwards or backwards. A fixed order favours
one corner of an interface all the time: walls then need up to ten times the sweeps and more.

A judgement is what the error is made of: the sums of squares of the natural map and of p, and the largest
squares of the map in velocities, of the velocity that impulses cause, and of the velocity.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from masonry_fem.nscd.local import answer_2d, answer_3d, pressed_2d, pressed_3d

Judgement = tuple[float, float, float, float, float]


@njit(cache=True, inline="always")
def _mixed(turn: int, first: int) -> int:
    """Bits that look random, and are the same in every run."""
    return (turn * 2654435761 + first * 40503) & 0xFFFFFFFF


@njit(cache=True, inline="always")
def _place(k: int, first: int, last: int, mixed: int, start: int) -> int:
    """The k-th contact of a group that is visited, from ``start`` on and forwards or backwards."""
    step = k + start
    if step >= last - first:
        step -= last - first
    return last - 1 - step if mixed & 512 else first + step


@njit(cache=True, inline="always")
def onto_cone_2d(mu: float, xn: float, xt: float) -> tuple[float, float]:
    """P_K of one impulse."""
    size = abs(xt)
    if size > mu * xn:
        if mu * size <= -xn:
            xn, xt = 0.0, 0.0
        else:
            xn = (xn + mu * size) / (1.0 + mu * mu)
            xt = math.copysign(mu * xn, xt)
    return xn, xt


@njit(cache=True, inline="always")
def onto_cone_3d(mu: float, xn: float, x1: float, x2: float) -> tuple[float, float, float]:
    """P_K of one impulse."""
    size = math.sqrt(x1 * x1 + x2 * x2)
    if size > mu * xn:
        if mu * size <= -xn:
            xn, x1, x2 = 0.0, 0.0, 0.0
        else:
            xn = (xn + mu * size) / (1.0 + mu * mu)
            x1 *= mu * xn / size
            x2 *= mu * xn / size
    return xn, x1, x2


@njit(cache=True, inline="always")
def visit_bodies_2d(first: int, last: int, turn: int, relaxation: float, data: Any) -> None:
    """Visit of contacts between rigid bodies in 2D."""
    bodies, maps, own, local, _, friction, free, law, impulse, motion, _ = data
    mixed = _mixed(turn, first)
    start = (mixed >> 16) % (last - first)
    for k in range(last - first):
        i = _place(k, first, last, mixed, start)
        pn, pt = impulse[i, 0], impulse[i, 1]
        bn = free[i, 0] - own[i, 0] * pn - own[i, 1] * pt
        bt = free[i, 1] - own[i, 2] * pn - own[i, 3] * pt
        for s in range(2):
            body = bodies[i, s]
            if body >= 0:
                for m in range(3):
                    bn += maps[i, s, m] * motion[body, m]
                    bt += maps[i, s, 3 + m] * motion[body, m]
        qn, qt = answer_2d(local[i], friction[i], bn, bt, law, i)
        if relaxation != 1.0:
            qn, qt = onto_cone_2d(friction[i], pn + relaxation * (qn - pn), pt + relaxation * (qt - pt))
        impulse[i, 0], impulse[i, 1] = qn, qt
        qn, qt = qn - pn, qt - pt
        for s in range(2):
            body = bodies[i, s]
            if body >= 0:
                for m in range(3):
                    motion[body, m] += maps[i, s, m] * qn + maps[i, s, 3 + m] * qt


@njit(cache=True, inline="always")
def visit_bodies_3d(first: int, last: int, turn: int, relaxation: float, data: Any) -> None:
    """Visit of contacts between rigid bodies in 3D."""
    bodies, maps, own, local, _, friction, free, law, impulse, motion, slip = data
    mixed = _mixed(turn, first)
    start = (mixed >> 16) % (last - first)
    for k in range(last - first):
        i = _place(k, first, last, mixed, start)
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
        qn, q1, q2, slip[i] = answer_3d(local[i], friction[i], bn, b1, b2, slip[i], law, i)
        if relaxation != 1.0:
            qn, q1, q2 = pn + relaxation * (qn - pn), p1 + relaxation * (q1 - p1), p2 + relaxation * (q2 - p2)
            qn, q1, q2 = onto_cone_3d(friction[i], qn, q1, q2)
        impulse[i, 0], impulse[i, 1], impulse[i, 2] = qn, q1, q2
        qn, q1, q2 = qn - pn, q1 - p1, q2 - p2
        if qn == 0.0 and q1 == 0.0 and q2 == 0.0:
            continue
        for s in range(2):
            body = bodies[i, s]
            if body >= 0:
                for m in range(6):
                    motion[body, m] += maps[i, s, m] * qn + maps[i, s, 6 + m] * q1 + maps[i, s, 12 + m] * q2


@njit(cache=True, inline="always")
def visit_plain_2d(first: int, last: int, turn: int, relaxation: float, data: Any) -> None:
    """Visit of contacts that W couples in 2D."""
    pointer, other, blocks, _, local, _, friction, free, law, impulse, _ = data
    mixed = _mixed(turn, first)
    start = (mixed >> 16) % (last - first)
    for k in range(last - first):
        i = _place(k, first, last, mixed, start)
        bn, bt = free[i, 0], free[i, 1]
        for e in range(pointer[i], pointer[i + 1]):
            j = other[e]
            bn += blocks[e, 0] * impulse[j, 0] + blocks[e, 1] * impulse[j, 1]
            bt += blocks[e, 2] * impulse[j, 0] + blocks[e, 3] * impulse[j, 1]
        qn, qt = answer_2d(local[i], friction[i], bn, bt, law, i)
        if relaxation != 1.0:
            pn, pt = impulse[i, 0], impulse[i, 1]
            qn, qt = onto_cone_2d(friction[i], pn + relaxation * (qn - pn), pt + relaxation * (qt - pt))
        impulse[i, 0], impulse[i, 1] = qn, qt


@njit(cache=True, inline="always")
def visit_plain_3d(first: int, last: int, turn: int, relaxation: float, data: Any) -> None:
    """Visit of contacts that W couples in 3D."""
    pointer, other, blocks, _, local, _, friction, free, law, impulse, slip = data
    mixed = _mixed(turn, first)
    start = (mixed >> 16) % (last - first)
    for k in range(last - first):
        i = _place(k, first, last, mixed, start)
        bn, b1, b2 = free[i, 0], free[i, 1], free[i, 2]
        for e in range(pointer[i], pointer[i + 1]):
            j = other[e]
            pn, p1, p2 = impulse[j, 0], impulse[j, 1], impulse[j, 2]
            bn += blocks[e, 0] * pn + blocks[e, 1] * p1 + blocks[e, 2] * p2
            b1 += blocks[e, 3] * pn + blocks[e, 4] * p1 + blocks[e, 5] * p2
            b2 += blocks[e, 6] * pn + blocks[e, 7] * p1 + blocks[e, 8] * p2
        qn, q1, q2, slip[i] = answer_3d(local[i], friction[i], bn, b1, b2, slip[i], law, i)
        if relaxation != 1.0:
            pn, p1, p2 = impulse[i, 0], impulse[i, 1], impulse[i, 2]
            qn, q1, q2 = pn + relaxation * (qn - pn), p1 + relaxation * (q1 - p1), p2 + relaxation * (q2 - p2)
            qn, q1, q2 = onto_cone_3d(friction[i], qn, q1, q2)
        impulse[i, 0], impulse[i, 1], impulse[i, 2] = qn, q1, q2


@njit(cache=True, inline="always")
def _miss_2d(mu: float, w: float, pn: float, pt: float, vn: float, vt: float) -> float:
    """‖p − P_K(p − v̂/w)‖² of one contact."""
    xn, xt = onto_cone_2d(mu, pn - (vn + mu * abs(vt)) / w, pt - vt / w)
    miss: float = (pn - xn) ** 2 + (pt - xt) ** 2
    return miss


@njit(cache=True, inline="always")
def _miss_3d(mu: float, w: float, pn: float, p1: float, p2: float, vn: float, v1: float, v2: float) -> float:
    """‖p − P_K(p − v̂/w)‖² of one contact."""
    speed = math.sqrt(v1 * v1 + v2 * v2)
    xn, x1, x2 = onto_cone_3d(mu, pn - (vn + mu * speed) / w, p1 - v1 / w, p2 - v2 / w)
    miss: float = (pn - xn) ** 2 + (p1 - x1) ** 2 + (p2 - x2) ** 2
    return miss


@njit(cache=True, inline="always")
def judge_bodies_2d(first: int, last: int, data: Any) -> Judgement:
    """Judgement of contacts between rigid bodies in 2D."""
    bodies, maps, _, _, scale, friction, free, law, impulse, motion, _ = data
    square = size = worst = caused = fastest = 0.0
    for i in range(first, last):
        pn, pt = impulse[i, 0], impulse[i, 1]
        vn, vt = free[i, 0], free[i, 1]
        for s in range(2):
            body = bodies[i, s]
            if body >= 0:
                for m in range(3):
                    vn += maps[i, s, m] * motion[body, m]
                    vt += maps[i, s, 3 + m] * motion[body, m]
        xn, xt = pressed_2d(pn, pt, vn, vt, law, i)
        miss = _miss_2d(friction[i], scale[i], xn, xt, vn, vt)
        given = pn * pn + pt * pt
        square += miss
        size += given
        worst = max(worst, scale[i] ** 2 * miss)
        caused = max(caused, scale[i] ** 2 * given)
        fastest = max(fastest, vn * vn + vt * vt)
    return square, size, worst, caused, fastest


@njit(cache=True, inline="always")
def judge_bodies_3d(first: int, last: int, data: Any) -> Judgement:
    """Judgement of contacts between rigid bodies in 3D."""
    bodies, maps, _, _, scale, friction, free, law, impulse, motion, _ = data
    square = size = worst = caused = fastest = 0.0
    for i in range(first, last):
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
        xn, x1, x2 = pressed_3d(pn, p1, p2, vn, v1, v2, law, i)
        miss = _miss_3d(friction[i], scale[i], xn, x1, x2, vn, v1, v2)
        given = pn * pn + p1 * p1 + p2 * p2
        square += miss
        size += given
        worst = max(worst, scale[i] ** 2 * miss)
        caused = max(caused, scale[i] ** 2 * given)
        fastest = max(fastest, vn * vn + v1 * v1 + v2 * v2)
    return square, size, worst, caused, fastest


@njit(cache=True, inline="always")
def judge_plain_2d(first: int, last: int, data: Any) -> Judgement:
    """Judgement of contacts that W couples in 2D."""
    pointer, other, blocks, own, _, scale, friction, free, law, impulse, _ = data
    square = size = worst = caused = fastest = 0.0
    for i in range(first, last):
        pn, pt = impulse[i, 0], impulse[i, 1]
        un = own[i, 0] * pn + own[i, 1] * pt
        ut = own[i, 2] * pn + own[i, 3] * pt
        for e in range(pointer[i], pointer[i + 1]):
            j = other[e]
            un += blocks[e, 0] * impulse[j, 0] + blocks[e, 1] * impulse[j, 1]
            ut += blocks[e, 2] * impulse[j, 0] + blocks[e, 3] * impulse[j, 1]
        vn, vt = un + free[i, 0], ut + free[i, 1]
        xn, xt = pressed_2d(pn, pt, vn, vt, law, i)
        miss = _miss_2d(friction[i], scale[i], xn, xt, vn, vt)
        square += miss
        size += pn * pn + pt * pt
        worst = max(worst, scale[i] ** 2 * miss)
        caused = max(caused, un * un + ut * ut)
        fastest = max(fastest, vn * vn + vt * vt)
    return square, size, worst, caused, fastest


@njit(cache=True, inline="always")
def judge_plain_3d(first: int, last: int, data: Any) -> Judgement:
    """Judgement of contacts that W couples in 3D."""
    pointer, other, blocks, own, _, scale, friction, free, law, impulse, _ = data
    square = size = worst = caused = fastest = 0.0
    for i in range(first, last):
        qn, q1, q2 = impulse[i, 0], impulse[i, 1], impulse[i, 2]
        un = own[i, 0] * qn + own[i, 1] * q1 + own[i, 2] * q2
        u1 = own[i, 3] * qn + own[i, 4] * q1 + own[i, 5] * q2
        u2 = own[i, 6] * qn + own[i, 7] * q1 + own[i, 8] * q2
        for e in range(pointer[i], pointer[i + 1]):
            j = other[e]
            pn, p1, p2 = impulse[j, 0], impulse[j, 1], impulse[j, 2]
            un += blocks[e, 0] * pn + blocks[e, 1] * p1 + blocks[e, 2] * p2
            u1 += blocks[e, 3] * pn + blocks[e, 4] * p1 + blocks[e, 5] * p2
            u2 += blocks[e, 6] * pn + blocks[e, 7] * p1 + blocks[e, 8] * p2
        vn, v1, v2 = un + free[i, 0], u1 + free[i, 1], u2 + free[i, 2]
        xn, x1, x2 = pressed_3d(qn, q1, q2, vn, v1, v2, law, i)
        miss = _miss_3d(friction[i], scale[i], xn, x1, x2, vn, v1, v2)
        square += miss
        size += qn * qn + q1 * q1 + q2 * q2
        worst = max(worst, scale[i] ** 2 * miss)
        caused = max(caused, un * un + u1 * u1 + u2 * u2)
        fastest = max(fastest, vn * vn + v1 * v1 + v2 * v2)
    return square, size, worst, caused, fastest
