"""The command line on ranks, whose first step must be preconditioned as one rank alone would."""

import sys
from dataclasses import replace

import numpy as np

from masonry_fem.cli import main
from masonry_fem.host.ranks import team
from masonry_fem.nscd.scaling import method_scales
from masonry_fem.nscd.solvers.elastic_krylov import Undivided
from masonry_fem.nscd.solvers.elastic_ranks.division import whole as put_together
from masonry_fem.nscd.solvers.elastic_ranks.system import DividedSystem
from masonry_fem.nscd.solvers.elastic_ranks.work import Worker
from masonry_fem.nscd.solvers.newton_system import NewtonSystem

AGREES = 1e-9
iteration, begin, ways, wholes = DividedSystem._iteration, Worker.begin, [], []


def begun(self, given):
    """What a rank begins a run with; the leader knows the whole problem."""
    wholes.append(given.run and given.run())
    return begin(self, given)


def compared(self, kept, terms):
    """The step's solver; of the first one how far what ranks make of given rows is from one rank's."""
    solve = iteration(self, kept, terms)
    if ways:
        return solve
    portion, random = self._portion, np.random.default_rng(1 + self._portion.member.rank)
    force = random.normal(size=self.problem.free_velocity.shape)
    balance = np.random.default_rng(0).normal(size=self.column.shape)
    impulse, motion = portion._precondition(force, balance[portion.its_bodies])
    motion = portion.of_all(motion[: portion.share.own])
    of_terms = terms.own, terms.by_velocity, terms.plain, terms.closed
    given = portion.member.collected((force, impulse, *of_terms))
    ways.append(0.0)
    if given is None:
        return solve
    problem, contacts = wholes[-1].problem, wholes[-1].division.contacts
    force, impulse, *of_contacts = (put_together(contacts, list(parts)) for parts in zip(*given, strict=True))
    alone = NewtonSystem(problem, method_scales(problem, moving=False)[1], self.library)
    mass = terms.coupled.diagonal().reshape(balance.shape)  # all of it is the leader's
    coupled = alone.body_matrix.assemble(np.zeros((0, *force.shape[1:] * 2)), np.zeros(0, dtype=int), mass)
    own, by_velocity, plain, closed = of_contacts
    whole = replace(
        terms, own=own, by_velocity=by_velocity, plain=plain, closed=closed, coupled=coupled,
        body_matrix=alone.body_matrix,
    )  # fmt: skip
    solver = Undivided(problem, alone.elastic, alone.scale).solver(
        whole, np.flatnonzero(closed), alone.body_matrix, alone._bodies_factorised
    )
    ways[:] = [
        np.linalg.norm(one - other) / np.linalg.norm(other)
        for one, other in zip((impulse, motion), solver._precondition(force, balance), strict=True)
    ]
    return solve


DividedSystem._iteration, Worker.begin = compared, begun
code = main(sys.argv[1:])
if team().size > 1:
    print("impulses and motions agree to", *(f"{way:.1e}" for way in ways), file=sys.stderr)
    code = code or int(not ways or max(ways) > AGREES)
sys.exit(code)
