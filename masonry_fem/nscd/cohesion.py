"""Cohesion of a contact problem: what joints resist besides contact, p_adh = a + S v.

The laws of contact hold for p̃ = p + a + S v, the blocks move by p. The constant part a goes exactly
into loads and free velocities, and no solver needs to know of it:

    p° = p + a:    v = W_el p° + (q − W_el a) + B U,    Bᵀ p° + (f_r − Bᵀ a) − M_r (U − U_0) = 0

The stiffness S does not: it couples what only a contact's own impulse coupled. With the contact's own
block w it folds into w' = (I + w S)⁻¹ w and v' = (I + w S)⁻¹ v_free.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.graphs import project_cone
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import multiplied
from masonry_fem.nscd.settings import Start

FloatArray = NDArray[np.float64]

# Share of a contact's largest stiffness below which a direction has none.
SLACK = 1e-9


def without_offset(problem: ContactProblem) -> ContactProblem:
    """The problem for p° = p + a; itself where a = 0."""
    offset = problem.cohesion_offset
    if offset is None:
        return problem
    return replace(
        problem,
        free_velocity=problem.free_velocity - problem.elastic_velocity(offset),
        rigid_impulse=problem.rigid_impulse - problem.body_impulse(offset),
        cohesion_offset=None,
    )


def frozen(problem: ContactProblem, impulse: FloatArray, velocity: FloatArray) -> ContactProblem:
    """The dry problem that p̃ solves with the same velocities: cohesion stays as it is at (p, v).

    Parameters
    ----------
    problem : The contact problem.
    impulse : p, shape (c, d) [N s].
    velocity : v, shape (c, d) [m/s].
    """
    held = problem.contact_part(impulse, velocity) - impulse
    return without_offset(replace(problem, cohesion_offset=held, cohesion_stiffness=None))


def onto_cones(problem: ContactProblem, impulse: FloatArray, velocity: FloatArray) -> FloatArray:
    """Impulses whose contact parts lie in the cones, the nearest at given velocities, shape (c, d) [N s].

    Parameters
    ----------
    problem : The contact problem.
    impulse : p, shape (c, d) [N s].
    velocity : v, shape (c, d) [m/s].
    """
    if not problem.cohesive:
        return project_cone(impulse, problem.friction)
    pressed = problem.contact_part(impulse, velocity)
    return impulse + (project_cone(pressed, problem.friction) - pressed)


def sprung_directions(problem: ContactProblem) -> FloatArray | None:
    """Projectors on the impulses that the stiffness S can give, shape (c, d, d); None where it is none."""
    if problem.cohesion_stiffness is None:
        return None
    left, size, _ = np.linalg.svd(problem.cohesion_stiffness)
    left = left * (size > SLACK * size[:, :1])[:, None, :]
    projector: FloatArray = multiplied(left, left.transpose(0, 2, 1))
    return projector


def refuse_stiffness(problem: ContactProblem, method: str) -> None:
    """Refuse cohesion with stiffness, for methods that do not know it.

    Parameters
    ----------
    problem : The contact problem.
    method : Name of the method.

    Raises
    ------
    ProblemError : The cohesion of a contact has stiffness.
    """
    if problem.cohesion_stiffness is not None:
        contacts = problem.cohesion_stiffness.any(axis=(1, 2))
        raise ProblemError(
            f"{method} got {int(contacts.sum())} of {len(contacts)} contacts whose cohesion has stiffness, "
            f"contact {int(contacts.argmax())} first, expected none; use method 'newton'"
        )


def shifted_start(problem: ContactProblem, start: Start | None) -> Start | None:
    """A first guess for p° = p + a, of one for p.

    Parameters
    ----------
    problem : The contact problem with the constant part a of cohesion.
    start : First guess for p; None: there is none.
    """
    if start is None or start.impulse is None or problem.cohesion_offset is None:
        return start
    return replace(start, impulse=start.impulse + problem.cohesion_offset)
