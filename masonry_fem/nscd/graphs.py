"""Graphs: Signorini's, Coulomb's and what projects on them. Pure functions over c contacts.

The friction cone is K = {p : ‖p_T‖ ≤ μ p_N}; component 0 is the normal one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def lengths(vectors: FloatArray) -> FloatArray:
    """Euclidean length of each row, shape (n,)."""
    from masonry_fem.nscd.transfer import row_lengths  # noqa: PLC0415 - Numba is slow to import

    found: FloatArray = row_lengths(np.ascontiguousarray(vectors))
    return found


def tangential_norm(vector: FloatArray) -> FloatArray:
    """‖x_T‖ of each contact, shape (c,)."""
    tangent = vector[:, 1:]
    if tangent.shape[1] == 1:
        return np.abs(tangent[:, 0])
    norm: FloatArray = np.hypot(tangent[:, 0], tangent[:, 1])
    return norm


def augmented_velocity(velocity: FloatArray, friction: FloatArray) -> FloatArray:
    """v̂ = v + μ‖v_T‖ n, with which Signorini's and Coulomb's laws read K* ∋ v̂ ⊥ p ∈ K, shape (c, d) [m/s].

    Parameters
    ----------
    velocity : v, shape (c, d) [m/s].
    friction : Coefficients μ, shape (c,).

    References
    ----------
    G. De Saxcé and Z.-Q. Feng, "The bipotential method", Mathematical and Computer Modelling 28 (1998).
    """
    augmented = velocity.copy()
    augmented[:, 0] += friction * tangential_norm(velocity)
    return augmented


def project_cone(vector: FloatArray, friction: FloatArray) -> FloatArray:
    """Nearest points of the cones K, shape (c, d).

    Parameters
    ----------
    vector : What is projected, shape (c, d).
    friction : Coefficients μ, shape (c,).
    """
    normal, tangent = vector[:, 0], tangential_norm(vector)
    outside = tangent > friction * normal
    polar = friction * tangent <= -normal
    on_surface = np.maximum(normal + friction * tangent, 0.0) / (1.0 + friction**2)
    factor = np.divide(
        friction * on_surface, tangent, out=np.zeros_like(tangent), where=outside & (tangent > 0)
    )
    projected = vector.copy()
    projected[outside, 0] = on_surface[outside]
    projected[outside, 1:] *= factor[outside, None]
    projected[polar] = 0.0
    return projected


def natural_map(
    impulse: FloatArray, velocity: FloatArray, friction: FloatArray, scale: FloatArray
) -> FloatArray:
    """Natural map p − P_K(p − v̂/w), zero at a solution, shape (c, d) [N s].

    By Moreau's decomposition x = P_K(x) + P_K°(x), with the polar cone K°, it is v̂/w + P_K°(p − v̂/w). In
    this form no velocity is lost beside a large impulse: where a contact sticks it is v̂/w, however small.

    Parameters
    ----------
    impulse : p, shape (c, d) [N s].
    velocity : v, shape (c, d) [m/s].
    friction : Coefficients μ, shape (c,).
    scale : w of each contact, shape (c,) [1/kg].

    References
    ----------
    J. J. Moreau, "Décomposition orthogonale d'un espace hilbertien selon deux cônes mutuellement polaires",
    Comptes rendus 255 (1962).
    """
    from masonry_fem.nscd.contact_measures import natural_maps  # noqa: PLC0415 - Numba is slow to import

    given = (np.ascontiguousarray(part) for part in (impulse, velocity, friction, scale))
    found: FloatArray = natural_maps(*given)
    return found
