"""Deformation: by how much elastic blocks are strained and turned as a whole, and whether that is small.

    beyond = beyond_small(model, state)       # a sentence, or None

Elastic blocks are computed for small strains and small turns. Where a stiffness is given in MPa for Pa, or a
mechanism runs on, equations hold to rounding and mean nothing; no other measure tells.
"""

from __future__ import annotations

import math

import numpy as np

from masonry_fem.bodies.base import BodyGroup, FloatArray
from masonry_fem.dynamics.model import Model
from masonry_fem.dynamics.state import SystemState

STRAIN = 0.05  # mean strain of a block from which it is no longer small: lengths are off by as much
TURN = 0.1  # rad: lever arms are off by half of its square, and by what the turn itself adds


def beyond_small(model: Model, state: SystemState) -> str | None:
    """What is strained or turned too far for the kinematics of elastic blocks; None where nothing is."""
    parts = []
    strain, strained, turn, turned = _greatest(model, state)
    if not strain <= STRAIN:
        parts.append(f"'{strained}' is strained by {strain:.2g}")
    if not turn <= TURN:
        parts.append(f"'{turned}' has turned by {math.degrees(turn):.3g} degrees")
    return " and ".join(parts) or None


def _greatest(model: Model, state: SystemState) -> tuple[float, str, float, str]:
    """Greatest mean strain and turn [rad] of the elastic blocks, each with its block's name."""
    strain, strained, turn, turned = 0.0, "", 0.0, ""
    for group, own in zip(model.groups, state.bodies, strict=True):
        if group.prescribed or group.cell == "polytope":
            continue
        for body, block in enumerate(group.blocks.tolist()):
            gradient = _mean_gradient(group, own, body)
            name = model.assembly.blocks[block].name
            stretched = float(np.abs(np.linalg.eigvalsh(0.5 * (gradient + gradient.T))).max())
            spun = float(np.linalg.norm(0.5 * (gradient - gradient.T))) / math.sqrt(2)
            if not stretched <= strain:
                strain, strained = stretched, name
            if not spun <= turn:
                turn, turned = spun, name
    return strain, strained, turn, turned


def _mean_gradient(group: BodyGroup, state: object, body: int) -> FloatArray:
    """Displacement gradient of the affine field nearest to a block's nodal displacements, (d, d)."""
    nodes, moved = group.nodes(body), group.displacement_field(state, body)
    arms = nodes - nodes.mean(axis=0)
    gradient: FloatArray = np.linalg.lstsq(arms, moved - moved.mean(axis=0), rcond=None)[0].T
    return gradient
