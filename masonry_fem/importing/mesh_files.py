"""Mesh files: blocks that were drawn, meshed or surveyed elsewhere.

In files that gmsh reads (``.msh``, ``.unv``, ``.med``, ``.geo``, ``.step``) physical groups of volumes (of
surfaces in 2D) are blocks, and groups of surfaces (curves) are named faces; without groups each volume of the
model is a block ``b1``, ``b2`` ... A group or volume of several disconnected bodies gives one block each,
``name_1``, ``name_2`` ... Nodes that blocks share in the file are duplicated, one for each block. The joint
label of a face is its name, or ``joint`` if it has none.
For other files see ``volumes``, ``abaqus``, ``surfaces`` and ``compas``.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.errors import GeometryError
from masonry_fem.importing import COMPAS, DRAWINGS, INPUTS, MESHES, PROGRAMS, SURFACES, VOLUMES
from masonry_fem.importing.abaqus import read_abaqus
from masonry_fem.importing.alone import alone
from masonry_fem.importing.compas import read_compas
from masonry_fem.importing.foreign import check_points
from masonry_fem.importing.naming import UNSELECTABLE, Names, tell_renamed, unlike
from masonry_fem.importing.outline import outline
from masonry_fem.importing.skin import Skin, once, shape_of
from masonry_fem.importing.surfaces import read_surfaces
from masonry_fem.importing.volumes import read_volumes
from masonry_fem.meshing.cells import boundary_facets, corner_count, turned
from masonry_fem.meshing.session import Elements, elements_of, node_positions, session
from masonry_fem.records.remark import remark
from masonry_fem.records.structure import MeshSettings
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.mesh import FACET_OF, IntArray, Mesh
from masonry_fem.solid.pose import FloatArray, Pose

if TYPE_CHECKING:
    from masonry_fem.structures.file import FileStructure

GEOMETRIES = (*PROGRAMS, *DRAWINGS)
UNNAMED = "joint"


@dataclass(frozen=True, slots=True)
class _Body:
    name: str
    elements: Elements


def read(spec: FileStructure, dimension: int, base: Path, settings: MeshSettings) -> Assembly:
    """The blocks of a file.

    Parameters
    ----------
    spec : Its record in the scene.
    dimension : 2 or 3.
    base : Folder that the path is relative to.
    settings : How geometry files are meshed.

    Raises
    ------
    GeometryError : A missing or unreadable file, a program without trust, no cells of the scene's
        dimension, mixed or inverted elements.
    """
    path = base / spec.path
    key = f"structures.{spec.name}.path"
    if not path.is_file():
        raise GeometryError(
            f"{key}: there is no file '{path}'; correct the path (it is relative to the scene)"
        )
    kind = path.suffix.lower()
    title = f"{key} '{spec.path}'"
    for fault, expected in spec.faults(dimension):  # none, if the scene has been checked
        raise GeometryError(
            f"structures.{spec.name}.{fault} is {getattr(spec, fault)!r}, expected {expected}"
        )
    if kind in MESHES + GEOMETRIES:
        made = _meshed(spec, path, dimension, settings, title)
    elif kind in VOLUMES:
        made = _volumes(spec, path, dimension, title)
    elif kind in INPUTS:
        made = _inputs(spec, path, dimension, title)
    elif kind in SURFACES + COMPAS:
        if dimension == 2:
            raise GeometryError(
                f"{title} holds surfaces of solids, expected a scene with dimension = 3; set it"
            )
        made = _skins(spec, (read_compas if kind in COMPAS else read_surfaces)(path, title), title)
    else:
        known = ", ".join(MESHES + GEOMETRIES + VOLUMES + INPUTS + SURFACES + COMPAS)
        raise GeometryError(f"{key} is '{spec.path}', expected a file ending in one of {known}; convert it")
    _check_supports(spec, [shape.name.removeprefix(f"{spec.name}.") for shape, _ in made])
    blocks = tuple(
        Block(shape.name, number, Pose.identity(dimension), (spec.name,), support=support)
        for number, (shape, support) in enumerate(made)
    )
    return Assembly(dimension, tuple(shape for shape, _ in made), blocks)


def _meshed(
    spec: FileStructure, path: Path, dimension: int, settings: MeshSettings, title: str
) -> list[tuple[Shape, bool]]:
    """Blocks of a file that gmsh reads, and whether each is held."""
    with alone(path, title) as place, session(title) as gmsh:
        _open(gmsh, place, dimension, settings, spec.scale)
        tags, positions = node_positions(gmsh)
        bodies = _distinct(_bodies(gmsh, dimension, spec), title)
        named = _named_facets(gmsh, dimension, spec.path)
    points = _placed(spec, positions, dimension, title)
    shapes = [_shape(spec, body, tags, points, named) for body in bodies]
    _doubt_inner_names(named, shapes, bodies, title)
    return [(shape, _is_support(spec, body.name)) for shape, body in zip(shapes, bodies, strict=True)]


def _doubt_inner_names(
    named: dict[tuple[int, ...], str], shapes: list[Shape], bodies: list[_Body], title: str
) -> None:
    """Remark named facets that are none of the bodies' outer ones: the faces have their name in part only."""
    if not named:
        return
    outer: set[tuple[int, ...]] = set()
    for shape, body in zip(shapes, bodies, strict=True):
        assert shape.mesh is not None  # each is made of elements
        facets = _corners(shape.mesh.facets, body.elements.kind, np.unique(body.elements.nodes))
        outer |= set(map(tuple, facets))
    if lost := Counter(name for row, name in named.items() if row not in outer):
        told = ", ".join(f"'{name}' {many}" for name, many in lost.items())
        remark(
            "names_inside",
            f"{title}: some facets of named surfaces are on the outside of no block (of {told}), as where "
            "elements beside them have other diagonals or nodes; loads, supports and joints that ask for "
            "these names miss parts of the faces; mesh surfaces and volumes together",
        )


