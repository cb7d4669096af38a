"""Mean stress: the stress of each stone in the mean over its volume, of rigid stones from their forces.

    stress, volume = mean_stress(model, state)      # (b, 6) [Pa], (b,) [m³]

What forces of all kinds do to a body in balance decides its mean stress, whatever it is made of
(Signorini): ∫ σ dV = Σ f ⊗ (x − c), symmetric, as its own weight has no part in it. So the mean stress of a
rigid stone is known as well as its contact forces are; how the stress varies within it is not.

References
----------
Truesdell, Toupin, The classical field theories, Handbuch der Physik III/1 (1960), section 220.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.loads import external_forces
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState

FloatArray = NDArray[np.float64]

_ROW, _COLUMN = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)  # of (xx, yy, zz, xy, yz, xz)


def mean_stress(model: Model, state: SystemState) -> tuple[FloatArray, FloatArray]:
    """Mean stress of each stone, world axes, and its volume; NaN for supports.

    Of plane scenes rigid stones have no σ_zz. Where there is inertia the spin of rigid stones is left out.

    Parameters
    ----------
    model : The structure of b blocks.
    state : A state of it.

    Returns
    -------
    Shapes (b, 6) [Pa] and (b,) [m³; m² in 2D].
    """
    count, d = len(model.assembly.blocks), model.assembly.dimension
    stress, volume = np.full((count, 6), np.nan), np.full(count, np.nan)
    given: FloatArray | None = None
    forces = external_forces(model, state.time, state.bodies)
    for group, moved, force in zip(model.groups, state.bodies, forces, strict=True):
        if group.prescribed:
            continue
        field = group.stress(moved)
        if field is not None:
            volume[group.blocks] = field.weight.sum()
            stress[group.blocks] = np.einsum("bcgs,cg->bs", field.gauss, field.weight) / field.weight.sum()
            continue
        blocks = model.assembly.blocks
        shapes, of = np.unique(blocks.shape[group.blocks], return_inverse=True)
        solids = [model.assembly.shapes[shape].solid.mass_properties() for shape in shapes.tolist()]
        middle = np.array([solid.centroid for solid in solids])[of]
        centre = np.einsum("bij,bj->bi", blocks.rotation[group.blocks], middle)
        centre += blocks.translation[group.blocks]
        turn, shift = group.motion(moved)
        now = np.einsum("bij,bj->bi", turn, centre) + shift
        given = contact_moments(model, state) if given is None else given
        # Σ f ⊗ x of contacts less that of their resultant at the centroid; loads come as (x − c) ⊗ f
        total, resultant = given[group.blocks, :-1], given[group.blocks, -1]
        total = total - resultant[:, :, None].swapaxes(1, 2) * now[:, :, None]
        total = total + turn @ force[:, d:].reshape(-1, d, d)
        volume[group.blocks] = np.array([solid.volume for solid in solids])[of]
        mean = np.zeros((len(now), 3, 3))
        mean[:, :d, :d] = 0.5 * (total + total.swapaxes(1, 2)) / volume[group.blocks, None, None]
        stress[group.blocks] = mean[:, _ROW, _COLUMN]
    return stress, volume


def contact_moments(model: Model, state: SystemState) -> FloatArray:
    """Σ x ⊗ f of the contact forces on each block and, as a last row, their resultant, shape (b, d + 1, d).

    Parameters
    ----------
    model, state : Of which instant.
    """
    blocks, force = model.contacts.blocks, state.force
    arms = np.repeat(state.points[:, None], 2, axis=1) if state.acting is None else state.acting.arms
    total = np.zeros((len(model.assembly.blocks), force.shape[1] + 1, force.shape[1]))
    for side, sign in ((0, 1.0), (1, -1.0)):
        own = sign * force
        np.add.at(total[:, :-1], blocks[:, side], arms[:, side, :, None] * own[:, None, :])
        np.add.at(total[:, -1], blocks[:, side], own)
    return total
