"""Place: contact points on all interfaces, with their frames and gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import sparse

from masonry_fem.contact.contacts import Contacts, Interface, height, local_frames
from masonry_fem.contact.interfaces import Interfaces, numbered
from masonry_fem.contact.placement import names, on_round_faces, points_of, together_of
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.contact.smooth import round_joints
from masonry_fem.contact.surface import Surface, surfaces_of, typical_size
from masonry_fem.contact.update import picked
from masonry_fem.errors import ExtensionError, GeometryError
from masonry_fem.records.remark import counted, remark
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

ROUNDING = 1e-12  # of a block's size: a gap below it is zero
NO_WEIGHT = 1e-13  # of a node in a mean: rounding
ROUGH = 1e-3  # of a contact's width: by how much facets may miss a round face untold
AREAS = 1e-6  # of an interface's area: what the areas of its points may sum to beside it
CONGRUENT = 1e-12  # of their size: interfaces that differ by less are congruent


class Placed(NamedTuple):
    """Points on k joints, which are interfaces or all that two round faces have in common.

    Attributes
    ----------
    spots : Points on the first joint of each kind.
    of : Which of them are those of each joint, shape (k,).
    rows : Interfaces, joint by joint, shape (n,). first : First row of each joint, shape (k,).
    blocks, faces : Candidate and antagonist, shape (k, 2).
    frame, origin : Of the plane of each joint's first patch, shapes (k, d, d) and (k, d).
    """

    spots: list[Spots]
    of: IntArray
    rows: IntArray
    first: IntArray
    blocks: IntArray
    faces: IntArray
    frame: FloatArray
    origin: FloatArray


def place(
    assembly: Assembly,
    interfaces: Sequence[Interface],
    rules: Sequence[Rule],
    surfaces: tuple[Surface, ...] | None = None,
    tell: bool = False,
) -> Contacts:
    """Place contact points on interfaces.

    The rule ``nodes`` puts them on the side of the finer mesh. If that is the antagonist, candidate and
    antagonist of these contacts, and so the direction of the normal, are exchanged.

    Parameters
    ----------
    assembly : Blocks in their reference poses.
    interfaces : Where they touch, from ``detect``.
    rules : A placement rule for each interface.
    surfaces : Surfaces of the assembly's shapes (``masonry_fem.contact.surface.surfaces_of``); None: they are
        computed.
    tell : Whether to warn of round faces whose facets do not coincide.

    Raises
    ------
    GeometryError
        A rule is unknown, an inset or density is out of range, or no side is meshed where ``nodes`` is asked.
    ExtensionError
        A user's rule returns no ``Spots``, arrays of the wrong shapes, or a wrong total area.
    """
    for rule in dict.fromkeys(rules):  # looks into the folder of rules: not for each of many interfaces
        _check(rules.index(rule), rule)
    interfaces = Interfaces.of(interfaces, assembly.dimension)
    if not interfaces:
        return _none(assembly.dimension)
    surfaces = surfaces_of(assembly) if surfaces is None else surfaces
    placed = _placed(assembly, surfaces, interfaces, rules)
    if tell:
        _tell_round(assembly, placed.spots)
    _check_areas(placed, interfaces, rules)
    contacts = _contacts(assembly, surfaces, placed)
    if (np.diff(contacts.interface) < 0).any():
        contacts = picked(contacts, np.argsort(contacts.interface, kind="stable"))
    return contacts


def _contacts(assembly: Assembly, surfaces: tuple[Surface, ...], placed: Placed) -> Contacts:
    """The points of all joints as contacts."""
    rows = _Rows.of([len(spot.area) for spot in placed.spots], placed.of)
    made = _on_round_faces(_on_planes(assembly, surfaces, placed, rows), placed, rows.joint)
    small = np.abs(made.gap) < ROUNDING * typical_size(assembly, surfaces)
    return replace(made, gap=np.where(small, 0.0, made.gap), means=_means(assembly, placed, rows))


class _Rows(NamedTuple):
    """Where n things of k joints are, each joint having those of its spots.

    Attributes
    ----------
    joint : Of each thing, shape (n,). at : Its row among those of all spots, shape (n,).
    start : First thing of each joint, shape (k,).
    """

    joint: IntArray
    at: IntArray
    start: IntArray

    @classmethod
    def of(cls, counts: Sequence[int], spots: IntArray) -> _Rows:
        """The rows, from how many things each of the spots has and the spots of each joint, shape (k,)."""
        count, first = np.array(counts)[spots], np.cumsum([0, *counts])[spots]
        start = np.cumsum(count) - count
        joint = np.repeat(np.arange(len(count)), count)
        return cls(joint, (first - start)[joint] + np.arange(len(joint)), start)


def _on_planes(assembly: Assembly, surfaces: tuple[Surface, ...], placed: Placed, rows: _Rows) -> Contacts:
    """Contacts in the planes of their patches."""
    spots, of = placed.spots, rows.joint
    frame = placed.frame[of]
    flat = np.concatenate([spot.points for spot in spots])[rows.at]
    middle = placed.origin[of] + np.einsum("cp,cpd->cd", flat, frame[:, 1:])
    heights = np.stack(
        [
            height(middle, frame[:, 0], on_face[of], normal[of])
            for on_face, normal in (_faces(assembly, surfaces, placed, side) for side in (0, 1))
        ],
        axis=1,
    )
    return Contacts(
        blocks=placed.blocks[of],
        interface=placed.rows[placed.first][of],
        points=middle[:, None] + heights[:, :, None] * frame[:, :1],
        facets=np.concatenate([spot.facets for spot in spots])[rows.at],
        frame=frame,
        gap=heights[:, 0] - heights[:, 1],
        area=np.concatenate([spot.area for spot in spots])[rows.at],
    )


def _faces(
    assembly: Assembly, surfaces: tuple[Surface, ...], placed: Placed, side: int
) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of one side's face at each joint, world coordinates, (k, d) each."""
    solids = [surface.solid for surface in surfaces]
    first = np.cumsum([0, *(len(solid.faces) for solid in solids)])
    corner = np.concatenate([solid.vertices[[face[0] for face in solid.faces]] for solid in solids])
    normals = np.concatenate([surface.normals for surface in surfaces])
    shape, rotation, translation = _poses(assembly)
    block = placed.blocks[:, side]
    face = first[shape[block]] + placed.faces[:, side]
    return (
        np.einsum("iab,ib->ia", rotation[block], corner[face]) + translation[block],
        np.einsum("iab,ib->ia", rotation[block], normals[face]),
    )


