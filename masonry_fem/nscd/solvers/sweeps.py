"""Sweeps: contact after contact, each solved exactly with the others held; the one compiled loop of NSGS.

Contacts stand in the order of a colouring. Groups of one colour share nothing (``colouring``), so it does
not matter in which order they are visited, or at once by several threads. What an error sums up it sums
within groups, then over groups in their order. So results depend on no number of threads.

    sweep = kernel(parallel=True)
    made, error = sweep(
        groups, colours, sums, speed, relaxation, turns, interval, tolerance, axes, law, data
    )

``axes`` are as many numbers as there are dimensions: Numba knows how long a tuple is when it compiles, so
the plane and space have each their own machine code from this one source. Of plane vectors the third
component is 0. ``law`` is of ``local``, and ``data`` are, contact after contact: what couples them, of two
ways one (the others are None: Numba leaves out, before it compiles, all that they are for)

    bodies (c, 2), maps B M^-½ (c, 2, d, m) and motions M^½ U (b, m), which sweeps keep up to date, or
    pointer, other and blocks (k, d, d) of W by rows, the contacts' own included;

and own (c, d, d) and ``local.reduce_blocks``, scale, friction, free velocity, impulse (c, d) and λ of slip
(c,). None of them is a tuple: threads get tuples, but no tuples within tuples.

A visit goes ω times as far as the exact local solution s, and back to the cone: p ← P_K(p + ω (s − p)).
Its fixed points are those of ω = 1: there ω (s − p) is normal to K at p, so (s − p)·(z − p) ≤ 0 for all
z in K, s among them, and s = p.

Each sweep (``turns``) begins a group at another contact and goes forwards or backwards. A fixed order favours
one corner of an interface all the time: walls then need up to ten times the sweeps and more. A turn of 0
leaves the first group as it stands: one group of all contacts, shuffled, needs no more than that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np
from numba import prange
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled
from masonry_fem.nscd.local import Axes, Law, Vector, answer, pressed, times

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@compiled(inline="always")
def _row(vectors: FloatArray, i: int, axes: Axes) -> Vector:
    """A contact's vector."""
    return vectors[i, 0], vectors[i, 1], vectors[i, 2] if len(axes) == 3 else 0.0


@compiled(inline="always")
def _length(x1: float, x2: float, axes: Axes) -> float:
    """Length of a tangential vector."""
    return math.sqrt(x1 * x1 + x2 * x2) if len(axes) == 3 else abs(x1)


@compiled(forceinline=True)
def _velocity(
    axes: Axes, bodies: Any, maps: Any, motion: Any, pointer: Any, other: Any, blocks: Any, free: FloatArray,
    impulse: FloatArray, i: int,
) -> Vector:  # fmt: skip
    """Velocity of contact ``i``."""
    vn, v1, v2 = _row(free, i, axes)
    if pointer is not None:  # what is None is left out before it is compiled
        for e in range(pointer[i], pointer[i + 1]):
            pn, p1, p2 = _row(impulse, other[e], axes)
            un, u1, u2 = times(blocks, e, pn, p1, p2, axes)
            vn += un
            v1 += u1
            v2 += u2
    if bodies is not None:
        for s in range(2):
            body = bodies[i, s]
            if body >= 0:
                for m in range(6 if len(axes) == 3 else 3):
                    u = motion[body, m]
                    vn += maps[i, s, 0, m] * u
                    v1 += maps[i, s, 1, m] * u
                    if len(axes) == 3:
                        v2 += maps[i, s, 2, m] * u
    return vn, v1, v2


@compiled(forceinline=True)
def _move(axes: Axes, bodies: Any, maps: Any, motion: Any, i: int, pn: float, p1: float, p2: float) -> None:
    """Give an impulse at contact ``i`` to the motions of its bodies."""
    if bodies is not None:
        for s in range(2):
            body = bodies[i, s]
            if body >= 0:
                for m in range(6 if len(axes) == 3 else 3):
                    given = maps[i, s, 0, m] * pn + maps[i, s, 1, m] * p1
                    if len(axes) == 3:
                        given += maps[i, s, 2, m] * p2
                    motion[body, m] += given


@compiled(inline="always")
def _onto_cone(mu: float, xn: float, x1: float, x2: float, axes: Axes) -> Vector:
    """P_K of one impulse."""
    size = _length(x1, x2, axes)
    if size > mu * xn:
        if mu * size <= -xn:
            xn, x1, x2 = 0.0, 0.0, 0.0
        else:
            xn = (xn + mu * size) / (1.0 + mu * mu)
            x1 *= mu * xn / size
            x2 *= mu * xn / size
    return xn, x1, x2


