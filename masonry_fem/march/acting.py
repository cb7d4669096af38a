"""Acting: all that acts on each block of a structure in a step, as arrays that are written.

made = acted(model, step, extents(model.assembly))
acting = made.after.acting
left = imbalance(acting.contact + acting.given, acting.centre)

Whoever has the files can do the same sum; nothing here knows how the step was solved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.bodies.rotation import moment
from masonry_fem.nscd.graphs import lengths

if TYPE_CHECKING:
    from masonry_fem.march.model import Model
    from masonry_fem.march.step import Increment
    from masonry_fem.solid.assembly import Assembly

ROUNDING = 1e-12  # of the largest contact force: a load below it is none


@dataclass(frozen=True, slots=True)
class Acting:
    """What acts on the b blocks of an assembly, and where the c contacts act.

    Forces and moments about the world origin stand side by side: m is 3 in 2D, 6 in 3D.

    Attributes
    ----------
    load, clamp, inertia : Loads, clamped faces, and what inertia takes, shape (b, m) [N, N m].
    held : Sizes of the forces that clamps give to nodes, summed up, shape (b,) [N].
    contact : What contacts give, shape (b, m) [N, N m].
    displaced : Moments of loads and clamps where elastic blocks have gone to, shape (b, 1 or 3) [N m].
    centre : Point of each block to take moments about, shape (b, d) [m]. size : Its extent, (b,) [m].
    arms : Where each contact acts on its candidate and its antagonist as these balance, (c, 2, d) [m]:
        the point itself, for elastic blocks of small kinematics that of the reference.
    solved : False for supports, which take what they are given, shape (b,).
    small : Whether a block deforms and balances in the reference, as small kinematics has it, shape (b,).
    summed : Absolute values of the products that forces of clamps are sums of, summed up, (b,) [N]; or 0.
    """

    load: FloatArray
    clamp: FloatArray
    held: FloatArray
    inertia: FloatArray
    contact: FloatArray
    displaced: FloatArray
    centre: FloatArray
    size: FloatArray
    arms: FloatArray
    solved: np.ndarray
    small: np.ndarray
    summed: FloatArray | float = 0.0

    @property
    def given(self) -> FloatArray:
        """All but contacts, shape (b, m)."""
        return self.load + self.clamp - self.inertia


def extents(assembly: Assembly) -> FloatArray:
    """Diagonal of the box round each block, shape (b,) [m]."""
    found = np.array(
        [float(np.linalg.norm(np.ptp(shape.solid.vertices, axis=0))) for shape in assembly.shapes]
    )
    size: FloatArray = found[assembly.blocks.shape]
    return size


def acted(model: Model, made: Increment, size: FloatArray) -> Increment:
    """The step with what acts on its blocks put into the state that it reached.

    Parameters
    ----------
    model : The structure of b blocks.
    made : A step of it.
    size : Extents of the blocks, shape (b,) [m], as ``extents`` gives them.
    """
    return replace(made, after=replace(made.after, acting=_acting(model, made, size)))


def _acting(model: Model, made: Increment, size: FloatArray) -> Acting:
    count, d = len(size), model.assembly.dimension
    m = 3 if d == 2 else 6
    load, clamp, inertia = np.zeros((3, count, m))
    displaced, centre = np.zeros((count, m - d)), np.zeros((count, d))
    held, summed = np.zeros((2, count))
    solved, small = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    rows = zip(
        model.groups, made.before.bodies, made.after.bodies, made.forces, made.nodal_impulse, strict=True
    )
    for group, start, end, force, nodal in rows:
        solved[group.blocks] = not group.prescribed
        small[group.blocks] = group.deforms and not group.turns
        if group.prescribed:
            continue
        own = group.actions(start, end, force, nodal, made.scheme)
        load[group.blocks], clamp[group.blocks], inertia[group.blocks] = own.load, own.clamp, own.inertia
        displaced[group.blocks], centre[group.blocks] = own.displaced, own.centre
        held[group.blocks], summed[group.blocks] = own.held, own.summed
    arms = np.where(small[model.contacts.blocks][:, :, None], model.contacts.points, made.here.arms)
    contact = contact_wrenches(model.contacts.blocks, arms, made.after.force, count)
    return Acting(load, clamp, held, inertia, contact, displaced, centre, size, arms, solved, small, summed)


def contact_wrenches(blocks: IntArray, arms: FloatArray, force: FloatArray, count: int) -> FloatArray:
    """Forces and moments about the origin that contacts give to each of ``count`` blocks, shape (b, m).

    Parameters
    ----------
    blocks : Candidate and antagonist of each contact, shape (c, 2).
    arms : Where the force acts on each of them, shape (c, 2, d) [m].
    force : On the candidate, world axes; its opposite acts on the antagonist, shape (c, d) [N].
    """
    from masonry_fem.bodies.motions import wrenches  # noqa: PLC0415 - Numba is slow to import

    total: FloatArray = wrenches(blocks, np.ascontiguousarray(arms), np.ascontiguousarray(force), count)
    return total


def imbalance(total: FloatArray, centre: FloatArray) -> FloatArray:
    """What is left of each block's balance, with moments taken about ``centre``, shape (b, m) [N, N m].

    Parameters
    ----------
    total : All that acts on each block, moments about the origin, shape (b, m) [N, N m]; m is 3 in 2D, 6 in
        3D.
    centre : Point of each block to take moments about, shape (b, d) [m].
    """
    left, d = total.copy(), centre.shape[1]
    left[:, d:] -= moment(centre, left[:, :d])
    return left


def relative(left: FloatArray, acting: Acting, largest: float) -> FloatArray:
    """Size of what is left of each block's balance, relative to its load, shape (b,); 0 for supports.

    A moment counts as the force that has this moment at an arm as long as the block. What clamps give counts
    as load where it is more: a block that they squeeze may have no other. A block with less load than the
    mean of the loaded blocks is compared with this mean.

    Parameters
    ----------
    left : What is left of balance, shape (b, m) [N, N m], from ``imbalance``.
    acting : What acts on the blocks.
    largest : Largest contact force [N]; where no block is loaded, it or what clamps give is the scale,
        whichever is more.
    """
    d = acting.centre.shape[1]
    size = np.maximum(lengths(left[:, :d]), lengths(left[:, d:]) / acting.size)
    load = lengths(acting.load[:, :d])
    loaded = acting.solved & (load > ROUNDING * largest)
    load = np.maximum(load, acting.held)
    if loaded.any():
        typical = float(load[loaded].mean())
    else:  # moving supports and clamps are all that loads
        typical = max(largest, float(acting.held.max(initial=0.0)))
    scale = np.maximum(load, typical if typical > 0 else 1.0)
    return np.where(acting.solved, size / scale, 0.0)