def _poses(assembly: Assembly) -> tuple[IntArray, FloatArray, FloatArray]:
    """Shape (b,), rotation (b, d, d) and translation (b, d) of each block."""
    return (
        np.array([block.shape for block in assembly.blocks], dtype=np.int64),
        np.array([block.pose.rotation for block in assembly.blocks]),
        np.array([block.pose.translation for block in assembly.blocks]),
    )


def _on_round_faces(flat: Contacts, placed: Placed, joint: IntArray) -> Contacts:
    """The same, with what contacts on round faces have of their own; ``joint``: that of each, shape (c,)."""
    is_round = np.array([spot.round is not None for spot in placed.spots])[placed.of]
    if not is_round.any():
        return flat
    own = is_round[joint]
    rounds = [one for number in placed.of[is_round] if (one := placed.spots[number].round) is not None]
    first = placed.first[is_round]
    interface, frame, points = flat.interface.copy(), flat.frame.copy(), flat.points.copy()
    bulge, gap = np.zeros(len(joint)), flat.gap.copy()
    interface[own] = placed.rows[
        np.concatenate([row + one.patch for row, one in zip(first, rounds, strict=True)])
    ]
    frame[own] = np.concatenate([one.frame for one in rounds])
    points[own] = np.concatenate([one.points for one in rounds])
    bulge[own] = np.concatenate([one.bulge for one in rounds])
    gap[own] = np.einsum("cd,cd->c", points[own, 0] - points[own, 1], frame[own, 0]) - bulge[own]
    return replace(flat, interface=interface, frame=frame, points=points, bulge=bulge, gap=gap)


def _tell_round(assembly: Assembly, spots: Sequence[Spots]) -> None:
    """Say where the facets of two round faces do not coincide: by themselves they are apart or overlap."""
    width = 1.0 / (assembly.dimension - 1)
    found = [
        (spot.round.rise, spot.patch)
        for spot in spots
        if spot.round is not None and spot.round.rise > ROUGH * spot.area.max() ** width
    ]
    if found:
        rise, patch = max(found, key=lambda one: one[0])
        blocks = [assembly.blocks[side.block].name for side in patch.sides]
        remark(
            "round_faces",
            f"round faces touch in {counted(len(found), 'place')}, worst between '{blocks[0]}' and "
            f"'{blocks[1]}', in facets that do not coincide and miss the arcs by up to {rise:.2g} m: "
            "contacts take the faces for as round as their facets turn; halve the elements to have a "
            "quarter of that",
            *blocks,
        )


def _means(assembly: Assembly, placed: Placed, points: _Rows) -> sparse.csr_array | None:
    """Weights of the nodes that carry contacts which are means, shape (2c, nodes of the largest mesh)."""
    found = [spot.means for spot in placed.spots]
    given = [means for means in found if means is not None]
    if not given:
        return None
    rows = _Rows.of([0 if means is None else len(means.row) for means in found], placed.of)
    row = 2 * points.start[rows.joint] + np.concatenate([means.row for means in given])[rows.at]
    node = np.concatenate([means.node for means in given])[rows.at]
    weight = np.concatenate([means.weight for means in given])[rows.at]
    width = max(len(shape.mesh.points) for shape in assembly.shapes if shape.mesh is not None)
    shape = (2 * len(points.joint), width)
    means = sparse.csr_array(sparse.coo_array((weight, (row, node)), shape=shape))
    means.data[np.abs(means.data) < NO_WEIGHT] = 0.0
    means.eliminate_zeros()
    return means


