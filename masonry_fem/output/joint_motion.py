"""Joint motion: where the faces of joints are now, and how far the blocks have slid on each other.

    points = both_points(model, state)               # of candidates and antagonists
    faces = moved_faces(model, state, JointFaces.of(model), points, nearest)
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


def joints_of(model: Model, faces: JointFaces) -> IntArray:
    """The joint that each contact is in, shape (c,).

    Parameters
    ----------
    model : The model. faces : Of its joints.
    """
    return faces.facets.joint[model.contacts.interface]


def signs(model: Model, faces: JointFaces) -> FloatArray:
    """−1 where a contact has its joint's candidate for antagonist, shape (c,).

    Parameters
    ----------
    model : The model. faces : Of its joints.
    """
    candidate = model.interfaces.blocks[faces.first, 0]
    return np.where(model.contacts.blocks[:, 0] == candidate[joints_of(model, faces)], 1.0, -1.0)


def moved_faces(
    model: Model, state: SystemState, faces: JointFaces, points: FloatArray, nearest: IntArray
) -> JointFaces:
    """The faces where they are now: they rotate with the antagonists and slide with the candidates.

    Reactions act at the candidates' points; a face that stayed with the antagonist might no longer contain
    its centre of pressure once the candidate has slid. Corners of facets go with their nearest contacts.

    Parameters
    ----------
    model, state : Of which instant.
    faces : In the reference configuration.
    points : As ``both_points`` returns them.
    nearest : As ``nearest_contacts`` returns them.
    """
    number, count = joints_of(model, faces), len(faces.first)
    turned = np.einsum("kab,kac->kbc", state.frame, model.contacts.frame)
    turn = turned[np.unique(number, return_index=True)[1]]
    many = np.bincount(number)[:, None]
    ahead = points[:, 0] - points[:, 1]
    ahead -= np.einsum("ca,ca->c", ahead, state.frame[:, 0])[:, None] * state.frame[:, 0]
    before, shift = (
        sum_by(at, number, count) / many for at in (model.contacts.points[:, 1], points[:, 1] + ahead)
    )
    away = faces.facets.polygon - model.contacts.points[nearest, 1]
    moved = np.einsum("ikab,ikb->ika", turned[nearest], away) + (points[:, 1] + ahead)[nearest]
    return replace(
        faces,
        facets=replace(faces.facets, polygon=moved),
        centroid=np.einsum("iab,ib->ia", turn, faces.centroid - before) + shift,
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
    """The contact of the same joint that is nearest to each corner of a facet, shape (i, k).

    Parameters
    ----------
    model : The model.
    faces : Faces of its joints, with i facets of k corners, in the reference configuration.
    """
    polygon, points = faces.facets.polygon, model.contacts.points[:, 1]
    if not len(polygon):
        return np.zeros(polygon.shape[:2], dtype=np.int64)
    apart = 10.0 * float(np.ptp(polygon, axis=(0, 1)).max(initial=0.0)) + 1.0
    tree = cKDTree(np.column_stack([points, apart * joints_of(model, faces)]))
    count, corners, d = polygon.shape
    own = np.repeat(faces.facets.joint, corners)
    _, nearest = tree.query(np.column_stack([polygon.reshape(-1, d), apart * own]))
    result: IntArray = np.asarray(nearest, dtype=np.int64).reshape(count, corners)
    return result


def sum_by(values: FloatArray, number: IntArray, count: int) -> FloatArray:
    """Sums over the contacts of each joint, shape (count, ...).

    Parameters
    ----------
    values : One per contact, shape (c, ...).
    number : Joint of each contact, shape (c,).
    count : Number of joints.
    """
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, number, values)
    return total
