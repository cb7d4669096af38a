"""COMPAS: blocks with the forces in their joints, as ``compas.json_load`` and compas_dem (0.6) read them.

    compas.json_load("arch.json")       # {"model": BlockModel, "results": Results}

compas_dem's viewer shows it by ``viewer.add_solution(data["results"])``. Each joint is a FrictionContact
whose points are the corners of the convex hull of its contact points; their reactions are shared among the
corners so that force and moment stay the same and pressures stay pressures. Blocks have their outer faces,
and the rigid motion that is nearest to theirs.
"""

from __future__ import annotations

import json
import uuid
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from masonry_fem.errors import SceneError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.output import fields
from masonry_fem.output.exporting.motion import motion_of
from masonry_fem.output.scenery import surface_of
from masonry_fem.output.viewing.recorded import Recorded, entries_of, read_grid

FloatArray = NDArray[np.float64]

SUPPORT = "support"  # of fidelities
FLAT = 1e-9  # of a joint's size: contact points this near to a line are on it


def write(recorded: Recorded, place: int, path: Path) -> list[Path]:
    """Write a step.

    Parameters
    ----------
    recorded : The steps. place : Which, from 0 on. path : The file.

    Raises
    ------
    SceneError : The structure is plane, as COMPAS knows solids only.
    """
    blocks = recorded.blocks(place)
    if int(blocks.field_data["dimension"][0]) == 2:
        raise SceneError(
            f"'{recorded.directory}' is a plane structure, expected solids: COMPAS has no others"
        )
    names = bytes(np.asarray(blocks.field_data["block_names"])).decode().splitlines()
    meshes, held = _meshes(blocks, len(names)), _held(blocks, len(names))
    joints = _joints(recorded, place)
    model, guids = _model(recorded, names, meshes, held, joints)
    told = {"model": model, "results": _results(model["guid"], blocks, guids, joints)}
    write_atomic(path, json.dumps(told).encode())
    return [path]


