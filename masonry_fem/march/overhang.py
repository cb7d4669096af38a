"""Overhang: blocks that bear on each other past the end of a face, as one has slid off it.

tell_overhang(model, made)

A contact keeps its point on the candidate. Once that has slid past the end of the antagonist's face there is
nothing behind it. That a point is past the end says little, as others bear; where the force of all of them
is, the block is held by nothing.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.contact.posed import Posed
from masonry_fem.contact.surface import surfaces_of
from masonry_fem.march.acting import extents
from masonry_fem.march.model import Model
from masonry_fem.march.step import Increment
from masonry_fem.records.remark import first_few, remark

PAST = 1e-2  # of the smaller block: how far past the end of a face may be borne without a word
SHOWN = 3  # pairs that are named


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
    assembly = model.assembly
    if not bears.size:
        return np.zeros((0, 2), dtype=np.int64), np.zeros(0)
    posed = Posed.of(assembly, surfaces_of(assembly))
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
    antagonist = pairs[:, 1]
    ends = np.einsum(
        "jfi,jfi->jf", middle[:, None] - posed.on_face[antagonist], posed.normal[antagonist]
    ).max(axis=1)
    size = extents(assembly)[pairs].min(axis=1)
    found = np.flatnonzero(posed.convex[antagonist] & (ends > PAST * size))
    found = found[np.argsort(-ends[found], kind="stable")]
    return pairs[found], ends[found]
