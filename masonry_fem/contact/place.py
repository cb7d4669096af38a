"""Place: contact points on all interfaces, with their frames, gaps and identities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from hashlib import blake2b

import numpy as np
from scipy import sparse

from masonry_fem.contact.contacts import Contacts, Interface, height, local_frames
from masonry_fem.contact.placement import names, on_round_faces, points_of, together_of
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.planes import shapes
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

type Placed = tuple[Spots, IntArray]  # points, and the numbers of the interfaces that they are on


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
    surfaces = surfaces_of(assembly) if surfaces is None else surfaces
    placed = _placed(assembly, surfaces, interfaces, rules)
    if not placed:
        return _none(assembly.dimension)
    if tell:
        _tell_round(assembly, [spot for spot, _ in placed])
    _check_areas(placed, interfaces, rules)
    contacts = _contacts(assembly, surfaces, placed)
    if (np.diff(contacts.interface) < 0).any():
        contacts = picked(contacts, np.argsort(contacts.interface, kind="stable"))
    return replace(contacts, key=_keys(assembly, interfaces, contacts.interface))


def _contacts(assembly: Assembly, surfaces: tuple[Surface, ...], placed: Sequence[Placed]) -> Contacts:
    """The points of all interfaces as contacts, still without their identities."""
    spots = [spot for spot, _ in placed]
    of = np.repeat(np.arange(len(spots)), [len(spot.area) for spot in spots])
    made = _on_round_faces(_on_planes(placed, of), placed, of)
    small = np.abs(made.gap) < ROUNDING * typical_size(assembly, surfaces)
    return replace(made, gap=np.where(small, 0.0, made.gap), means=_means(assembly, spots))


def _on_planes(placed: Sequence[Placed], of: IntArray) -> Contacts:
    """Contacts in the planes of their patches; ``of``: the spots that each is one of, shape (c,)."""
    spots = [spot for spot, _ in placed]
    patches = [spot.patch for spot in spots]
    frame = np.array([patch.frame for patch in patches])[of]
    flat = np.concatenate([spot.points for spot in spots])
    middle = np.array([patch.origin for patch in patches])[of] + np.einsum("cp,cpd->cd", flat, frame[:, 1:])
    heights = _heights(patches, of, middle, frame[:, 0])
    return Contacts(
        blocks=np.array([[side.block for side in patch.sides] for patch in patches])[of],
        interface=np.array([rows[0] for _, rows in placed])[of],
        points=middle[:, None] + heights[:, :, None] * frame[:, :1],
        facets=np.concatenate([spot.facets for spot in spots]),
        frame=frame,
        gap=heights[:, 0] - heights[:, 1],
        area=np.concatenate([spot.area for spot in spots]),
        key=np.zeros(len(of), dtype=np.int64),
    )


def _on_round_faces(flat: Contacts, placed: Sequence[Placed], of: IntArray) -> Contacts:
    """The same, with what contacts on round faces have of their own."""
    rounds = [(spot.round, rows) for spot, rows in placed if spot.round is not None]
    if not rounds:
        return flat
    own = np.array([spot.round is not None for spot, _ in placed])[of]
    interface, frame, points = flat.interface.copy(), flat.frame.copy(), flat.points.copy()
    bulge, gap = np.zeros(len(of)), flat.gap.copy()
    interface[own] = np.concatenate([rows[one.patch] for one, rows in rounds])
    frame[own] = np.concatenate([one.frame for one, _ in rounds])
    points[own] = np.concatenate([one.points for one, _ in rounds])
    bulge[own] = np.concatenate([one.bulge for one, _ in rounds])
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


def _means(assembly: Assembly, spots: list[Spots]) -> sparse.csr_array | None:
    """Weights of the nodes that carry contacts which are means, shape (2c, nodes of the largest mesh)."""
    first = 2 * np.cumsum([0, *(len(spot.area) for spot in spots)])
    found = [(start, spot.means) for start, spot in zip(first, spots, strict=False) if spot.means is not None]
    if not found:
        return None
    row = np.concatenate([start + means.row for start, means in found])
    node = np.concatenate([means.node for _, means in found])
    weight = np.concatenate([means.weight for _, means in found])
    width = max(len(shape.mesh.points) for shape in assembly.shapes if shape.mesh is not None)
    means = sparse.csr_array(sparse.coo_array((weight, (row, node)), shape=(int(first[-1]), width)))
    means.data[np.abs(means.data) < NO_WEIGHT] = 0.0
    means.eliminate_zeros()
    return means


def _placed(
    assembly: Assembly, surfaces: tuple[Surface, ...], interfaces: Sequence[Interface], rules: Sequence[Rule]
) -> list[Placed]:
    """The points of each interface, or of all that two round faces have in common, by its rule."""
    for rule in dict.fromkeys(rules):  # looks into the folder of rules: not for each of many interfaces
        _check(rules.index(rule), rule)
    normals = np.array([interface.normal for interface in interfaces]).reshape(-1, assembly.dimension)
    frames = local_frames(normals)
    groups = _round_groups(assembly, surfaces, interfaces, rules)
    joints = [
        _from_one_side([Patch.of(assembly, surfaces, interfaces[row], frames[row]) for row in rows])
        for rows in groups
    ]
    of = [rules[rows[0]] for rows in groups]
    alike = _congruent(joints, of)
    waiting: dict[Rule, list[int]] = {}
    for number in dict.fromkeys(alike):
        waiting.setdefault(of[number], []).append(number)
    made: dict[int, list[Spots]] = {}
    for rule, numbers in waiting.items():
        made |= zip(numbers, _by_rule([joints[number] for number in numbers], rule), strict=True)
    placed: list[Placed] = []
    for number, rows in enumerate(groups):
        spots = made[alike[number]]
        if len(rows) == 1:
            placed.append((_moved_to(spots[0], joints[alike[number]][0], joints[number][0]), rows))
        else:
            placed += [(spots[0], rows)] if len(spots) == 1 else zip(spots, rows[:, None], strict=True)
    return placed


def _congruent(joints: Sequence[Sequence[Patch]], rules: Sequence[Rule]) -> list[int]:
    """The first joint that each is congruent to and has a rule with: walls have hundreds of each kind.

    Parameters
    ----------
    joints : Those of more than one patch are like no other. rules : Of each.
    """
    keys: list[object] = list(range(len(joints)))
    single = [number for number, joint in enumerate(joints) if len(joint) == 1]
    for number, shape in zip(single, shapes([joints[number][0] for number in single]), strict=True):
        keys[number] = (rules[number], *shape)
    first: dict[object, int] = {}
    return [first.setdefault(key, number) for number, key in enumerate(keys)]


def _moved_to(spots: Spots, patch: Patch, there: Patch) -> Spots:
    """Contacts of a patch as those of a congruent one.

    Parameters
    ----------
    spots : What a rule has placed on ``patch``, maybe with sides exchanged. there : The other.
    """
    if there is patch:
        return spots
    exchanged = spots.patch.sides[0] is not patch.sides[0]
    return replace(spots, patch=there.exchanged() if exchanged else there)


def _from_one_side(patches: Sequence[Patch]) -> list[Patch]:
    """Patches between the same two blocks, the same one being the candidate in all."""
    first = patches[0].sides[0].block
    return [patch if patch.sides[0].block == first else patch.exchanged() for patch in patches]


def _round_groups(
    assembly: Assembly, surfaces: tuple[Surface, ...], interfaces: Sequence[Interface], rules: Sequence[Rule]
) -> list[IntArray]:
    """Interfaces, those together that two round faces have in common and whose rule places on whole faces."""
    whole = {rule: on_round_faces(rule.name) for rule in dict.fromkeys(rules)}
    joints = round_joints(assembly, interfaces, [surface.smooth for surface in surfaces]).tolist()
    groups: dict[object, list[int]] = {}
    for number, (joint, rule) in enumerate(zip(joints, rules, strict=True)):
        groups.setdefault((joint, rule) if whole[rule] else number, []).append(number)
    return [np.array(rows) for rows in groups.values()]


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


def _check_areas(placed: Sequence[Placed], interfaces: Sequence[Interface], rules: Sequence[Rule]) -> None:
    """Refuse areas of a rule that do not sum to the interfaces': stresses would be wrong."""
    total = np.array([spot.area.sum() for spot, _ in placed])
    whole = np.array([sum(interfaces[row].area for row in rows) for _, rows in placed])
    for k in np.flatnonzero(np.abs(total - whole) > AREAS * whole)[:1]:
        i = int(placed[k][1][0])
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


