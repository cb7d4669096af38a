"""Determinacy: which forces are facts, that is, the same in all solutions of the last step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.march.model import Model
from masonry_fem.records.told import Told

if TYPE_CHECKING:
    from masonry_fem.march.determinacy import ForceDeterminacy

SHOWN = 50  # interfaces that a summary names
# Components of a support's wrench, in the axes of the scene
WORLD = {2: ("fx", "fy", "mz"), 3: ("fx", "fy", "fz", "mx", "my", "mz")}


class LeftOpen(Told, frozen=True, kw_only=True):
    """An interface whose resultant is not determined as a whole.

    Attributes
    ----------
    interface : Names of its blocks.
    components : Components that are not determined.
    """

    interface: str
    components: tuple[str, ...]


class Determinacy(Told, frozen=True, kw_only=True):
    """Which forces are determined, and the names of those interfaces and supports of which something is not.

    Attributes
    ----------
    reactions : ``least norm`` or ``as solved``; where the last step was not solved it says so, and all else
        is None.
    error : Error of the least-norm reactions, as the contact solver measures it.
    interfaces_determined, interfaces_not_determined : How many.
    not_determined : Interfaces with the components that are not determined, the first 50.
    supports_not_determined : Components that are not determined, by support.
    contacts_unique, contacts_not_unique : How many contacts have the same reaction in every solution.
    """

    reactions: str
    error: float | None = None
    interfaces_determined: int | None = None
    interfaces_not_determined: int | None = None
    not_determined: tuple[LeftOpen, ...] | None = None
    supports_not_determined: dict[str, tuple[str, ...]] | None = None
    contacts_unique: int | None = None
    contacts_not_unique: int | None = None


def determinacy_summary(model: Model, told: ForceDeterminacy) -> Determinacy:
    """What ``summary.json`` says of which forces are determined.

    Parameters
    ----------
    model : The structure.
    told : What its last step determines.
    """
    # loaded only where a scene asks for it
    from masonry_fem.march.determinacy import COMPONENTS  # noqa: PLC0415
    from masonry_fem.output.interface_fields import interface_name  # noqa: PLC0415

    names = COMPONENTS[model.assembly.dimension]
    whole = told.determined.all(axis=1)
    open_ones = np.flatnonzero(~whole).tolist()
    return Determinacy(
        reactions="least norm" if told.least_norm else "as solved",
        error=told.error,
        interfaces_determined=int(whole.sum()),
        interfaces_not_determined=len(open_ones),
        not_determined=tuple(
            LeftOpen(interface=interface_name(model, k), components=_left_open(names, told.determined[k]))
            for k in open_ones[:SHOWN]
        ),
        supports_not_determined={
            name: _left_open(WORLD[model.assembly.dimension], known)
            for name, known in told.supports_determined.items()
            if not known.all()
        },
        contacts_unique=int(told.unique.sum()),
        contacts_not_unique=int((~told.unique).sum()),
    )


def _left_open(names: tuple[str, ...], known: np.ndarray) -> tuple[str, ...]:
    return tuple(name for name, is_known in zip(names, known.tolist(), strict=True) if not is_known)
