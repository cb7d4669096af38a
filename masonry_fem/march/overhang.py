"""Overhang: blocks that bear on each other past the end of a face, as one has slid off it.

tell_overhang(model, made)
pairs = slid_off(model, coupling.placement(state.bodies), state, ends)

A contact keeps its point on the candidate. Once that has slid past the end of the antagonist's face there is
nothing behind it. The joints of a scene are those that it begins with: blocks slide on along them, beyond the
end of a face, too. In time a joint is one no more where the blocks have turned by more than faces in contact
may, nor are contacts that blocks have made on the way: these are found anew (``renewal``). In statics all
stay: that a point is past the end says little there, as others bear; where the force of all of them is, the
block is held by nothing, and that is told.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.contact.posed import Posed
from masonry_fem.contact.surface import surfaces_of
from masonry_fem.march.acting import extents
from masonry_fem.march.coupling import Placement
from masonry_fem.march.model import Model
from masonry_fem.march.motion import nearest_motions
from masonry_fem.march.step import Increment
from masonry_fem.records.remark import first_few, remark
from masonry_fem.solid.assembly import Assembly

PAST = 1e-2  # of the smaller block: how far past the end of a face may be borne without a word
SHOWN = 3  # pairs that are named


@dataclass(frozen=True, slots=True)
class Ends:
    """Where the faces of an assembly's convex blocks end; others are not looked at.

    Attributes
    ----------
    on_face, normal : A point and the outward normal of each face, shape (b, f, d), in the reference [m].
    convex : Whether a block is, shape (b,).
    size : Extents of the blocks, shape (b,) [m].
    """

    on_face: FloatArray
    normal: FloatArray
    convex: np.ndarray
    size: FloatArray

    @classmethod
    def of(cls, assembly: Assembly) -> Self:
        """Of all blocks."""
        posed = Posed.of(assembly, surfaces_of(assembly))
        return cls(posed.on_face, posed.normal, posed.convex, extents(assembly))

    def allowed(self, pairs: IntArray) -> FloatArray:
        """How far past the end two blocks may bear on each other, pair by pair, shape (k,) [m]."""
        far: FloatArray = PAST * self.size[pairs].min(axis=1)
        return far

    def past(self, blocks: IntArray, points: FloatArray) -> FloatArray:
        """How far points are outside blocks, −inf where these are not convex, shape (k,) [m].

        Parameters
        ----------
        blocks : Numbers, shape (k,).
        points : In the planes of their faces, in the reference, shape (k, d) [m].
        """
        heights = np.einsum("kfi,kfi->kf", points[:, None] - self.on_face[blocks], self.normal[blocks])
        return np.where(self.convex[blocks], heights.max(axis=1, initial=-np.inf), -np.inf)


def tell_overhang(model: Model, made: Increment) -> None:
    """Say which blocks bear past the end of a face where statics ends; what falls touches only in passing.

    Parameters
    ----------
    model : The structure. made : The last step.
    """
    if made.scheme.inertia:
        return
    pairs, far = past_ends(model, made)
    if not len(pairs):
        return
    blocks = model.assembly.blocks
    named = [
        f"'{blocks[a].name}' on '{blocks[b].name}' by {way:.2g} m"
        for (a, b), way in zip(pairs.tolist(), far.tolist(), strict=True)
    ]
    cure = "contact.update = 'redetect' finds contacts of rigid blocks anew on the way"
    if model.update is not None:
        cure = "take smaller contact.every, or make these blocks rigid"
    remark(
        "overhang",
        f"contacts bear past the end of a face: {first_few(named, SHOWN, noun='pairs')}; nothing is there to "
        f"bear, so do not rely on what these blocks do; {cure}",
        *(blocks[block].name for block in pairs[0].tolist()),
    )


def past_ends(model: Model, made: Increment) -> tuple[IntArray, FloatArray]:
    """Joints whose force is past the end of a convex face, the farthest first.

    Parameters
    ----------
    model : The structure. made : A step of it.

    Returns
    -------
    Candidates and antagonists, shape (k, 2), and how far past the end, shape (k,) [m].
    """
    contacts, here = model.contacts, made.here
    bears = np.flatnonzero((made.impulse[:, 0] > 0) & ~contacts.tied)
    if not bears.size:
        return np.zeros((0, 2), dtype=np.int64), np.zeros(0)
    ends = Ends.of(model.assembly)
    # where the force of a joint acts, on the antagonist in the reference
    slid = here.offset[bears].copy()
    slid[:, 0] = 0.0
    point = contacts.points[bears, 1] + np.einsum("ci,cij->cj", slid, contacts.frame[bears])
    sides = np.column_stack([contacts.interface[bears], contacts.blocks[bears]])
    joints, of = np.unique(sides, axis=0, return_inverse=True)
    force = made.impulse[bears, 0]
    total = np.bincount(of, force)
    middle = np.stack([np.bincount(of, force * axis) for axis in point.T], axis=1) / total[:, None]
    pairs = joints[:, 1:]
    far = ends.past(pairs[:, 1], middle)
    found = np.flatnonzero(far > ends.allowed(pairs))
    found = found[np.argsort(-far[found], kind="stable")]
    return pairs[found], far[found]


def slid_off(
    model: Model, here: Placement, bodies: tuple[Any, ...], held: np.ndarray, ends: Ends
) -> IntArray:
    """Pairs of blocks of which a contact is past the end of a face, the lower number first, shape (k, 2).

    Not where both touched there at the start and have turned by no more than ``meet.angle``. Whether it
    bears does not matter: it would as soon as it closes. Where contacts are, the nearest rigid motions tell,
    since blocks that spread do not slide.

    Parameters
    ----------
    model : The structure of c contacts and b blocks. here : Where the contacts are.
    bodies : Body states there.
    held : Contacts that cohesion holds, shape (c,): their pairs stay as they are.
    ends : Of the model's blocks.
    """
    contacts = model.contacts
    assert model.meet is not None
    far = np.linalg.norm(here.offset[:, 1:], axis=1) > ends.allowed(contacts.blocks)
    gone = np.flatnonzero(far & ~contacts.tied)
    if not gone.size:
        return np.zeros((0, 2), dtype=np.int64)
    rotation, translation = nearest_motions(model, bodies)
    points = contacts.points
    met = np.linalg.norm(points[gone, 0] - points[gone, 1], axis=1) > ends.allowed(contacts.blocks[gone])
    gone = gone[met | (_turned(rotation, contacts.blocks[gone]) > model.meet.angle)]
    (candidate, antagonist), points = contacts.blocks[gone].T, points[gone]
    world = np.einsum("cij,cj->ci", rotation[candidate], points[:, 0]) + translation[candidate]
    back = np.einsum("cji,cj->ci", rotation[antagonist], world - translation[antagonist])
    normal = contacts.frame[gone, 0]
    height = np.einsum("ci,ci->c", back - points[:, 1], normal)
    past = ends.past(antagonist, back - height[:, None] * normal) > ends.allowed(contacts.blocks[gone])
    sides, count = np.sort(contacts.blocks, axis=1), len(ends.size)
    keys = sides @ np.array([count, 1])
    off = np.setdiff1d(keys[gone[past]], keys[held])
    pairs: IntArray = np.stack(np.divmod(off, count), axis=1)
    return pairs


def _turned(rotation: FloatArray, pairs: IntArray) -> FloatArray:
    """By how much two blocks have turned against each other, pair by pair, shape (k,) [degrees].

    Parameters
    ----------
    rotation : Of all blocks, shape (b, d, d). pairs : Shape (k, 2).
    """
    trace = np.einsum("kij,kij->k", *rotation[pairs.T])  # 1 + 2 cos φ, in 2D 2 cos φ
    cosine = np.clip(0.5 * (trace - (rotation.shape[1] - 2)), -1.0, 1.0)
    angle: FloatArray = np.degrees(np.arccos(cosine))
    return angle
