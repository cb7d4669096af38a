"""Joints: how many joints are in which state, and which opened and slid furthest."""

from __future__ import annotations

import numpy as np

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import without_ties
from masonry_fem.records.told import Told


class Furthest(Told, frozen=True, kw_only=True):
    """The greatest or least value of all interfaces.

    Attributes
    ----------
    value : Opening or sliding [m], share of the way to the edge, or friction that is left.
    interface : Names of the interface's blocks.
    """

    value: float
    interface: str


class Joints(Told, frozen=True, kw_only=True):
    """How many joints are in which state.

    Attributes
    ----------
    open, closed, middle_third, cracked, hinge, held : Numbers of joints, each in one of these states.
    slide : Number of joints that slide, in whichever state.
    greatest_opening, greatest_sliding : How far, and which joint.
    nearest_edge : The centre of pressure that is nearest to its face's outline: 0 middle, 1 outline.
    least_margin : Least μ − T/N of a joint that presses. Both None where no joint does.
    """

    open: int
    closed: int
    middle_third: int
    cracked: int
    hinge: int
    held: int
    slide: int
    greatest_opening: Furthest
    greatest_sliding: Furthest
    nearest_edge: Furthest | None = None
    least_margin: Furthest | None = None


def joint_summary(model: Model, state: SystemState) -> Joints:
    """What ``summary.json`` says of the joints of a model that has at least one.

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    """
    # loaded only where a scene asks for joints
    from masonry_fem.output.interface_fields import interface_name  # noqa: PLC0415
    from masonry_fem.output.interfaces import STATUS_WORDS, interface_forces  # noqa: PLC0415

    model, state = without_ties(model, state)
    told = interface_forces(model, state)
    counts = np.bincount(told.status, minlength=len(STATUS_WORDS)).tolist()

    def most(values: np.ndarray) -> Furthest:
        k = int(values.argmax())
        return Furthest(value=float(values[k]), interface=interface_name(model, k))

    def first(values: np.ndarray, sign: float) -> Furthest | None:
        known = np.where(np.isnan(values), -np.inf, sign * values)
        k = int(known.argmax())
        if np.isinf(known[k]):
            return None
        return Furthest(value=float(values[k]), interface=interface_name(model, k))

    return Joints(
        **{word.replace(" ", "_"): number for word, number in zip(STATUS_WORDS, counts, strict=True)},
        slide=int(told.slides.sum()),
        greatest_opening=most(told.opening),
        greatest_sliding=most(told.sliding[:, 1]),
        nearest_edge=first(told.edge_share, 1.0),
        least_margin=first(told.sliding_margin, -1.0),
    )