def _heights(patches: list[Patch], of: IntArray, middle: FloatArray, along: FloatArray) -> FloatArray:
    """How far the faces of both sides are from the middles ``along`` the normals, shape (c, 2) [m]."""
    planes = (_planes(patches, side) for side in (0, 1))
    return np.stack([height(middle, along, on_face[of], normal[of]) for on_face, normal in planes], axis=1)


def _planes(patches: list[Patch], side: int) -> tuple[FloatArray, FloatArray]:
    """A point and the normal of one side's face of each patch, world coordinates, (i, d) each."""
    solids = [(patch.sides[side].surface, patch.sides[side]) for patch in patches]
    on_face = np.array([surface.solid.vertices[surface.solid.faces[own.face][0]] for surface, own in solids])
    normal = np.array([surface.normals[own.face] for surface, own in solids])
    rotation = np.array([own.pose.rotation for _, own in solids])
    translation = np.array([own.pose.translation for _, own in solids])
    return (
        np.einsum("iab,ib->ia", rotation, on_face) + translation,
        np.einsum("iab,ib->ia", rotation, normal),
    )


def _keys(assembly: Assembly, interfaces: Sequence[Interface], of: IntArray) -> IntArray:
    """Identities from the blocks' names, the faces and the place within them, shape (c,).

    Names, not numbers: a contact keeps its identity when other blocks come or go.
    """
    names = [block.name for block in assembly.blocks]
    if len(set(names)) < len(names):  # hand-made assemblies without names
        names = [f"{name}#{number}" for number, name in enumerate(names)]
    pairs = []
    for interface in interfaces:
        a, b = sorted(zip(interface.blocks, interface.faces, strict=True))
        text = f"{names[a[0]]}\n{a[1]}\n{names[b[0]]}\n{b[1]}"
        pairs.append(int.from_bytes(blake2b(text.encode(), digest_size=8).digest()))
    pair = np.array(pairs, dtype=np.uint64)[of]
    # several pieces may lie between the same two faces: number their points on
    order = np.argsort(pair, kind="stable")
    ordered = pair[order]
    start = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    index = np.empty(len(pair), dtype=np.uint64)
    index[order] = np.arange(len(pair)) - np.repeat(start, np.diff(np.concatenate([start, [len(pair)]])))
    return (_mixed(pair + index * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(1)).astype(np.int64)


def _mixed(number: np.ndarray) -> np.ndarray:
    """Bits well mixed (SplitMix64), so that near numbers give far keys."""
    number = (number ^ (number >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    number = (number ^ (number >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: np.ndarray = number ^ (number >> np.uint64(31))
    return mixed


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
        key=empty,
    )
