"""glTF: the blocks of a step as a model for Blender, browsers and slides, in one ``.glb`` file.

    write_gltf(recorded, -1, look, Path("arch.glb"))

Each block is a node with its name, coloured at its corners. Displacements are a morph target, amplified as
the look says, with an animation that lets them grow and go back: programs show it at rest, displaced or
moving. glTF has y upwards and metres; the root node turns models whose z is upwards.

References
----------
Khronos Group, glTF 2.0 Specification, 2021.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import masonry_fem
from masonry_fem.errors import SceneError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.output import fields
from masonry_fem.output.sheet import HELD
from masonry_fem.output.viewing.look import VALUES, Look, Shade
from masonry_fem.output.viewing.recorded import Recorded

FloatArray = NDArray[np.float64]

MAGIC, VERSION = 0x46546C67, 2
CHUNKS = {"json": 0x4E4F534A, "data": 0x004E4942}
FLOAT, UNSIGNED, BYTE = 5126, 5125, 5121  # kinds of numbers
VERTICES, TRIANGLES = 34962, 34963  # what a part of the data is for
SIZES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
SWAY = 4.0  # seconds of the animation


def write_gltf(recorded: Recorded, place: int, look: Look, path: Path) -> Path:
    """Write a step as binary glTF.

    Parameters
    ----------
    recorded : The steps. place : Which, from 0 on; negative ones count from the end.
    look : What is coloured, amplified and cut away.
    path : Where to, ending in ``.glb``.

    Raises
    ------
    SceneError : Another ending.
    OutputError : The file cannot be written.
    """
    if path.suffix.lower() != ".glb":
        raise SceneError(f"--gltf '{path}', expected a file that ends in .glb")
    blocks = recorded.blocks(place)
    names = bytes(np.asarray(blocks.field_data["block_names"])).decode().splitlines()
    shade = Shade.of([blocks], look.field)
    skin = _skin(look.shown(blocks).surface)
    origin = skin.points - look.factor * skin.moves
    colours = _colours(skin.values, shade)
    packed = _Packed()
    nodes, meshes = [], []
    for block, (points, cells) in _by_block(skin).items():
        own = cells - points.start
        attributes = {
            "POSITION": packed.add(origin[points], VERTICES, bounds=True),
            "NORMAL": packed.add(skin.normals[points], VERTICES),
            "COLOR_0": packed.add(colours[points], VERTICES, normalized=True),
        }
        target = {"POSITION": packed.add(look.factor * skin.moves[points], VERTICES, bounds=True)}
        indices = packed.add(own.ravel().astype("<u4"), TRIANGLES)
        meshes.append({
            "name": names[block], "weights": [1.0],
            "primitives": [
                {"attributes": attributes, "indices": indices, "material": 0, "targets": [target]}
            ],
        })  # fmt: skip
        nodes.append({"name": names[block], "mesh": len(meshes) - 1})
    flat = int(blocks.field_data["dimension"][0]) == 2
    root: dict[str, Any] = {"name": recorded.title, "children": list(range(len(nodes)))}
    if not flat:
        root["rotation"] = [-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
    told = {
        "asset": {"version": "2.0", "generator": f"masonry_fem {masonry_fem.__version__}"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes)]}],
        "nodes": [*nodes, root],
        "meshes": meshes,
        "materials": [_MATERIAL],
        "animations": [_animation(packed, len(nodes))],
        "extras": {
            "field": look.field, "limits": list(shade.limits), "colours": shade.colours,
            "amplification": look.factor, "time": recorded.times[place],
        },
    }  # fmt: skip
    write_atomic(path, packed.file(told))
    return path


_MATERIAL = {
    "name": "stone",
    "doubleSided": True,
    "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9},
}


@dataclass(frozen=True, slots=True)
class _Skin:
    """Triangles of all blocks, block after block; faces do not share points, so that edges stay sharp."""

    points: FloatArray
    normals: FloatArray
    moves: FloatArray
    values: FloatArray
    block: NDArray[np.int64]  # of each triangle


def _skin(surface: Any) -> _Skin:
    """The triangles of a surface with sharp edges."""
    skin = surface.triangulate()
    cells = np.asarray(skin.faces).reshape(-1, 4)[:, 1:]
    block = np.asarray(skin.cell_data[fields.BLOCK], np.int64)
    order = np.argsort(block, kind="stable")
    cells, block = cells[order], block[order]
    corners = cells.ravel()
    points = np.asarray(skin.points, float)[corners]
    sides = points.reshape(-1, 3, 3)
    across = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    long = np.linalg.norm(across, axis=1, keepdims=True)
    # a triangle without area has no direction; any will do
    unit = np.where(long > 0, across / np.where(long > 0, long, 1.0), [0.0, 0.0, 1.0])
    if VALUES in skin.point_data:
        values = np.asarray(skin.point_data[VALUES], float)[corners]
    else:
        values = np.repeat(np.asarray(skin.cell_data[VALUES], float)[order], 3)
    moves = np.asarray(skin.point_data[fields.DISPLACEMENT], float)[corners]
    return _Skin(points, np.repeat(unit, 3, axis=0), moves, values, block)


def _by_block(skin: _Skin) -> dict[int, tuple[slice, NDArray[np.int64]]]:
    """Points and triangles of each block."""
    found, first, count = np.unique(skin.block, return_index=True, return_counts=True)
    made = {}
    for block, start, many in zip(found.tolist(), first.tolist(), count.tolist(), strict=True):
        corners = np.arange(3 * start, 3 * (start + many)).reshape(-1, 3)
        made[block] = slice(3 * start, 3 * (start + many)), corners
    return made


def _colours(values: FloatArray, shade: Shade) -> NDArray[np.uint8]:
    """Colours of points, linear as glTF has them."""
    from matplotlib import colormaps  # noqa: PLC0415
    from matplotlib.colors import to_rgba  # noqa: PLC0415

    low, high = shade.limits
    rgba = np.asarray(colormaps[shade.colours](np.clip((np.nan_to_num(values) - low) / (high - low), 0, 1)))
    rgba[np.isnan(values)] = to_rgba(HELD)
    linear = np.where(rgba <= 0.04045, rgba / 12.92, ((rgba + 0.055) / 1.055) ** 2.4)
    linear[:, 3] = 1.0
    return np.rint(255 * linear).astype(np.uint8)


def _animation(packed: _Packed, count: int) -> dict[str, Any]:
    """Displacements of all blocks that grow and go back."""
    times = packed.add(np.linspace(0.0, SWAY, 3).astype("<f4"), None, bounds=True)
    shares = packed.add(np.array([0.0, 1.0, 0.0], "<f4"), None)
    return {
        "name": "displacement",
        "samplers": [{"input": times, "output": shares, "interpolation": "LINEAR"}],
        "channels": [{"sampler": 0, "target": {"node": node, "path": "weights"}} for node in range(count)],
    }


@dataclass(slots=True)
class _Packed:
    """Arrays one after another, and what glTF says of each."""

    views: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    parts: list[bytes] = field(default_factory=list)
    length: int = 0

    def add(
        self, array: NDArray[Any], use: int | None, *, bounds: bool = False, normalized: bool = False
    ) -> int:
        """Number of a new array: floats in single precision, indices or bytes.

        Parameters
        ----------
        array : Shape (n,) or (n, 3 or 4). use : What for, ``VERTICES`` or ``TRIANGLES``.
        bounds : Whether its least and greatest values are told. normalized : Whether bytes mean 0 to 1.
        """
        given = np.ascontiguousarray(array)
        data = given.astype("<f4") if given.dtype.kind == "f" else given
        kind = {"f": FLOAT, "u": UNSIGNED if data.dtype.itemsize == 4 else BYTE}[data.dtype.kind]
        content = data.tobytes()
        content += b"\0" * (-len(content) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self.length, "byteLength": data.nbytes}
        self.views.append(view | ({"target": use} if use is not None else {}))
        self.parts.append(content)
        self.length += len(content)
        told: dict[str, Any] = {
            "bufferView": len(self.views) - 1, "componentType": kind, "count": len(data),
            "type": SIZES[1 if data.ndim == 1 else data.shape[1]],
        }  # fmt: skip
        if normalized:
            told["normalized"] = True
        if bounds:
            rows = data.reshape(len(data), -1)
            told |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(told)
        return len(self.accessors) - 1

    def file(self, told: dict[str, Any]) -> bytes:
        """The whole file."""
        told = told | {
            "bufferViews": self.views, "accessors": self.accessors, "buffers": [{"byteLength": self.length}]
        }  # fmt: skip
        text = json.dumps(told, separators=(",", ":"), ensure_ascii=False).encode()
        text += b" " * (-len(text) % 4)
        data = b"".join(self.parts)
        chunks = b"".join(
            np.array([len(content), CHUNKS[kind]], "<u4").tobytes() + content
            for kind, content in (("json", text), ("data", data))
        )
        return np.array([MAGIC, VERSION, 12 + len(chunks)], "<u4").tobytes() + chunks