def _placed(
    assembly: Assembly,
    surfaces: tuple[Surface, ...],
    interfaces: Interfaces,
    rules: Sequence[Rule],
) -> Placed:
    """The points of each interface, or of all that two round faces have in common, by its rule.

    Walls have hundreds of congruent interfaces: points are placed on the first of each kind.
    """
    kinds = {rule: number for number, rule in enumerate(dict.fromkeys(rules))}
    rule = np.array([kinds[one] for one in rules])
    frames = local_frames(interfaces.normal)
    group = _round_groups(assembly, surfaces, interfaces, rule, list(kinds))
    rows, count = np.argsort(group, kind="stable"), np.bincount(group)
    first = np.cumsum(count) - count
    lone = rows[first[count == 1]]  # interfaces that are joints by themselves
    alike, kind = np.arange(len(count)), _shapes(assembly, surfaces, interfaces, frames, rule, lone)
    alike[count == 1] = np.flatnonzero(count == 1)[kind]
    chosen = np.unique(alike)
    joints = [
        _from_one_side([Patch.of(assembly, surfaces, interfaces[row], frames[row]) for row in own])
        for own in (rows[first[number] : first[number] + count[number]] for number in chosen)
    ]
    made: list[list[Spots]] = [[] for _ in joints]
    for one, number in kinds.items():
        its = np.flatnonzero(rule[rows[first[chosen]]] == number).tolist()
        for k, spots in zip(its, _by_rule([joints[k] for k in its], one), strict=True):
            made[k] = spots
    return _everywhere(interfaces, frames, rows, first, np.searchsorted(chosen, alike), made)


def _everywhere(
    interfaces: Interfaces,
    frames: FloatArray,
    rows: IntArray,
    first: IntArray,
    kind: IntArray,
    made: Sequence[Sequence[Spots]],
) -> Placed:
    """What was placed on the first joint of each kind, at all of them.

    Parameters
    ----------
    interfaces, frames : Of all interfaces.
    rows, first : Interfaces joint by joint, and the first of each of g joints, shape (g,).
    kind : Of each joint, shape (g,). made : What was placed on the first joint of each kind.
    """
    begin = np.cumsum([0, *map(len, made)])
    parted = np.array([len(own) > 1 for own in made])
    spots = [spot for own in made for spot in own]
    exchanged = np.array([spot.patch.sides[0].block != spot.patch.interface.blocks[0] for spot in spots])
    # joints of several patches that have points of their own become as many joints
    count = np.where(parted[kind], np.diff([*first, len(rows)]), 1)
    joint = np.repeat(np.arange(len(kind)), count)
    within = np.arange(len(joint)) - np.repeat(np.cumsum(count) - count, count)
    start, of = first[joint] + within, begin[kind[joint]] + within
    row, turned = rows[start], exchanged[of]
    blocks, faces, frame = interfaces.blocks[row], interfaces.faces[row], frames[row]
    blocks[turned], faces[turned] = blocks[turned, ::-1], faces[turned, ::-1]
    frame[turned] = local_frames(-interfaces.normal[row[turned]])
    return Placed(spots, of, rows, start, blocks, faces, frame, interfaces.corners[interfaces.first[row]])


def _shapes(
    assembly: Assembly,
    surfaces: tuple[Surface, ...],
    interfaces: Interfaces,
    frames: FloatArray,
    rule: IntArray,
    rows: IntArray,
) -> IntArray:
    """For each of some interfaces the first of them that is congruent to it, to rounding, shape (n,).

    Congruent ones have faces, label and rule in common, and how the faces lie on each other.

    Parameters
    ----------
    assembly, surfaces : Blocks and their surfaces.
    interfaces, frames, rule : Where they touch, frames there, and numbers of rules.
    rows : Which of them, shape (n,).
    """
    if not len(rows):
        return rows
    shape, rotation, translation = _poses(assembly)
    surface = {id(one): number for number, one in enumerate(surfaces)}
    of_block = np.array([surface[id(one)] for one in surfaces])[shape]
    start, last = interfaces.first[:-1][rows], interfaces.first[1:][rows]
    corner = np.minimum(start[:, None] + np.arange((last - start).max(initial=0)), last[:, None] - 1)
    origin, across = interfaces.corners[start], frames[rows][:, 1:]
    polygon = np.einsum("nkd,npd->nkp", interfaces.corners[corner] - origin[:, None], across)
    size = np.ptp(polygon, axis=1).max(axis=1)
    size = np.where(size > 0, size, 1.0)[:, None]
    numbers = [polygon.reshape(len(rows), -1) / size]
    for side in (0, 1):
        block = interfaces.blocks[rows, side]
        numbers.append((across @ rotation[block]).reshape(len(rows), -1))
        numbers.append(np.einsum("kpd,kd->kp", across, translation[block] - origin) / size)
    digits = np.rint(np.concatenate(numbers, axis=1) / CONGRUENT)
    own = [
        of_block[interfaces.blocks[rows]],
        interfaces.faces[rows],
        interfaces.label[rows],
        interfaces.area[rows] == 0,
    ]
    found, first = numbered(np.column_stack([rule[rows], *own, last - start, digits]))
    congruent: IntArray = first[found]
    return congruent


