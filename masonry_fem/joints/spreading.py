"""Spreading: what spreads along a joint: −Δ among the contact points of interfaces, and adhesion that decays.

    L β = M⁻¹ K β,    K_ij = −w_ij ≤ 0,    K_ii = Σ w_ij,    M = tributary areas

with linear elements: along a plane joint w = 1/distance between neighbours, in a joint of a space scene
w = ½ (cot α + cot β) of the angles opposite to an edge of the Delaunay triangulation. L is an M-matrix
with zero row sums: constants spread no further, and no point ever drives its neighbour past itself.
Adhesion of neighbouring points that decays together solves

    (Y + b/h) β + k L β + λ = w + b β_i/h,    β ≤ β_i,    λ ≥ 0,    λ (β_i − β) = 0

an obstacle problem with an M-matrix, by active sets, which end after finitely many linear systems. A broken
point weakens its neighbours within √(k/Y).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial import Delaunay

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FLAT = 1e-6  # height over the longest edge below which three points lie on a line
LEAST_AREA = 1e-6  # of an interface's largest tributary area
LIMIT = 100  # active sets; a handful in practice


def interface_laplacian(points: FloatArray, area: FloatArray, interface: IntArray) -> sparse.csr_array:
    """−Δ with free edges [1/m²], shape (c, c).

    Parameters
    ----------
    points : Contact points in the frame of their interface's plane [m], shape (c, d − 1).
    area : Tributary areas [m², m in the plane], shape (c,).
    interface : Interface of each point, shape (c,). Points of different interfaces do not touch.
    """
    c = len(points)
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    weights = [np.zeros(0)]
    mass = area.astype(float).copy()
    order = np.argsort(interface, kind="stable")
    for own in np.split(order, np.flatnonzero(np.diff(interface[order])) + 1):
        if len(own) < 2:
            continue
        mass[own] = np.maximum(area[own], LEAST_AREA * area[own].max())
        edges, conductance = _edges(points[own])
        pairs.append(own[edges])
        weights.append(conductance)
    first, second = np.concatenate(pairs).T
    weight = np.concatenate(weights)
    coupling = sparse.coo_array((weight, (first, second)), shape=(c, c))
    coupling = coupling + coupling.T
    total = sparse.diags_array(np.asarray(coupling.sum(axis=1)).ravel())
    share = np.divide(1.0, mass, out=np.zeros(c), where=mass > 0)
    return sparse.csr_array(sparse.diags_array(share) @ (total - coupling))


def _edges(points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Pairs of neighbours (m, 2) and their weights w > 0, shape (m,)."""
    centred = points - points.mean(axis=0)
    directions = np.linalg.svd(centred, full_matrices=False)[2]
    along = centred @ directions.T
    reach = np.ptp(along, axis=0)
    if along.shape[1] == 1 or len(points) < 3 or reach[1] <= FLAT * reach[0]:
        return _chain(along[:, 0])
    return _triangles(points)


def _chain(position: FloatArray) -> tuple[IntArray, FloatArray]:
    """Neighbours on a line; points in one place are bound through what lies beside them."""
    order = np.argsort(position, kind="stable")
    distance = np.diff(position[order])
    apart = np.maximum(distance, FLAT * np.ptp(position))
    return np.stack([order[:-1], order[1:]], axis=1), 1.0 / apart


def _triangles(points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Neighbours in a plane, by linear triangles."""
    corners = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    side = points[np.roll(corners, -1, axis=1)] - points[corners]  # from corner i to i + 1
    back = -np.roll(side, 1, axis=1)  # from corner i to i − 1
    twice = side[:, 0, 0] * back[:, 0, 1] - side[:, 0, 1] * back[:, 0, 0]  # the area, signed
    longest = (side**2).sum(axis=2).max(axis=1)
    # flat triangles along the hull have no area and would bind their corners without limit
    sound = np.abs(twice) > FLAT * longest
    half_cotangent = 0.5 * (side * back).sum(axis=2)[sound] / np.abs(twice[sound])[:, None]
    opposite = np.stack([np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1)], axis=2)[sound]
    opposite.sort(axis=2)
    pairs, which = np.unique(opposite.reshape(-1, 2), axis=0, return_inverse=True)
    weight = np.bincount(which.ravel(), weights=half_cotangent.ravel())
    # obtuse corners at the hull, and rounding where four points share a circle
    kept = weight > FLAT * weight.max()
    return pairs[kept], weight[kept]


def spread_damage(diagonal: FloatArray, coupling: Any, load: FloatArray, before: FloatArray) -> FloatArray:
    """β at the end of a step, shape (c,).

    Parameters
    ----------
    diagonal : Y + b/h [J/m²], shape (c,). coupling : k L, sparse, shape (c, c) [J/m²].
    load : w + b β_i/h [J/m²], shape (c,). before : β_i, shape (c,).
    """
    matrix = sparse.csr_array(sparse.diags_array(diagonal) + coupling)
    after = before.copy()
    decays = np.zeros(len(before), dtype=bool)
    for _ in range(LIMIT):
        # where kept the multiplier tells, where free the bound
        pushes = matrix @ after - load > 1e-14 * load
        chosen = np.where(decays, after < before, pushes)
        if (chosen == decays).all():
            break
        decays = chosen
        after = before.copy()
        free, kept = np.flatnonzero(decays), np.flatnonzero(~decays)
        if len(free):
            right = load[free] - matrix[free][:, kept] @ before[kept]
            after[free] = np.atleast_1d(spsolve(sparse.csc_array(matrix[free][:, free]), right))
    return np.clip(after, 0.0, before)
