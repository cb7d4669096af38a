"""Cuts: Gauss points on the pieces that the facets of both sides cut out of many polygons at once.

As ``quadrature``, which has one polygon in whose plane the facets are given.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_fem.contact.placement.parts.planes import Planes
from masonry_fem.contact.placement.parts.quadrature import Rules, gauss_lines, on_polygon
from masonry_fem.host.compiled import compiled, put
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def gauss_planes(
    planes: Planes,
    facets: Sequence[FloatArray],
    ranges: Sequence[IntArray],
    rules: Rules,
    quadrilaterals: bool,
) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """Gauss points of the common parts of many polygons and the facets of both sides.

    Parameters
    ----------
    planes : With the polygons.
    facets : World coordinates of the facets of candidate and antagonist, shape (f, v, d) each [m].
    ranges : First facet of each polygon and the one after its last, shape (k, 2) each; −1 where the side has
        none and the polygon is one facet.
    rules : Points and weights on [-1, 1], and on a triangle.
    quadrilaterals : Whether Gauss points will do on those that are no parallelograms.

    Returns
    -------
    Polygon (q,), place in its plane (q, d - 1), weight (q,) and facets of both sides (q, 2) of the points.
    """
    # one layout, of a single plane too: else the loop would be compiled once more
    polygon, basis = planes.polygon, np.ascontiguousarray(planes.frame[:, 1:])
    if polygon.shape[2] == 1:
        return gauss_lines(polygon, planes.origin, basis[:, 0], facets, ranges, len(rules[0][0]))
    return _many_areas(  # type: ignore[no-any-return]
        polygon, planes.count, planes.origin, basis, *facets, *ranges, *rules[0], *rules[1], 1, quadrilaterals
    )


@compiled
def _many_areas(
    polygon: FloatArray,
    count: IntArray,
    origin: FloatArray,
    basis: FloatArray,
    candidate: FloatArray,
    antagonist: FloatArray,
    of_candidate: IntArray,
    of_antagonist: IntArray,
    gauss: FloatArray,
    gauss_weight: FloatArray,
    barycentric: FloatArray,
    weight: FloatArray,
    density: int,
    quadrilaterals: bool,
) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """The compiled loop over polygons."""
    room, total = 64, 0
    owner, at = np.empty(room, dtype=np.int64), np.empty((room, 2))
    share, rows = np.empty(room), np.empty((room, 2), dtype=np.int64)
    for k in range(len(polygon)):
        own = polygon[k, : count[k]]
        first, second = of_candidate[k, 0], of_antagonist[k, 0]
        # a candidate's facets look against the normal
        one = _in_plane(candidate[first : of_candidate[k, 1]], origin[k], basis[k], True)
        two = _in_plane(antagonist[second : of_antagonist[k, 1]], origin[k], basis[k], False)
        if first < 0:
            one = own.copy().reshape(1, len(own), 2)
        if second < 0:
            two = own.copy().reshape(1, len(own), 2)
        points, weights, of = on_polygon(
            own, one, two, gauss, gauss_weight, barycentric, weight, density, quadrilaterals
        )
        after = total + len(points)
        if after > room:
            more = max(after, 2 * room) - total
            owner = np.concatenate((owner[:total], np.empty(more, dtype=np.int64)))
            at = np.concatenate((at[:total], np.empty((more, 2))))
            share = np.concatenate((share[:total], np.empty(more)))
            rows = np.concatenate((rows[:total], np.empty((more, 2), dtype=np.int64)))
            room = total + more
        owner[total:after] = k
        put(at[total:], points)
        put(share[total:], weights)
        for i in range(len(points)):
            rows[total + i, 0] = of[i, 0] + first if first >= 0 else -1
            rows[total + i, 1] = of[i, 1] + second if second >= 0 else -1
        total = after
    return owner[:total], at[:total], share[:total], rows[:total]


@compiled
def _in_plane(facets: FloatArray, origin: FloatArray, basis: FloatArray, turned: bool) -> FloatArray:
    """Plane coordinates of the corners of facets, in the other order where these are to be turned."""
    corners = facets.shape[1]
    flat = np.empty((len(facets), corners, 2))
    for f in range(len(facets)):
        for v in range(corners):
            to = corners - 1 - v if turned else v
            for p in range(2):
                along = 0.0
                for axis in range(len(origin)):
                    along += (facets[f, v, axis] - origin[axis]) * basis[p, axis]
                flat[f, to, p] = along
    return flat
