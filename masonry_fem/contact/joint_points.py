"""JointPoints: the points on all joints of blocks, placed on the first joint of each kind.

    placed = JointPoints.of(assembly, surfaces, interfaces, rules)
    placed.spots[placed.kind[k]]          # on joint k

Walls have hundreds of congruent interfaces: a rule is asked once for each kind.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from masonry_fem.contact.contacts import local_frames
from masonry_fem.contact.interfaces import Interfaces, numbered
from masonry_fem.contact.placement import on_round_faces, points_of, together_of
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.contact.posed import poses
from masonry_fem.contact.smooth import round_joints
from masonry_fem.contact.surface import Surface
from masonry_fem.errors import ExtensionError
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

AREAS = 1e-6  # of an interface's area: what the areas of its points may sum to beside it
CONGRUENT = 1e-12  # of their size: interfaces that differ by less are congruent


class JointPoints(NamedTuple):
    """Points on k joints, which are interfaces or all that two round faces have in common.

    Attributes
    ----------
    spots : Points on the first joint of each kind.
    kind : Which of them are those of each joint, shape (k,).
    rows : Interfaces, joint by joint, shape (n,). first : First row of each joint, shape (k,).
    blocks, faces : Candidate and antagonist, shape (k, 2).
    frame, origin : Of the plane of each joint's first patch, shapes (k, d, d) and (k, d).
    """

    spots: list[Spots]
    kind: IntArray
    rows: IntArray
    first: IntArray
    blocks: IntArray
    faces: IntArray
    frame: FloatArray
    origin: FloatArray

    @classmethod
    def of(
        cls,
        assembly: Assembly,
        surfaces: tuple[Surface, ...],
        interfaces: Interfaces,
        rules: Sequence[Rule],
    ) -> JointPoints:
        """The points of each interface, or of all that two round faces have in common, by its rule.

        Parameters
        ----------
        assembly, surfaces : Blocks and their surfaces.
        interfaces, rules : Where they touch, and a placement rule for each.

        Raises
        ------
        ExtensionError : A user's rule returns no ``Spots``, or arrays of the wrong shapes.
        """
        kinds = {rule: number for number, rule in enumerate(dict.fromkeys(rules))}
        rule = np.fromiter(map(kinds.__getitem__, rules), np.int64)
        frames = local_frames(interfaces.normal)
        group = _round_groups(assembly, surfaces, interfaces, rule, list(kinds))
        rows, count = np.argsort(group, kind="stable"), np.bincount(group)
        first = np.cumsum(count) - count
        lone = rows[first[count == 1]]  # interfaces that are joints by themselves
        alike, kind = np.arange(len(count)), _congruent(assembly, surfaces, interfaces, frames, rule, lone)
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

    def check_areas(self, interfaces: Interfaces, rules: Sequence[Rule]) -> None:
        """Refuse areas of a rule that do not sum to the interfaces': stresses would be wrong.

        Parameters
        ----------
        interfaces, rules : As for ``of``.

        Raises
        ------
        ExtensionError : On the first joint where they do not.
        """
        total = np.array([spot.area.sum() for spot in self.spots])[self.kind]
        whole = np.add.reduceat(interfaces.area[self.rows], self.first)
        for k in np.flatnonzero(np.abs(total - whole) > AREAS * whole)[:1]:
            i = int(self.rows[self.first[k]])
            raise ExtensionError(
                f"placement rule '{rules[i].name}' gives areas that sum to {total[k]:g} on interface {i}, "
                f"expected {whole[k]:g}, the area of the interface (patch.interface.area); correct them"
            )


def _everywhere(
    interfaces: Interfaces,
    frames: FloatArray,
    rows: IntArray,
    first: IntArray,
    kind: IntArray,
    made: Sequence[Sequence[Spots]],
) -> JointPoints:
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
    return JointPoints(
        spots, of, rows, start, blocks, faces, frame, interfaces.corners[interfaces.first[row]]
    )


def _congruent(
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
    shape, rotation, translation = poses(assembly)
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
