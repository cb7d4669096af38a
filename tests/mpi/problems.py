"""Contact problems that ranks solve as one process does, whichever turns Newton's method takes.

Ranks solve for all of them by iterations, few contacts as they are.
"""

import gc
import sys
from dataclasses import replace

import numpy as np

from masonry_fem.host import ranks
from masonry_fem.nscd import SolverSettings, Start
from masonry_fem.nscd.compliance import Kinds, Shared
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.newton import ProximalNewton
from masonry_fem.nscd.solvers.elastic_krylov import Effort
from masonry_fem.nscd.solvers.elastic_ranks import system
from masonry_fem.nscd.solvers.elastic_ranks.run import RanksRun
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT
from tests.nscd.walls import wall

SIZE = {"courses": 4, "length": 1.5, "elements": (2, 1, 1)}
TOLERANCE, AGREES = 1e-10, 1e-6


def shared(rigid=()):
    """A wall under its weight that is pushed sideways, its stones kinds of their own."""
    structure = wall(**SIZE)
    problem, blocks, kinds = structure.problem(rigid=rigid), range(len(structure.blocks)), []
    for block in sorted(set(blocks) - set(rigid)):
        alone = structure.problem(rigid=set(blocks) - {block}).compliance
        own = np.flatnonzero(np.diff(alone.indptr))
        dofs = (3 * own[:, None] + np.arange(3)).ravel()
        matrix = alone.toarray()[np.ix_(dofs, dofs)]
        kinds.append(Kinds.alike(own[None], np.tile(np.eye(3), (1, len(own), 1, 1)), matrix))
    return structure, replace(problem, compliance=Shared(problem.count, 3, kinds))


def pushed(problem, share):
    """The problem with this share of the weight as a push along the wall."""
    loads = problem.rigid_impulse.copy()
    loads[:, 0] -= share * loads[:, 2]
    return replace(problem, rigid_impulse=loads)


def opened(problem, structure, gap):
    """The problem with head joints open."""
    heads = np.abs(np.array([frame[0, 0] for *_, frame in structure.pairs])) > 0.5
    free = problem.free_velocity.copy()
    free[heads, 0] += gap
    return replace(problem, free_velocity=free)


def bonded(problem):
    """The problem with half of its contacts glued."""
    c = problem.count
    glued = np.arange(c) < c // 2
    own = 1.0 / problem.operator.norms()
    stiffness = np.where(glued, own, 0.0)[:, None, None] * np.eye(3)
    offset = np.where(glued[:, None], [1.0, 0.0, 0.0], 0.0) * np.abs(problem.rigid_impulse).max() / c
    return replace(problem, cohesion_stiffness=stiffness, cohesion_offset=offset)


def cases():
    structure, problem = shared()
    guess = np.zeros_like(problem.free_velocity)
    guess[:, 0] = np.abs(problem.rigid_impulse).max() / problem.count
    yield "weight", problem, None
    yield "pushed", pushed(problem, 0.3), None
    yield "from a guess", pushed(problem, 0.3), Start(guess)
    yield "pushed over", pushed(problem, 5.0), None
    for gap in (1e-12, 1e-9, 1e-7, 1e-4):
        yield f"head joints open by {gap:g} m", opened(problem, structure, gap), None
    yield "half of it bonded", bonded(pushed(problem, 0.3)), None
    yield "some of it rigid", shared(rigid=(0, 1, 4, 5))[1], None
    structure, mixed = shared(rigid=(0, 1, 4, 5))
    yield "some of it rigid, head joints open", opened(mixed, structure, 1e-7), None
    rough = replace(problem, friction=np.full(problem.count, 3.0))
    yield "rough", pushed(rough, 0.8), None
    yield "without an end of iterations", pushed(problem, 0.3), None


def solved(problem, start):
    """Its solution, and whether ranks have a part in it."""
    method = ProximalNewton(library="krylov")
    return iterate(problem, method, SolverSettings(tolerance=TOLERANCE), start)


def compared(name, problem, start):
    """How ranks and one process differ; "" where they do not."""
    everywhere = ranks.team().call
    everywhere(ask, [Hopeless if name.startswith("without") else Effort] * ranks.team().size)
    found = solved(problem, start)
    leader, ranks._team = ranks._team, ranks.Alone()
    expected = solved(problem, start)
    ranks._team = leader
    size = np.abs(expected.velocity).max()
    differs = np.abs(found.velocity - expected.velocity).max() / size
    if found.outcome is not expected.outcome:
        return f"{name}: {found.outcome} for {expected.outcome}"
    if expected.converged and not differs < AGREES:
        return f"{name}: velocities differ by {differs:.1e}"
    print(name, found.outcome, f"{differs:.1e}", found.iterations, expected.iterations, file=sys.stderr)
    return ""


class Hopeless:
    """An effort that solves no system."""

    @staticmethod
    def of(count, *, rests):
        return Effort(most=1, accuracy=1e-13)


def ask(member, effort):
    """Ask for this effort on a rank."""
    system.Effort = effort


def short(member, _):
    """Work in the midst of which the leader has too little memory for what others wait for."""
    return member.serve() if member.rank else ranks.team().lead(lacking)


def lacking():
    raise MemoryError("for parts")


def shortage():
    """What is wrong after such work; "" where all ranks have learnt of it and are ready for more."""
    everywhere, size = ranks.team().call, ranks.team().size
    try:
        everywhere(short, [None] * size)
    except MemoryError:
        everywhere(ask, [Effort] * size)
        return ""
    return "nobody was told of too little memory"


if ranks.join():
    sys.exit(0)
code = 1
try:
    made = []
    runs = RanksRun.__init__
    RanksRun.__init__ = lambda self, *given: made.append(self) or runs(self, *given)
    faults = [compared(*case) for case in cases()]
    expected = len(faults)
    faults.append(shortage())
    count, alone = len(made), sum(run._alone is not None for run in made)
    made.clear()
    gc.collect()
    kept = len(ranks.team().held[KEPT])  # by ranks, of what is done with
    print(f"runs of all ranks: {count}, of which the leader ended {alone}; kept {kept}", file=sys.stderr)
    code = int(any(faults) or count != expected or alone != 1 or kept != 0)
    print(*filter(None, faults), sep="\n", file=sys.stderr)
finally:
    ranks.team().end(code)
sys.exit(code)
