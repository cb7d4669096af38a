"""True error of a run's stress: against a run on a much finer mesh of the same scene.

∫ (σ_fine − σ_h) : C⁻¹ : (σ_fine − σ_h) over each block, at the fine mesh's Gauss points. Cells must be boxes
along their shapes' axes, so that the cell of a point is found by its bounds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.fem.error_estimate import energy_density
from masonry_fem.fem.lagrange import lagrange, quadrature
from masonry_fem.run import RunResult


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
    """Cell of each point and its reference coordinates there."""
    corners = mesh.points[mesh.cells]
    low, high = corners.min(axis=1), corners.max(axis=1)
    cell = np.empty(len(points), dtype=int)
    for first in range(0, len(points), 2000):
        part = points[first : first + 2000, None]
        cell[first : first + 2000] = np.maximum(low - part, part - high).max(axis=2).argmin(axis=1)
    return cell, (points - low[cell]) / (high - low)[cell]


def _stress(group: Any, state: Any, body: int, cell: np.ndarray, local: np.ndarray) -> np.ndarray:
    """Stress (q, 6) of the elements, shape axes, at reference points of cells."""
    mesh, own = group.mesh, group.operators
    reference = lagrange(mesh.cell).gradients(local)
    jacobian = np.einsum("qkd,qkt->qdt", mesh.points[mesh.cells[cell]], reference)
    gradient = np.einsum("qkt,qtd->qkd", reference, np.linalg.inv(jacobian))
    moved = state.displacement[body].reshape(-1, mesh.dimension)[mesh.cells[cell]]
    D = own.material.stress_matrix(mesh.dimension, own.plane)
    return np.einsum("sij,qkj,qki->qs", D, gradient, moved)
