"""Joints: how many joints are in which state, and which opened and slid furthest."""

from __future__ import annotations

import numpy as np

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import tie_forces, without_ties
from masonry_fem.records.told import Told


class Furthest(Told, frozen=True, kw_only=True):
    """The greatest or least value of all joints.

    Attributes
    ----------
    value : Opening or sliding [m], share of the way to the edge, or friction that is left.
    interface : Names of the joint's blocks.
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
        return Furthest(value=float(values[k]), interface=interface_name(model, int(told.faces.first[k])))

    def first(values: np.ndarray, sign: float) -> Furthest | None:
        known = np.where(np.isnan(values), -np.inf, sign * values)
        k = int(known.argmax())
        if np.isinf(known[k]):
            return None
        return Furthest(value=float(values[k]), interface=interface_name(model, int(told.faces.first[k])))

    return Joints(
        **{word.replace(" ", "_"): number for word, number in zip(STATUS_WORDS, counts, strict=True)},
        slide=int(told.slides.sum()),
        greatest_opening=most(told.opening),
        greatest_sliding=most(told.sliding[:, 1]),
        nearest_edge=first(told.edge_share, 1.0),
        least_margin=first(told.sliding_margin, -1.0),
    )


class TieTold(Told, frozen=True, kw_only=True):
    """What a straight part of a tie bears.

    Attributes
    ----------
    force : Tension; 0 where it is slack [N].
    stress : Over its cross-section [Pa].
    elongation : From its length without force; less than 0 where it is slack [m].
    strain : The same over that length. plastic_strain : Part of it that stays.
    utilisation : Force over that at which it yields further; None where it never does.
    snapped : Whether it has.
    """

    force: float
    stress: float
    elongation: float
    strain: float
    plastic_strain: float
    utilisation: float | None = None
    snapped: bool


def ties_told(model: Model, state: SystemState) -> dict[str, TieTold] | None:
    """What ``summary.json`` says of ties; None where there are none.

    Parameters
    ----------
    model : The structure. state : A state of it.
    """
    told = tie_forces(model, state)
    if told is None:
        return None
    return {
        name: TieTold(
            force=float(told.force[k]),
            stress=float(told.stress[k]),
            elongation=float(told.elongation[k]),
            strain=float(told.strain[k]),
            plastic_strain=float(told.plastic[k]),
            utilisation=float(told.utilisation[k]) if told.yields[k] else None,
            snapped=bool(told.snapped[k]),
        )
        for k, name in enumerate(told.names)
    }
