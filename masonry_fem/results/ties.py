"""Ties: what each one bears at the end of a run."""

from __future__ import annotations

from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import tie_forces
from masonry_fem.records.told import Told


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
