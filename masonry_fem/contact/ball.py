"""Ball: how deep two many-sided blocks overlap, as the diameter of the largest ball that lies in both."""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.pose import FloatArray


def ball_in_both(one: FloatArray, two: FloatArray) -> float:
    """Diameter [m] of the largest ball within two convex hulls at once; negative if the hulls are apart.

    To separate the hulls, one must be moved by at least this much.

    Parameters
    ----------
    one, two : Points whose convex hulls are meant, each of shape (n, 3) [m].
    """
    # loaded only for blocks that overlap, as loading takes a fifth of a second
    from scipy.optimize import linprog  # noqa: PLC0415
    from scipy.spatial import ConvexHull  # noqa: PLC0415

    origin = one.mean(axis=0)
    size = float(np.ptp(one, axis=0).max())
    planes = np.concatenate([ConvexHull((cloud - origin) / size).equations for cloud in (one, two)])
    sides = np.column_stack([planes[:, :-1], np.ones(len(planes))])
    aim = np.zeros(sides.shape[1])
    aim[-1] = -1.0  # the largest radius
    best = linprog(
        aim,
        A_ub=sides,
        b_ub=-planes[:, -1],
        bounds=(None, None),
        options={"primal_feasibility_tolerance": 1e-10},
    )
    assert best.x is not None  # bounded, and feasible with a negative radius
    return 2 * size * float(best.x[-1])
