"""Joint motion: where the faces of joints are now, and how far the blocks have slid on each other.

    points = both_points(model, state)               # of candidates and antagonists
    faces = moved_faces(model, state, JointFaces.of(model), points)
    slides_of(model, state, points)

Faces move rigidly with the antagonists: the strains of elastic blocks are too small to matter here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from masonry_fem.march.coupling import connect
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.joint_faces import JointFaces

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def both_points(model: Model, state: SystemState) -> FloatArray:
    """Where the candidates' and the antagonists' points are now, shape (c, 2, d) [m].

    Parameters
    ----------
    model, state : Of which instant.
    """
    coupling = connect(model)
    points = np.empty_like(model.contacts.points)
    for sides, attachment, own in zip(coupling.sides, coupling.attachments, state.bodies, strict=True):
        points[sides.contact, sides.side] = sides.point + attachment.displacements(own)
    return points


def first_contacts(model: Model) -> IntArray:
    """First contact of each interface, shape (i,).

    A facet of a round face may have none: contacts beside it bear what it bears. It takes the first between
    the same two blocks.
    """
    number = model.contacts.interface
    first = np.full(len(model.interfaces), -1)
    first[number[::-1]] = np.arange(len(number))[::-1]
    bare = np.flatnonzero(first < 0)
    if len(bare) and len(number):
        pairs = np.sort(np.array([one.blocks for one in model.interfaces]), axis=1)
        _, pair = np.unique(pairs, axis=0, return_inverse=True)
        borne = np.flatnonzero(first >= 0)[::-1]
        of_pair = np.zeros(pair.max() + 1, dtype=np.int64)
        of_pair[pair[borne]] = first[borne]
        first[bare] = of_pair[pair[bare]]
    return first


def signs(model: Model) -> FloatArray:
    """−1 where an interface's contacts have its candidate for antagonist, shape (i,)."""
    candidate = np.array([interface.blocks[0] for interface in model.interfaces])
    return np.where(model.contacts.blocks[first_contacts(model), 0] == candidate, 1.0, -1.0)


def moved_faces(model: Model, state: SystemState, faces: JointFaces, points: FloatArray) -> JointFaces:
    """The faces where they are now: they rotate with the antagonists and slide with the candidates.

    Reactions act at the candidates' points; a face that stayed with the antagonist might no longer contain
    its centre of pressure once the candidate has slid.

    Parameters
    ----------
    model, state : Of which instant.
    faces : In the reference configuration.
    points : As ``both_points`` returns them.
    """
    number, count = model.contacts.interface, len(model.interfaces)
    first = first_contacts(model)
    turn = np.einsum("iab,iac->ibc", state.frame[first], model.contacts.frame[first])
    many = np.bincount(number, minlength=count)[:, None]
    ahead = points[:, 0] - points[:, 1]
    ahead -= np.einsum("ca,ca->c", ahead, state.frame[:, 0])[:, None] * state.frame[:, 0]
    before, shift = (
        np.where(many > 0, sum_by(at, number, count) / np.maximum(many, 1), at[first])
        for at in (model.contacts.points[:, 1], points[:, 1] + ahead)
    )

    def carried(points: FloatArray) -> FloatArray:
        arms = points - (before if points.ndim == 2 else before[:, None])
        moved = np.einsum("iab,i...b->i...a", turn, arms)
        result: FloatArray = moved + (shift if points.ndim == 2 else shift[:, None])
        return result

    return replace(
        faces,
        polygon=carried(faces.polygon),
        centroid=carried(faces.centroid),
        normal=np.einsum("iab,ib->ia", turn, faces.normal),
        axes=np.einsum("iab,ikb->ika", turn, faces.axes),
    )


def slides_of(model: Model, state: SystemState, points: FloatArray) -> FloatArray:
    """How far candidates' points have slid over the antagonists' since the start, shape (c, d − 1) [m].

    Parameters
    ----------
    model, state : Of which instant.
    points : As ``both_points`` returns them.
    """
    frame, start = model.contacts.frame, model.contacts.points
    now = np.einsum("cai,ci->ca", state.frame[:, 1:], points[:, 0] - points[:, 1])
    slide: FloatArray = now - np.einsum("cai,ci->ca", frame[:, 1:], start[:, 0] - start[:, 1])
    return slide


def nearest_contacts(model: Model, faces: JointFaces) -> IntArray:
    """The contact of the same interface that is nearest to each corner of its face, shape (i, k).

    Parameters
    ----------
    model : The model.
    faces : Faces of its i joints, with k corners, in the reference configuration.
    """
    number, points = model.contacts.interface, model.contacts.points[:, 1]
    if not len(faces.polygon):
        return np.zeros(faces.polygon.shape[:2], dtype=np.int64)
    apart = 10.0 * float(np.ptp(faces.polygon, axis=(0, 1)).max(initial=0.0)) + 1.0
    tree = cKDTree(np.column_stack([points, apart * number]))
    count, corners, d = faces.polygon.shape
    own = np.repeat(number[first_contacts(model)], corners)
    _, nearest = tree.query(np.column_stack([faces.polygon.reshape(-1, d), apart * own]))
    result: IntArray = np.asarray(nearest, dtype=np.int64).reshape(count, corners)
    return result


def sum_by(values: FloatArray, number: IntArray, count: int) -> FloatArray:
    """Sums over the contacts of each interface, shape (count, ...).

    Parameters
    ----------
    values : One per contact, shape (c, ...).
    number : Interface of each contact, shape (c,).
    count : Number of interfaces.
    """
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, number, values)
    return total
