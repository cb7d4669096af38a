"""Foresight: estimate how large a scene is before anything large is made of it.

    foresee_blocks(scene)               # from the keys alone
    foresee_meshes(scene, stones)       # from the blocks, before they are meshed
    foresee_points(scene, counts)       # from the common faces, before points are placed on them
    foresee_memory(scene, ...)          # from the points, before anything is factorised

Each raises an error if the limits below are exceeded, unless ``scene.large`` says that the size is meant.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import psutil

from masonry_fem.build.stones import Stones
from masonry_fem.contact.contacts import Contacts
from masonry_fem.errors import SceneError
from masonry_fem.nscd.mumps import LARGE
from masonry_fem.scene import specs
from masonry_fem.scene.misfit import shown
from masonry_fem.solid.assembly import Shape, first_of_each, taken
from masonry_fem.solid.mesh import IntArray

BLOCKS = 1e5  # a rigid wall of so many is built in about a minute
SHARE = 0.9  # of this machine's memory: what a scene may need by the estimate

# measured on walls of rigid bricks and on cubes of up to 50³ elements, in bytes
START = 3.5e8  # libraries, DOLFINx among them
A_POINT = 13e3  # a contact point of rigid blocks: its row of the solver's factor, its state
COPIES = 4  # of the compliance between an elastic block's or a joint's contact points, in factors
A_SHAPE = 1.1e6  # its mesh, and all that is small, for each distinct shape of elastic blocks
DENSE = 1500  # unknowns of a shape that is factorised densely
FACTOR = {2: 4e3, 3: 400.0}  # a sparse factor and its matrices: times n log₂ n / 16 in 2D, n^(4/3) in 3D
BESIDE = 120.0  # the same in 3D where the factor is on disk, while it is made


def foresee_blocks(scene: specs.Scene) -> None:
    """Refuse a scene whose keys ask for more blocks than are built without asking.

    Raises
    ------
    SceneError : Names the structure that has most of them, its keys and the numbers.
    """
    sized = [(one, found) for one in scene.structures if (found := one.foreseen(scene.dimension)) is not None]
    if scene.large or not sized:
        return
    usual = 2 * scene.dimension
    blocks = sum(found.blocks for _, found in sized)
    # two sides meet at a joint, which has two points in 2D and four in space
    points = sum(found.blocks * (found.sides or usual) for _, found in sized) * (scene.dimension - 1)
    memory = START + A_POINT * points
    structure, most = max(sized, key=lambda pair: pair[1].blocks * (pair[1].sides or usual))
    keys = ", ".join(f"{key} = {shown(getattr(structure, key))}" for key in most.keys)
    asked = f"structures.{structure.name} with {keys} brings the scene to some {blocks:.2g} blocks"
    if not blocks <= BLOCKS:
        raise _refused(asked, f"expected at most {BLOCKS:.0f}", "take fewer")
    if not memory <= _room():
        raise _refused(
            f"{asked} and {points:.2g} contact points, {_size(memory)} of memory", _expected(), "take fewer"
        )


def foresee_meshes(scene: specs.Scene, stones: Stones) -> None:
    """Refuse meshes whose factors would not fit into this machine's memory.

    Parameters
    ----------
    scene : The scene.
    stones : Its blocks, not yet meshed.

    Raises
    ------
    SceneError : They would not fit.
    """
    if scene.large:
        return
    total = START
    worst: tuple[float, int, float] = (0.0, -1, 0.0)
    for block, cells in _elastic_shapes(stones):
        shape = stones.assembly.shapes[stones.assembly.blocks.shape[block]]
        memory = factor_memory(unknowns_of(shape, cells, stones.mesh[block]), scene.dimension)
        total += memory
        worst = max(worst, (memory, block, cells))
    if total <= _room():
        return
    _, block, cells = worst
    name, settings = stones.assembly.blocks.names[block], stones.mesh[block]
    key, value = ("size", settings.size) if settings.divisions is None else ("divisions", settings.divisions)
    shape = stones.assembly.shapes[stones.assembly.blocks.shape[block]]
    raise _refused(
        f"mesh.{key} = {shown(value)} makes some {cells:.2g} elements and "
        f"{unknowns_of(shape, cells, settings):.2g} unknowns of block '{name}', and all of it takes "
        f"{_size(total)} of memory",
        _expected(),
        "take larger elements, or make blocks rigid",
    )


def foresee_points(scene: specs.Scene, density: Sequence[int] | IntArray) -> None:
    """Refuse more Gauss points than fit into memory.

    Parameters
    ----------
    scene : The scene.
    density : Subdivision of each interface.

    Raises
    ------
    SceneError : They would not fit.
    """
    total = float((np.array(density, dtype=float) ** (scene.dimension - 1)).sum())
    if not scene.large and not A_POINT * total <= _room():
        raise _refused(
            f"joints with density = {max(density)} have more than {total:.2g} contact points, "
            f"{_size(A_POINT * total)} of memory",
            _expected(),
            "lower joints.density",
        )


def foresee_memory(scene: specs.Scene, memory: float) -> None:
    """Refuse a run that needs more memory than this machine has.

    Parameters
    ----------
    scene : The scene.
    memory : What the run is expected to need [bytes].

    Raises
    ------
    SceneError : It is more than there is.
    """
    if not scene.large and not memory <= _room():
        raise _refused(
            f"a run of this scene needs some {_size(memory)} of memory",
            _expected(),
            "take larger elements, fewer elastic blocks, or rigid ones where stresses are not asked for",
        )


def memory_of_run(stones: Stones, contacts: Contacts) -> float:
    """Peak of a run [bytes].

    A factor of the contact system holds the compliance of each elastic block. Where that is more, it is held
    once for blocks that are alike, and factorised joint by joint.

    Parameters
    ----------
    stones : As they are meshed. contacts : Of all blocks.
    """
    blocks, d = stones.assembly.blocks, stones.assembly.dimension
    points = np.bincount(contacts.blocks.ravel(), minlength=len(blocks))
    elastic = np.array(stones.deforming, dtype=np.int64)
    entries = (d * points[elastic].astype(float)) ** 2
    shapes, of = np.unique(blocks.shape[elastic], return_inverse=True)
    most = np.zeros(len(shapes))  # that a block of the shape has
    np.maximum.at(most, of, entries)
    joints = np.bincount(contacts.interface[np.isin(contacts.blocks, stones.deforming).any(axis=1)])
    by_joints = float(most.sum()) + COPIES * float(((d * joints) ** 2).sum())
    compliance = 8.0 * min(COPIES * float(entries.sum()), by_joints)
    meshes = [stones.assembly.shapes[shape].mesh for shape in shapes.tolist()]
    sizes = [float(mesh.points.size) for mesh in meshes if mesh is not None]
    held = sum(factor_memory(size, d) for size in sizes if size < LARGE)
    # what a factor on disk is made in is free when contacts are solved
    made = sum(factor_memory(size, d) for size in sizes if size >= LARGE)
    return START + A_POINT * contacts.count + A_SHAPE * len(shapes) + held + max(compliance, made)


def factor_memory(unknowns: float, dimension: int) -> float:
    """Of a shape's matrices and the factor of its stiffness [bytes]."""
    if unknowns <= DENSE:
        return 24.0 * unknowns**2
    if dimension == 2:
        return float(FACTOR[2] * unknowns * np.log2(unknowns) / 16)
    return float((FACTOR[3] if unknowns < LARGE else BESIDE) * unknowns ** (4 / 3))