@compiled(inline="always")
def _visit(first: int, last: int, turn: int, relaxation: float, axes: Axes, law: Law, data: Any) -> None:
    """Visit the contacts of a group."""
    bodies, maps, motion, pointer, other, blocks, own, local, _, friction, free, impulse, slip = data
    # bits that look random, and are the same in every run
    mixed = (turn * 2654435761 + first * 40503) & 0xFFFFFFFF
    start = (mixed >> 16) % (last - first)
    for k in range(last - first):
        step = k + start
        if step >= last - first:
            step -= last - first
        i = last - 1 - step if mixed & 512 else first + step
        pn, p1, p2 = _row(impulse, i, axes)
        vn, v1, v2 = _velocity(axes, bodies, maps, motion, pointer, other, blocks, free, impulse, i)
        un, u1, u2 = times(own, i, pn, p1, p2, axes)
        qn, q1, q2, slip[i] = answer(local[i], friction[i], vn - un, v1 - u1, v2 - u2, slip[i], law, i, axes)
        if relaxation != 1.0:
            qn, q1, q2 = pn + relaxation * (qn - pn), p1 + relaxation * (q1 - p1), p2 + relaxation * (q2 - p2)
            qn, q1, q2 = _onto_cone(friction[i], qn, q1, q2, axes)
        impulse[i, 0], impulse[i, 1] = qn, q1
        if len(axes) == 3:
            impulse[i, 2] = q2
        qn, q1, q2 = qn - pn, q1 - p1, q2 - p2
        if qn != 0.0 or q1 != 0.0 or q2 != 0.0:
            _move(axes, bodies, maps, motion, i, qn, q1, q2)


@compiled(inline="always")
def _judge(
    first: int, last: int, axes: Axes, law: Law, data: Any
) -> tuple[float, float, float, float, float]:
    """What a group adds to the error: the sums of squares of the natural map p − P_K(p − v̂/w) and of p.

    And the largest squares of the map in velocities, of what impulses cause, and of the velocity.
    """
    bodies, maps, motion, pointer, other, blocks, _, _, scale, friction, free, impulse, _ = data
    square = size = worst = caused = fastest = 0.0
    for i in range(first, last):
        pn, p1, p2 = _row(impulse, i, axes)
        vn, v1, v2 = _velocity(axes, bodies, maps, motion, pointer, other, blocks, free, impulse, i)
        xn, x1, x2 = pressed(pn, p1, p2, vn, v1, v2, law, i, axes)
        mu, w = friction[i], scale[i]
        yn, y1, y2 = _onto_cone(
            mu, xn - (vn + mu * _length(v1, v2, axes)) / w, x1 - v1 / w, x2 - v2 / w, axes
        )
        miss = (xn - yn) ** 2 + (x1 - y1) ** 2 + (x2 - y2) ** 2
        square += miss
        size += pn * pn + p1 * p1 + p2 * p2
        worst = max(worst, w**2 * miss)
        fn, f1, f2 = _row(free, i, axes)
        caused = max(caused, (vn - fn) ** 2 + (v1 - f1) ** 2 + (v2 - f2) ** 2)
        fastest = max(fastest, vn * vn + v1 * v1 + v2 * v2)
    return square, size, worst, caused, fastest


@compiled
def _error(sums: FloatArray, speed: float) -> float:
    """``Quality.error`` without the bodies' balance, from the groups' judgements, shape (g, 5).

    ``speed`` is what it is measured by, the largest free velocity; 0: by what the impulses cause.
    """
    square = size = worst = caused = fastest = 0.0
    for g in range(len(sums)):
        square += sums[g, 0]
        size += sums[g, 1]
        worst = max(worst, sums[g, 2])
        caused = max(caused, sums[g, 3])
        fastest = max(fastest, sums[g, 4])
    caused = speed**2 if speed > 0.0 else caused
    if size == 0.0:
        return 0.0 if worst == 0.0 else math.sqrt(worst / fastest)
    if worst == 0.0:
        return 0.0
    return max(math.sqrt(square / size), math.sqrt(worst / caused) if caused > 0.0 else math.inf)


def _sweep(
    groups: IntArray, colours: IntArray, sums: FloatArray, speed: float, relaxation: float,
    turns: IntArray, interval: int, tolerance: float, axes: Axes, law: Law, data: Any,
) -> tuple[int, float]:  # fmt: skip
    """At most as many sweeps as there are ``turns``; how many, and the error they left."""
    count = len(turns)
    error = math.inf
    for sweep in range(count):
        for colour in range(len(colours) - 1):
            for g in prange(colours[colour], colours[colour + 1]):
                _visit(groups[g], groups[g + 1], turns[sweep], relaxation, axes, law, data)
        if (sweep + 1) % interval and sweep + 1 < count:
            continue
        for g in prange(len(sums)):
            sums[g, 0], sums[g, 1], sums[g, 2], sums[g, 3], sums[g, 4] = _judge(
                groups[g], groups[g + 1], axes, law, data
            )
        error = _error(sums, speed)
        if error <= tolerance:
            return sweep + 1, error
    return count, error


@cache
def kernel(*, parallel: bool) -> Callable[..., tuple[int, float]]:
    """The compiled sweeps; only what is ``parallel`` loads Numba's threads."""
    source = FunctionType(_sweep.__code__, globals(), _sweep.__name__)
    # Numba's cache on disk tells kernels apart by their names
    source.__qualname__ = "parallel" if parallel else "alone"
    source.__module__ = __name__
    sweeps: Callable[..., tuple[int, float]] = compiled(parallel=parallel)(source)
    return sweeps
