"""Centre: of a proximal problem of impulses, a little inside the cones where contacts stick.

Where three stones meet, an impulse that goes round their three joints moves nothing, or next to nothing, and
is hardly determined. The proximal term leaves it where it was, often with a contact on the edge of its cone
that sticks all the same: the next step that changes something nearby throws it far out. A centre inside the
cone draws it back.

    centre = inside(problem, impulse, velocity, scale, error, weight)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import lengths
from masonry_fem.nscd.problem import ContactProblem

FloatArray = NDArray[np.float64]

MARGIN = 0.1  # share of the cone by which a contact is drawn inside at most


def inside(
    problem: ContactProblem,
    impulse: FloatArray,
    velocity: FloatArray,
    scale: FloatArray,
    error: float,
    weight: float,
) -> FloatArray:
    """The impulses of a centre, shape (c, d).

    Tangential impulses are at most (1 − m) μ p_N where contacts stick. The proximal term then moves what is
    determined by α w m μ p_N: no more than the error allows. A contact that slips by less than the error may
    stick as well; the margin m falls with its speed, or else such contacts would be drawn inside in every
    other round. An impulse that goes round a stone changes all the contacts that it passes by as much, and
    would pull at those that bear next to nothing: the way, m μ p_N, is no longer than such a share of the
    least normal impulse of both bodies.

    Parameters
    ----------
    problem : The contact problem.
    impulse, velocity : The state, shapes (c, d). scale : w of each contact, shape (c,).
    error : Norm of the state's residual over that of the impulses. weight : α.
    """
    normal, tangent, cone = impulse[:, 0], lengths(impulse[:, 1:]), problem.friction * impulse[:, 0]
    slow = error * scale * np.maximum(cone, 0.0)
    speed = np.divide(lengths(velocity[:, 1:]), slow, out=np.ones_like(slow), where=slow > 0)
    sticks = np.maximum(1.0 - speed, 0.0)
    margin = min(MARGIN, error / weight) * sticks * problem.friction * _least(problem, normal)
    edge = cone - margin
    drawn = (tangent > edge) & (sticks > 0)
    centre = impulse.copy()
    centre[drawn, 1:] *= (edge[drawn] / tangent[drawn])[:, None]
    return centre


def _least(problem: ContactProblem, normal: FloatArray) -> FloatArray:
    """The least normal impulse among the closed contacts of each contact's two bodies, shape (c,)."""
    closed = np.flatnonzero(normal > 0)
    of_bodies = np.full(problem.body_count + 1, np.inf)  # the last is none
    for side in range(2):  # one row at a time is seven times as fast
        np.minimum.at(of_bodies, problem.bodies[closed, side], normal[closed])
    of_bodies[-1] = np.inf
    of_bodies = problem.least(of_bodies)
    least: FloatArray = np.minimum(of_bodies[problem.bodies].min(axis=1), np.maximum(normal, 0.0))
    return least
