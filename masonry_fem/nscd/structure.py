"""Structure: what the contact solver keeps from one problem to the next while contacts stay the same.

Whoever makes problems of the same contacts one after another, as the rounds and steps of a march are, gives
all of them one ``Structure``. Solvers look at what is in it, and use it where it fits a problem: it decides
what a solution costs, and of what it is no more than the tolerance leaves open.

    structure = Structure()
    problem = ContactProblem(..., structure=structure)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from masonry_fem.nscd.solvers.body_matrix import BodyPattern
    from masonry_fem.nscd.solvers.elastic_matrix import ElasticMatrix
    from masonry_fem.nscd.solvers.elastic_ranks.division import Division
    from masonry_fem.nscd.solvers.modal_system import Eliminated
    from masonry_fem.nscd.solvers.newton_system import NewtonFactor


@dataclass(slots=True, eq=False)
class Structure:
    """What is kept.

    Attributes
    ----------
    pattern : Of the matrix of bodies.
    matrix : Pattern of the last Newton matrix with elastic contacts, and its factor's order of elimination.
    factor : The last factor of such a matrix.
    factored : An iteration in place of a factor took too long: there are factors only from then on, in
        dynamics to the end of the step.
    bodies : The last matrix of bodies with modes, and its factor.
    division : Contacts and bodies as they were dealt to ranks.
    """

    pattern: BodyPattern | None = None
    matrix: ElasticMatrix | None = None
    factor: NewtonFactor | None = None
    factored: bool = False
    bodies: Eliminated | None = None
    division: Division | None = None

    def empty(self) -> None:
        """Keep no matrices: they are as large as all that is known of the contacts."""
        self.pattern = self.matrix = self.factor = self.bodies = self.division = None
