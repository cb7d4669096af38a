"""Seams: contacts of several joints that lie close together on a stone, where what one does the others feel.

Where a head joint ends on a bed joint three stones meet, and their contacts act on the same corners. An
impulse at one moves the others nearly as far as its own, and impulses that go round the stones move nothing.
What solves for one interface after the other knows nothing of that, and is wrong by orders of magnitude for
the latter.

    found = seams(operator, interface)                      # sets of contacts, once for a problem

Solved for together, less what solving for them interface by interface has given already, they make a
preconditioner of overlapping sets, additive as Schwarz's.

References
----------
A. Toselli and O. B. Widlund, "Domain Decomposition Methods: Algorithms and Theory" (2005), chapters 2 and 3.
Contacts chosen by how strongly they are coupled, as unknowns of algebraic multigrid: K. Stüben, "A review of
algebraic multigrid", Journal of Computational and Applied Mathematics 128 (2001).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.nscd.compliance import Operator

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Coupling of contacts, over the geometric mean of what each gives way by itself, from which they belong
# together. Seams begin with the strongest and grow while they have no more than so many contacts: a system of
# rubble takes 9 iterations so, 11 with 30 contacts and 20 with 15. Down to 0.2 it takes as many.
STRONG = (0.6, 0.5, 0.4, 0.3)
WIDEST = 60


def seams(operator: Operator, interface: IntArray) -> list[IntArray]:
    """Contacts of several interfaces that are strongly coupled.

    Parameters
    ----------
    operator : W_el between c contacts.
    interface : Number of each contact's interface, negative where it takes no part, shape (c,).

    Returns
    -------
    For each number k of contacts the n seams that have as many, shape (n, k). A contact is in one at most.
    """
    return _sets(_grown(*operator.strongest(STRONG[-1]), interface))


def together(operator: Operator, interface: IntArray) -> tuple[list[IntArray] | None, list[IntArray]]:
    """Interfaces that are to be solved for as one where they are in one seam with all of their contacts.

    Parameters
    ----------
    operator, interface : As for ``seams``.

    Returns
    -------
    All interfaces, or what they are joined to, by their numbers of contacts, and the seams between these;
    None for the first where none are joined.
    """
    pairs, coupling = operator.strongest(STRONG[-1])
    seam = _grown(pairs, coupling, interface)
    inside = np.flatnonzero(interface >= 0)
    number, count = interface[inside], int(interface.max(initial=-1)) + 1
    least, most = np.full(count, len(seam) * len(seam)), np.full(count, -1)
    np.minimum.at(least, number, seam[inside])
    np.maximum.at(most, number, seam[inside])
    whole = np.flatnonzero(least == most)
    _, of, times = np.unique(most[whole], return_inverse=True, return_counts=True)
    joined = times[of] > 1
    if not joined.any():
        return None, _sets(seam)
    new = np.arange(count)
    new[whole[joined]] = count + of[joined]
    interface = np.where(interface >= 0, new[interface], interface)
    return _sets(interface, least=1), _sets(_grown(pairs, coupling, interface))


def _grown(pairs: IntArray, coupling: FloatArray, interface: IntArray) -> IntArray:
    """Number of each contact's seam, shape (c,), from pairs (p, 2) that are coupled so strongly, (p,)."""
    sides = interface[pairs]
    apart = (sides[:, 0] != sides[:, 1]) & (sides >= 0).all(axis=1)
    pairs, coupling, c = pairs[apart], coupling[apart], len(interface)
    seam = np.arange(c)
    for number, least in enumerate(STRONG, start=1):
        joined = pairs[coupling > least]
        graph = sparse.coo_array((np.ones(len(joined)), tuple(joined.T)), shape=(c, c))
        grown = connected_components(graph, directed=False)[1]
        narrow = np.bincount(grown, minlength=c)[grown] <= WIDEST
        seam = np.where(narrow, number * c + grown, seam)
    return seam


def _sets(number: IntArray, least: int = 2) -> list[IntArray]:
    """Contacts with one number, at least so many, sorted by how many they are; negative ones are in none."""
    order = np.argsort(number, kind="stable")[(number < 0).sum() :]
    _, first, size = np.unique(number[order], return_index=True, return_counts=True)
    return [order[first[size == k][:, None] + np.arange(k)] for k in np.unique(size[size >= least]).tolist()]
