"""True error of a run's stress: against a run on a much finer mesh of the same scene.

∫ (σ_fine − σ_h) : C⁻¹ : (σ_fine − σ_h) over each block, at the fine mesh's Gauss points; straight or
curved.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from masonry_fem.analyses.run import RunResult
from masonry_fem.fem.error_estimate import energy_density
from masonry_fem.fem.lagrange import is_simplex, lagrange, quadrature

NEAR, NEWTON = 12, 6


def true_squares(coarse: RunResult, fine: RunResult) -> dict[int, float]:
    """e² by block number [J]."""
    found: dict[int, float] = {}
    for group, state in zip(fine.march.model.groups, fine.march.state.bodies, strict=True):
        if group.stress(state) is None:
            continue
        mesh, (points, weights) = group.mesh, quadrature(group.mesh.cell)
        element = lagrange(mesh.cell)
        places = np.einsum("pk,mkd->mpd", element.values(points), mesh.points[mesh.cells])
        cells = np.repeat(np.arange(len(mesh.cells)), len(points))
        local = np.tile(points, (len(mesh.cells), 1))
        jacobian = np.einsum("mkd,pkt->mpdt", mesh.points[mesh.cells], element.gradients(points))
        volume = (np.linalg.det(jacobian) * weights).ravel()
        for body, block in enumerate(group.blocks):
            other, moved, number = _owner(coarse, int(block))
            flat = places.reshape(-1, mesh.dimension)
            missing = _stress(group, state, body, cells, local) - _stress(
                other, moved, number, *_located(other.mesh, flat)
            )
            found[int(block)] = float(energy_density(missing, group.operators.material) @ volume)
    return found


def _owner(result: RunResult, block: int) -> tuple[Any, Any, int]:
    for group, state in zip(result.march.model.groups, result.march.state.bodies, strict=True):
        here = np.flatnonzero(group.blocks == block)
        if len(here):
            return group, state, int(here[0])
    raise AssertionError(f"block {block} is in no group")


def _located(mesh: Any, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cell of each point, of the near ones that which holds it best, and its reference coordinates there."""
    element, corners = lagrange(mesh.cell), mesh.points[mesh.cells]
    _, near = cKDTree(corners.mean(axis=1)).query(points, k=min(NEAR, len(corners)))
    best, cell = np.full(len(points), np.inf), np.zeros(len(points), dtype=int)
    local = np.zeros(points.shape)
    for tried in near.reshape(len(points), -1).T:
        place = np.full(points.shape, 0.5)
        for _ in range(NEWTON):
            miss = np.einsum("qk,qkd->qd", element.values(place), corners[tried]) - points
            jacobian = np.einsum("qkd,qkt->qdt", corners[tried], element.gradients(place))
            place = np.clip(place - np.linalg.solve(jacobian, miss[..., None])[..., 0], -2.0, 3.0)
        outside = np.maximum(-place, place - 1.0).max(axis=1)
        if is_simplex(mesh.cell):
            outside = np.maximum(outside, place.sum(axis=1) - 1.0)
        better = outside < best
        best[better], cell[better], local[better] = outside[better], tried[better], place[better]
    return cell, local


def _stress(group: Any, state: Any, body: int, cell: np.ndarray, local: np.ndarray) -> np.ndarray:
    """Stress (q, 6) of the elements, shape axes, at reference points of cells."""
    mesh, own = group.mesh, group.operators
    reference = lagrange(mesh.cell).gradients(local)
    jacobian = np.einsum("qkd,qkt->qdt", mesh.points[mesh.cells[cell]], reference)
    gradient = np.einsum("qkt,qtd->qkd", reference, np.linalg.inv(jacobian))
    moved = state.displacement[body].reshape(-1, mesh.dimension)[mesh.cells[cell]]
    D = own.material.stress_matrix(mesh.dimension, own.plane)
    return np.einsum("sij,qkj,qki->qs", D, gradient, moved)