def _volumes(spec: FileStructure, path: Path, dimension: int, title: str) -> list[tuple[Shape, bool]]:
    """Blocks of a file of elements with a field, or of connected parts."""
    found = read_volumes(path, dimension, spec.field, title)
    points = _placed(spec, found.points, dimension, title)
    bodies: list[_Body] = []
    for name, elements in found.parts:
        bodies += _split(name, "_", elements) if name else _split("b", "", elements, always=True)
    if len({body.name for body in bodies}) < len(
        bodies
    ):  # several kinds of elements, and no field with blocks
        bodies = [_Body(f"b{number}", body.elements) for number, body in enumerate(bodies, start=1)]
    tags = np.arange(len(points))
    shapes = [_shape(spec, body, tags, points, {}) for body in bodies]
    return [(shape, _is_support(spec, body.name)) for shape, body in zip(shapes, bodies, strict=True)]


def _inputs(spec: FileStructure, path: Path, dimension: int, title: str) -> list[tuple[Shape, bool]]:
    """Blocks of an input file of Abaqus or CalculiX."""
    found = read_abaqus(path, dimension, title)
    points = _placed(spec, found.points, dimension, title)
    bodies = [
        body
        for name, elements in found.parts
        for body in (_split(name, "_", elements) if name else _split("b", "", elements, always=True))
    ]
    tags = np.arange(len(points))
    bodies = _distinct(bodies, title)
    shapes = [_shape(spec, body, tags, points, found.named) for body in bodies]
    return [(shape, _is_support(spec, body.name)) for shape, body in zip(shapes, bodies, strict=True)]


def _skins(spec: FileStructure, skins: list[Skin], title: str) -> list[tuple[Shape, bool]]:
    """Blocks of closed surfaces."""
    made = []
    skins = _distinct([once(skin) for skin in skins], title)
    doubled = [skin for skin in skins if skin.doubles]
    if doubled:
        remark(
            "doubled_faces",
            f"{title} has {sum(skin.doubles for skin in doubled)} faces a second time (in {len(doubled)} "
            f"blocks, '{doubled[0].name}' the first); they are left out",
            *(f"{spec.name}.{skin.name}" for skin in doubled),
        )
    for skin in skins:
        with np.errstate(over="ignore"):  # told by the check
            scaled = replace(skin, points=spec.scale * skin.points)
        made.append((shape_of(scaled, spec.name, title), skin.support or _is_support(spec, skin.name)))
    return made


def _placed(spec: FileStructure, found: FloatArray, dimension: int, title: str) -> FloatArray:
    """The points of a file in metres, in the scene's dimension."""
    with np.errstate(over="ignore"):  # told by the check
        positions = spec.scale * found
    check_points(positions, title)
    if dimension == 2 and np.ptp(positions[:, 2]) > 1e-9 * np.ptp(positions, axis=0).max():
        raise GeometryError(
            f"{title} is not flat in z, expected a plane figure; set dimension = 3 or flatten it"
        )
    return positions[:, :dimension]


