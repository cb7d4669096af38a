"""COMPAS: skins of blocks from the JSON files of compas, compas_assembly, compas_cra and compas_dem.

    skins = read_compas(Path("arch.json"), "structures.arch.path 'arch.json'")

The package compas is not needed. A mesh is a record of ``vertex`` (x, y, z by key) and ``face`` (keys of its
corners), wrapped as ``{"dtype", "value"}`` (compas 0 and 1) or ``{"dtype", "data"}`` (1 and 2). Blocks are
the ``block`` or ``part`` of the nodes of an assembly's graph, the ``blocks`` of an old assembly, the
``geometry``
of the elements of a model (or of the model of a problem), or a mesh or list of meshes. A block is named ``b``
and its key in the file; in a list ``b1``, ``b2`` ... Blocks that the file marks ``is_support`` are supports.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.naming import tell_renamed, tidy_name, unlike
from masonry_fem.importing.skin import Skin
from masonry_fem.solid.pose import FloatArray

GEOMETRIES = ("block", "part", "geometry", "shape", "mesh")  # keys that hold a block's mesh


@dataclass(frozen=True, slots=True)
class _Found:
    """A block as the file has it: its key, its mesh's record, whether it is held, how it is moved."""

    key: str
    mesh: dict[str, Any]
    support: bool = False
    matrix: Any = None


def read_compas(path: Path, title: str) -> list[Skin]:
    """The blocks of a file, in the order of their keys in it.

    Parameters
    ----------
    path : The JSON file.
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : The file is no JSON, has no block, or a mesh lacks corners or faces.
    """
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        found = list(_blocks(_unwrapped(record)))
    except RecursionError as error:
        raise GeometryError(
            f"{title} nests lists or records hundreds deep, expected an assembly, a model or meshes of "
            "compas; save it again with compas.json_dump"
        ) from error
    except ValueError as error:  # bad JSON or UTF-8, numbers of thousands of digits
        raise GeometryError(f"{title} is no JSON ({error}); save it again with compas.json_dump") from error
    except (AttributeError, TypeError) as error:
        raise GeometryError(
            f"{title} is laid out as no file of compas is ({error}), expected an assembly, a model or "
            "meshes; save it again with compas.json_dump"
        ) from error
    if not found:
        kind = "a list" if isinstance(record, list) else "a single value"
        if isinstance(record, dict):
            kind = record.get("dtype", "a record")
        raise GeometryError(
            f"{title} is {kind} without blocks, expected an assembly, a model or meshes of compas with "
            "'vertex' and 'face'; convert other geometry (Brep, polyhedron) to meshes there"
        )
    names = unlike([f"b{tidy_name(one.key)}" for one in found])
    pairs = zip(found, names, strict=True)
    tell_renamed(title, {one.key: name for one, name in pairs if name != f"b{one.key}"})
    return [_skin(name, one, title) for name, one in zip(names, found, strict=True)]


def _unwrapped(record: Any) -> Any:
    """The content of ``{"dtype", "data"}`` or ``{"dtype", "value"}``, however deep."""
    while isinstance(record, dict) and ("dtype" in record or "datatype" in record):
        inner = record.get("data", record.get("value"))
        if not isinstance(inner, dict | list):
            break
        record = inner
    return record


def _blocks(record: Any) -> Iterator[_Found]:
    """Blocks of unwrapped data."""
    if isinstance(record, list):
        yield from _of_list(record)
    elif not isinstance(record, dict):
        return
    elif _is_mesh(record):
        yield _Found("1", record)
    elif isinstance(record.get("model"), dict) and ("boundary_conditions" in record or "results" in record):
        yield from _blocks(_unwrapped(record["model"]))
    elif isinstance(record.get("elements"), dict | list):
        yield from _of_elements(record)
    elif isinstance(record.get("blocks"), dict):
        yield from _of_old_assembly(record)
    else:
        yield from _of_graph(_unwrapped(record.get("graph")) or record)


def _of_list(record: list[Any]) -> Iterator[_Found]:
    """Meshes of a list, by their place among its records."""
    flat = [one for one in _flat(record) if isinstance(one, dict)]
    yield from (_Found(str(number), one) for number, one in enumerate(flat, start=1) if _is_mesh(one))


