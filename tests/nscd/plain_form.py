"""Plain form: a contact problem as its Delassus operator alone, without bodies."""

from dataclasses import replace

from masonry_fem.nscd import ContactProblem


def condensed(problem: ContactProblem) -> ContactProblem:
    """The same problem in plain form; every body needs a mass."""
    assert (problem.rigid_mass > 0).all()
    plain = ContactProblem.plain(problem.delassus(), problem.plain_velocity(), problem.friction)
    return replace(
        plain, cohesion_offset=problem.cohesion_offset, cohesion_stiffness=problem.cohesion_stiffness
    )
