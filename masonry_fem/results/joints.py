"""Joints: the parts of a summary that tell how joints are, and which of their forces are facts."""

from __future__ import annotations

import numpy as np

from masonry_fem.march.determinacy import COMPONENTS, ForceDeterminacy
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.interface_fields import interface_name
from masonry_fem.output.interfaces import STATUS_WORDS, interface_forces
from masonry_fem.results.summary import Determinacy, Furthest, Joints, LeftOpen

SHOWN = 50  # interfaces that a summary names
# Components of a support's wrench, in the axes of the scene
WORLD = {2: ("fx", "fy", "mz"), 3: ("fx", "fy", "fz", "mx", "my", "mz")}


def joint_summary(model: Model, state: SystemState) -> Joints:
    """What ``summary.json`` says of the joints of a model that has at least one.

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    """
    told = interface_forces(model, state)
    counts = np.bincount(told.status, minlength=len(STATUS_WORDS)).tolist()

    def most(values: np.ndarray) -> Furthest:
        k = int(values.argmax())
        return Furthest(value=float(values[k]), interface=interface_name(model, k))

    return Joints(
        **{word.replace(" ", "_"): number for word, number in zip(STATUS_WORDS, counts, strict=True)},
        slide=int(told.slides.sum()),
        greatest_opening=most(told.opening),
        greatest_sliding=most(told.sliding[:, 1]),
    )


def determinacy_summary(model: Model, told: ForceDeterminacy) -> Determinacy:
    """What ``summary.json`` says of which forces are determined.

    Parameters
    ----------
    model : The structure.
    told : What its last step determines.
    """
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