def _flat(record: list[Any]) -> Iterator[Any]:
    for one in record:
        inner = _unwrapped(one)
        if isinstance(inner, list):
            yield from _flat(inner)
        else:
            yield inner


def _is_mesh(record: Any) -> bool:
    return isinstance(record, dict) and isinstance(record.get("vertex"), dict) and "face" in record


def _of_elements(record: dict[str, Any]) -> Iterator[_Found]:
    """Elements of a model, by the number of their node in its graph."""
    elements = record["elements"]
    if isinstance(elements, list):
        elements = {str((one or {}).get("guid", at)): one for at, one in enumerate(elements)}
    nodes = (_unwrapped(record.get("graph")) or {}).get("node", {})
    number = {str(node.get("element")): key for key, node in nodes.items() if isinstance(node, dict)}
    for at, (guid, element) in enumerate(elements.items()):
        yield from _of_node(str(number.get(str(guid), at)), _unwrapped(element))


def _of_old_assembly(record: dict[str, Any]) -> Iterator[_Found]:
    """Blocks beside the network whose vertices say which are held."""
    nodes = _unwrapped(record.get("assembly")) or {}
    held = {key: bool(node.get("is_support")) for key, node in nodes.get("vertex", {}).items()}
    for key, block in record["blocks"].items():
        yield from _of_node(str(key), {"block": block, "is_support": held.get(key, False)})


def _of_graph(graph: dict[str, Any]) -> Iterator[_Found]:
    """Blocks or parts at the nodes of a graph."""
    for key, node in (graph.get("node") or {}).items():
        if isinstance(node, dict):
            yield from _of_node(str(key), node)


def _of_node(key: str, node: Any) -> Iterator[_Found]:
    """The mesh of a node or an element, under whichever key it is stored."""
    if _is_mesh(node):
        yield _Found(key, node)
        return
    if not isinstance(node, dict):
        return
    attributes = node.get("attributes") or {}
    held = bool(node.get("is_support") or attributes.get("is_support"))
    matrix = _unwrapped(node.get("transformation"))
    for name in GEOMETRIES:
        inner = _unwrapped(node.get(name, attributes.get(name)))
        found = next(_of_node(key, inner), None) if inner is not None else None
        if found is not None:
            own = matrix.get("matrix") if isinstance(matrix, dict) else None
            yield replace(found, support=held or found.support, matrix=own or found.matrix)
            return


def _skin(name: str, found: _Found, title: str) -> Skin:
    mesh = found.mesh
    rows = {str(key): row for row, key in enumerate(mesh["vertex"])}
    faces = mesh["face"]
    try:
        defaults = {"x": 0.0, "y": 0.0, "z": 0.0} | (
            mesh.get("default_vertex_attributes") or mesh.get("dva") or {}
        )
        points = np.array(
            [
                [float(vertex.get(axis, defaults[axis])) for axis in "xyz"]
                for vertex in mesh["vertex"].values()
            ]
        )
        loops = tuple(
            tuple(rows[str(key)] for key in face)
            for face in (faces.values() if isinstance(faces, dict) else faces)
        )
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise GeometryError(
            f"{title}, block '{name}': its mesh has the corner {error}, expected numbers x, y, z and faces "
            "of known corners; save it again with compas.json_dump"
        ) from error
    if found.matrix is not None:
        points = _moved(points, found.matrix, f"{title}, block '{name}'")
    return Skin(name, points.reshape(-1, 3), loops, support=found.support)


def _moved(points: FloatArray, given: Any, title: str) -> FloatArray:
    """Points where an element's transformation puts them."""
    try:
        matrix = np.array(given, dtype=float).reshape(4, 4)
    except (TypeError, ValueError, OverflowError) as error:
        raise GeometryError(
            f"{title}: its transformation is no matrix ({error}), expected 4 rows of 4 numbers; save it "
            "again with compas.json_dump"
        ) from error
    moved: FloatArray = points @ matrix[:3, :3].T + matrix[:3, 3]
    return moved