def _guid(*parts: object) -> str:
    """A number that is the same in each export of the same thing."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, "masonry_fem/" + "/".join(map(str, parts))))


def _model(
    recorded: Recorded, names: list[str], meshes: list[Any], held: NDArray[np.bool_], joints: list[Any]
) -> tuple[dict[str, Any], list[str]]:
    """The BlockModel, and the number of each block in it."""
    title = recorded.title
    guids = [_guid(title, name) for name in names]
    elements = {
        guid: {
            "dtype": "compas_dem.elements/Block", "guid": guid,
            "data": {
                "transformation": None, "features": [], "name": name, "material": None, "geometry": mesh,
                "is_support": bool(support),
            },
        }
        for guid, name, mesh, support in zip(guids, names, meshes, held, strict=True)
    }  # fmt: skip
    edges: dict[str, dict[str, Any]] = {str(number): {} for number in range(len(names))}
    for joint in joints:
        at = edges[str(joint["edge"][0])].setdefault(str(joint["edge"][1]), {"contacts": []})
        at["contacts"].append(joint["contact"])
    graph = {
        "attributes": {},
        "default_node_attributes": {"x": 0.0, "y": 0.0, "z": 0.0, "element": None},
        "default_edge_attributes": {"modifiers": None, "contacts": None},
        "node": {str(number): {"element": guid} for number, guid in enumerate(guids)},
        "edge": edges, "max_node": len(names) - 1,
    }  # fmt: skip
    tree = {
        "attributes": {},
        "root": {"name": "root", "children": [{"name": "ElementNode", "element": guid} for guid in guids]},
    }
    data = {"transformation": None, "elements": elements, "materials": {}, "tree": tree, "graph": graph}
    guid = _guid(title)
    return {"dtype": "compas_dem.models/BlockModel", "data": data, "name": title, "guid": guid}, guids


def _results(model: str, blocks: Any, guids: list[str], joints: list[Any]) -> dict[str, Any]:
    """The Results: how blocks have moved, and what joints carry."""
    matrices = motion_of(blocks, len(guids)).matrix.tolist()
    nodes = {
        str(number): {
            "transformation": {"dtype": "compas.geometry/Transformation", "data": {"matrix": matrix}}
        }
        for number, matrix in enumerate(matrices)
    }
    edges: dict[str, Any] = {}
    for joint in joints:
        edges.setdefault(f"{joint['edge'][0]},{joint['edge'][1]}", joint["told"])
    data = {
        "model_id": model, "problem_id": model, "displacement_scale": 1.0, "node_data": nodes,
        "edge_data": edges, "metadata": {"solver": "masonry_fem"},
    }  # fmt: skip
    return {"dtype": "compas_dem.problem/Results", "data": data, "guid": _guid(model, "results")}


def _held(blocks: Any, count: int) -> NDArray[np.bool_]:
    """Which blocks are supports."""
    words = bytes(np.asarray(blocks.field_data["fidelity_names"])).decode().splitlines()
    held = np.zeros(count, bool)
    own = np.asarray(blocks.cell_data[fields.FIDELITY]) == words.index(SUPPORT)
    held[np.asarray(blocks.cell_data[fields.BLOCK])[own]] = True
    return held


def _meshes(blocks: Any, count: int) -> list[dict[str, Any]]:
    """The outer faces of each block as a mesh of COMPAS."""
    skin = surface_of(blocks)
    points = np.asarray(skin.points, float)
    offset = np.asarray(skin.GetPolys().GetOffsetsArray())
    corners = np.asarray(skin.GetPolys().GetConnectivityArray())
    owner = np.asarray(skin.cell_data[fields.BLOCK])
    order = np.argsort(owner, kind="stable")
    ends = np.searchsorted(owner[order], np.arange(count + 1))
    made = []
    for block in range(count):
        faces = [corners[offset[cell] : offset[cell + 1]] for cell in order[ends[block] : ends[block + 1]]]
        used, where = np.unique(np.concatenate(faces), return_inverse=True)
        loops = np.split(where, np.cumsum([len(face) for face in faces])[:-1])
        made.append(_mesh(points[used], loops))
    return made


def _mesh(points: FloatArray, loops: list[NDArray[np.int64]]) -> dict[str, Any]:
    data = {
        "attributes": {},
        "default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0},
        "default_edge_attributes": {}, "default_face_attributes": {},
        "vertex": {str(n): dict(zip("xyz", p, strict=True)) for n, p in enumerate(points.tolist())},
        "face": {str(n): loop.tolist() for n, loop in enumerate(loops)},
        "facedata": {}, "edgedata": {}, "max_vertex": len(points) - 1, "max_face": len(loops) - 1,
    }  # fmt: skip
    return {"dtype": "compas.datastructures/Mesh", "data": data}


def _joints(recorded: Recorded, place: int) -> list[dict[str, Any]]:
    """Edge, contact and figures of each joint that has three contact points which are not in line."""
    collection = recorded.directory / "contacts.pvd"
    if not collection.exists():
        return []
    cloud = read_grid(entries_of(collection)[recorded.times[place]])
    number = np.asarray(cloud.point_data[fields.INTERFACE])
    order = np.argsort(number, kind="stable")
    starts = np.flatnonzero(np.diff(number[order], prepend=-1))
    arrays = {
        name: np.asarray(cloud.point_data[name])
        for name in (fields.NORMAL, fields.TANGENTS[0], fields.REACTION, fields.ANTAGONIST, fields.CANDIDATE)
    }
    points = np.asarray(cloud.points, float)
    made = []
    for rows in np.split(order, starts[1:]):
        joint = _joint(points[rows], {name: values[rows] for name, values in arrays.items()})
        if joint is not None:
            made.append(joint)
    return made


def _joint(points: FloatArray, arrays: dict[str, Any]) -> dict[str, Any] | None:
    """A joint as compas_dem has it; None where its points are on a line."""
    normal = np.asarray(arrays[fields.NORMAL], float).mean(axis=0)
    normal /= np.linalg.norm(normal)
    first = np.asarray(arrays[fields.TANGENTS[0]], float)[0]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    frame = np.stack([first, np.cross(normal, first), normal])
    corners = hull_of((points - points.mean(axis=0)) @ frame[:2].T)
    if corners is None:
        return None
    reaction = np.asarray(arrays[fields.REACTION], float)
    shared = shares((points - points.mean(axis=0)) @ frame[:2].T, corners).T @ reaction
    local = shared @ frame.T  # along both tangents and the normal
    forces = [{"c_np": max(n, 0.0), "c_nn": max(-n, 0.0), "c_u": u, "c_v": v} for u, v, n in local.tolist()]
    at = [{"dtype": "compas.geometry/Point", "data": point} for point in points[corners].tolist()]
    placed = {
        "dtype": "compas.geometry/Frame",
        "data": {
            "point": points.mean(axis=0).tolist(),
            "xaxis": frame[0].tolist(),
            "yaxis": frame[1].tolist(),
        },
    }
    contact = {
        "dtype": "compas_dem.interactions/FrictionContact",
        "data": {"name": "FrictionContact", "points": at, "frame": placed, "size": None, "mesh": None,
                 "holes": [], "forces": forces},
    }  # fmt: skip
    total = reaction.sum(axis=0)
    edge = int(arrays[fields.ANTAGONIST][0]), int(arrays[fields.CANDIDATE][0])
    told = {
        "contact_data": contact, "contact_frame": placed, "face_contact": True,
        "contact_polygon": {"dtype": "compas.geometry/Polygon", "data": {"points": points[corners].tolist()}},
        "contact_points": points[corners].tolist(), "resultant_global": total.tolist(),
        "resultant_local": (frame @ total).tolist(), "force_magnitude": float(np.linalg.norm(total)),
        "force_normal": local[:, 2].tolist(), "force_tangent1": local[:, 0].tolist(),
        "force_tangent2": local[:, 1].tolist(),
    }  # fmt: skip
    return {"edge": edge, "contact": contact, "told": told}


def hull_of(flat: FloatArray) -> NDArray[np.int64] | None:
    """Rows of the corners of a convex hull, anticlockwise; None where all points are on a line.

    Parameters
    ----------
    flat : Points of a plane, shape (n, 2) [m].
    """
    if len(flat) < 3 or np.linalg.svd(flat - flat.mean(axis=0), compute_uv=False)[1] <= FLAT * np.ptp(flat):
        return None
    try:
        corners: NDArray[np.int64] = ConvexHull(flat).vertices.astype(np.int64)
    except QhullError:
        return None
    return corners


def shares(flat: FloatArray, corners: NDArray[np.int64]) -> FloatArray:
    """What share of each of n points falls to each of k corners, of which the point is the weighted mean.

    Parameters
    ----------
    flat : Points of a plane, shape (n, 2). corners : Rows of the convex hull, in order, shape (k,).

    Returns
    -------
    Shape (n, k), not negative; rows sum to 1. A point is within a triangle of the fan from the first corner.
    """
    apex, ring = flat[corners[0]], flat[corners[1:]] - flat[corners[0]]
    a, b = ring[:-1], ring[1:]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    p = (flat - apex)[:, None]
    second = (p[..., 0] * b[:, 1] - p[..., 1] * b[:, 0]) / area
    third = (a[:, 0] * p[..., 1] - a[:, 1] * p[..., 0]) / area
    weights = np.stack([1.0 - second - third, second, third], axis=2)
    best = weights.min(axis=2).argmax(axis=1)
    rows = np.arange(len(flat))
    made = np.zeros((len(flat), len(corners)))
    for corner, column in enumerate((np.zeros_like(best), best + 1, best + 2)):
        made[rows, column] += weights[rows, best, corner]
    return made
