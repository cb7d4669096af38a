"""State of a whole structure at an instant; replaced by each step, never changed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from masonry_fem.joints.state import JointState
    from masonry_fem.march.acting import Acting

FloatArray = NDArray[np.float64]

# bonded: not pressed together, yet held by the cohesion of the joint
OPEN, STICK, SLIP, BONDED = 0, 1, 2, 3
STATUS_NAMES = ("open", "stick", "slip", "bonded")


@dataclass(frozen=True, slots=True)
class TrendState:
    """How a step of statics went on, by unit of the load factor: the next one may do so, too.

    Attributes
    ----------
    growth : Of ``reaction``, in its frames [N], shape (c, d).
    rigid, elastic : U and u_el of each group, (b, m) and (b, n) [m kg^½, m]; None where blocks do not deform.
    """

    growth: FloatArray
    rigid: tuple[FloatArray, ...]
    elastic: tuple[FloatArray | None, ...]


@dataclass(frozen=True, slots=True)
class SystemState:
    """State of a structure at ``time``: motion of the bodies, forces and gaps at the c contacts.

    Attributes
    ----------
    time : Time [s] (load factor in statics).
    index : Number of steps made.
    bodies : One state for each body group, in the model's order.
    reaction : Force on the candidate, local frame (n, t1[, t2]), mean over the last step [N], shape (c, d).
    velocity : Relative velocity at the end of the last step, local frame [m/s], shape (c, d).
    gap : Signed distance [m], shape (c,).
    status : OPEN, STICK, SLIP or BONDED, shape (c,).
    frame : Current contact frames, shape (c, d, d).
    points : Current contact points (on the candidate), world, shape (c, d) [m].
    reaction_frame : Frames in which ``reaction`` and ``velocity`` are given, shape (c, d, d): those of the
        end of the last step in statics, of its start where there is inertia.
    jump : Displacement jump since bonding ũ, as the joint laws see it [m], shape (c, d).
    joints : What the joint laws remember.
    rigid_velocity : U of the solved bodies in the last step, a first guess for the next, shape (b, m);
        None before the first.
    held : Overlaps that could not be driven apart are held for so many steps more, of so many.
    acting : What acted on the blocks in the last step; None until a march has seen it.
    trend : How the last step went on; None where it was not one of statics.
    """

    time: float
    index: int
    bodies: tuple[Any, ...]
    reaction: FloatArray
    velocity: FloatArray
    gap: FloatArray
    status: NDArray[np.int8]
    frame: FloatArray
    points: FloatArray
    reaction_frame: FloatArray
    jump: FloatArray
    joints: JointState
    rigid_velocity: FloatArray | None = None
    held: tuple[int, int] = (0, 0)
    acting: Acting | None = None
    trend: TrendState | None = None

    @property
    def force(self) -> FloatArray:
        """``reaction`` in world axes, shape (c, d) [N]."""
        force: FloatArray = np.einsum("cij,ci->cj", self.reaction_frame, self.reaction)
        return force
