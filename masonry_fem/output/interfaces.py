"""Interface forces: what each joint between two blocks carries and how far it has opened and slid.

    told = interface_forces(model, state)
    told.normal[k], told.eccentricity[k], told.status_words[k], told.opening[k]

Everything is measured where the blocks are now. Forces act on the candidate (N > 0 is compression); moments
and eccentricities are about the middle of the face, which moves with the antagonist. Sliding is that of the
two material points of a contact since the start. Facets of a round joint count together: N is the sum of what
presses across them. Where they turn too far for a section there is no eccentricity, and T is the sum of the
friction in each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.march.model import Model
from masonry_fem.march.state import SLIP, SystemState
from masonry_fem.output.joint_faces import JointFaces
from masonry_fem.output.joint_motion import (
    both_points,
    joints_of,
    moved_faces,
    nearest_contacts,
    signs,
    slides_of,
    sum_by,
)
from masonry_fem.output.stress_block import (
    Block,
    kern_share,
    linear_block,
    outline,
    plastic_block,
)

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

FREE, CLOSED, MIDDLE_THIRD, CRACKED, HINGE, HELD = range(6)
STATUS_WORDS = ("open", "closed", "middle third", "cracked", "hinge", "held")
SMALL = 1e-8  # of the greatest contact force: what carries no more is open
NEAR = 0.01  # of a face's width: a centre of pressure that near what contact can reach is a hinge
LIMIT = 1e-6  # of μ N: what lacks no more of it slides


@dataclass(frozen=True, slots=True)
class InterfaceForces:
    """i joints of f facets; a = 1 axis in 2D, 2 in 3D. Forces [N], moments [N m], in 2D for a metre of depth.

    Attributes
    ----------
    faces : The faces, where they are now.
    corner_reference : Corners of the facets in the reference configuration, shape (f, k, d) [m].
    force : Of the antagonist on the candidate, world axes, shape (i, d).
    normal, shear : N, > 0 pressing, and T along the axes, shapes (i,) and (i, a).
    tangential : T, shape (i,).
    moment : About the face's middle in world axes, shape (i, 1 | 3).
    centre : Centre of pressure, world, shape (i, d) [m]; NaN where N is 0.
    eccentricity : Of the centre from the middle along the axes, shape (i, a) [m].
    kern : 0 where the centre is the middle, 1 on the rim of the kern, shape (i,).
    edge_share : 0 where the centre is the middle, 1 on the outline of the face, shape (i,).
    status : FREE, CLOSED (a corner, an edge or a round face that presses), MIDDLE_THIRD, CRACKED, HINGE or
        HELD (it pulls somewhere), shape (i,).
    edge : Name of the side where a hinge lies, else "".
    slides : Where friction is used up, shape (i,).
    friction : Greatest friction force over N, shape (i,); NaN where it does not press.
    friction_used : T over that force, shape (i,).
    opening : Greatest, and at the facets' corners, shapes (i,) and (f, k) [m].
    sliding, corner_sliding : Mean over the area and greatest, and at the corners, shapes (i, 2), (f, k) [m].
    linear, plastic : Stress blocks for N; NaN where it does not press within the face.
    """

    faces: JointFaces
    corner_reference: FloatArray
    force: FloatArray
    normal: FloatArray
    shear: FloatArray
    tangential: FloatArray
    moment: FloatArray
    centre: FloatArray
    eccentricity: FloatArray
    kern: FloatArray
    edge_share: FloatArray
    status: IntArray
    edge: tuple[str, ...]
    slides: Mask
    friction: FloatArray
    friction_used: FloatArray
    opening: FloatArray
    corner_opening: FloatArray
    sliding: FloatArray
    corner_sliding: FloatArray
    linear: Block
    plastic: Block

    @property
    def sliding_margin(self) -> FloatArray:
        """μ − T/N: what friction has left, shape (i,); NaN where it does not press."""
        margin: FloatArray = self.friction * (1.0 - self.friction_used)
        return margin

    @property
    def status_words(self) -> list[str]:
        """The states in words."""
        words: list[str] = np.array(STATUS_WORDS)[self.status].tolist()
        return words


def interface_forces(
    model: Model, state: SystemState, reference: JointFaces | None = None
) -> InterfaceForces:
    """Forces, openings and slides of a model's interfaces.

    Parameters
    ----------
    model, state : Of which instant.
    reference : Faces of the joints in the reference configuration, if they are known.
    """
    reference = JointFaces.of(model) if reference is None else reference
    number, count = joints_of(model, reference), len(reference.first)
    points = both_points(model, state)
    nearest = nearest_contacts(model, reference)
    faces = moved_faces(model, state, reference, points, nearest)
    sign = signs(model, reference)
    world = sign[:, None] * np.einsum("cai,ca->ci", state.reaction_frame, state.reaction)
    force = sum_by(world, number, count)
    arm = state.points - faces.centroid[number]
    moment = sum_by(_cross(arm, world), number, count)
    across = sign[:, None] * state.frame[:, 0]
    pressing = np.einsum("ci,ci->c", world, across)
    flat = np.einsum("ci,cai->ca", arm, faces.axes[number])
    normal, turning = sum_by(pressing, number, count), sum_by(pressing[:, None] * flat, number, count)
    small = SMALL * float(np.linalg.norm(world, axis=1).max(initial=0.0))
    loaded = np.abs(normal) > small
    carries = loaded & faces.plane
    eccentricity = np.full((count, flat.shape[1]), np.nan)
    eccentricity[carries] = turning[carries] / normal[carries, None]
    eccentricity[faces.size == 0] = 0.0
    eccentricity[~carries] = np.nan
    kern = kern_share(faces, np.where(carries[:, None], eccentricity, 0.0))
    pulls = _least(pressing, number, count) < -small
    depth, towards = _to_rim(faces, flat, number, eccentricity)
    status = _status(faces, np.linalg.norm(force, axis=1) > small, pulls, kern, depth)
    hinge = status == HINGE
    shear = np.einsum("ai,ai->a", force, faces.normal)[:, None] * faces.normal
    shear = np.einsum("id,iad->ia", force - shear, faces.axes)
    along = sum_by(world - pressing[:, None] * across, model.contacts.interface, len(model.interfaces))
    along = sum_by(np.linalg.norm(along, axis=1), faces.facets.joint, count)
    tangential = np.where(faces.plane, np.linalg.norm(shear, axis=1), along)
    friction, used, slides = _friction(model, state, pressing, tangential, number, small)
    openings = np.maximum(state.gap, 0.0)
    slide = slides_of(model, state, points)
    sized = np.linalg.norm(slide, axis=1)
    at = np.where((normal > 0)[:, None], eccentricity, np.nan)
    centre = sum_by(pressing[:, None] * state.points, number, count)
    centre = np.divide(centre, normal[:, None], out=np.full_like(centre, np.nan), where=loaded[:, None])
    section = faces.centroid + np.einsum("ia,iad->id", eccentricity, faces.axes)
    return InterfaceForces(
        faces=faces,
        corner_reference=reference.facets.polygon,
        force=force,
        normal=normal,
        shear=shear,
        tangential=tangential,
        moment=moment,
        centre=np.where(faces.plane[:, None], section, centre),
        eccentricity=eccentricity,
        kern=np.where(carries, kern, np.nan),
        edge_share=_edge_share(faces, eccentricity),
        status=status,
        edge=tuple(np.where(hinge, _side_names(faces, towards), "").tolist()),
        slides=slides,
        friction=friction,
        friction_used=used,
        opening=_most(openings, number, count),
        corner_opening=openings[nearest],
        sliding=np.stack([_mean(model, sized, number, count), _most(sized, number, count)], axis=1),
        corner_sliding=sized[nearest],
        linear=_scaled(linear_block(faces, at), normal),
        plastic=_scaled(plastic_block(faces, at), normal),
    )


def _edge_share(faces: JointFaces, centre: FloatArray) -> FloatArray:
    """How far centres of pressure are on the way from the middle to the outline, shape (i,)."""
    normals, rim = outline(faces)
    real = np.isfinite(rim) & (rim > 0)
    ahead = np.einsum("ika,ia->ik", normals, np.nan_to_num(centre))
    share = np.divide(ahead, rim, out=np.zeros_like(ahead), where=real).max(axis=1, initial=0.0)
    known = (faces.area > 0) & ~np.isnan(centre).any(axis=1)
    return np.where(known, share, np.nan)


def _to_rim(
    faces: JointFaces, flat: FloatArray, number: IntArray, centre: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """How near centres of pressure are to the farthest that contact points allow, over the face's width.

    And in which direction that is, shapes (i,), (i, a).
    """
    normals, rim = outline(faces)
    ahead = np.einsum("cka,ca->ck", normals[number], flat)
    reach = np.full(rim.shape, -np.inf)
    np.maximum.at(reach, number, ahead)
    back = np.full(rim.shape, np.inf)
    np.minimum.at(back, number, ahead)
    real = np.isfinite(rim) & np.isfinite(reach) & (reach > back)
    width = np.where(real, reach - back, 1.0)
    left = (reach - np.einsum("ika,ia->ik", normals, centre)) / width
    left = np.where(real & np.isfinite(left), left, np.inf)
    edge = left.argmin(axis=1)
    rows = np.arange(len(edge))
    return left[rows, edge], normals[rows, edge]


def _status(faces: JointFaces, loaded: Mask, pulls: Mask, kern: FloatArray, depth: FloatArray) -> IntArray:
    status = np.where(kern <= 1 + 1e-9, MIDDLE_THIRD, CRACKED)
    status = np.where(depth <= NEAR, HINGE, status)
    status = np.where(faces.plane & (faces.area > 0), status, CLOSED)
    status = np.where(pulls, HELD, status)
    result: IntArray = np.where(loaded, status, FREE).astype(np.int64)
    return result


def _side_names(faces: JointFaces, towards: FloatArray) -> NDArray[np.object_]:
    """Side of each face in a direction (i, a): by name, or by where it lies, along x, y or z; shape (i,)."""
    rows = np.arange(len(towards))
    axis = np.abs(towards).argmax(axis=1)
    far = towards[rows, axis]
    along = far[:, None] * faces.axes[rows, axis]
    most = np.abs(along).argmax(axis=1)
    places = np.array([[f"{sign}{name}" for name in "xyz"] for sign in "-+"], dtype=object)
    named = np.asarray(faces.sides, dtype=object)[rows, axis, (far > 0).astype(int)]
    place = places[(along[rows, most] > 0).astype(int), most]
    found: NDArray[np.object_] = np.where(named != "", named, place)
    return found


def _friction(
    model: Model, state: SystemState, pressing: FloatArray, along: FloatArray, number: IntArray, small: float
) -> tuple[FloatArray, FloatArray, Mask]:
    """Greatest friction over N, the share of it that is used, and where nothing is left."""
    count = len(along)
    coefficient = model.laws.reduce(state.joints, state.jump, model.contacts.area, 1.0).friction
    pressed = np.maximum(pressing, 0.0)
    total = sum_by(pressed, number, count)
    most = sum_by(coefficient * pressed, number, count)
    loaded = total > small
    friction = np.full(count, np.nan)
    used = np.full(count, np.nan)
    friction[loaded] = most[loaded] / total[loaded]
    able = loaded & (most > 0)
    used[able] = along[able] / most[able]
    slipping = sum_by(np.where(state.status == SLIP, pressed, 0.0), number, count)
    # a joint that turns about its normal slides all over, though its resultant is small
    slides = loaded & ((np.nan_to_num(used) >= 1 - LIMIT) | (slipping >= (1 - LIMIT) * total))
    return friction, used, slides


def _scaled(block: Block, normal: FloatArray) -> Block:
    return Block(block.pressure * normal, block.area)


def _mean(model: Model, values: FloatArray, number: IntArray, count: int) -> FloatArray:
    """Means over the contacts of each joint, weighted by tributary area if there is any."""
    bare = np.bincount(number, model.contacts.area, count) <= 0
    weight = np.where(bare[number], 1.0, model.contacts.area)
    total = np.bincount(number, weight, count)
    mean: FloatArray = np.bincount(number, weight * values, count) / np.where(total > 0, total, 1.0)
    return mean


def _most(values: FloatArray, number: IntArray, count: int) -> FloatArray:
    most = np.zeros(count)
    np.maximum.at(most, number, values)
    return most


def _least(values: FloatArray, number: IntArray, count: int) -> FloatArray:
    least = np.zeros(count)
    np.minimum.at(least, number, values)
    return least


def _cross(arm: FloatArray, force: FloatArray) -> FloatArray:
    if arm.shape[1] == 2:
        return (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])[:, None]
    return np.cross(arm, force)
