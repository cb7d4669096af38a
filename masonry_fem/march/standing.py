"""Standing: all that a march knows between two steps, so that another one goes on from there, bit for bit.

march(model, strategy, settings, keeper=keeper)                    # keeper.between(standing), each step
march(model, strategy, settings, going_on=(model, standing))       # the same steps from there on
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from masonry_fem.contact.contacts import Contacts
from masonry_fem.contact.depth import Overlaps
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.march.ledger import Ledger
from masonry_fem.march.state import SystemState


@dataclass(frozen=True, slots=True)
class Worst:
    """The worst value of a figure.

    Attributes
    ----------
    value : The value. share : What ranks it.
    blocks : Their names. step : In which it was.
    """

    value: float = 0.0
    blocks: tuple[str, ...] = ()
    step: int = 0
    share: float = 0.0


@dataclass(frozen=True, slots=True)
class Seen:
    """What a witness has seen.

    Attributes
    ----------
    balance, turning, overlap, last : Its figures, the last one of the last step.
    looked : Where the nodes of all blocks were at its last look for overlaps, shape (n, d) [m].
    borne : Overlaps that it bears.
    """

    balance: Worst
    turning: Worst
    overlap: Worst
    last: Worst
    looked: np.ndarray
    borne: Overlaps


@dataclass(frozen=True, slots=True)
class Found:
    """Contacts that a march found on its way.

    Attributes
    ----------
    interfaces : Common faces of blocks. contacts : Points on them.
    records : Number of the scene's joint record of each interface.
    """

    interfaces: Interfaces
    contacts: Contacts
    records: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Standing:
    """A march between two steps.

    Attributes
    ----------
    done : Number of steps of its schedule that are made. largest : Norm of its largest impulses [N s].
    start, state : Where it began, and where it is, velocities as the next step begins with.
    found : Its contacts; None: those of the start.
    ledger : Energies so far. seen : What its witness keeps. troubles : What its steps left undone, by name.
    seconds : CPU time by phase [s].
    factored : Its contact solver has given up iterations for factors.
    warmed : Strains by temperature of the blocks of each group, shape (b,); None where there are none.
    ages : Whether materials change on its way.
    """

    done: int
    largest: float
    start: SystemState
    state: SystemState
    found: Found | None
    ledger: Ledger
    seen: Seen
    troubles: dict[str, Any]
    seconds: dict[str, float]
    factored: bool
    warmed: tuple[np.ndarray | None, ...] = ()
    ages: bool = False


class Keep(Protocol):
    """Who is given what a march knows."""

    def between(self, standing: Standing) -> None:
        """Before each step but the first."""
        ...

    def reached(self, standing: Standing | None) -> None:
        """After the last step, before anything is told of it; None where no more steps can be made."""
        ...
