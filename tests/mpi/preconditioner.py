"""The command line on ranks, whose first step must be preconditioned as one rank alone would."""

import sys

import numpy as np

from masonry_fem.cli import main
from masonry_fem.host.ranks import team
from masonry_fem.nscd.solvers.elastic_krylov import Undivided
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT
from masonry_fem.nscd.solvers.newton_system import NewtonSystem

AGREES = 1e-9
iteration, ways = NewtonSystem._iteration, []


def preconditioned(member, given):
    """Impulses and motions of what is a rank's own."""
    number, force, balance = given
    impulse, motion = member.kept[KEPT][number]._precondition(force, balance)
    return impulse, motion[: len(balance)]


def compared(self, kept, terms):
    """The step's solver; of the first one how far what ranks make of given rows is from one rank's."""
    solve = iteration(self, kept, terms)
    if ways:
        return solve
    random, division = np.random.default_rng(1), self.interfaces.division
    force, balance = (
        random.normal(size=self.problem.free_velocity.shape),
        random.normal(size=self.column.shape),
    )
    alone = Undivided(self.problem, self.elastic, self.scale)
    expected = alone.solver(terms, kept, self.body_matrix, self._bodies_factorised)._precondition(
        force, balance
    )
    shares = [
        (division.number, force[own], balance[division.part == rank])
        for rank, own in enumerate(division.contacts)
    ]
    found = np.zeros_like(force), np.zeros_like(balance)
    for rank, (impulse, motion) in enumerate(team().call(preconditioned, shares)):
        found[0][division.contacts[rank]], found[1][division.part == rank] = impulse, motion
    ways.extend(
        np.linalg.norm(one - other) / np.linalg.norm(other)
        for one, other in zip(found, expected, strict=True)
    )
    return solve


NewtonSystem._iteration = compared
code = main(sys.argv[1:])
if team().size > 1:
    print("impulses and motions agree to", *(f"{way:.1e}" for way in ways), file=sys.stderr)
    code = code or int(not ways or max(ways) > AGREES)
sys.exit(code)
