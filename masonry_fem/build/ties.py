"""Ties: those of a scene as contacts of their own, one for each straight part.

    faces, contacts = ties(scene, stones)          # an interface and a contact for each part
    law = tie_law(scene, names, contacts)          # how they stretch, yield and snap

The normal of such a contact points along the tie from its candidate to its antagonist, and ``bulge`` is less
than 0 by the length L_0 of the tie without force: its gap L_0 − L is open where the tie is slack.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy import sparse

from masonry_fem.build.selection import select_blocks
from masonry_fem.build.stones import Stones
from masonry_fem.contact.contacts import Contacts, FloatArray, IntArray, local_frames
from masonry_fem.contact.interfaces import Interfaces
from masonry_fem.contact.update import joined
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.joints.laws.parts.tie import Tie
from masonry_fem.records.remark import remark
from masonry_fem.scene import specs
from masonry_fem.scene.selector import only

SHORT = 1e-6  # of a block's size: ends that are nearer to each other have no direction
STIFFER = 1e3  # the other way round: how much less than its modulus a tie hardens where nothing is said
NO_WEIGHT = 1e-13  # of a node in a mean: rounding


def with_ties(
    scene: specs.Scene, stones: Stones, interfaces: Interfaces, contacts: Contacts
) -> tuple[Interfaces, Contacts]:
    """Interfaces and contacts where blocks touch, followed by those of the scene's ties.

    Parameters
    ----------
    scene : Has the ties. stones : Its blocks.
    interfaces, contacts : Where these touch.

    Raises
    ------
    SceneError : A tie is fixed to no block or to no point of it, has no length, or joins no free block.
    """
    if not scene.ties:
        return interfaces, contacts
    return joined((interfaces, contacts), ties(scene, stones))


def ties(scene: specs.Scene, stones: Stones) -> tuple[Interfaces, Contacts]:
    """An interface and a contact for each straight part of each tie.

    Parameters
    ----------
    scene : Has the ties. stones : Its blocks.

    Raises
    ------
    SceneError : A tie is fixed to no block or to no point of it, has no length, or joins no free block.
    """
    parts = list(_straight(scene, stones))
    names, own = [one.name for one in parts], [one.tie for one in parts]
    blocks = np.array([[block for block, _ in one.ends] for one in parts], dtype=np.int64)
    points = np.array([[point for _, point in one.ends] for one in parts])
    reach = points[:, 1] - points[:, 0]
    length = np.linalg.norm(reach, axis=1)
    frame = local_frames(reach / length[:, None])
    rest = _rest_length(own, length)
    labels = tuple(dict.fromkeys(names))
    faces = Interfaces(
        blocks=blocks, faces=np.full((len(blocks), 2), -1), normal=frame[:, 0], area=np.zeros(len(blocks)),
        tie=np.ones(len(blocks), dtype=bool), label=np.array([labels.index(name) for name in names]),
        labels=labels, corners=points.mean(axis=1), gap=rest - length, first=np.arange(len(blocks) + 1),
    )  # fmt: skip
    contacts = Contacts(
        blocks=blocks,
        interface=np.arange(len(faces)),
        points=points,
        facets=np.full((len(faces), 2), -1),
        frame=frame,
        gap=rest - length,
        area=np.array([tie.area for tie in own]),
        means=_means(stones, blocks, points, names),
        bulge=-rest,
        ties=np.ones(len(faces), dtype=bool),
    )
    return faces, contacts


@dataclass(frozen=True, slots=True)
class _Part:
    """A straight part of a tie: its name, and block and point of both ends."""

    name: str
    tie: specs.Tie
    ends: tuple[tuple[int, FloatArray], tuple[int, FloatArray]]


def _straight(scene: specs.Scene, stones: Stones) -> Iterator[_Part]:
    """All parts of all ties."""
    for index, tie in enumerate(scene.ties):
        places = [_place(stones, point, f"ties.{index}.points.{k}") for k, point in enumerate(tie.points)]
        ends = pairwise([*places, places[0]] if tie.closed else places)
        for name, part in zip(tie.parts, ends, strict=True):
            _refuse(stones, f"ties.{index} ('{name}')", part)
            yield _Part(name, tie, part)


def tie_law(scene: specs.Scene, interfaces: Interfaces, contacts: Contacts, points: IntArray) -> Tie:
    """How the ties at some contacts stretch, yield and snap.

    Parameters
    ----------
    scene : Has the ties.
    interfaces, contacts : Of the model.
    points : Numbers of those that are ties, shape (k,).
    """
    known = {name: tie for tie in scene.ties for name in tie.parts}
    own = [known[interfaces[number].label] for number in contacts.interface[points].tolist()]
    assert contacts.bulge is not None
    return Tie(
        modulus=np.array([tie.young for tie in own]),
        length=-contacts.bulge[points],
        prestress=np.array([tie.pretension / tie.area for tie in own]),
        strength=_given([tie.yield_stress for tie in own]),
        hardening=_given([tie.hardening for tie in own], [tie.young / STIFFER for tie in own]),
        rupture=_given([tie.rupture_strain for tie in own]),
    )


def _given(values: list[float | None], usual: float | list[float] = np.inf) -> FloatArray:
    """Values, or what is usual where there is none."""
    found = np.array([np.nan if value is None else value for value in values])
    return np.where(np.isnan(found), usual, found)


def _rest_length(own: list[specs.Tie], length: FloatArray) -> FloatArray:
    """Lengths without force of ties that bear their pretension at a length (k,) [m]."""
    strain = np.array([tie.pretension / (tie.young * tie.area) for tie in own])
    rest: FloatArray = length / (1.0 + strain)
    return rest


def _place(stones: Stones, point: specs.TiePoint, key: str) -> tuple[int, FloatArray]:
    """Block and point of an end."""
    blocks, what = stones.assembly.blocks, f"{key}.block"
    block = only(select_blocks(point.block, blocks, what), point.block, blocks.names, what)
    solid = stones.assembly.solid(block)
    at = solid.mass_properties().centroid if point.point is None else np.array(point.point, dtype=float)
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    away = float(np.linalg.norm(np.maximum(np.maximum(low - at, at - high), 0.0)))
    if away > 0.1 * float(np.linalg.norm(high - low)):
        name = stones.assembly.blocks.names[block]
        raise SceneError(
            f"{key}.point is {away:.3g} m outside '{name}', expected a point of the block in world "
            "coordinates; correct it, or name the block that it is on"
        )
    return block, at


def _refuse(stones: Stones, title: str, part: tuple[tuple[int, FloatArray], tuple[int, FloatArray]]) -> None:
    (first, start), (second, end) = part
    blocks = stones.assembly.blocks
    if first == second:
        raise SceneError(
            f"{title} leads from '{blocks[first].name}' to itself, expected two blocks; name "
            "another one, or leave the tie out"
        )
    size = float(np.linalg.norm(np.ptp(stones.assembly.solid(first).vertices, axis=0)))
    if float(np.linalg.norm(end - start)) <= SHORT * size:
        raise SceneError(
            f"{title} has its ends on '{blocks[first].name}' and '{blocks[second].name}' in "
            "one point, expected two: a tie needs a length to stretch"
        )
    if stones.fidelity[first] is None and stones.fidelity[second] is None:
        remark(
            "idle_tie",
            f"{title} joins two supports, '{blocks[first].name}' and "
            f"'{blocks[second].name}': it holds nothing; fix one end to a free block, or drop it",
            blocks[first].name,
            blocks[second].name,
        )


def _means(stones: Stones, blocks: IntArray, points: FloatArray, names: list[str]) -> sparse.csr_array | None:
    """Weights of the nodes of blocks with meshes at the ends, shape (2k, nodes of the largest mesh)."""
    assembly = stones.assembly
    rows, columns, values, width = [], [], [], 0
    ends = zip(blocks.ravel(), points.reshape(-1, points.shape[2]), strict=True)
    for row, (block, point) in enumerate(ends):
        placed = assembly.blocks[int(block)]
        mesh = assembly.shapes[placed.shape].mesh
        if mesh is None:
            continue
        from masonry_fem.fem.locate import in_cells  # noqa: PLC0415 - rigid scenes need no elements

        what = f"tie '{names[row // 2]}' at '{placed.name}'"
        try:
            nodes, weights = in_cells(mesh, placed.pose.to_shape(point), what)
        except MasonryError as error:
            raise SceneError(str(error)) from error
        kept = np.abs(weights) > NO_WEIGHT
        rows += [row] * int(kept.sum())
        columns += nodes[kept].tolist()
        values += weights[kept].tolist()
        width = max(width, len(mesh.points))
    if not width:
        return None
    return sparse.csr_array(sparse.coo_array((values, (rows, columns)), shape=(2 * len(blocks), width)))


def stretched_from(
    scene: specs.Scene, interfaces: Interfaces, contacts: Contacts, length: FloatArray
) -> Contacts:
    """Contacts whose ties bear their pretension at other lengths than in the reference.

    Parameters
    ----------
    scene : Has the ties.
    interfaces, contacts : Of the model.
    length : Of each contact that is such a tie; NaN of the others, shape (c,) [m].
    """
    found = np.flatnonzero(np.isfinite(length))
    if not len(found):
        return contacts
    assert contacts.bulge is not None
    law = tie_law(scene, interfaces, contacts, found)
    bulge, gap = contacts.bulge.copy(), contacts.gap.copy()
    rest = length[found] / (1.0 + law.prestress / law.modulus)
    gap[found] += rest + bulge[found]
    bulge[found] = -rest
    return replace(contacts, bulge=bulge, gap=gap)
