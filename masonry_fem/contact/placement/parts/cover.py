"""Cover: the mesh facets that one side of many joints has there, as arrays.

A joint is one patch, or all that two round faces have in common. Facets and nodes of each joint have rows of
their own: what its patches share has one number, what two joints share has two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.interpolation import CORNERS_OF
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.surface import FaceMesh, face_mesh
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

type Joint = Sequence[Patch]  # one, or all that two round faces have in common, with the same candidate


@dataclass(frozen=True, slots=True)
class Cover:
    """f facets and n nodes on the faces of J joints, joint by joint.

    Attributes
    ----------
    kind : Of the facets.
    facet : Their numbers in the meshes, shape (f,).
    rows : Their nodes as rows of ``node``, shape (f, nodes of a facet).
    facets_from : First facet of each joint and, last, f; shape (J + 1,).
    of_patch : First facet of each patch and the one after its last, shape (k, 2).
    node : Numbers of the nodes in the meshes, shape (n,).
    carrier : For each of them the first facet (row of ``facet``) that has it, shape (n,).
    nodes_from : First node of each joint and, last, n; shape (J + 1,).
    own : Where nodes are in the frames of the shapes, shape (n, d) [m].
    world : And in the world.
    """

    kind: str
    facet: IntArray
    rows: IntArray
    facets_from: IntArray
    of_patch: IntArray
    node: IntArray
    carrier: IntArray
    nodes_from: IntArray
    own: FloatArray
    world: FloatArray

    @classmethod
    def of(cls, joints: Sequence[Joint], number: int) -> Cover:
        """The facets of one side.

        Parameters
        ----------
        joints : Whose meshes there have facets of one kind.
        number : 0 for the candidates, 1 for the antagonists.
        """
        sides = [joint[0].sides[number] for joint in joints]
        mesh = sides[0].mesh
        assert mesh is not None
        faces = [_faces(joint, number) for joint in joints]
        facets_from = _starts([len(one.facets) for one in faces])
        nodes_from = _starts([len(one.nodes) for one in faces])
        of = np.repeat(np.arange(len(joints)), np.diff(nodes_from))
        facet, rows, node, carrier, own = (
            np.concatenate(parts)
            for parts in zip(
                *((one.facets, one.rows, one.nodes, one.carrier, one.points) for one in faces), strict=True
            )
        )
        rotation = np.array([side.pose.rotation for side in sides])
        translation = np.array([side.pose.translation for side in sides])
        first = np.repeat(nodes_from[:-1], np.diff(facets_from))
        return cls(
            kind=mesh.facet,
            facet=facet,
            rows=rows + first[:, None],
            facets_from=facets_from,
            of_patch=_of_patches(joints, number, facets_from),
            node=node,
            carrier=carrier + facets_from[of],
            nodes_from=nodes_from,
            own=own,
            world=np.einsum("nij,nj->ni", rotation[of], own) + translation[of],
        )

    @property
    def vertices(self) -> IntArray:
        """Vertices of the facets, rows of ``node``, shape (f, v)."""
        return self.rows[:, : CORNERS_OF[self.kind]]

    @property
    def joint(self) -> IntArray:
        """The joint of each node, shape (n,)."""
        return np.repeat(np.arange(len(self.nodes_from) - 1), np.diff(self.nodes_from))

    @property
    def of_facet(self) -> IntArray:
        """The joint of each facet, shape (f,)."""
        return np.repeat(np.arange(len(self.facets_from) - 1), np.diff(self.facets_from))

    def areas(self, facets: IntArray) -> FloatArray:
        """Areas of some of the facets (rows), shape (m,) [m²; m in 2D]."""
        at = self.own[self.vertices[facets]]
        if at.shape[2] == 2:
            return np.linalg.norm(at[:, 1] - at[:, 0], axis=1)
        spokes = at[:, 1:] - at[:, :1]
        area: FloatArray = 0.5 * np.linalg.norm(np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1), axis=1)
        return area


def _starts(count: Sequence[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(count)])


def _faces(joint: Joint, number: int) -> FaceMesh:
    """Mesh facets of the faces that one side of a joint has there."""
    side = joint[0].sides[number]
    if len(joint) == 1 or len(faces := _numbers(joint, number)) == 1:
        return side.facets
    assert side.mesh is not None
    return face_mesh(side.mesh, faces)


def _numbers(joint: Joint, number: int) -> list[int]:
    """Faces of one side of a joint, each once."""
    return list(dict.fromkeys(patch.sides[number].face for patch in joint))


def _of_patches(joints: Sequence[Joint], number: int, start: IntArray) -> IntArray:
    """First facet of each patch and the one after its last, shape (k, 2).

    Parameters
    ----------
    joints : Of the patches. number : Of the side.
    start : First facet of each joint and, last, all; shape (J + 1,).
    """
    if len(joints[0]) == 1:  # and so have the others
        return np.column_stack([start[:-1], start[1:]])
    ranges: list[tuple[int, int]] = []
    for joint, first in zip(joints, start[:-1].tolist(), strict=True):
        meshes = joint[0].sides[number].surface.face_meshes
        place, at = {}, first
        for face in _numbers(joint, number):
            place[face] = (at, at + len(meshes[face].facets))
            at = place[face][1]
        ranges += [place[patch.sides[number].face] for patch in joint]
    return np.array(ranges)
