"""Polish: from a point near the end of the central path to its end, by semismooth Newton steps.

At the end p is the projection of −(multipliers)/(u ω) on the faces. Where the edges that p lies on
are known, a step or two get there to rounding.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.central_path import CentralPath

FloatArray = NDArray[np.float64]

# Relative to the equations' own, what keeps the bodies' matrix regular where few impulses are free.
REGULAR = 1e-9
# Distances from the end, relative to ‖p‖: good enough, and hopeless.
POLISHED, DIVERGED = 1e-14, 1e2
STEPS = 20  # most of Newton's method


def polished(path: CentralPath) -> tuple[FloatArray, float]:
    """The best impulses met, in their faces, shape (c, d) [N s], and their distance from the end of the path.

    Parameters
    ----------
    path : The central path at a point near its end; its multipliers move on.
    """
    u, problem = path.unit * path.weight, path.problem
    c, d = path.member.shape
    own, own_inverse = (np.eye(d) * part[:, None, None] for part in (u, 1 / u))
    mass = REGULAR * path.system.column**2 / path.unit
    impulse = path.impulse
    best, least = impulse, _distance(path, impulse)
    for _ in range(STEPS):
        if least <= POLISHED:
            break
        nearest, slope = path.faces.project(_aim(path, impulse))
        factor = path.system.factor(own, slope, path.closed, np.zeros(c, bool), mass, own_inverse)
        balance = problem.body_impulse(impulse) - path.given
        change, motion = factor.solve(u[:, None] * (impulse - nearest), balance)
        path.motion, impulse = path.motion + motion, impulse + change
        path.pull = path.pull + problem.elastic_velocity(impulse - path.member)
        miss = _distance(path, impulse)
        if not miss < DIVERGED:
            break
        if miss < least:
            best, least = impulse, miss
    return path.faces.project(best)[0], least


def _aim(path: CentralPath, impulse: FloatArray) -> FloatArray:
    """−(multipliers)/(u ω), shape (c, d)."""
    return impulse - path.gradient(impulse) / (path.unit * path.weight[:, None])


def _distance(path: CentralPath, impulse: FloatArray) -> float:
    """How far impulses are from their projection, or from the equations, relative to ‖p‖."""
    nearest = path.faces.project(_aim(path, impulse))[0]
    size = float(np.linalg.norm(impulse)) or 1.0
    return max(float(np.linalg.norm(nearest - impulse)) / size, path.equations(impulse))
