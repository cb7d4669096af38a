"""Deformation: by how much elastic blocks are strained and turned as a whole, and whether that is small.

    beyond = beyond_small(model, state)       # a sentence, or None
    share = second_order(model, bodies)       # what is not known of places, of a block's size

Elastic blocks are computed for small strains, and for small turns where a clamp or fixed contacts keep their
kinematics small. Where a stiffness is given in MPa for Pa, or a
mechanism runs on, equations hold to rounding and mean nothing; no other measure tells.
"""

from __future__ import annotations

import math

import numpy as np

from masonry_fem.bodies.base import FloatArray, Shown
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState

STRAIN = 0.05  # mean strain of a block from which it is no longer small: lengths are off by as much


def beyond_small(model: Model, state: SystemState) -> str | None:
    """Which elastic block is strained or turned too far for its kinematics, in words; None where none is.

    Small kinematics stretches a block that turns by φ by φ²/2.

    Parameters
    ----------
    model : The structure.
    state : A state of it.
    """
    parts = []
    strain, strained, turn, turned = _greatest(model, state)
    if not strain <= STRAIN:
        parts.append(f"'{strained}' is strained by {strain:.2g}")
    if not 0.5 * turn**2 <= STRAIN:
        parts.append(f"'{turned}' has turned by {math.degrees(turn):.3g} degrees")
    return " and ".join(parts) or None


def _greatest(model: Model, state: SystemState) -> tuple[float, str, float, str]:
    """Greatest mean strain and turn [rad] of the elastic blocks, each with its block's name."""
    strain, strained, turn, turned = 0.0, "", 0.0, ""
    for group, own in zip(model.groups, state.bodies, strict=True):
        if not group.deforms:
            continue
        gradient = _mean_gradients(group, own)
        if group.turns:  # what is left when the blocks are turned back is strain
            back, one = np.swapaxes(group.motion(own)[0], 1, 2), np.eye(gradient.shape[1])
            gradient = back @ (one + gradient) - one
        across = np.swapaxes(gradient, 1, 2)
        stretched = np.abs(np.linalg.eigvalsh(0.5 * (gradient + across))).max(axis=1)
        spun = np.linalg.norm(0.5 * (gradient - across), axis=(1, 2)) / math.sqrt(2)
        names = [
            model.assembly.blocks.names[group.blocks[int(values.argmax())]] for values in (stretched, spun)
        ]
        if not stretched.max() <= strain:
            strain, strained = float(stretched.max()), names[0]
        if not spun.max() <= turn:
            turn, turned = float(spun.max()), names[1]
    return strain, strained, turn, turned


def second_order(model: Model, bodies: tuple[object, ...]) -> float:
    """Square of the greatest mean displacement gradient of the elastic blocks; 0 without such blocks.

    Small kinematics knows places to this share of a block's size, and no better.

    Parameters
    ----------
    model : The structure.
    bodies : One state a body group, in the model's order.
    """
    greatest = 0.0
    for group, own in zip(model.groups, bodies, strict=True):
        if group.deforms and not group.turns:
            norms = np.linalg.norm(_mean_gradients(group, own), ord=2, axis=(1, 2))
            greatest = max(greatest, float(norms.max()))
    return greatest**2


def _mean_gradients(group: Shown, state: object) -> FloatArray:
    """Displacement gradients of the affine fields nearest to the blocks' nodal displacements, (b, d, d)."""
    start = group.places.reshape(len(group.blocks), -1, group.places.shape[1])
    moved = group.displacements(state).reshape(start.shape)
    arms, moved = (values - values.mean(axis=1, keepdims=True) for values in (start, moved))
    across = np.swapaxes(arms, 1, 2)
    return np.swapaxes(np.linalg.solve(across @ arms, across @ moved), 1, 2)
