"""Colouring: contacts in groups, groups in colours, so that groups of one colour share nothing.

A group holds the contacts of one interface, which are visited one after another: those between the same
two bodies, or those that W couples to the same contacts. Two groups of one colour share no body, or no
stored block of W, so that sweeps may visit them at the same time. Colours of few groups are not worth
that: all their contacts make up one last group, a colour of its own.

    colouring = colour_bodies(problem.bodies)
    visited = colouring.order[colouring.groups[0] : colouring.groups[1]]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.host.compiled import compiled

IntArray = NDArray[np.int64]

# Groups that a colour has at least: to wake the threads costs as much as some twenty of them.
FEWEST = 16


@dataclass(frozen=True, slots=True)
class Colouring:
    """Contacts by colour and group; g groups, k colours.

    Attributes
    ----------
    order : Contacts in visiting order, shape (c,).
    groups : Where each group begins in ``order``, and the end, shape (g + 1,).
    colours : Where each colour begins among the groups, and the end, shape (k + 1,).
    """

    order: IntArray
    groups: IntArray
    colours: IntArray

    @property
    def count(self) -> int:
        """Number of colours k."""
        return len(self.colours) - 1


def colour_bodies(bodies: IntArray, fewest: int = FEWEST) -> Colouring:
    """Colours of contacts between rigid bodies.

    Parameters
    ----------
    bodies : Bodies at the two sides, −1 for none, shape (c, 2).
    fewest : Colours with fewer groups become one group.
    """
    pairs, group = np.unique(np.sort(bodies, axis=1), axis=0, return_inverse=True)
    rows, side = np.nonzero(pairs >= 0)
    shape = (len(pairs), int(bodies.max(initial=-1)) + 1)
    # a group that touches a body on both sides meets it once
    hubs = sparse.csr_array((np.ones(len(rows), bool), (rows, pairs[rows, side])), shape=shape)
    hubs.sum_duplicates()
    return _arranged(_colours(hubs, hubs.T.tocsr()), group.ravel(), fewest)


def colour_couplings(couplings: sparse.csr_array, fewest: int = FEWEST) -> Colouring:
    """Colours of contacts that W does not couple, either way.

    Parameters
    ----------
    couplings : Stores an entry where W has a block, shape (c, c).
    fewest : Colours with fewer groups become one group.
    """
    c = couplings.shape[0]
    stored = sparse.csr_array(
        (np.ones(couplings.nnz, np.int64), couplings.indices, couplings.indptr), shape=(c, c)
    )
    near = sparse.csr_array(stored + stored.T + sparse.eye_array(c, dtype=np.int64))
    near.data[:] = 1
    # equal sums of random marks: equal neighbours (should that ever fail, a group is merely larger)
    _, group = np.unique(near @ np.random.default_rng(0).integers(0, 2**62, c), return_inverse=True)
    shape = (int(group.max(initial=-1)) + 1, c)
    member = sparse.csr_array((np.ones(c, np.int64), (group, np.arange(c))), shape=shape)
    met = sparse.csr_array(member @ near @ member.T)
    return _arranged(_colours(sparse.eye_array(met.shape[0], format="csr"), met), group, fewest)


def _colours(hubs: sparse.csr_array, members: sparse.csr_array) -> IntArray:
    """Colour of each group (g,): ``hubs`` (g, h) is where groups are, ``members`` (h, g) who is there."""
    # in a shuffled order, always the same: colours of a regular one let errors travel along courses
    visits = np.random.default_rng(0).permutation(hubs.shape[0])
    csr = (hubs.indptr, hubs.indices, members.indptr, members.indices)
    colours: IntArray = _greedy(visits, *(array.astype(np.int64) for array in csr))
    return colours


def _arranged(colour: IntArray, group: IntArray, fewest: int) -> Colouring:
    """The colouring, from the colour of each group (g,) and the group of each contact (c,)."""
    if not len(group):
        nothing = np.zeros(1, np.int64)
        return Colouring(np.zeros(0, np.int64), nothing, nothing)
    rare = np.bincount(colour) < fewest
    # common colours in their order, then what is rare, by colour still
    order = np.lexsort((group, colour[group], rare[colour[group]]))
    kept = np.sort(colour[~rare[colour]])
    sizes = np.bincount(group)[np.lexsort((np.arange(len(colour)), colour, rare[colour]))]
    groups, colours = sizes[: len(kept)], np.bincount(kept)[~rare[: kept.max(initial=-1) + 1]]
    if rare.any():
        groups, colours = np.append(groups, sizes[len(kept) :].sum()), np.append(colours, 1)
    return Colouring(order, _starts(groups), _starts(colours))


def _starts(sizes: IntArray) -> IntArray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


@compiled
def _greedy(
    visits: IntArray, hub_start: IntArray, hubs: IntArray, member_start: IntArray, members: IntArray
) -> IntArray:
    """The least colour that no group at the same hubs has yet, group after group."""
    count = len(visits)
    colour = np.full(count, -1)
    taken_by = np.full(count + 1, -1)
    for group in visits:
        for h in range(hub_start[group], hub_start[group + 1]):
            hub = hubs[h]
            for k in range(member_start[hub], member_start[hub + 1]):
                if colour[members[k]] >= 0:
                    taken_by[colour[members[k]]] = group
        least = 0
        while taken_by[least] == group:
            least += 1
        colour[group] = least
    return colour