def _from_one_side(patches: Sequence[Patch]) -> list[Patch]:
    """Patches between the same two blocks, the same one being the candidate in all."""
    first = patches[0].sides[0].block
    return [patch if patch.sides[0].block == first else patch.exchanged() for patch in patches]


def _round_groups(
    assembly: Assembly,
    surfaces: tuple[Surface, ...],
    interfaces: Interfaces,
    rule: IntArray,
    rules: Sequence[Rule],
) -> IntArray:
    """Joint of each interface, as they first come: one for all that two round faces have in common, (i,).

    Parameters
    ----------
    assembly, surfaces, interfaces : Blocks, their surfaces, and where they touch.
    rule : Number of each interface's rule among ``rules``: some place points on whole faces.
    """
    whole = np.array([on_round_faces(one.name) for one in rules])[rule]
    joints = round_joints(assembly, interfaces, [surface.smooth for surface in surfaces])
    apart = np.where(whole, -1, np.arange(len(rule)))
    return numbered(np.column_stack([np.where(whole, joints, -1), np.where(whole, rule, -1), apart]))[0]


def _by_rule(joints: Sequence[Sequence[Patch]], rule: Rule) -> list[list[Spots]]:
    """What a rule places on joints."""
    together = together_of(rule.name)
    if together is not None:
        return together(joints, rule)
    return [[_checked(points_of(rule.name)(patch, rule), patch, rule) for patch in joint] for joint in joints]


def _checked(spots: Spots, patch: Patch, rule: Rule) -> Spots:
    """What a rule gave back, if it is what is expected."""
    if not isinstance(spots, Spots):
        raise ExtensionError(
            f"placement rule '{rule.name}' gives a {type(spots).__name__}, expected Spots; "
            "end its function points by: return Spots(patch, points, area, patch.facets_at(points))"
        )
    m, shapes = len(spots.points), (spots.points.shape, spots.area.shape, spots.facets.shape)
    if shapes != (expected := ((m, patch.polygon.shape[1]), (m,), (m, 2))):
        raise ExtensionError(
            f"placement rule '{rule.name}' gives points, area and facets of the shapes {shapes}, expected "
            f"{expected}: a row for each of its points, in the plane of patch.polygon"
        )
    return spots


def _check_areas(placed: Placed, interfaces: Interfaces, rules: Sequence[Rule]) -> None:
    """Refuse areas of a rule that do not sum to the interfaces': stresses would be wrong."""
    total = np.array([spot.area.sum() for spot in placed.spots])[placed.of]
    whole = np.add.reduceat(interfaces.area[placed.rows], placed.first)
    for k in np.flatnonzero(np.abs(total - whole) > AREAS * whole)[:1]:
        i = int(placed.rows[placed.first[k]])
        raise ExtensionError(
            f"placement rule '{rules[i].name}' gives areas that sum to {total[k]:g} on interface {i}, "
            f"expected {whole[k]:g}, the area of the interface (patch.interface.area); correct them"
        )


def _check(number: int, rule: Rule) -> None:
    where = f"interface {number}"
    if rule.name not in names():
        raise GeometryError(f"{where}: placement is '{rule.name}', expected one of {', '.join(names())}")
    if not 0 < rule.inset <= 1:
        raise GeometryError(f"{where}: inset is {rule.inset}, expected 0 < inset <= 1 (1 is the very corner)")
    if rule.density < 1:
        raise GeometryError(f"{where}: density is {rule.density}, expected at least 1 subdivision")


def _none(d: int) -> Contacts:
    empty = np.empty(0, dtype=np.int64)
    return Contacts(
        blocks=np.empty((0, 2), dtype=np.int64),
        interface=empty,
        points=np.empty((0, 2, d)),
        facets=np.empty((0, 2), dtype=np.int64),
        frame=np.empty((0, d, d)),
        gap=np.empty(0),
        area=np.empty(0),
    )
