"""Scale of a contact: the inverse mass that the error measures and the solvers measure by.

Elastic contacts are measured by the elastic part of their diagonal block: the rigid scale 1/m lies
10⁶ to 10¹⁰ above it and would hide errors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import lengths
from masonry_fem.nscd.problem import ContactProblem

FloatArray = NDArray[np.float64]


def contact_scale(problem: ContactProblem, *, fold: bool = True) -> FloatArray:
    """w_i = ‖W_el,ii‖₂, or ‖B_i M_r⁻¹ B_iᵀ‖₂ (unit mass in statics) at rigid contacts, (c,) [1/kg].

    A contact that nothing can move gets the mean of the others, so that no scale is ever 0.

    Parameters
    ----------
    problem : The contact problem.
    fold : Where cohesion stiffens a contact, take the folded block (I + w S)⁻¹ w.
    """
    own = problem.operator.diagonal()
    scale = _norm(own)
    stiff = scale <= 0
    if stiff.any() and problem.body_count:
        rigid = rigid_diagonal(problem)[stiff]
        own[stiff], scale[stiff] = rigid, _norm(rigid)
    if fold and problem.cohesion_stiffness is not None:
        scale = _norm(folded(own, problem.cohesion_stiffness))
    movable = scale > 0
    scale[~movable] = scale[movable].mean() if movable.any() else 1.0
    return scale


def whole_scale(problem: ContactProblem) -> FloatArray:
    """w_i = ‖W_ii‖₂ of elastic and rigid part together, unit mass in statics, (c,) [1/kg].

    Parameters
    ----------
    problem : The contact problem, with cohesion folded in.
    """
    own = problem.operator.diagonal()
    own = own + rigid_diagonal(problem)
    if problem.cohesion_stiffness is not None:
        own = folded(own, problem.cohesion_stiffness)
    scale = _norm(own)
    return np.where(scale > 0, scale, scale[scale > 0].mean() if scale.any() else 1.0)


def free_speed(problem: ContactProblem) -> float:
    """Largest ‖q + B (U_0 + M_r⁻¹ f_r)‖, with unit mass where M_r = 0 [m/s].

    How fast the contacts would move if there were none.
    """
    mass = np.where(problem.rigid_mass > 0, problem.rigid_mass, 1.0)
    velocity = problem.contact_velocity(problem.rigid_velocity + problem.rigid_impulse / mass)
    return float(lengths(problem.free_velocity + velocity).max(initial=0.0))


def folded(own: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Blocks (I + w S)⁻¹ w by which a cohesive contact's velocity follows p̃, shape (c, d, d) [1/kg]."""
    block: FloatArray = np.linalg.solve(np.eye(own.shape[1]) + own @ stiffness, own)
    return block


def rigid_diagonal(problem: ContactProblem) -> FloatArray:
    """Diagonal blocks of B M_r⁻¹ Bᵀ with unit mass where M_r = 0, shape (c, d, d) [1/kg]."""
    mass = np.where(problem.rigid_mass > 0, problem.rigid_mass, 1.0)
    inverse = np.concatenate([1.0 / mass, np.zeros((1, mass.shape[1]))])
    weighted = problem.rigid_map * inverse[problem.bodies][:, :, None, :]
    product: FloatArray = weighted @ problem.rigid_map.transpose(0, 1, 3, 2)
    return product.sum(axis=1)


def _norm(blocks: FloatArray) -> FloatArray:
    """‖block‖₂ of each, from the largest eigenvalue of blockᵀ block: SVDs cost twenty times as much."""
    if not len(blocks):
        return np.zeros(0)
    size = np.abs(blocks).max(axis=(1, 2))  # their squares must not leave the range of floats
    unit = blocks / np.where(size > 0, size, 1.0)[:, None, None]
    square = unit.transpose(0, 2, 1) @ unit
    d = square.shape[1]
    mean = np.trace(square, axis1=1, axis2=2) / d
    deviation = square - mean[:, None, None] * np.eye(d)
    spread = np.sqrt((deviation**2).sum(axis=(1, 2)) / (d * (d - 1)))
    largest = mean + spread
    if d == 3:  # the cubic's largest root by cosines (Smith 1961)
        third = np.linalg.det(deviation / np.where(spread > 0, spread, 1.0)[:, None, None]) / 2
        largest = mean + 2 * spread * np.cos(np.arccos(np.clip(third, -1, 1)) / 3)
    norm: FloatArray = size * np.sqrt(largest)
    return norm