def unknowns_of(shape: Shape, cells: float, settings: specs.MeshSettings) -> float:
    """Displacements at the nodes of so many quadrilaterals or hexahedra."""
    d = shape.solid.dimension
    per_side = int(settings.elements[1])
    return float(d * (per_side * cells ** (1 / d) + 1) ** d)


def _elastic_shapes(stones: Stones) -> Iterator[tuple[int, float]]:
    """A block of each distinct shape and mesh that is still to be meshed, and its elements."""
    if not (elastic := stones.deforming):
        return
    from masonry_fem.meshing.mesher import foreseen_cells  # noqa: PLC0415 - rigid stones need no meshes

    shapes, meshes = stones.assembly.blocks.shape[elastic], taken(stones.mesh, np.array(elastic))
    for (number, mesh), at in first_of_each(list(zip(shapes.tolist(), meshes, strict=True))).items():
        shape = stones.assembly.shapes[number]
        if shape.mesh is None:
            yield elastic[at], foreseen_cells(shape, mesh)


def _room() -> float:
    """Memory that a scene may take on this machine [bytes]."""
    return SHARE * float(psutil.virtual_memory().total)


def _expected() -> str:
    return f"expected at most {_size(_room())}, {SHARE:.0%} of what this machine has"


def _size(memory: float) -> str:
    return f"{memory / 1e9:.2g} GB"


def _refused(said: str, expected: str, cure: str) -> SceneError:
    return SceneError(f"{said}, {expected}; {cure}, or confirm it with --yes (large = true in the scene)")