def _open(gmsh: Any, path: Path, dimension: int, settings: MeshSettings, scale: float) -> None:
    """Load the file; mesh it where it is a geometry, in elements of its own order where none is asked for."""
    gmsh.option.setString("Geometry.OCCTargetUnit", "M")
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0)
    gmsh.open(str(path))
    if path.suffix.lower() in MESHES:
        return
    if settings.size is not None:
        gmsh.option.setNumber("Mesh.MeshSizeMax", settings.size / scale)
    gmsh.model.mesh.generate(dimension)
    if settings.element is not None:
        gmsh.model.mesh.setOrder(int(settings.element[1]))


def _bodies(gmsh: Any, dimension: int, spec: FileStructure) -> list[_Body]:
    if gmsh.model.getPhysicalGroups(dimension):
        _doubt_ungrouped(gmsh, dimension, spec)
        bodies = _of_groups(gmsh, dimension, spec)
    else:
        bodies = _of_entities(gmsh, dimension, spec)
    if not bodies:
        cells = {2: "surface", 3: "volume"}[dimension]
        raise GeometryError(
            f"structures.{spec.name}.path '{spec.path}' has no {cells} elements, expected a meshed "
            f"{dimension}D model; mesh it in {dimension}D and save all elements or groups"
        )
    return bodies


def _of_groups(gmsh: Any, dimension: int, spec: FileStructure) -> list[_Body]:
    """The bodies of each physical group, by its name."""
    bodies: list[_Body] = []
    names = _group_names(gmsh, dimension, f"structures.{spec.name}.path '{spec.path}'")
    for tag, name in names.items():
        entities = [int(entity) for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)]
        elements = elements_of(gmsh, dimension, entities, f"'{spec.path}', group '{name}'")
        if elements is not None:
            bodies += _split(name, "_", elements)
    return bodies


def _of_entities(gmsh: Any, dimension: int, spec: FileStructure) -> list[_Body]:
    """The bodies of a file without groups, numbered: the disconnected parts of each of gmsh's entities."""
    entities = [int(entity) for _, entity in gmsh.model.getEntities(dimension)]
    found = [elements_of(gmsh, dimension, [entity], f"'{spec.path}'") for entity in entities]
    parts = [part for part in found if part is not None]
    _tell_shared(parts, dimension, spec)
    bodies = [body for part in parts for body in _split("b", "", part, always=True)]
    return [_Body(f"b{number}", body.elements) for number, body in enumerate(bodies, start=1)]


def _tell_shared(parts: list[Elements], dimension: int, spec: FileStructure) -> None:
    """Remark entities with common nodes: they are blocks with joints between them."""
    nodes = np.concatenate([np.unique(part.nodes) for part in parts]) if parts else np.empty(0, np.int64)
    if len(np.unique(nodes)) < len(nodes):
        what = {2: "surfaces", 3: "volumes"}[dimension]
        remark(
            "shared_nodes",
            f"structures.{spec.name}.path '{spec.path}' has no physical groups, and some of its {len(parts)} "
            f"{what} share nodes; each of them is a block of its own, with joints between them; put {what} "
            "that make one block in one physical group",
        )


def _group_names(gmsh: Any, dimension: int, title: str) -> dict[int, str]:
    """Name of each physical group by its tag, one that selectors can use."""
    names = Names(UNSELECTABLE)
    tags = [int(tag) for _, tag in gmsh.model.getPhysicalGroups(dimension)]
    made = {
        tag: names.of(gmsh.model.getPhysicalName(dimension, tag).rstrip()) or f"group{tag}" for tag in tags
    }
    tell_renamed(title, names.changed)
    return made


def _doubt_ungrouped(gmsh: Any, dimension: int, spec: FileStructure) -> None:
    """Remark meshed entities that no group holds: they are left out."""
    left = [
        int(entity)
        for _, entity in gmsh.model.getEntities(dimension)
        if not len(gmsh.model.getPhysicalGroupsForEntity(dimension, entity))
        and len(gmsh.model.mesh.getElements(dimension, entity)[0])
    ]
    if left:
        remark(
            "ungrouped",
            f"structures.{spec.name}.path '{spec.path}': {len(left)} of its bodies (gmsh's tags "
            f"{', '.join(map(str, left[:8]))}) are in no physical group and left out; put each in a group, "
            "or take all groups away",
        )


def _distinct[Named: (_Body, Skin)](parts: list[Named], title: str) -> list[Named]:
    """The parts by names that differ: the first part of ``a`` is ``a_1``, and the file may have that, too."""
    names = unlike([part.name for part in parts])
    changed = [(part.name, name) for part, name in zip(parts, names, strict=True) if part.name != name]
    tell_renamed(title, dict(changed))
    return [replace(part, name=name) for part, name in zip(parts, names, strict=True)]


