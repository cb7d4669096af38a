"""Assembly: the blocks of a structure as shapes and poses.

Congruent blocks share one Shape, so that everything that is costly (mesh, stiffness, factor)
is done once for each distinct shape.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import overload

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import GeometryError
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Shape:
    """Geometry of a block in its own frame; equal blocks share a shape.

    Attributes
    ----------
    name : Its name in messages and mesh files.
    solid : Flat-faced solid, from which contact faces and rigid mass are computed.
    mesh : Elements, if they were read from a mesh file; None: it is meshed later.
    arcs : Edges that are circular arcs rather than straight: ``(vertex, vertex, centre)`` with
        the centre in shape coordinates; the mesher places nodes on them.
    rails : Of a solid with six sides (four in 2D), some of which consist of several facets: the chains
        of vertices along its first axis, low and high, in 3D those of the front, then of the back.
        The mesher places nodes on them.
    parts : Number of equal parts of the rails; where two parts meet there is a kink and a node.
    """

    name: str
    solid: Polytope
    mesh: Mesh | None = None
    arcs: tuple[tuple[int, int, tuple[float, ...]], ...] = ()
    rails: tuple[tuple[int, ...], ...] = ()
    parts: int = 1


@dataclass(frozen=True, slots=True)
class Block:
    """One stone: a shape in a pose.

    Attributes
    ----------
    name : Unique in the scene, such as ``wall.c2.b3``.
    shape : Index into ``Assembly.shapes``.
    pose : Its place and orientation.
    groups : Names by which a scene may select it (its structure, course, ...).
    support : True for a block that its structure adds to carry the others (ground, springing).
    """

    name: str
    shape: int
    pose: Pose
    groups: tuple[str, ...] = ()
    support: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Blocks(Sequence[Block]):
    """b blocks as arrays; one by one they are objects, made as they are looked at.

    Attributes
    ----------
    names : Of all blocks.
    shape : Index into ``Assembly.shapes``, shape (b,).
    rotation, translation : Their poses, shape (b, d, d) and (b, d) [m].
    grouping : Number of each block's groups in ``groupings``, shape (b,).
    groupings : Groups that blocks have, and maybe some that none of them has.
    support : True for supports, shape (b,).
    """

    names: tuple[str, ...]
    shape: IntArray
    rotation: FloatArray
    translation: FloatArray
    grouping: IntArray
    groupings: tuple[tuple[str, ...], ...]
    support: Mask

    @classmethod
    def of(cls, blocks: Iterable[Block], dimension: int) -> Blocks:
        """The arrays of some blocks.

        Parameters
        ----------
        blocks : One by one, or arrays already.
        dimension : d.

        Raises
        ------
        GeometryError : A pose has another dimension.
        """
        if isinstance(blocks, Blocks):
            return blocks
        stones = list(blocks)
        for stone in stones:
            if stone.pose.translation.shape != (dimension,):
                raise GeometryError(
                    f"block '{stone.name}' has the place {stone.pose.translation.tolist()}, expected "
                    f"{dimension} coordinates; correct its pose"
                )
        groupings = {groups: number for number, groups in enumerate(dict.fromkeys(s.groups for s in stones))}
        return cls(
            names=tuple(stone.name for stone in stones),
            shape=np.array([stone.shape for stone in stones], dtype=np.int64),
            rotation=np.array([s.pose.rotation for s in stones], float).reshape(-1, dimension, dimension),
            translation=np.array([s.pose.translation for s in stones], float).reshape(-1, dimension),
            grouping=np.array([groupings[stone.groups] for stone in stones], dtype=np.int64),
            groupings=tuple(groupings),
            support=np.array([stone.support for stone in stones], dtype=bool),
        )

    @classmethod
    def laid(
        cls,
        names: Sequence[str],
        shape: int | IntArray,
        rotation: FloatArray,
        translation: FloatArray,
        groupings: Sequence[tuple[str, ...]],
        grouping: int | IntArray = 0,
        *,
        support: bool = False,
    ) -> Blocks:
        """The b blocks of a course or a ring, all supports or none.

        Parameters
        ----------
        names : Of the blocks. shape : Of all, or of each, shape (b,).
        rotation, translation : Of all, or of each, shapes (b, d, d) and (b, d) [m].
        groupings : Groups that they have.
        grouping : Number of the groups of all blocks among these, or of each, shape (b,).
        support : Whether they are supports.
        """
        b, d = len(names), translation.shape[-1]
        return cls(
            names=tuple(names),
            shape=np.broadcast_to(np.asarray(shape, dtype=np.int64), (b,)),
            rotation=np.broadcast_to(rotation, (b, d, d)),
            translation=np.broadcast_to(translation, (b, d)),
            grouping=np.broadcast_to(np.asarray(grouping, dtype=np.int64), (b,)),
            groupings=tuple(groupings),
            support=np.full(b, support),
        )

    @classmethod
    def joined(cls, parts: Sequence[Blocks]) -> Blocks:
        """All blocks of some parts, one part after another.

        Parameters
        ----------
        parts : At least one.
        """
        groupings = list(dict.fromkeys(chain.from_iterable(part.groupings for part in parts)))
        number = dict(zip(groupings, range(len(groupings)), strict=True))
        own = [np.fromiter(map(number.__getitem__, part.groupings), np.int64) for part in parts]
        return cls(
            names=tuple(chain.from_iterable(part.names for part in parts)),
            shape=np.concatenate([part.shape for part in parts]),
            rotation=np.concatenate([part.rotation for part in parts]),
            translation=np.concatenate([part.translation for part in parts]),
            grouping=np.concatenate([new[part.grouping] for new, part in zip(own, parts, strict=True)]),
            groupings=tuple(groupings),
            support=np.concatenate([part.support for part in parts]),
        )

    def only(self, chosen: IntArray | Mask) -> Blocks:
        """Some of the blocks.

        Parameters
        ----------
        chosen : Their numbers, shape (k,), or a mask, shape (b,).
        """
        numbers = np.arange(len(self))[chosen]
        return replace(
            self,
            names=taken(self.names, numbers),
            shape=self.shape[numbers],
            rotation=self.rotation[numbers],
            translation=self.translation[numbers],
            grouping=self.grouping[numbers],
            support=self.support[numbers],
        )

    def index(self, value: object, start: int = 0, stop: int | None = None) -> int:
        """Number of a block, which its name tells."""
        if not isinstance(value, Block):
            raise ValueError(f"{value!r} is no block, expected a Block; look names up in 'names'")
        return self.names.index(value.name, start, len(self) if stop is None else stop)

    def __contains__(self, value: object) -> bool:
        return isinstance(value, Block) and value.name in self.names

    def __len__(self) -> int:
        return len(self.names)

    @overload
    def __getitem__(self, number: int) -> Block: ...
    @overload
    def __getitem__(self, number: slice) -> Blocks: ...
    def __getitem__(self, number: int | slice) -> Block | Blocks:
        if isinstance(number, slice):
            return self.only(np.arange(len(self))[number])
        pose = Pose(self.rotation[number], self.translation[number])
        groups = self.groupings[self.grouping[number]]
        return Block(self.names[number], int(self.shape[number]), pose, groups, bool(self.support[number]))

    def __iter__(self) -> Iterator[Block]:
        return map(self.__getitem__, range(len(self)))


def taken[T](values: Sequence[T], numbers: IntArray) -> tuple[T, ...]:
    """Values by number, k of them.

    Parameters
    ----------
    values : Of any kind. numbers : Shape (k,).
    """
    return tuple(map(values.__getitem__, numbers.tolist()))


def first_of_each[T: Hashable](values: Sequence[T]) -> dict[T, int]:
    """Where each distinct value comes first, in that order.

    Parameters
    ----------
    values : Of any kind.
    """
    places = dict(zip(reversed(values), reversed(range(len(values))), strict=True))
    return dict(sorted(places.items(), key=lambda one: one[1]))


@dataclass(frozen=True, slots=True)
class Assembly:
    """All blocks of a structure or of a scene.

    Attributes
    ----------
    dimension : 2 or 3.
    shapes : Distinct shapes.
    blocks : Blocks; the place in this sequence is the number of a block everywhere in the program.
    """

    dimension: int
    shapes: tuple[Shape, ...]
    blocks: Blocks

    def __init__(self, dimension: int, shapes: Sequence[Shape], blocks: Iterable[Block]) -> None:
        """Blocks one by one, or their arrays."""
        object.__setattr__(self, "dimension", dimension)
        object.__setattr__(self, "shapes", tuple(shapes))
        object.__setattr__(self, "blocks", Blocks.of(blocks, dimension))

    @property
    def meshed(self) -> Mask:
        """Blocks that have a mesh, shape (b,)."""
        shapes = np.array([shape.mesh is not None for shape in self.shapes], dtype=bool)
        found: Mask = shapes[self.blocks.shape]
        return found

    def solid(self, block: int) -> Polytope:
        """The solid of one block in world coordinates."""
        blocks = self.blocks
        return self.shapes[int(blocks.shape[block])].solid.moved(
            Pose(blocks.rotation[block], blocks.translation[block])
        )
