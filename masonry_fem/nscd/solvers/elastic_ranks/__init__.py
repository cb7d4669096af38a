"""ElasticRanks: Newton steps with elastic contacts by iteration, each rank for its stones.

What ``elastic_krylov`` does, with the wall in parts: PT-Scotch divides the graph of stones and interfaces, a
rank has the rows of W_el of its stones, and the interfaces between two parts are one's or the other's. A
product with W_el takes impulses of such interfaces from one part to the other, and velocities back. Seams
are solved for by the rank that has most of their contacts, so that steps are preconditioned as on one rank.
The bodies' matrix is factorised by MUMPS on all ranks together, or, where there are few, by each. GMRES is
PETSc's.

    division = Division(problem, elastic, pattern, library, team)           # once for contacts
    portions = Portions(problem, division, scale, column, team)             # once for a problem
    solve = portions.solver(terms, kept, body_matrix, factorised)           # once for a step
"""

from masonry_fem.nscd.solvers.elastic_ranks.portions import Portions, parted

__all__ = ["Portions", "parted"]
