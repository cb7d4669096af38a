"""Place: contact points on all interfaces, with their frames and gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import sparse

from masonry_fem.contact.contacts import Contacts, Interface, height
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.contact.joint_points import JointPoints
from masonry_fem.contact.placement import names
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.contact.posed import poses
from masonry_fem.contact.surface import Surface, surfaces_of, typical_size
from masonry_fem.contact.update import picked
from masonry_fem.errors import GeometryError
from masonry_fem.records.remark import counted, remark
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

ROUNDING = 1e-12  # of a block's size: a gap below it is zero
NO_WEIGHT = 1e-13  # of a node in a mean: rounding
ROUGH = 1e-3  # of a contact's width: by how much facets may miss a round face untold
AREAS = 1e-6  # of an interface's area: what the areas of its points may sum to beside it
CONGRUENT = 1e-12  # of their size: interfaces that differ by less are congruent


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
    placed = JointPoints.of(assembly, surfaces, interfaces, rules)
    if tell:
        _tell_round(assembly, placed.spots)
    placed.check_areas(interfaces, rules)
    contacts = _contacts(assembly, surfaces, placed)
    if (np.diff(contacts.interface) < 0).any():
        contacts = picked(contacts, np.argsort(contacts.interface, kind="stable"))
    return contacts


def _contacts(assembly: Assembly, surfaces: tuple[Surface, ...], placed: JointPoints) -> Contacts:
    """The points of all joints as contacts."""
    rows = _Rows.of([len(spot.area) for spot in placed.spots], placed.kind)
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


def _on_planes(
    assembly: Assembly, surfaces: tuple[Surface, ...], placed: JointPoints, rows: _Rows
) -> Contacts:
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
    assembly: Assembly, surfaces: tuple[Surface, ...], placed: JointPoints, side: int
) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of one side's face at each joint, world coordinates, (k, d) each."""
    solids = [surface.solid for surface in surfaces]
    first = np.cumsum([0, *(len(solid.faces) for solid in solids)])
    corner = np.concatenate([solid.vertices[[face[0] for face in solid.faces]] for solid in solids])
    normals = np.concatenate([surface.normals for surface in surfaces])
    shape, rotation, translation = poses(assembly)
    block = placed.blocks[:, side]
    face = first[shape[block]] + placed.faces[:, side]
    return (
        np.einsum("iab,ib->ia", rotation[block], corner[face]) + translation[block],
        np.einsum("iab,ib->ia", rotation[block], normals[face]),
    )


def _on_round_faces(flat: Contacts, placed: JointPoints, joint: IntArray) -> Contacts:
    """The same, with what contacts on round faces have of their own; ``joint``: that of each, shape (c,)."""
    is_round = np.array([spot.round is not None for spot in placed.spots])[placed.kind]
    if not is_round.any():
        return flat
    own = is_round[joint]
    rounds = [one for number in placed.kind[is_round] if (one := placed.spots[number].round) is not None]
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
        blocks = [assembly.blocks.names[side.block] for side in patch.sides]
        remark(
            "round_faces",
            f"round faces touch in {counted(len(found), 'place')}, worst between '{blocks[0]}' and "
            f"'{blocks[1]}', in facets that do not coincide and miss the arcs by up to {rise:.2g} m: "
            "contacts take the faces for as round as their facets turn; halve the elements to have a "
            "quarter of that",
            *blocks,
        )


def _means(assembly: Assembly, placed: JointPoints, points: _Rows) -> sparse.csr_array | None:
    """Weights of the nodes that carry contacts which are means, shape (2c, nodes of the largest mesh)."""
    found = [spot.means for spot in placed.spots]
    given = [means for means in found if means is not None]
    if not given:
        return None
    rows = _Rows.of([0 if means is None else len(means.row) for means in found], placed.kind)
    row = 2 * points.start[rows.joint] + np.concatenate([means.row for means in given])[rows.at]
    node = np.concatenate([means.node for means in given])[rows.at]
    weight = np.concatenate([means.weight for means in given])[rows.at]
    width = max(len(shape.mesh.points) for shape in assembly.shapes if shape.mesh is not None)
    shape = (2 * len(points.joint), width)
    means = sparse.csr_array(sparse.coo_array((weight, (row, node)), shape=shape))
    means.data[np.abs(means.data) < NO_WEIGHT] = 0.0
    means.eliminate_zeros()
    return means


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
