"""Share: what the leader hands out to a rank, of contacts and of a problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.compliance import Kinds
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.settings import Start

if TYPE_CHECKING:
    import weakref

    from masonry_fem.nscd.methods.newton import ProximalNewton
    from masonry_fem.nscd.solvers.elastic_ranks.run import RanksRun

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
    elastic : Those of its own contacts that have compliance, shape (c,).
    bodies : Of its own contacts, numbered as in ``places``, shape (c, 2).
    places : Where its bodies stand among those of all ranks, shape (b,); the first ``own`` are its own.
    everywhere : All bodies, those of each rank after those of the one before, shape (n,).
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
    elastic: Mask
    bodies: IntArray
    places: IntArray
    own: int
    everywhere: IntArray
    library: Library | None

    @property
    def sides(self) -> IntArray:
        """Bodies of its own contacts, numbered as they are in the problem, −1 for none, shape (c, 2)."""
        return np.append(self.everywhere[self.places], -1)[self.bodies]


@dataclass(frozen=True, slots=True)
class Given:
    """What a rank has of a problem of these contacts, and of what solves it.

    Attributes
    ----------
    kinds : Stones at its own contacts and those of its seams, kind by kind.
    bed : Of its own contacts and those of its seams, shape (met, d); None: none.
    arrays : Those of the problem of its own contacts and all bodies, by name.
    count : Contacts of all ranks.
    scale, unfolded, proximal : w of its own contacts, the same in linear systems, and what α is relative to,
        shape (c,).
    method : What solves the problem. start : First guess at its own contacts and all bodies; None: none.
    number : Of the run that begins.
    run : Itself where the rank leads, not kept with what ranks keep; None elsewhere.
    """

    kinds: tuple[Kinds, ...]
    bed: FloatArray | None
    arrays: dict[str, Any]
    count: int
    scale: FloatArray
    unfolded: FloatArray
    proximal: FloatArray
    method: ProximalNewton
    start: Start | None
    number: int
    run: weakref.ref[RanksRun] | None
