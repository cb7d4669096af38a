"""Share: what the leader hands out to a rank, of a problem and of a step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.compliance import Kinds
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.solvers.elastic_krylov import Values

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

KEPT = "elastic_ranks"  # name of what ranks keep


@dataclass(frozen=True, slots=True)
class Share:
    """What a rank has of a problem.

    Attributes
    ----------
    dimension : d. count : Contacts that are its own; those that its stones touch beside them follow these.
    contacts : Where its contacts stand among those of all ranks, shape (t,).
    kinds : Stones of which some contact is its own, and which of them are its own, (n,).
    bed : Of its own contacts, shape (c, d); None: none.
    groups : Its interfaces, by their own contacts.
    bodies : Of its own contacts, numbered as in ``places``, shape (c, 2).
    places : Where its bodies stand among those of all ranks, shape (b,); the first ``own`` are its own.
    maps : B of its own contacts, shape (c, 2, d, m).
    coupled : Block rows and columns that it adds to the bodies' matrix beside its interfaces' ones, (2, k).
    library : By which it factorises the bodies' matrix; None: all ranks do so together.
    """

    dimension: int
    count: int
    contacts: IntArray
    kinds: tuple[tuple[Kinds, Mask], ...]
    bed: FloatArray | None
    groups: list[IntArray]
    bodies: IntArray
    places: IntArray
    own: int
    maps: FloatArray
    coupled: IntArray
    library: Library | None


Step = tuple[Values, FloatArray]  # at a rank's own contacts, and blocks that it adds to the bodies' matrix
