"""Share: what the leader hands out to a rank, of contacts, of a problem and of a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

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
    """What a rank has of contacts and bodies, whatever the problem.

    Attributes
    ----------
    dimension : d. width : Velocities of a body, m.
    count : Contacts that are its own. met : The same with those of its seams that are not.
    contacts : Where its contacts stand among those of all ranks, shape (t,): its own, the others of its
        seams, and what its stones touch beside them.
    stones : By kind, which of the stones of which some contact is its own are its own, shape (n,).
    groups, seams : Its interfaces and seams, by their contacts.
    interface : Number of the interface of each contact that is its own or of its seams, shape (met,).
    divided : Some rank has seams of which not all contacts are its own.
    bodies : Of its own contacts, numbered as in ``places``, shape (c, 2).
    places : Where its bodies stand among those of all ranks, shape (b,); the first ``own`` are its own.
    coupled : Block rows and columns that it adds to the bodies' matrix beside its interfaces' ones, (2, k).
    library : By which it factorises the bodies' matrix; None: all ranks do so together.
    """

    dimension: int
    width: int
    count: int
    met: int
    contacts: IntArray
    stones: tuple[Mask, ...]
    groups: list[IntArray]
    seams: list[IntArray]
    interface: IntArray
    divided: bool
    bodies: IntArray
    places: IntArray
    own: int
    coupled: IntArray
    library: Library | None


class Given(NamedTuple):
    """What a rank has of a problem of these contacts.

    Attributes
    ----------
    kinds : Stones of which some contact is its own, kind by kind.
    bed : Of its own contacts and those of its seams, shape (met, d); None: none.
    maps : B of its own contacts, shape (c, 2, d, m).
    column : What the columns of B are to be divided by, by body, shape (b, m).
    """

    kinds: tuple[Kinds, ...]
    bed: FloatArray | None
    maps: FloatArray
    column: FloatArray


# Of a rank's own contacts and those of its seams, and blocks that it adds to the bodies' matrix
Step = tuple[Values, FloatArray]
