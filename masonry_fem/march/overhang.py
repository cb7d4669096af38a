"""Overhang: pairs of blocks that bear on each other past the end of a face, as one has slid off it.

    pairs = Overhang.of(assembly).past(model.contacts, placement, impulse)

A contact keeps its point on the candidate. Once that has slid past the end of the antagonist's face there is
nothing behind it: the face's end bears, further inwards on the candidate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.contact.contacts import Contacts
from masonry_fem.contact.posed import Posed
from masonry_fem.contact.surface import surfaces_of
from masonry_fem.march.coupling import Placement
from masonry_fem.solid.assembly import Assembly

PAST = 1e-2  # of the smaller block's least extent: how far past the end of a face nothing need bear


@dataclass(frozen=True, slots=True)
class Overhang:
    """Where the faces of an assembly's convex blocks end; others are not looked at.

    Attributes
    ----------
    on_face, normal : A point and the outward normal of each face, shape (b, f, d), in the reference.
    convex : Whether a block is, shape (b,).
    """

    on_face: FloatArray
    normal: FloatArray
    convex: np.ndarray

    @classmethod
    def of(cls, assembly: Assembly) -> Self:
        """Of all blocks."""
        posed = Posed.of(assembly, surfaces_of(assembly))
        return cls(posed.on_face, posed.normal, posed.convex)

    def past(self, contacts: Contacts, here: Placement, impulse: FloatArray, sizes: FloatArray) -> IntArray:
        """Pairs of blocks of which a contact bears past the end of a face, the lower number first, (m, 2).

        Parameters
        ----------
        contacts : All c of them. here : Where they are.
        impulse : In the local frames, shape (c, d) [N s].
        sizes : Least extents of the blocks, shape (b,) [m].
        """
        bears = np.flatnonzero((impulse[:, 0] > 0) & self.convex[contacts.blocks[:, 1]])
        slid = here.offset[bears].copy()
        slid[:, 0] = 0.0  # along the face
        antagonist = contacts.blocks[bears, 1]
        point = contacts.points[bears, 1] + np.einsum("ci,cij->cj", slid, contacts.frame[bears])
        heights = np.einsum("cfj,cfj->cf", point[:, None] - self.on_face[antagonist], self.normal[antagonist])
        pairs = np.sort(contacts.blocks[bears], axis=1)
        beyond = heights.max(axis=1) > PAST * sizes[pairs].min(axis=1)
        found: IntArray = np.unique(pairs[beyond], axis=0)
        return found
