"""Promotion: which stones became inelastic on the way, told as a remark."""

from __future__ import annotations

import numpy as np

from masonry_fem.bodies.base import nonlinear
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.records.remark import first_few, remark

SHOWN = 5  # stones that the remark's sentence names


def tell_promoted(model: Model, state: SystemState) -> None:
    """Remark on the stones of fidelity ``auto`` that became inelastic, and when.

    Parameters
    ----------
    model : The structure. state : Where its march ended.
    """
    times = {
        model.assembly.blocks[block].name: since
        for group, own in zip(model.groups, state.bodies, strict=True)
        if group.nonlinear and (known := nonlinear(group).promoted(own)) is not None
        for block, since in zip(group.blocks.tolist(), known.tolist(), strict=True)
    }
    names = sorted(
        (name for name, since in times.items() if np.isfinite(since)), key=lambda name: times[name]
    )
    if not names:
        return
    shown = first_few((f"'{name}' at t = {times[name]:.4g}" for name in names), SHOWN)
    remark(
        "promoted",
        f"{len(names)} of {len(times)} stones of fidelity 'auto' became inelastic, as their stress came to "
        f"promote_at of that of first yield: {shown}",
        *names,
    )
