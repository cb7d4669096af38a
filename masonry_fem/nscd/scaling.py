"""Scale of a contact: the inverse mass that the error measures and the solvers measure by.

Elastic contacts are measured by the elastic part of their diagonal block: the rigid scale 1/m lies
10⁶ to 10¹⁰ above it and would hide errors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import multiplied

FloatArray = NDArray[np.float64]

# Scale of an elastic contact over the least; among blocks of one kind it is ten. With ten, a soft wall of few
# contacts that slides fast is not solved.
SLENDER, SLENDER_OF_MANY = 100.0, 10.0


def contact_scale(problem: ContactProblem, *, fold: bool = True) -> FloatArray:
    """w_i = ‖W_el,ii‖₂, or ‖B_i M_r⁻¹ B_iᵀ‖₂ (unit mass in statics) at rigid contacts, (c,) [1/kg].

    A contact that nothing can move gets the mean of the others, so that no scale is ever 0.

    Parameters
    ----------
    problem : The contact problem.
    fold : Where cohesion stiffens a contact, take the folded block (I + w S)⁻¹ w.
    """
    alone = problem.rigid and problem.body_count > 0
    folds = fold and problem.cohesion_stiffness is not None
    own = rigid_diagonal(problem) if alone else problem.operator.giving() if folds else None
    scale = problem.operator.norms() if own is None else _norm(own)  # norms are kept
    stiff = scale <= 0
    if not alone and stiff.any() and problem.body_count:
        rigid = rigid_diagonal(problem)[stiff]
        scale[stiff] = _norm(rigid)
        if own is not None:
            own[stiff] = rigid
    if folds and own is not None and problem.cohesion_stiffness is not None:
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


def newton_scale(problem: ContactProblem, *, fold: bool = True) -> FloatArray:
    """Scale w of each contact, (c,) [1/kg]; among elastic contacts the rigid ones take the elastic mean.

    What holds an impulse back is to be small beside how far *joined* blocks give way. The rigid scale 1/m
    lies many orders above 1/(h² k).

    Parameters
    ----------
    problem : The contact problem.
    fold : Take the blocks of contacts with the stiffness of their cohesion.
    """
    scale = contact_scale(problem, fold=fold)
    elastic = problem.operator.elastic()
    if elastic.any() and not elastic.all():
        scale[~elastic] = scale[elastic].mean()
    return scale


def method_scales(problem: ContactProblem, *, moving: bool) -> tuple[FloatArray, FloatArray]:
    """Scales w that Newton's method measures states by, and impulses in its linear systems, both (c,) [1/kg].

    Parameters
    ----------
    problem : The contact problem. moving : They are those of all of W, as befits blocks that fly.
    """
    scale = whole_scale(problem) if moving else newton_scale(problem)
    # where stiff cohesion bonds elastic blocks, they give way as they would without a joint
    return scale, scale if problem.cohesion_stiffness is None else newton_scale(problem, fold=False)


def proximal_scale(problem: ContactProblem, scale: FloatArray, most: float = SLENDER) -> FloatArray:
    """Scale that α is relative to, (c,) [1/kg]: at most ``most`` times the least among elastic contacts.

    A slender block alone bends 10⁴ to 10⁹ times as far as between its neighbours, and only the latter counts
    here: a layer of mortar of 1 mm between bricks takes 4 steps so, and 14 with ``scale``. A brick that
    yields gives way far in one way, and hardly more than before in all others. What a contact's state is
    told by, and what ε is relative to, is not bounded so: a column of blocks 1e8 apart in stiffness takes 2
    steps, and 27 if it were.

    Parameters
    ----------
    problem : The contact problem.
    scale : That of its contacts, shape (c,). most : Over the least.
    """
    elastic = problem.operator.elastic()
    if not elastic.any():
        return scale
    own = contact_scale(problem, fold=False)[elastic]
    gives = own > np.finfo(float).eps * own.max()  # of what is held, blocks are rounding
    return np.minimum(scale, most * own[gives].min())


def free_speed(problem: ContactProblem) -> float:
    """Largest ‖q + B (U_0 + M_r⁻¹ f_r)‖, with unit mass where M_r = 0 [m/s].

    How fast the contacts would move if there were none.
    """
    from masonry_fem.nscd.transfer import longest  # noqa: PLC0415 - Numba is slow to import

    mass = np.where(problem.rigid_mass > 0, problem.rigid_mass, 1.0)
    velocity = problem.contact_velocity(problem.rigid_velocity + problem.rigid_impulse / mass)
    return float(longest(problem.free_velocity + velocity))


def folded(own: FloatArray, stiffness: FloatArray) -> FloatArray:
    """Blocks (I + w S)⁻¹ w by which a cohesive contact's velocity follows p̃, shape (c, d, d) [1/kg]."""
    block: FloatArray = np.linalg.solve(np.eye(own.shape[1]) + multiplied(own, stiffness), own)
    return block


def rigid_diagonal(problem: ContactProblem) -> FloatArray:
    """Diagonal blocks of B M_r⁻¹ Bᵀ with unit mass where M_r = 0, shape (c, d, d) [1/kg]."""
    from masonry_fem.nscd.transfer import rigid_blocks  # noqa: PLC0415 - Numba is slow to import

    blocks: FloatArray = rigid_blocks(problem.bodies, problem.rigid_map, problem.rigid_mass)
    return blocks


def _norm(blocks: FloatArray) -> FloatArray:
    """‖block‖₂ of each, shape (c,)."""
    from masonry_fem.nscd.contact_measures import spectral_norms  # noqa: PLC0415 - Numba is slow to import

    norm: FloatArray = spectral_norms(np.ascontiguousarray(blocks))
    return norm