def _split(name: str, mark: str, elements: Elements, always: bool = False) -> list[_Body]:
    """One body for each disconnected part."""
    corners = elements.nodes[:, : corner_count(elements.kind)]
    nodes, numbers = np.unique(corners, return_inverse=True)
    numbers = numbers.reshape(corners.shape)
    cell = np.repeat(np.arange(len(corners)), corners.shape[1])
    incidence = sparse.csr_array(
        (np.ones(len(cell)), (cell, numbers.ravel())), shape=(len(corners), len(nodes))
    )
    count, part = connected_components(incidence @ incidence.T, directed=False)
    if count == 1 and not always:
        return [_Body(name, elements)]
    return [
        _Body(f"{name}{mark}{i + 1}", Elements(elements.kind, elements.nodes[part == i]))
        for i in range(count)
    ]


def _named_facets(gmsh: Any, dimension: int, path: str) -> dict[tuple[int, ...], str]:
    """Name of each facet in a physical group, by its sorted corner tags."""
    named: dict[tuple[int, ...], str] = {}
    names = _group_names(gmsh, dimension - 1, f"'{path}'")
    for _, tag in gmsh.model.getPhysicalGroups(dimension - 1):
        name = names[tag]
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension - 1, tag):
            found = elements_of(gmsh, dimension - 1, [int(entity)], f"'{path}', group '{name}'")
            if found is not None:
                corners = np.sort(found.nodes[:, : corner_count(found.kind)], axis=1)
                named |= {tuple(row): name for row in corners.tolist()}
    return named


def _shape(
    spec: FileStructure,
    body: _Body,
    tags: IntArray,
    positions: FloatArray,
    named: dict[tuple[int, ...], str],
) -> Shape:
    kind = body.elements.kind
    used, cells = np.unique(body.elements.nodes, return_inverse=True)
    points = positions[np.searchsorted(tags, used)]
    cells = _upright(cells.reshape(body.elements.nodes.shape), points, kind, f"{spec.name}.{body.name}")
    facets = boundary_facets(cells, kind)
    if not len(facets):
        raise GeometryError(
            f"block '{spec.name}.{body.name}' of '{spec.path}' has no outer face, as each of its elements "
            "stands in the file twice; export it again"
        )
    names = [named.get(tuple(row), "") for row in _corners(facets, kind, used)]
    solid, owner = outline(points, kind, facets, names, UNNAMED)
    return Shape(f"{spec.name}.{body.name}", solid, Mesh(points, kind, cells, facets, owner))


def _corners(facets: IntArray, kind: str, tags: IntArray) -> list[list[int]]:
    """Sorted tags of the corners of each facet of elements of a kind, whose nodes have these tags."""
    found: list[list[int]] = np.sort(tags[facets[:, : corner_count(FACET_OF[kind])]], axis=1).tolist()
    return found


def _upright(cells: IntArray, points: FloatArray, kind: str, name: str) -> IntArray:
    """The cells with positive volume: a block meshed inside out is turned, a tangled one refused."""
    linear = kind.rstrip("0123456789")
    corner = points[cells[:, : corner_count(kind)]]
    edges = {"triangle": (1, 2), "quad": (1, 3), "tetra": (1, 2, 3), "hexahedron": (1, 3, 4)}[linear]
    volume = np.linalg.det(corner[:, list(edges)] - corner[:, :1])
    folded = (np.diff(np.sort(cells, axis=1)) == 0).any(axis=1)  # a node stands in them twice
    if (volume > 0).all() and not folded.any():
        return cells
    if (volume < 0).all() and not folded.any():
        return cells[:, turned(kind)]
    bad = int(((volume <= 0) | folded).sum())
    raise GeometryError(
        f"block '{name}': {bad} of {len(cells)} elements are inverted, flat or folded, expected positive "
        "volumes; mesh it again with consistent orientation"
    )


def _is_support(spec: FileStructure, name: str) -> bool:
    return any(
        fnmatchcase(name, pattern) or fnmatchcase(f"{spec.name}.{name}", pattern) for pattern in spec.supports
    )


def _check_supports(spec: FileStructure, names: list[str]) -> None:
    for index, pattern in enumerate(spec.supports):
        if not any(fnmatchcase(n, pattern) or fnmatchcase(f"{spec.name}.{n}", pattern) for n in names):
            raise GeometryError(
                f"structures.{spec.name}.supports.{index} = '{pattern}' selects no block of the file; "
                f"there are {', '.join(names[:8])}"
            )
