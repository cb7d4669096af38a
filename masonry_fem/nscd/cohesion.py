"""Cohesion of a contact problem: what joints resist besides contact, p_adh = a + S v (formulation 5).

The laws of contact hold for p̃ = p + a + S v, the blocks move by p. The constant part a goes exactly
into loads and free velocities, and no solver needs to know of it:

    p° = p + a:    v = W_el p° + (q − W_el a) + B U,    Bᵀ p° + (f_r − Bᵀ a) − M_r (U − U_0) = 0

The stiffness S does not: it couples what only a contact's own impulse coupled. With the contact's own
block w it folds into w' = (I + w S)⁻¹ w and v' = (I + w S)⁻¹ v_free.
"""

from __future__ import annotations

from dataclasses import replace

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.settings import Start


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


def refuse_stiffness(problem: ContactProblem, method: str) -> None:
    """Raise ProblemError where a method got cohesion with stiffness, which it does not know."""
    if problem.cohesion_stiffness is not None:
        contacts = problem.cohesion_stiffness.any(axis=(1, 2))
        raise ProblemError(
            f"{method} got {int(contacts.sum())} of {len(contacts)} contacts whose cohesion has stiffness, "
            f"contact {int(contacts.argmax())} first, expected none; use method 'newton'"
        )


def shifted_start(problem: ContactProblem, start: Start | None) -> Start | None:
    """A first guess for p° of one for p."""
    if start is None or start.impulse is None or problem.cohesion_offset is None:
        return start
    return replace(start, impulse=start.impulse + problem.cohesion_offset)
