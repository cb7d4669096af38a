"""Slip: the planes of Mohr and Coulomb in principal stresses σ1 ≥ σ2 ≥ σ3, tension positive.

normals, flows = slip_planes(35.0, 10.0)
"""

from __future__ import annotations

import math

import numpy as np

from masonry_fem.fem.material_law import FloatArray

PAIRS = (
    (0, 2),
    (1, 2),
    (0, 1),
)  # of axes; the second and third bear on the first at equal principal stresses


def sine_cosine(angle: float) -> tuple[float, float]:
    """Of an angle [degrees]."""
    return math.sin(math.radians(angle)), math.cos(math.radians(angle))


def slip_planes(friction_angle: float, dilatancy_angle: float | None) -> tuple[FloatArray, FloatArray]:
    """Normals n and flows m of (1 + sin φ) σ_i − (1 − sin φ) σ_j ≤ bound, by pair, each of shape (3, 3).

    Parameters
    ----------
    friction_angle : φ [degrees]. dilatancy_angle : ψ [degrees]; None: φ.
    """
    sine = sine_cosine(friction_angle)[0]
    flowing = sine if dilatancy_angle is None else sine_cosine(dilatancy_angle)[0]
    normals, flows = np.zeros((3, 3)), np.zeros((3, 3))
    for row, (i, j) in enumerate(PAIRS):
        normals[row, [i, j]] = 1 + sine, -(1 - sine)
        flows[row, [i, j]] = 1 + flowing, -(1 - flowing)
    return normals, flows
