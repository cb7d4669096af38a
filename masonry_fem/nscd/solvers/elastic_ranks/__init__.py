"""ElasticRanks: Newton's method for many elastic contacts on several ranks, each with its stones.

PT-Scotch divides the graph of stones and interfaces into as many parts as there are ranks. A rank has the
rows of W_el of its stones, and the interfaces between them; interfaces between two parts are one's or the
other's. Of bodies, which are few beside contacts, every rank has all. Newton's method runs on each rank with
its contacts (``work``), for the leader (``run``): what it asks of all contacts are sums over ranks. A product
with W_el takes impulses of interfaces between two parts from one to the other, and velocities back. Seams are
solved for by the rank that has most of their contacts, so that steps are preconditioned as on one rank. The
bodies' matrix is factorised by MUMPS on all ranks together, or, where there are few, by each. GMRES is
PETSc's.

    run = on_ranks(problem, method, start)          # None where ranks have no part in it
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_fem.host.ranks import Leader, team

if TYPE_CHECKING:
    from masonry_fem.nscd.iterate import Run
    from masonry_fem.nscd.methods.newton import ProximalNewton
    from masonry_fem.nscd.problem import ContactProblem
    from masonry_fem.nscd.settings import Start


def on_ranks(problem: ContactProblem, method: ProximalNewton, start: Start | None) -> Run | None:
    """A run of all ranks; None where there is one process, or ranks are at work, or would not share this.

    Parameters
    ----------
    problem : The contact problem. method : What solves it. start : First guess; None: there is none.
    """
    leader = team()
    if not isinstance(leader, Leader) or leader.busy:
        return None
    from masonry_fem.nscd.solvers.elastic_ranks.run import RanksRun, divisible  # noqa: PLC0415 - ranks only

    return RanksRun(problem, method, start, leader) if divisible(problem, method) else None
